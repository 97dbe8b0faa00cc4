//! What is known of a motor, its load and its supply, in the units of their data sheets.

use canopen::Duration;
use serde::{Deserialize, Deserializer};

use super::Motor;

/// A hybrid stepper motor. [`MotorData::default`] has one of NEMA 23 of ordinary size.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MotorData {
    /// Full steps in a turn.
    pub full_steps: u16,
    /// Steps of the axis (those in which its positions are given) in a full step. The drive may be set to others.
    pub microsteps: u16,
    /// The peak current of a phase for which the torque is given, in mA.
    #[serde(rename = "rated_current_ma")]
    pub rated_current: u16,
    /// The greatest torque at rest at that current, in mN·m.
    #[serde(rename = "holding_torque_mnm")]
    pub holding_torque: u32,
    /// The greatest torque without current, in mN·m.
    #[serde(rename = "detent_torque_mnm")]
    pub detent_torque: u32,
    /// In g·cm².
    #[serde(rename = "rotor_inertia_gcm2")]
    pub rotor_inertia: u32,
    /// Of a phase, in mΩ.
    #[serde(rename = "resistance_mohm")]
    pub resistance: u32,
    /// Of a phase, in µH.
    #[serde(rename = "inductance_uh")]
    pub inductance: u32,
    /// How the swinging of the rotor about its field is damped at the rated current, in percent of what would end it at once.
    #[serde(rename = "damping_percent")]
    pub damping: u8,
    /// The driver senses that the motor does not follow.
    #[serde(rename = "stall_sense")]
    pub senses_stall: bool,
    /// How fine the encoder on the shaft is, in counts a turn; `None` is as fine as the pulses.
    pub encoder_counts: Option<u32>,
    /// What the motor carries.
    #[serde(skip)]
    pub load: Load,
    /// How warm it gets.
    #[serde(skip)]
    pub heat: Heat,
}

impl Default for MotorData {
    fn default() -> Self {
        Self {
            full_steps: 200,
            microsteps: 16,
            rated_current: 2_800,
            holding_torque: 1_260,
            detent_torque: 40,
            rotor_inertia: 300,
            resistance: 900,
            inductance: 2_500,
            damping: 15,
            senses_stall: false,
            encoder_counts: None,
            load: Load::default(),
            heat: Heat::default(),
        }
    }
}

/// The finest encoder: 24 bits a turn.
const MAX_COUNTS: u32 = 1 << 24;

impl MotorData {
    /// What the types do not say.
    pub(crate) fn check(&self) -> Result<(), String> {
        let zero = [
            ("full_steps", u32::from(self.full_steps)),
            ("microsteps", self.microsteps.into()),
            ("rated_current_ma", self.rated_current.into()),
            ("holding_torque_mnm", self.holding_torque),
            ("rotor_inertia_gcm2", self.rotor_inertia),
            ("resistance_mohm", self.resistance),
            ("encoder_counts", self.encoder_counts.unwrap_or(1)),
        ];
        if let Some((name, _)) = zero.iter().find(|(_, value)| *value == 0) {
            return Err(format!("{name} = 0"));
        }
        if self.encoder_counts > Some(MAX_COUNTS) {
            return Err(format!("encoder_counts: at most {MAX_COUNTS}"));
        }
        if self.heat.time_constant.ticks() == 0 {
            return Err("time_constant_s = 0 in [heat]".to_owned());
        }
        if !Motor::can_be_shown(self) {
            return Err(
                "too much torque, or too stiff a stop, for so little inertia: it would swing faster than the simulation"
                    .to_owned(),
            );
        }
        Ok(())
    }
}

/// What turns with the motor, and what holds it back; all as the shaft of the motor feels it.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Load {
    /// In g·cm².
    #[serde(rename = "inertia_gcm2")]
    pub inertia: u32,
    /// Friction that does not depend on the speed, in mN·m.
    #[serde(rename = "friction_mnm")]
    pub friction: u32,
    /// Friction that grows with the speed: what it is at 1000 turns a minute, in mN·m.
    #[serde(rename = "drag_mnm")]
    pub drag: u32,
    /// A torque that is always there, such as weight, in mN·m; positive ones turn the motor towards positive positions.
    #[serde(rename = "torque_mnm")]
    pub torque: i32,
    /// What the holding brake holds, in mN·m; 0 is none.
    #[serde(rename = "brake_mnm")]
    pub brake: u32,
    /// From the order to open the brake until it lets go.
    #[serde(rename = "brake_release_ms", deserialize_with = "milliseconds")]
    pub brake_release: Duration,
    /// From the order to close the brake, or from when it loses its power, until it holds.
    #[serde(rename = "brake_engage_ms", deserialize_with = "milliseconds")]
    pub brake_engage: Duration,
    /// How far an end stop gives way under 1 N·m, in steps of the axis.
    #[serde(skip)]
    pub compliance: u32,
}

impl Default for Load {
    fn default() -> Self {
        Self {
            inertia: 0,
            friction: 0,
            drag: 0,
            torque: 0,
            brake: 0,
            brake_release: Duration::from_ticks(0),
            brake_engage: Duration::from_ticks(0),
            compliance: 0,
        }
    }
}

/// A winding that warms up as a body of one temperature does.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Heat {
    /// The temperature around the motor, in °C.
    #[serde(rename = "ambient_c")]
    pub ambient: i16,
    /// How much warmer it gets by its rated current at last, in K.
    #[serde(rename = "rise_k")]
    pub rise: u16,
    /// After this time 63 % of the way are done.
    #[serde(rename = "time_constant_s", deserialize_with = "seconds")]
    pub time_constant: Duration,
}

impl Default for Heat {
    fn default() -> Self {
        Self {
            ambient: 25,
            rise: 60,
            time_constant: Duration::from_ticks(900_000_000),
        }
    }
}

/// A supply, and what happens to it.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SupplyData {
    /// In mV, when no current flows.
    #[serde(rename = "voltage_mv")]
    pub voltage: u32,
    /// Of the source and its wires, in mΩ: the voltage sags by the current.
    #[serde(rename = "resistance_mohm")]
    pub resistance: u32,
    /// Dips and surges. Where several hold at a time the last one counts.
    #[serde(rename = "change")]
    pub changes: Vec<SupplyChange>,
}

impl Default for SupplyData {
    fn default() -> Self {
        Self {
            voltage: 24_000,
            resistance: 0,
            changes: Vec::new(),
        }
    }
}

/// For a time the supply has another voltage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SupplyChange {
    /// When it begins, after the start of the simulation.
    #[serde(rename = "at_ms", deserialize_with = "milliseconds")]
    pub at: Duration,
    /// How long it lasts.
    #[serde(rename = "for_ms", deserialize_with = "milliseconds")]
    pub duration: Duration,
    /// In mV.
    #[serde(rename = "voltage_mv")]
    pub voltage: u32,
}

fn seconds<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Duration, D::Error> {
    u32::deserialize(deserializer)
        .map(|seconds| Duration::from_ticks(u64::from(seconds) * 1_000_000))
}

fn milliseconds<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Duration, D::Error> {
    u32::deserialize(deserializer)
        .map(|milliseconds| Duration::from_ticks(u64::from(milliseconds) * 1_000))
}
