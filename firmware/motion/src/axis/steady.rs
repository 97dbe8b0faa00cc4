//! Along a velocity that stays, from pulse to pulse: what most of the time is spent with.

use super::Axis;
use crate::clock::Ticks;
use crate::record::SHORTEST_RECORD;

/// What is handed out at least, in ticks.
const LEAST: i32 = 2 * SHORTEST_RECORD.cast_signed();

impl Axis {
    /// Makes the records of a stretch from pulse to pulse: of a velocity that stays, if the last chord was of it, or of a linear ramp. Whether it
    /// did.
    #[inline]
    pub(super) fn go_straight_on(&mut self, enough: Ticks) -> bool {
        if self.train.is_even() {
            return self.coast(enough);
        }
        match &self.leg {
            Some(leg) if leg.is_slope(self.horizon, enough) => self.go_along_slope(enough),
            _ => false,
        }
    }

    #[inline(never)]
    fn coast(&mut self, enough: Ticks) -> bool {
        let (begin, train) = (self.horizon, &mut self.train);
        let Some(leg) = self.leg.as_mut() else {
            return false;
        };
        let Some((from, pace, left)) = leg.steady(begin, train) else {
            return false;
        };
        // Neither is far from what was handed out. A run of a few ticks would be too short for a record, and one that is stretched costs rate.
        let wanted = (enough as u32).wrapping_sub(begin as u32).cast_signed();
        let wanted = wanted.max(LEAST).cast_unsigned().min(leg.reach);
        let Some(length) = train.go_on(begin, from, pace, wanted, left) else {
            return false;
        };
        let state = leg.coast(length);
        self.go_to(begin.wrapping_add(length.into()), state);
        true
    }
}
