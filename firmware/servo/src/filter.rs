//! A filter of first or second order: low-pass or notch, for the current that the velocity loop asks for.
//!
//! The analogue filter by the bilinear transform, with its frequency where it is meant (Bristow-Johnson's audio EQ cookbook).

use crate::Angle;
use crate::motor::Implausible;
use crate::number::{is_within, limit};
use crate::transform::direction;

/// Currents are cut to this amount, in A.
const MAX: f32 = 1e4;

/// A filter with its memory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filter {
    ahead: [f32; 3],
    back: [f32; 2],
    memory: [f32; 2],
}

impl Filter {
    /// A filter that passes everything.
    pub const NONE: Self = Self {
        ahead: [1.0, 0.0, 0.0],
        back: [0.0; 2],
        memory: [0.0; 2],
    };

    /// Passes what is below a frequency in Hz; with a quality of 0.707 it is flat. The period is in s.
    ///
    /// # Errors
    /// With a frequency that is not from 10⁻⁴ to 0.45 of the rate, or a quality that is not from 0.1 to 100.
    pub fn low_pass(frequency: f32, quality: f32, period: f32) -> Result<Self, Implausible> {
        let half = Half::of(frequency, period)?;
        let pass = half.sine * half.sine;
        half.second_order(pass, 2.0 * pass, quality)
    }

    /// Passes what is below a frequency in Hz, with one pole. The period is in s.
    ///
    /// # Errors
    /// With a frequency that is not from 10⁻⁴ to 0.45 of the rate.
    pub fn first_low_pass(frequency: f32, period: f32) -> Result<Self, Implausible> {
        let Half { sine, cosine } = Half::of(frequency, period)?;
        let by = 1.0 / (sine + cosine);
        let pass = sine * by;
        Ok(Self {
            ahead: [pass, pass, 0.0],
            back: [(sine - cosine) * by, 0.0],
            memory: [0.0; 2],
        })
    }

    /// Takes out a frequency in Hz, the narrower the higher the quality. The period is in s.
    ///
    /// # Errors
    /// As [`Filter::low_pass`].
    pub fn notch(frequency: f32, quality: f32, period: f32) -> Result<Self, Implausible> {
        let half = Half::of(frequency, period)?;
        half.second_order(1.0, -2.0 * half.cosine_of_whole(), quality)
    }

    /// Settles at this input.
    #[inline(never)]
    pub fn settle(&mut self, value: f32) {
        let value = limit(value, MAX);
        let [first, second, third] = self.ahead;
        let sum = first + second + third;
        let [near, far] = self.back;
        let gone = 1.0 + near + far;
        let through = if gone > 0.0 { sum / gone } else { 1.0 };
        let out = value * through;
        let old = third * value - far * out;
        self.memory = [second * value - near * out + old, old];
    }

    /// The next value.
    #[inline]
    pub fn run(&mut self, value: f32) -> f32 {
        let value = limit(value, MAX);
        let [first, second, third] = self.ahead;
        let [near, far] = self.back;
        let [new, old] = self.memory;
        let out = first * value + new;
        self.memory = [second * value - near * out + old, third * value - far * out];
        out
    }
}

/// Half the angle that a period is of a turn of the frequency.
struct Half {
    sine: f32,
    cosine: f32,
}

impl Half {
    #[inline(never)]
    fn of(frequency: f32, period: f32) -> Result<Self, Implausible> {
        let turns = frequency * period;
        Implausible::unless(is_within(turns, 1e-4, 0.45))?;
        let (sine, cosine) = direction(Angle::from_turns(0.5 * turns));
        Ok(Self { sine, cosine })
    }

    /// Of the whole angle.
    fn cosine_of_whole(&self) -> f32 {
        1.0 - 2.0 * self.sine * self.sine
    }

    /// With the factors of the newest and the oldest input, and of that between.
    #[inline(never)]
    fn second_order(&self, outer: f32, middle: f32, quality: f32) -> Result<Filter, Implausible> {
        Implausible::unless(is_within(quality, 0.1, 100.0))?;
        let alpha = self.sine * self.cosine / quality;
        let by = 1.0 / (1.0 + alpha);
        let outer = outer * by;
        Ok(Filter {
            ahead: [outer, middle * by, outer],
            back: [-2.0 * self.cosine_of_whole() * by, (1.0 - alpha) * by],
            memory: [0.0; 2],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f32::consts::TAU;

    const PERIOD: f32 = 250e-6;

    /// The amplitude of a sine behind the filter.
    fn gain(filter: Filter, frequency: f32) -> f32 {
        let mut filter = filter;
        let mut max = 0.0_f32;
        for period in 0..20_000_u16 {
            let out = filter.run((TAU * frequency * PERIOD * f32::from(period)).sin());
            if period > 10_000 {
                max = max.max(out.abs());
            }
        }
        max
    }

    #[test]
    fn a_low_pass_is_three_decibels_down_at_its_frequency() {
        let filter = Filter::low_pass(100.0, core::f32::consts::FRAC_1_SQRT_2, PERIOD).unwrap();
        assert!((gain(filter, 10.0) - 1.0).abs() < 0.01);
        assert!((gain(filter, 100.0) - core::f32::consts::FRAC_1_SQRT_2).abs() < 0.01);
        assert!(gain(filter, 1_000.0) < 0.012);
    }

    #[test]
    fn a_low_pass_of_first_order_falls_by_twenty_decibels_for_ten_times_the_frequency() {
        let filter = Filter::first_low_pass(50.0, PERIOD).unwrap();
        assert!((gain(filter, 5.0) - 0.995).abs() < 0.005);
        assert!((gain(filter, 50.0) - core::f32::consts::FRAC_1_SQRT_2).abs() < 0.01);
        assert!((gain(filter, 500.0) - 0.1).abs() < 0.02);
        assert!(Filter::first_low_pass(0.0, PERIOD).is_err());
        assert!(Filter::first_low_pass(f32::NAN, PERIOD).is_err());
    }

    #[test]
    fn a_notch_takes_its_frequency_out() {
        let filter = Filter::notch(300.0, 2.0, PERIOD).unwrap();
        assert!(gain(filter, 300.0) < 0.01);
        assert!((gain(filter, 30.0) - 1.0).abs() < 0.02);
        assert!((gain(filter, 1_500.0) - 1.0).abs() < 0.02);
    }

    #[test]
    fn what_has_settled_stays() {
        for filter in [
            Filter::NONE,
            Filter::low_pass(100.0, core::f32::consts::FRAC_1_SQRT_2, PERIOD).unwrap(),
            Filter::first_low_pass(100.0, PERIOD).unwrap(),
            Filter::notch(300.0, 2.0, PERIOD).unwrap(),
        ] {
            let mut filter = filter;
            filter.settle(3.0);
            for _ in 0..10 {
                assert!((filter.run(3.0) - 3.0).abs() < 1e-3);
            }
            assert!(!filter.run(f32::NAN).is_nan());
            assert!(!filter.run(1.0).is_nan(), "nothing is left of it");
        }
        assert!(Filter::notch(f32::NAN, 1.0, PERIOD).is_err());
        assert!(Filter::low_pass(2_000.0, 1.0, PERIOD).is_err());
    }
}
