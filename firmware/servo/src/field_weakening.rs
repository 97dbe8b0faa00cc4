//! Field weakening: a current against the magnet, where the bus has no voltage left for the speed.
//!
//! An integral of the square of the voltage: above nine tenths of the circle the current in d falls, below it comes back to 0.

use crate::number::{between, held};

/// The share of the square of the circle above which the field is weakened: 0.9².
const FULL: f32 = 0.81;

/// The greatest current in parts, and what it moves by in a period without a voltage, as powers of 2: the core bounds these by one instruction.
const BITS: u32 = 24;
const RATE_BITS: u32 = 17;

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldWeakening {
    /// Parts that the square of a voltage takes from the rate.
    by_square: f32,
    /// The greatest current, in A.
    max: f32,
    /// Of a part, in A: 0 for none.
    scale: f32,
    parts: i32,
    current: f32,
}

impl FieldWeakening {
    /// With a current of at most so many A, 0 for none, and the square of the circle.
    pub(crate) fn new(max: f32, square: f32) -> Self {
        Self {
            by_square: (1 << RATE_BITS) as f32 / (FULL * square),
            max,
            scale: max / (1 << BITS) as f32,
            parts: 0,
            current: 0.0,
        }
    }

    /// At most so many A from now on, within the greatest current.
    pub fn limit(&mut self, current: f32) {
        self.scale = between(current, 0.0, self.max) / (1 << BITS) as f32;
        self.current = self.parts as f32 * self.scale;
        if self.current <= 0.0 {
            self.reset();
        }
    }

    /// The current against the magnet, in A: 0 or above.
    #[inline]
    pub fn current(&self) -> f32 {
        self.current
    }

    pub(crate) fn reset(&mut self) {
        (self.parts, self.current) = (0, 0.0);
    }

    /// Looks at the square of a voltage that is wanted, in the unit of that of the circle.
    #[inline]
    pub(crate) fn look(&mut self, square: f32) {
        if self.scale.to_bits() == 0 {
            return;
        }
        // Far beyond the circle it moves no faster than with nothing wanted it comes back; NaN is 0.
        let left = held(
            ((1 << RATE_BITS) as f32 - square * self.by_square) as i32,
            RATE_BITS,
        );
        self.parts = (self.parts - left).clamp(0, (1 << BITS) - 1);
        self.current = self.parts as f32 * self.scale;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn above_nine_tenths_of_the_circle_the_field_is_weakened() {
        let mut weakening = FieldWeakening::new(8.0, 100.0);
        weakening.look(80.0);
        assert_eq!(weakening.current(), 0.0);
        // At the circle, in 128 periods, by what the square is beyond 0.81 of it.
        for _ in 0..128 {
            weakening.look(100.0);
        }
        assert!((weakening.current() - 8.0 * (1.0 / 0.81 - 1.0)).abs() < 1e-3);
        for _ in 0..200 {
            weakening.look(1e30);
        }
        assert!((weakening.current() - 8.0).abs() < 1e-5);
        for _ in 0..64 {
            weakening.look(0.0);
        }
        assert!((weakening.current() - 4.0).abs() < 1e-3, "back as fast");
        let mut none = FieldWeakening::new(0.0, 100.0);
        none.limit(5.0);
        none.look(1e30);
        assert_eq!(none.current(), 0.0);
    }

    #[test]
    fn a_limit_holds_at_once_and_lets_it_go_again() {
        let mut weakening = FieldWeakening::new(8.0, 100.0);
        let full = |weakening: &mut FieldWeakening| {
            (0..200).for_each(|_| weakening.look(1e30));
            weakening.current()
        };
        assert!((full(&mut weakening) - 8.0).abs() < 1e-5);
        weakening.limit(3.0);
        assert!((weakening.current() - 3.0).abs() < 1e-5);
        assert!((full(&mut weakening) - 3.0).abs() < 1e-5);
        weakening.limit(0.0);
        assert_eq!(full(&mut weakening), 0.0);
        weakening.limit(20.0);
        assert_eq!(weakening.current(), 0.0, "it begins anew");
        assert!((full(&mut weakening) - 8.0).abs() < 1e-5);
        weakening.limit(f32::NAN);
        assert_eq!(full(&mut weakening), 0.0);
    }

    proptest! {
        #[test]
        fn no_number_takes_it_beyond_its_current(squares in prop::collection::vec(any::<u32>(), 1..300)) {
            let mut weakening = FieldWeakening::new(8.0, 100.0);
            for bits in squares {
                weakening.look(f32::from_bits(bits));
                prop_assert!((0.0..=8.0).contains(&weakening.current()));
            }
        }
    }
}
