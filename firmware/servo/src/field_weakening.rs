//! Field weakening: a current against the magnet, where the bus has no voltage left for the speed.
//!
//! An integral of the square of the voltage: above nine tenths of the circle the current in d falls, below it comes back to 0.

use crate::number::greater;
use crate::transform::Rotor;

/// The share of the square of the circle above which the field is weakened: 0.9².
const FULL: f32 = 0.81;

/// The share of its greatest current by which it moves in a period, at the edge of the circle without a voltage.
const RATE: f32 = 0.01;

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldWeakening {
    max: f32,
    /// How far it moves in a period at most, in A.
    rate: f32,
    current: f32,
}

impl FieldWeakening {
    /// With a current of at most so many A; 0 for none.
    pub(crate) const fn new(max: f32) -> Self {
        Self {
            max,
            rate: RATE * max,
            current: 0.0,
        }
    }

    /// The current in d, in A: 0 or below.
    #[inline]
    pub fn current(&self) -> f32 {
        self.current
    }

    pub(crate) fn reset(&mut self) {
        self.current = 0.0;
    }

    /// Looks at a voltage that is wanted, and at the circle, in V.
    #[inline]
    pub(crate) fn look(&mut self, wanted: Rotor, max: f32) {
        if self.max == 0.0 {
            return;
        }
        // Far beyond the circle, and by NaN, it moves no faster than with nothing wanted it comes back.
        let left = greater(1.0 - wanted.square() / (FULL * (max * max)), -1.0);
        let current = self.current + self.rate * left;
        self.current = if current > 0.0 {
            0.0
        } else if current < -self.max {
            -self.max
        } else {
            current
        };
    }
}
