//! The sin² ramp: v = v₀ + Δv·sin²(π·s/2), with s from 0 to 1 over the ramp.
//!
//! It takes as long as the linear ramp between the same velocities and goes as far, so a move has its corners where the trapezoid
//! has them. Its acceleration begins and ends with nothing; in the middle it is π/2 times that of the linear ramp.
//!
//! The way is v₀·t + Δv·T·f(s) with f(s) = s/2 − sin(π·s)/2π, the integral of sin². Both are power series in s, summed in 64-bit
//! integers: eleven terms are exact to the last bits.

use crate::clock::{Fine, TOP_SIXTH_JERK};
use crate::divide::quotient;
use crate::plan::phase::Offset;
use crate::wide::Wide;

/// The coefficients of a series in u. The last ones, which count for less, are 12 bits shorter: a product of theirs is a short one.
type Series = ([u64; 7], [u32; 4]);

/// π²ᵏ/(2·(2k+1)!) for k from 1 on, Q64: f(s) = s·(c₁u − c₂u² + c₃u³ − …) with u = s².
const WAY: Series = (
    [
        15_171_838_874_637_736_216,
        7_487_002_386_487_161_160,
        1_759_375_040_586_671_831,
        241_171_328_385_291_462,
        21_638_778_218_618_542,
        1_369_013_979_106_885,
        64_341_078_063_553,
    ],
    [569_979_488, 16_448_749, 386_530, 7_539],
);

/// π²ᵏ/(2·(2k)!) for k from 1 on, Q61: sin²(π·s/2) = d₁u − d₂u² + d₃u³ − …
const SPEED: Series = (
    [
        5_689_439_577_989_151_081,
        4_679_376_491_554_475_725,
        1_539_453_160_513_337_852,
        271_317_744_433_452_895,
        29_753_320_050_600_495,
        2_224_647_716_048_689,
        120_639_521_369_162,
    ],
    [1_211_206_412, 39_065_778, 1_014_642, 21_676],
);

const HALF: u64 = 1 << 63;

/// π²/2, Q61; rounded down.
const HALF_PI_SQUARED: u64 = 11_378_879_155_978_302_162;

/// A change of velocity, as it is seen from that end of the ramp at which the phase is anchored.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sine {
    /// The acceleration of the linear ramp in its place, Q96 steps per tick².
    mean: i128,
    /// From the velocity at the anchor to that at the other end, Q96 steps per tick.
    change: i128,
    /// How long it takes.
    time: Offset,
    /// How many bits that has: n. And 2ⁿ⁺⁶³ by it, rounded down.
    bits: u32,
    inverse: u64,
    /// The change times the time, Q64 steps.
    way: i128,
}

impl Sine {
    /// The ramp in the place of a linear one, of half of an acceleration, that takes `time`, which is not 0.
    pub(super) fn new(half_acceleration: i128, time: Offset) -> Self {
        let falls = half_acceleration < 0;
        let change = half_acceleration.unsigned_abs().wrapping_mul(time) >> 31;
        let way = Wide::product(change, time).shifted_wrapping(64);
        let bits = 128u32.wrapping_sub(time.leading_zeros());
        let exponent = bits.wrapping_add(63);
        let digits = exponent.saturating_sub(96) >> 5;
        let one = 1u128 << (exponent.wrapping_sub(digits << 5) & 127);
        Self {
            mean: half_acceleration.wrapping_mul(2),
            change: with_sign(change, falls),
            time,
            bits,
            inverse: u64::try_from(quotient(one, digits, time)).unwrap_or(u64::MAX),
            way: with_sign(way, falls),
        }
    }

    /// What the ramp adds to position and velocity at `away` ticks (Q32) behind the anchor, or before it if that is negative: Q96.
    pub(super) fn at(&self, away: i128) -> (i128, i128) {
        let s = self.part(away);
        self.moved(way(s), speed(s), away < 0)
    }

    /// The same, and the acceleration there, Q96 steps per tick².
    pub(super) fn at_with_acceleration(&self, away: i128) -> (i128, i128, i128) {
        let s = self.part(away);
        let gone = way(s);
        let (way, change) = self.moved(gone, speed(s), away < 0);
        (way, change, self.pull(s, gone, away < 0))
    }

    /// The acceleration there.
    pub(super) fn acceleration(&self, away: i128) -> i128 {
        let s = self.part(away);
        self.pull(s, way(s), away < 0)
    }

    /// Way and change of velocity where f(s) and sin² are these.
    fn moved(&self, gone: u64, risen: u64, before: bool) -> (i128, i128) {
        let (way_low, way_high) = halves(self.way.unsigned_abs(), gone);
        let (low, high) = halves(self.change.unsigned_abs(), risen);
        (
            with_sign(
                (way_high << 32).wrapping_add(way_low >> 32),
                (self.way < 0) != before,
            ),
            with_sign(high.wrapping_add(low >> 64), self.change < 0),
        )
    }

    /// The acceleration at a part of the ramp's time where f(s) is this.
    fn pull(&self, s: u64, gone: u64, before: bool) -> i128 {
        // π/2·sin(π·s) = π²/2·(s − 2·f(s)), Q61.
        let bent = s.wrapping_sub(gone.wrapping_mul(2));
        let (low, high) = halves(self.mean.unsigned_abs(), times(bent, HALF_PI_SQUARED));
        let acceleration = (high << 3).wrapping_add(low >> 61);
        with_sign(acceleration, (self.mean < 0) != before)
    }

    /// A sixth of the jerk with which it begins and ends, Δv·π²/2T², Q128 steps per tick³: the least at which it can be left without going
    /// beyond its velocity. Rounded up, and cut to [`TOP_SIXTH_JERK`].
    pub(super) fn sixth_jerk(&self) -> Fine {
        let jerk = Wide::product(self.mean.unsigned_abs(), self.inverse.into());
        // It is 0 if the time cannot be told.
        let jerk = jerk.shifted(self.bits.wrapping_sub(1).max(1));
        let jerk = jerk.map_or(TOP_SIXTH_JERK << 1, |jerk| jerk.min(TOP_SIXTH_JERK << 1));
        // π²/12 = 0.8225, and 27/32 = 0.8438.
        (jerk.wrapping_mul(27) >> 5)
            .wrapping_add(1)
            .min(TOP_SIXTH_JERK)
    }

    /// 2·(1 − cos θ) in Q64, where θ is how far the sine of the acceleration goes in so many ticks: the second difference of a sine is less than
    /// nothing by that part of it. `None` for a 32nd of the ramp or more.
    pub(super) fn bend(&self, length: u32) -> Option<u64> {
        let s = self.part(i128::from(length) << 32);
        if s >> 59 != 0 {
            return None;
        }
        // A half in Q61 is as much as the whole in Q60.
        let square = times(s, s);
        let square = (u128::from(square).wrapping_mul(HALF_PI_SQUARED.into()) >> 60) as u64;
        // θ² − θ⁴/12 + θ⁶/360 − θ⁸/20160
        let series = |less: u64, divisor: u64| {
            let term = times(square, less).checked_div(divisor).unwrap_or(0);
            u64::MAX.wrapping_sub(term)
        };
        Some(times(square, series(series(series(u64::MAX, 56), 30), 12)))
    }

    /// How much of the ramp's time that is, Q64.
    fn part(&self, away: i128) -> u64 {
        let away = away.unsigned_abs().min(self.time);
        let below = self.bits.saturating_sub(64);
        let away = (away >> (below & 127)) as u64;
        let part = u128::from(away).wrapping_mul(self.inverse.into());
        let shift = self.bits.wrapping_sub(below).wrapping_sub(1) & 63;
        u64::try_from(part >> shift).unwrap_or(u64::MAX)
    }
}

/// The products of both halves of a number with a factor.
fn halves(number: u128, factor: u64) -> (u128, u128) {
    let factor = u128::from(factor);
    (
        u128::from(number as u64).wrapping_mul(factor),
        (number >> 64).wrapping_mul(factor),
    )
}

fn with_sign(magnitude: u128, negative: bool) -> i128 {
    let value = magnitude.cast_signed();
    if negative {
        value.wrapping_neg()
    } else {
        value
    }
}

/// f(s), Q64.
fn way(s: u64) -> u64 {
    if s > HALF {
        // f(s) − f(1 − s) = s − ½
        return s.wrapping_sub(HALF).wrapping_add(way(s.wrapping_neg()));
    }
    let square = times(s, s);
    times(times(s, square), series(&WAY, square))
}

/// sin²(π·s/2), Q64.
fn speed(s: u64) -> u64 {
    if s > HALF {
        // sin² + cos² = 1
        return u64::MAX.wrapping_sub(speed(s.wrapping_neg()));
    }
    let square = times(s, s);
    times(square, series(&SPEED, square)) << 3
}

/// c₁ − c₂u + c₃u² − …, for u up to a quarter.
fn series((coefficients, last): &Series, u: u64) -> u64 {
    let short = u64::from((u >> 32) as u32);
    let rest = last.iter().rev().fold(0, |sum, c| {
        let part = short.wrapping_mul(u64::from(sum)) >> 32;
        c.wrapping_sub(part as u32)
    });
    let rest = u64::from(rest) << 12;
    (coefficients.iter().rev()).fold(rest, |sum, c| c.wrapping_sub(times(u, sum)))
}

/// The product of two fractions.
fn times(a: u64, b: u64) -> u64 {
    (u128::from(a).wrapping_mul(b.into()) >> 64) as u64
}

#[cfg(test)]
mod tests {
    use super::{HALF, Sine, speed, way};
    use crate::plan::phase::half_peak;
    use core::f64::consts::PI;
    use proptest::prelude::*;

    fn fraction(bits: u64) -> f64 {
        bits as f64 / 2f64.powi(64)
    }

    #[test]
    fn the_ends_and_the_middle_are_exact() {
        assert_eq!((way(0), speed(0)), (0, 0));
        assert!(speed(HALF).abs_diff(HALF) <= 16);
        assert!(way(u64::MAX).abs_diff(HALF) <= 2);
        assert!(speed(u64::MAX) > u64::MAX - 2);
    }

    proptest! {
        #[test]
        fn the_series_are_the_functions(s: u64) {
            let x = fraction(s);
            prop_assert!((fraction(speed(s)) - (PI * x / 2.0).sin().powi(2)).abs() < 1e-15);
            prop_assert!((fraction(way(s)) - (x / 2.0 - (PI * x).sin() / (2.0 * PI))).abs() < 1e-15);
        }

        #[test]
        fn neither_ever_falls(s: u64, step in 0u64..1 << 40) {
            let next = s.saturating_add(step);
            prop_assert!(way(next) + 2 >= way(s));
            prop_assert!(speed(next).saturating_add(16) >= speed(s));
        }

        #[test]
        fn the_acceleration_is_the_slope_of_the_velocity(part in 1u32..1 << 20, change in 1i128 << 70..1i128 << 90) {
            let ticks = 1i128 << 20;
            let half = change >> 21;
            let sine = Sine::new(half, (ticks << 32).cast_unsigned());
            let at = i128::from(part) << 32;
            let slope = sine.at(at + (8 << 32)).1 - sine.at(at - (8 << 32)).1;
            let slope = slope as f64 / 16.0;
            // That of the linear ramp, halved.
            let peak = half_peak(half) as f64 * 2.0;
            prop_assert!((sine.acceleration(at) as f64 - slope).abs() < 1e-4 * peak);
            prop_assert!(slope <= peak);
            prop_assert_eq!(sine.acceleration(-at), -sine.acceleration(at));
        }
    }
}
