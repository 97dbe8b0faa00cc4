//! The bound of a loop: counted wherever overflow is checked, and nothing at all in the firmware.
//!
//! Each `while` and `loop` of this crate counts its turns against a bound that stands beside it; a `for` has that of what it goes through. So the worst
//! case of a plan and of a refill follows from bounds, and a test, a property or a fuzzer that finds a turn more has found a defect.

use crate::low;

/// The turns that a loop may still make.
#[derive(Debug)]
pub(crate) struct Turns(u32);

impl Turns {
    /// So many at most.
    #[inline(always)]
    pub(crate) const fn at_most(bound: u32) -> Self {
        Self(bound)
    }

    /// One for each of these at most.
    #[inline(always)]
    pub(crate) const fn for_each<T>(all: &[T]) -> Self {
        // Beyond 32 bits there is nothing to go through.
        Self(low::word(all.len()))
    }

    /// One turn begins.
    #[inline(always)]
    pub(crate) const fn count(&mut self) {
        debug_assert!(self.0 > 0, "a loop makes more turns than it may");
        self.0 = self.0.saturating_sub(1);
    }
}

#[cfg(test)]
mod tests {
    use super::Turns;

    #[test]
    fn as_many_turns_as_the_bound_are_none_too_many() {
        let mut turns = Turns::at_most(2);
        turns.count();
        turns.count();
    }

    #[test]
    #[should_panic(expected = "more turns")]
    fn a_turn_more_is_found() {
        let mut turns = Turns::for_each(&[0]);
        turns.count();
        turns.count();
    }
}
