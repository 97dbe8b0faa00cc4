//! What a plant is made of, in SI units.

use serde::Deserialize;

/// The phases of a motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Phases {
    /// Two, each on a full bridge.
    Two,
    /// Three in a star, each on a half bridge.
    Three,
}

impl Phases {
    /// How many.
    pub fn count(self) -> usize {
        match self {
            Self::Two => 2,
            Self::Three => 3,
        }
    }
}

/// A motor with permanent magnets.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MotorData {
    /// Its phases.
    pub phases: Phases,
    /// Electrical turns in a mechanical one; 50 in a hybrid stepper of 200 full steps.
    pub pole_pairs: u16,
    /// Of a phase, in Ω.
    pub resistance: f64,
    /// Along the magnet, in H.
    pub inductance_d: f64,
    /// Across it, in H.
    pub inductance_q: f64,
    /// Peak linkage of the magnet with a phase, in V·s per electrical rad.
    pub flux: f64,
    /// Peak of the detent or cogging torque, in N·m.
    #[serde(default)]
    pub detent: f64,
    /// Periods of it in a turn: four times the pole pairs in a stepper; the common multiple of slots and poles in a servo motor.
    #[serde(default)]
    pub detent_periods: u32,
    /// Of the rotor, in kg·m².
    pub inertia: f64,
    /// In N·m.
    #[serde(default)]
    pub coulomb_friction: f64,
    /// In N·m·s/rad.
    #[serde(default)]
    pub viscous_friction: f64,
}

impl MotorData {
    /// Half the number of phases, times the pole pairs: the torque of 1 V·s and 1 A.
    fn gear(&self) -> f64 {
        self.phases.count() as f64 / 2.0 * f64::from(self.pole_pairs)
    }

    /// The torque of a current in d and q, in N·m.
    pub fn torque(&self, [d, q]: [f64; 2]) -> f64 {
        self.gear() * (self.flux + (self.inductance_d - self.inductance_q) * d) * q
    }

    /// The torque in N·m of an ampere in q, with none in d.
    pub fn torque_constant(&self) -> f64 {
        self.gear() * self.flux
    }

    /// The torque of the detents, in N·m; 0 and stable at angle 0.
    pub fn detent_torque(&self, angle: f64) -> f64 {
        -self.detent * libm::sin(angle * f64::from(self.detent_periods))
    }

    pub(crate) fn detent_energy(&self, angle: f64) -> f64 {
        let periods = f64::from(self.detent_periods);
        if self.detent_periods == 0 {
            return 0.0;
        }
        self.detent / periods * (1.0 - libm::cos(angle * periods))
    }

    pub(crate) fn magnetic_energy(&self, [d, q]: [f64; 2]) -> f64 {
        let energy = self.inductance_d * d * d + self.inductance_q * q * q;
        self.phases.count() as f64 / 4.0 * energy
    }
}

/// What the motor drives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadData {
    /// In kg·m².
    pub inertia: f64,
    /// In N·m.
    #[serde(default)]
    pub coulomb_friction: f64,
    /// In N·m·s/rad.
    #[serde(default)]
    pub viscous_friction: f64,
}

/// What is between motor and load.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Coupling {
    /// In N·m/rad.
    pub stiffness: f64,
    /// In N·m·s/rad, where it touches.
    #[serde(default)]
    pub damping: f64,
    /// The angle from touching on one side to touching on the other, in rad.
    #[serde(default)]
    pub backlash: f64,
}

/// The power stage.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StageData {
    /// Between switching one side of a half bridge off and the other on, in s.
    #[serde(default)]
    pub dead_time: f64,
    /// Of the modulation, in s.
    pub period: f64,
    /// The ripple of the current, in A: below it the dead time bends to nothing.
    pub ripple: f64,
}

/// The supply of the bus.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SupplyData {
    /// Without load, in V.
    pub voltage: f64,
    /// In Ω. It takes nothing back.
    pub resistance: f64,
    /// Of the bus, in F.
    pub capacitance: f64,
    /// Of the brake chopper, in Ω.
    pub chopper: f64,
}

/// Encoder, Hall sensors, and the measurement of the current.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SensorData {
    /// Counts of the incremental encoder in a turn.
    pub counts: u32,
    /// Where the index is, in rad.
    pub index: f64,
    /// Standard deviation of what the encoder sees, in counts.
    pub count_noise: f64,
    /// Of the absolute angle.
    pub bits: u8,
    /// Where its zero is, in rad.
    pub zero: f64,
    /// By how much the magnet is off its centre: the peak error once a turn, in rad.
    pub eccentricity: f64,
    /// Standard deviation of a measured current, in A.
    pub current_noise: f64,
    /// What is measured when there is none, in A, of each phase.
    pub current_offset: [f64; 3],
    /// A count of the converter, in A; 0 for none.
    pub current_count: f64,
    /// What the converter can show, in A.
    pub current_range: f64,
    /// The age of a measured current in steps of the plant, up to [`SensorData::MAX_DELAY`].
    pub current_delay: usize,
}

impl SensorData {
    /// See [`SensorData::current_delay`].
    pub const MAX_DELAY: usize = 15;

    /// An encoder of so many counts, and nothing that is not ideal.
    pub const fn ideal(counts: u32) -> Self {
        Self {
            counts,
            index: 0.0,
            count_noise: 0.0,
            bits: 20,
            zero: 0.0,
            eccentricity: 0.0,
            current_noise: 0.0,
            current_offset: [0.0; 3],
            current_count: 0.0,
            current_range: f64::INFINITY,
            current_delay: 0,
        }
    }
}

impl Default for SensorData {
    fn default() -> Self {
        Self::ideal(4096)
    }
}

/// All of it.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlantData {
    /// The motor.
    pub motor: MotorData,
    /// What it drives.
    #[serde(default)]
    pub load: LoadData,
    /// What is between them; without one they are one body.
    #[serde(default)]
    pub coupling: Option<Coupling>,
    /// The power stage.
    pub stage: StageData,
    /// The supply.
    pub supply: SupplyData,
    /// The sensors.
    #[serde(default)]
    pub sensors: SensorData,
}
