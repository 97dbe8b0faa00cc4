//! What a control tick publishes, and the last few sets of it.

use canopen::Instant;

use crate::actuator::Torque;
use crate::commands::Commands;
use crate::copied::copy_fields;
use crate::cyclic::SyncStatus;
use crate::mode::Mode;
use crate::state_machine::State;
use crate::units::Units;

/// Everything the bus may know of the drive: made together in one control tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Actuals {
    /// When the tick ran.
    pub at: Instant,
    /// 6041h.
    pub statusword: u16,
    /// 6061h.
    pub mode_display: i8,
    /// 603Fh.
    pub error_code: u16,
    /// 6043h in units of the velocity mode; 0 outside of it.
    pub vl_velocity_demand: i16,
    /// 6044h in units of the velocity mode; 0 outside of it.
    pub vl_velocity_actual: i16,
    /// 6062h in units of the user.
    pub position_demand: i32,
    /// 6063h in increments (steps).
    pub position_actual_internal: i32,
    /// 6064h in units of the user.
    pub position_actual: i32,
    /// 606Bh in units of the user.
    pub velocity_demand: i32,
    /// 606Ch in units of the user.
    pub velocity_actual: i32,
    /// 60F4h in units of the user.
    pub following_error: i32,
    /// 6074h, 6077h and 6078h; nothing where the actuator has none.
    pub torque: Torque,
    /// 60FDh.
    pub digital_inputs: u32,
    /// The second counter of the board, for [`gearing`](crate::gearing).
    pub counter: i32,
    /// The board carries out [`Outputs::compare`](crate::Outputs::compare).
    pub has_compare: bool,
    /// 2034h:1: the home position is known.
    pub referenced: bool,
    /// 2034h:2.
    pub homing_failure: u8,
    /// 2050h.
    pub sync: SyncStatus,
    /// The motor moves, or is about to.
    pub is_moving: bool,
    /// Power is off, the motor stands, and a restart that was asked for is done: a reset may go on.
    pub safe: bool,
}

impl Actuals {
    /// Whether the power stage is on, or may be so in a moment.
    pub fn has_power(&self) -> bool {
        matches!(
            State::from_statusword(self.statusword),
            Some(
                State::SwitchedOn
                    | State::OperationEnabled
                    | State::QuickStopActive
                    | State::FaultReactionActive
            )
        )
    }

    /// Whether there is current in the motor, or it turns.
    pub(crate) fn is_driving(&self) -> bool {
        self.is_moving || State::from_statusword(self.statusword).is_some_and(State::may_have_power)
    }

    /// Takes over all of other ones, field by field.
    #[inline]
    fn assign(&mut self, from: &Self) {
        copy_fields!(Self { at, statusword, mode_display, error_code, vl_velocity_demand, vl_velocity_actual, position_demand, position_actual_internal, position_actual, velocity_demand, velocity_actual, following_error, torque, digital_inputs, counter, has_compare, referenced, homing_failure, sync, is_moving, safe }, from => self);
    }

    /// What is known before the first tick: a drive that is not ready to switch on.
    pub const NONE: Self = Self {
        at: Instant::from_ticks(0),
        statusword: 0,
        mode_display: 0,
        error_code: 0,
        vl_velocity_demand: 0,
        vl_velocity_actual: 0,
        position_demand: 0,
        position_actual_internal: 0,
        position_actual: 0,
        velocity_demand: 0,
        velocity_actual: 0,
        following_error: 0,
        torque: Torque::NONE,
        digital_inputs: 0,
        counter: 0,
        has_compare: false,
        referenced: false,
        homing_failure: 0,
        sync: SyncStatus::NONE,
        is_moving: false,
        safe: false,
    };
}

impl Actuals {
    /// Whether a command to stop is felt by the motor.
    pub(super) fn is_stoppable(&self) -> bool {
        let state = State::from_statusword(self.statusword);
        self.is_moving
            && matches!(
                state,
                Some(State::OperationEnabled | State::QuickStopActive | State::FaultReactionActive)
            )
    }

    /// Whether an edge of bit 4 begins homing.
    pub(super) fn is_ready_to_home(&self) -> bool {
        self.mode_display == Mode::Homing.code()
            && State::from_statusword(self.statusword) == Some(State::OperationEnabled)
    }
}

/// What a control tick has come to, for the scope.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TickResult<'a> {
    /// What it has published.
    pub(crate) actuals: &'a Actuals,
    /// What it has obeyed.
    pub(crate) commands: &'a Commands,
    /// In which units.
    pub(crate) units: &'a Units,
}

/// The last sets of actual values: those of two control ticks, and of an early one.
#[derive(Debug)]
pub(super) struct History {
    sets: [Actuals; 3],
    newest: usize,
}

impl History {
    pub(super) const fn new() -> Self {
        Self {
            sets: [Actuals::NONE; 3],
            newest: 0,
        }
    }

    /// A tick has made these.
    pub(super) fn put(&mut self, actuals: &Actuals) {
        let [first, second, third] = &mut self.sets;
        let (newest, oldest) = match self.newest {
            0 => (1, second),
            1 => (2, third),
            _ => (0, first),
        };
        self.newest = newest;
        oldest.assign(actuals);
    }

    /// Those of the last tick.
    #[inline(never)]
    pub(super) const fn newest(&self) -> &Actuals {
        self.newest_first()[0]
    }

    /// The newest that were there at `stamp`; the oldest if none was.
    pub(super) fn at(&self, stamp: Instant) -> &Actuals {
        let [newest, before, oldest] = self.newest_first();
        [newest, before]
            .into_iter()
            .find(|set| set.at <= stamp)
            .unwrap_or(oldest)
    }

    const fn newest_first(&self) -> [&Actuals; 3] {
        let [first, second, third] = &self.sets;
        match self.newest {
            0 => [first, third, second],
            1 => [second, first, third],
            _ => [third, second, first],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn made_at(time: u64) -> Actuals {
        Actuals {
            at: Instant::from_ticks(time),
            ..Actuals::NONE
        }
    }

    #[test]
    fn a_frame_that_waits_for_two_ticks_and_an_early_one_meets_the_drive_as_it_was() {
        let mut history = History::new();
        for start in [1_000, 5_000, 9_000, 13_000_u64] {
            let made = [start, start + 900, start + 1_000];
            for time in made {
                history.put(&made_at(time));
                assert_eq!(history.newest().at.ticks(), time);
            }
            for (stamp, expected) in [
                (start, made[0]),
                (start + 899, made[0]),
                (start + 900, made[1]),
                (start + 999, made[1]),
                (start + 1_000, made[2]),
                (start + 3_900, made[2]),
                // Older than all of them.
                (start - 1, made[0]),
            ] {
                let found = history.at(Instant::from_ticks(stamp));
                assert_eq!(found.at.ticks(), expected);
            }
        }
    }
}
