//! The bound of a loop: counted wherever overflow is checked, and nothing at all in the firmware.
//!
//! Each `while` and `loop` of this crate counts its iterations against a bound that stands beside
//! it; a `for` has the length of what it iterates over. So the worst case of a plan and of a refill
//! follows from bounds, and a test, a property or a fuzzer that finds one iteration more has found
//! a defect.

use crate::low;

/// The iterations that a loop may still make.
#[derive(Debug)]
pub(crate) struct Iterations(u32);

impl Iterations {
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

    /// One iteration begins.
    #[inline(always)]
    pub(crate) const fn count(&mut self) {
        debug_assert!(self.0 > 0, "a loop makes more iterations than it may");
        self.0 = self.0.saturating_sub(1);
    }
}

#[cfg(test)]
mod tests {
    use super::Iterations;

    #[test]
    fn as_many_iterations_as_the_bound_are_none_too_many() {
        let mut iterations = Iterations::at_most(2);
        iterations.count();
        iterations.count();
    }

    #[test]
    #[should_panic(expected = "more iterations")]
    fn an_iteration_more_is_found() {
        let mut iterations = Iterations::for_each(&[0]);
        iterations.count();
        iterations.count();
    }
}
