//! The periphery of the drive, beside the motion of the motor: touch probes, digital outputs, the analogue input, the current of the motor, and
//! what is measured of the power stage.
//!
//! Each part looks at a control tick for itself and decides nothing about states or motion; the drive asks it what it has found. What
//! changes seldom ([`Latched`]) or is for the eye ([`Readings`]) goes to the device apart from the actual values, so that a tick in
//! which there is nothing new does not copy it.

pub mod analogue_input;
pub mod digital_outputs;
pub mod motor_current;
pub mod power_stage;
pub mod touch_probe;

use crate::board::Inputs;
use crate::configuration::Configuration;
use crate::objects::Objects;

use analogue_input::AnalogueInput;
use digital_outputs::DigitalOutputs;
use motor_current::MotorCurrent;
use power_stage::PowerStage;
use touch_probe::TouchProbes;

pub use analogue_input::Analogue;
pub use touch_probe::Latched;

/// What is measured, as objects show it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Readings {
    /// 6079h in millivolts; 0 if it is not measured.
    pub supply_voltage: u32,
    /// 2075h in millivolts: the supply of the electronics, and the battery of an encoder; 0 if they are not measured.
    pub other_supplies: [u32; 2],
    /// 2074h:1 in tenths of a degree Celsius; 0 if it is not measured.
    pub temperature: i16,
    /// 2064h:1 to :3.
    pub analogue: Analogue,
}

impl Readings {
    /// Nothing yet.
    pub const NONE: Self = Self {
        supply_voltage: 0,
        other_supplies: [0; 2],
        temperature: 0,
        analogue: Analogue {
            raw: 0,
            voltage: 0,
            filtered: 0,
        },
    };
}

/// The period with which readings are shown, in microseconds.
const READING_PERIOD: u32 = 10_000;

/// All parts.
#[derive(Debug)]
pub(crate) struct Periphery {
    pub(crate) probes: TouchProbes,
    pub(crate) outputs: DigitalOutputs,
    pub(crate) current: MotorCurrent,
    pub(crate) stage: PowerStage,
    analogue: AnalogueInput,
    /// Microseconds since readings were shown.
    since_shown: u32,
}

impl Periphery {
    pub(crate) const fn new() -> Self {
        Self {
            probes: TouchProbes::new(),
            outputs: DigitalOutputs::new(),
            current: MotorCurrent::new(),
            stage: PowerStage::new(),
            analogue: AnalogueInput::new(),
            since_shown: READING_PERIOD,
        }
    }

    /// Looks at the inputs of a tick, but for the edges. `elapsed` are the microseconds since the last tick.
    pub(crate) fn measure<D: Objects>(
        &mut self,
        elapsed: u32,
        inputs: &Inputs,
        configuration: &Configuration,
    ) {
        self.stage.has_supply = inputs.supply;
        if D::DRIVE.power_stage {
            self.stage.observe(inputs, &configuration.power_stage);
        }
        if D::DRIVE.analogue_input
            && let Some(raw) = inputs.analogue
        {
            self.analogue.observe(raw, elapsed, &configuration.analogue);
        }
        self.since_shown = self.since_shown.saturating_add(elapsed);
    }

    /// What the touch probes have that is new. `shown` gives the position that objects show for one of the drive's.
    pub(crate) fn take_latched<D: Objects>(
        &mut self,
        shown: impl Fn(i64) -> i32,
    ) -> Option<Latched> {
        if D::DRIVE.touch_probes {
            self.probes.take_news(shown)
        } else {
            None
        }
    }

    /// The readings, if it is time to show them.
    pub(crate) fn take_readings<D: Objects>(
        &mut self,
        inputs: &Inputs,
        configuration: &Configuration,
    ) -> Option<Readings> {
        (self.since_shown >= READING_PERIOD).then(|| self.readings::<D>(inputs, configuration))
    }

    #[cold]
    #[inline(never)]
    fn readings<D: Objects>(&mut self, inputs: &Inputs, configuration: &Configuration) -> Readings {
        self.since_shown = 0;
        Readings {
            supply_voltage: inputs.supply_voltage.unwrap_or(0),
            other_supplies: [inputs.auxiliary_voltage, inputs.battery_voltage]
                .map(Option::unwrap_or_default),
            temperature: inputs.temperature.unwrap_or(0),
            analogue: if D::DRIVE.analogue_input {
                self.analogue.shown(&configuration.analogue)
            } else {
                Analogue::default()
            },
        }
    }
}
