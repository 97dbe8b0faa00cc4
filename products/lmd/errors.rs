//! What the LMD tells of beside its faults, and whether what the motor does is plausible (FF01h).
//!
//! The manual has classes of errors and does not tell which error is of which: here a warning is told alone (class 0), a motor that is idle in a
//! move stops and keeps its power (1), temperature is a fault with a ramp (2), what cuts the power is one without (3), and what the hardware of the
//! drive finds (5xxxh) is over with the next power-on alone (4).

/// Causes of our own in the table of errors: the board is warm, it is hot, the motor is not where it should be; it is idle in a move, it moves
/// while it should be idle, it has ended short of its target.
pub(super) const WARM: u16 = 0x4311;
pub(super) const HOT: u16 = 0x4212;
pub(super) const FOLLOWING_ERROR: u16 = 0x8613;
const IDLE: u16 = 0x8614;
const RESTLESS: u16 = 0x8615;
const UNDERSHOT: u16 = 0x8616;

/// What is told, one bit each.
const TOLD: [u16; 5] = [WARM, FOLLOWING_ERROR, IDLE, RESTLESS, UNDERSHOT];

/// Errors that come and go without a fault.
#[derive(Debug, Default)]
pub(super) struct Warnings {
    stands: u8,
    told: u8,
}

impl Warnings {
    /// Whether this error stands.
    pub(super) fn set(&mut self, code: u16, stands: bool) {
        let mut bit = 1;
        for told in TOLD {
            if told == code {
                self.stands &= !bit;
                self.stands |= if stands { bit } else { 0 };
            }
            bit <<= 1;
        }
    }

    /// The next one to be told of.
    pub(super) fn next_change(&mut self) -> Option<(u16, bool)> {
        let changed = self.stands ^ self.told;
        let bit = changed & changed.wrapping_neg();
        self.told ^= bit;
        let code = TOLD.get(usize::try_from(bit.trailing_zeros()).ok()?)?;
        Some((*code, self.stands & bit != 0))
    }
}

/// From one look at the motor to the next, in microseconds.
const PERIOD: u64 = 100_000;

/// So many microsteps are a motion: four full steps, which is an electrical turn.
const MOTION: u32 = 1_024;

/// The motor as it was at the last look.
#[derive(Debug, Default)]
pub(super) struct Plausibility {
    at: u64,
    demand: i32,
    actual: i32,
    /// A move has not been looked at behind its end.
    has_moved: bool,
}

impl Plausibility {
    /// The motor has no power.
    pub(super) fn forget(&mut self, warnings: &mut Warnings) {
        for code in [IDLE, RESTLESS, UNDERSHOT] {
            warnings.set(code, false);
        }
        self.at = 0;
    }

    /// Demand and actual position at this time, in microseconds. Returns whether the motor is idle though it should move.
    pub(super) fn look(
        &mut self,
        at: u64,
        (demand, actual): (i32, i32),
        is_moving: bool,
        warnings: &mut Warnings,
    ) -> bool {
        let is_first = self.at == 0;
        if !is_first && at.saturating_sub(self.at) < PERIOD {
            return false;
        }
        let wanted = demand.abs_diff(self.demand);
        let way = actual.abs_diff(self.actual);
        (self.at, self.demand, self.actual) = (at, demand, actual);
        if is_first {
            return false;
        }
        let is_idle = wanted >= MOTION && way < wanted / 8;
        warnings.set(IDLE, is_idle);
        let stands = wanted == 0 && !is_moving;
        warnings.set(RESTLESS, stands && !self.has_moved && way >= MOTION);
        if !stands || self.has_moved {
            warnings.set(UNDERSHOT, stands && demand.abs_diff(actual) >= MOTION);
        }
        self.has_moved = !stands;
        is_idle
    }
}
