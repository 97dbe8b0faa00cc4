//! What the refill needs of a step axis, and the control tick shares with it.

use motion::{AdvanceError, Axis, PulseSink};

use super::directed::Directed;
use crate::actuator::ActuatorErrors;
use crate::board::{DriveConfig, outlast_tick};

/// The axis that makes pulses of motions.
#[derive(Debug)]
pub struct Emitter {
    pub(super) is_reversed: bool,
    /// Late: pulses came late, but all of them are sent. Broken: the axis has failed, and pulses may be missing.
    errors: ActuatorErrors,
    pub(super) axis: Axis,
}

impl Emitter {
    /// It stands at position 0.
    // Out of line, so that it is made where it stays.
    #[inline(never)]
    pub fn new(config: DriveConfig) -> Self {
        Self {
            is_reversed: false,
            errors: ActuatorErrors::default(),
            // Last, as it is large: so it is made where it stays.
            axis: Axis::new(outlast_tick(config)),
        }
    }

    /// Commits the pulses of the next time slices. Nothing is decided here.
    pub fn refill<S: PulseSink>(&mut self, pulses: &mut S) {
        let mut directed = Directed {
            pulses,
            is_reversed: self.is_reversed,
        };
        let result = self.axis.advance(&mut directed);
        self.look_at(result);
    }

    /// After either the motor may not be where the pulses say.
    pub(crate) fn look_at(&mut self, result: Result<(), AdvanceError>) {
        self.errors.is_late |= result == Err(AdvanceError::Underrun);
        self.errors.is_broken |= result == Err(AdvanceError::Internal);
    }

    pub(super) fn take_errors(&mut self) -> ActuatorErrors {
        core::mem::take(&mut self.errors)
    }
}

/// How the control tick gets at an emitter. Between any two calls a refill may commit pulses, so what belongs together is asked in one; none of them
/// takes longer than a refill.
pub trait EmitterLock: 'static {
    /// Reads from the emitter.
    fn look<R>(&self, f: impl FnOnce(&Emitter) -> R) -> R;

    /// Changes the emitter.
    fn lock<R>(&mut self, f: impl FnOnce(&mut Emitter) -> R) -> R;
}

/// Where ticks and refills come one after the other.
impl EmitterLock for Emitter {
    fn look<R>(&self, f: impl FnOnce(&Emitter) -> R) -> R {
        f(self)
    }

    fn lock<R>(&mut self, f: impl FnOnce(&mut Emitter) -> R) -> R {
        f(self)
    }
}
