//! A tracking observer: angle, speed and acceleration out of an angle in whole counts.
//!
//! Each period it goes on by its speed and acceleration, and is corrected by shares of how far the measured angle is away. The shares are those of a
//! filter with three equal poles, so what turns evenly, or speeds up evenly, is followed without an error.

use crate::Angle;
use crate::motor::Implausible;
use crate::number::{fade, is_within, limit};

/// Radians of a part of 2³² of a turn.
const RADIANS: f32 = core::f32::consts::TAU / 4_294_967_296.0;

/// The fastest that it goes, in parts of 2³² of a turn in a period: an eighth of a turn.
const FASTEST: i32 = 1 << 29;

/// See the module. Its angle is electrical, its speed in electrical rad/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observer {
    shares: [f32; 3],
    by_period: f32,
    angle: Angle,
    /// In parts of 2³² of a turn a period.
    speed: f32,
    /// By how much it is faster half a period later: half of the acceleration.
    faster: f32,
}

impl Observer {
    /// With a bandwidth in rad/s and a period in s.
    ///
    /// # Errors
    /// With a period outside 5 µs to 10 ms, or a bandwidth outside 1 rad/s to 1 / period.
    pub fn new(bandwidth: f32, period: f32) -> Result<Self, Implausible> {
        let is_one = is_within(period, 5e-6, 1e-2) && is_within(bandwidth, 1.0, 1.0 / period);
        if !is_one {
            return Err(Implausible);
        }
        let pole = fade(bandwidth, period);
        let rest = 1.0 - pole;
        Ok(Self {
            shares: [
                1.0 - pole * pole * pole,
                1.5 * rest * rest * (1.0 + pole),
                0.5 * rest * rest * rest,
            ],
            by_period: 1.0 / period,
            angle: Angle::ZERO,
            speed: 0.0,
            faster: 0.0,
        })
    }

    /// The rotor stands at this angle.
    pub fn stand_at(&mut self, angle: Angle) {
        (self.angle, self.speed, self.faster) = (angle, 0.0, 0.0);
    }

    /// The angle counts from elsewhere: it is greater by this.
    pub fn shift(&mut self, by: Angle) {
        self.angle = self.angle.plus(by);
    }

    /// A period has passed, and this angle was measured.
    pub fn look(&mut self, measured: Angle) {
        let [first, second, third] = self.shares;
        let on = self.speed + self.faster;
        let expected = self
            .angle
            .plus(Angle::from_bits((on as i32).cast_unsigned()));
        let away = measured.minus(expected).bits().cast_signed() as f32;
        let correction = (first * away) as i32;
        self.angle = expected.plus(Angle::from_bits(correction.cast_unsigned()));
        self.speed = on + self.faster + second * away;
        self.faster += third * away;
        // Two speeds within their bound one behind the other have less than a turn a period² between them, so that the acceleration need not be asked for itself.
        if !(-FASTEST..=FASTEST).contains(&(self.speed as i32)) {
            self.limit_speed();
        }
    }

    #[cold]
    #[inline(never)]
    fn limit_speed(&mut self) {
        self.speed = limit(self.speed, FASTEST as f32);
        self.faster = limit(self.faster, FASTEST as f32);
    }

    /// The electrical angle at the last look.
    #[inline]
    pub fn angle(&self) -> Angle {
        self.angle
    }

    /// By how much it turns in a period.
    #[inline]
    pub fn turn(&self) -> Angle {
        Angle::from_bits((self.speed as i32).cast_unsigned())
    }

    /// The electrical speed, in rad/s.
    #[inline]
    pub fn speed(&self) -> f32 {
        self.speed * (RADIANS * self.by_period)
    }

    /// The electrical acceleration, in rad/s².
    pub fn acceleration(&self) -> f32 {
        self.faster * (2.0 * RADIANS * self.by_period * self.by_period)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const PERIOD: f32 = 50e-6;

    /// Follows a motion for so long; gives how far angle and speed are away at its end.
    fn follow(
        observer: &mut Observer,
        seconds: f64,
        turns: impl Fn(f64) -> f64,
        grain: f64,
    ) -> f64 {
        let periods = (seconds / f64::from(PERIOD)) as u32;
        let mut away = 0.0;
        for period in 0..=periods {
            let true_turns = turns(f64::from(period) * f64::from(PERIOD));
            let seen = (true_turns / grain).floor() * grain + grain / 2.0;
            observer.look(Angle::from_bits(
                (seen.rem_euclid(1.0) * 4_294_967_296.0) as u32,
            ));
            let exact = Angle::from_bits((true_turns.rem_euclid(1.0) * 4_294_967_296.0) as u32);
            away = f64::from(observer.angle().minus(exact).turns().abs());
        }
        away
    }

    #[test]
    fn what_speeds_up_evenly_is_followed_without_an_error() {
        let mut observer = Observer::new(2_000.0, PERIOD).unwrap();
        let away = follow(&mut observer, 0.1, |time| 500.0 * time * time, 1e-9);
        assert!(away < 1e-5, "{away}");
        let wanted = 1_000.0 * 0.1 * core::f32::consts::TAU;
        assert!((observer.speed() / wanted - 1.0).abs() < 1e-3);
        assert!((observer.acceleration() / 6_283.0 - 1.0).abs() < 0.01);
    }

    /// Fifty pole pairs and 4,096 counts: a count is 4.4 electrical degrees; the observer sees between them.
    #[test]
    fn it_is_finer_than_a_count_while_the_rotor_turns() {
        let grain = 50.0 / 4_096.0;
        let mut observer = Observer::new(1_000.0, PERIOD).unwrap();
        let mut worst = follow(&mut observer, 0.1, |time| 200.0 * time, grain);
        for more in 0..50 {
            let begin = 0.1 + f64::from(more + 1) * f64::from(PERIOD) * 1.0;
            worst = worst.max(follow(&mut observer, 0.0, |_| 200.0 * begin, grain));
        }
        assert!(worst < grain / 3.0, "{worst} of {grain}");
        assert!((observer.speed() / (200.0 * core::f32::consts::TAU) - 1.0).abs() < 0.01);
    }

    proptest! {
        /// Whatever is measured, speed and acceleration stay numbers within what can be.
        #[test]
        fn no_angle_makes_it_faster_than_its_bound(
            measured in prop::collection::vec(any::<u32>(), 1..200),
            way: u32,
            part in 0.01..1.0_f32,
        ) {
            let mut observer = Observer::new(part / PERIOD, PERIOD).unwrap();
            let (turn, fastest) = (core::f32::consts::TAU, core::f32::consts::TAU / 8.0 / PERIOD);
            for (period, bits) in measured.into_iter().enumerate() {
                // One that always goes on, and one that jumps.
                let even = (period as u32).wrapping_mul(way);
                observer.look(Angle::from_bits(if way % 2 == 0 { even } else { bits }));
                prop_assert!(observer.speed().abs() <= fastest * 1.000_01);
                prop_assert!(observer.acceleration().abs() <= turn / (PERIOD * PERIOD));
            }
        }
    }

    #[test]
    fn bounds_of_its_data() {
        assert!(Observer::new(f32::NAN, PERIOD).is_err());
        assert!(Observer::new(1e6, PERIOD).is_err());
    }
}
