//! What ends the current of the motor.

use crate::current_loop::Trip;
use crate::feedback::FeedbackFault;

/// Why the motor has no current any more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// A current above its bound.
    OverCurrent,
    /// A current above its bound that flows beside the motor.
    Short,
    /// The bus is below its bound.
    UnderVoltage,
    /// The bus is above its bound.
    OverVoltage,
    /// Too hot for any current.
    Temperature,
    /// The rotor does not turn though much is asked of it.
    Blocked,
    /// The encoder is not where the magnet is, or has lost counts; or the data of the motor are far from it: both show as a voltage that the model does not know.
    Encoder,
    /// A phase carries nothing.
    PhaseLost,
    /// The currents of the phases do not add up to nothing, or one of them stands still whatever is done: a sensor of them is wrong, or a current leaks.
    CurrentSensor,
    /// Faster than the motor may turn.
    OverSpeed,
}

impl From<Trip> for Fault {
    fn from(trip: Trip) -> Self {
        match trip {
            Trip::OverCurrent => Self::OverCurrent,
            Trip::Short => Self::Short,
            Trip::UnderVoltage => Self::UnderVoltage,
            Trip::OverVoltage => Self::OverVoltage,
        }
    }
}

impl From<FeedbackFault> for Fault {
    fn from(_: FeedbackFault) -> Self {
        Self::Encoder
    }
}
