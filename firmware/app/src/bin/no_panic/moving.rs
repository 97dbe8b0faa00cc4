//! What moves the motor: by steps or by current.

use cia402::recorder::Memory;
use cia402::{Drive, DriveConfig, Emitter, ServoAxis, StepAxis};

use super::dictionary::Dictionary;
use super::SCOPE;

/// What moves the motor, as the board and its data sheet have it.
#[cfg(not(any(feature = "odrive36", feature = "stepper405")))]
pub type Axis402 = StepAxis;
#[cfg(any(feature = "odrive36", feature = "stepper405"))]
pub type Axis402 = ServoAxis;

/// How a drive is made with it.
pub trait Moving: Sized {
    fn drive(config: DriveConfig) -> Drive<Dictionary, Self>;
    fn control(config: DriveConfig) -> runtime::Control<Dictionary, &'static Memory, Self>;
}

impl Moving for StepAxis {
    fn drive(config: DriveConfig) -> Drive<Dictionary, Self> {
        Drive::new(config)
    }

    fn control(config: DriveConfig) -> runtime::Control<Dictionary, &'static Memory, Self> {
        runtime::Control::new(config, &SCOPE)
    }
}

impl Moving for ServoAxis {
    fn drive(config: DriveConfig) -> Drive<Dictionary, Self> {
        Drive::servo(config, || Emitter::new(config))
    }

    fn control(config: DriveConfig) -> runtime::Control<Dictionary, &'static Memory, Self> {
        runtime::Control::servo(config, &SCOPE)
    }
}
