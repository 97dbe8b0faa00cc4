//! The braking distance, and the velocity from which the motor stops within a distance; on the safe side where the jerk is limited.
//!
//! A jerk-limited ramp from v takes the time v/d + d/j, and covers v/2 times that. Where d is not reached it is less than this formula says for any
//! d, so d is cut to what keeps the numbers within 64 bits.

use motion::{Limits, Ramps, SignedSpeed, Speed, isqrt, low};

use crate::actuator::Actuator;
use crate::motor::Motor;
use crate::travel::Travel;

/// A ramp on which the motor slows down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Ramp {
    /// The limits of the motion that it belongs to.
    pub(super) limits: Limits,
    pub(super) ramps: Ramps,
}

/// How the motor is to slow down so that it does not pass the end of the travel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Braking {
    pub(super) ramp: Ramp,
    /// It is not the ramp that was asked for.
    pub(super) is_harder: bool,
    /// The motor passes the end even on the hardest ramp that is allowed.
    pub(super) passes: bool,
    /// The hardest ramp that is allowed, in steps/s²; 0 where none is needed.
    hardest: u32,
}

impl Braking {
    /// Tells the motor the hardest ramp on which its new motion may end. It does not count for later motions.
    pub(super) const fn taken(self, motor: &mut Motor<impl Actuator>) {
        if self.hardest > 0 {
            motor.set_hardest(self.hardest);
        }
    }

    /// This, with the hardest ramp of `other` if that is harder: `other` has chosen the ramp that this one was asked with.
    pub(super) fn after(self, other: Self) -> Self {
        Self {
            hardest: self.hardest.max(other.hardest),
            ..self
        }
    }
}

/// The ramp on which the motor, from whatever it does now, comes to rest between two positions, in steps: the one that is asked for; or a
/// linear one, as hard as needed, up to `hardest` steps/s², or to the ramp that the motion under way is planned with.
///
/// The motion ends at `target` if it ends.
pub(super) fn between(
    motor: &Motor<impl Actuator>,
    target: Option<i64>,
    (low, high): (i64, i64),
    asked: Ramp,
    hardest: u32,
) -> Braking {
    let as_asked = Braking {
        ramp: asked,
        is_harder: false,
        passes: false,
        hardest: 0,
    };
    let velocity = motor.committed_velocity();
    let deceleration = asked.limits.deceleration;
    let rest =
        |ramp: &Ramp| motor.stop_preview(ramp.limits.deceleration, ramp.ramps, Some(&asked.limits));
    // What runs ahead of a mean may have turned already.
    let reverse = match asked.ramps {
        Ramps::MovingAverage(_) if deceleration > 0 && velocity != SignedSpeed::ZERO => {
            rest(&asked) < motor.committed_position()
        }
        _ => velocity.bits() < 0,
    };
    let end = if reverse { low } else { high };
    let is_open = end == Travel::NONE.increments.0 || end == Travel::NONE.increments.1;
    if velocity == SignedSpeed::ZERO || is_open || deceleration == 0 {
        return as_asked;
    }
    let beyond = |position: i64| {
        let beyond = position.saturating_sub(end);
        if reverse {
            beyond.saturating_neg()
        } else {
            beyond
        }
    };
    // The motor may be on its way to the next step.
    let available = beyond(motor.committed_position()).saturating_add(1);
    let available = available.min(0).unsigned_abs();
    let speed = velocity.unsigned_abs();
    let accelerations = (0, deceleration);
    if asked.ramps == Ramps::Linear && distance(speed, accelerations, asked.ramps) < available {
        return as_asked;
    }
    // sin² braking for a target is finished as it was begun; for another one it is left, and so is what is no sin².
    let own = motor.deceleration();
    let is_finished = asked.ramps == Ramps::SinSquared
        && motor.is_ending()
        && deceleration >= own
        && target == Some(motor.destination());
    let first = if is_finished {
        motor.stop_preview(own, asked.ramps, None)
    } else {
        rest(&asked)
    };
    if beyond(first) <= 0 {
        return as_asked;
    }
    let hardest = hardest.max(motor.hardest()).max(deceleration);
    let mut ramp = Ramp {
        limits: Limits {
            deceleration: needed(speed, available).max(deceleration).min(hardest),
            ..asked.limits
        },
        ramps: Ramps::Linear,
    };
    let mut past = beyond(rest(&ramp));
    if past > 0 {
        // On the limit what is available is part of a step.
        ramp.limits.deceleration = hardest;
        past = beyond(rest(&ramp));
    }
    Braking {
        ramp,
        is_harder: true,
        // A stop ends on the next whole step.
        passes: past > 1,
        hardest,
    }
}

/// The deceleration of a linear ramp from a velocity to rest within so many steps, in steps/s².
fn needed(velocity: Speed, steps: u64) -> u32 {
    let velocity = rounded_up(velocity);
    let square = velocity.saturating_mul(velocity);
    let deceleration = square.div_ceil(steps.saturating_mul(2).max(1));
    u32::try_from(deceleration).unwrap_or(u32::MAX)
}

/// In steps/s.
const fn rounded_up(velocity: Speed) -> u64 {
    (velocity.bits() >> 32).saturating_add((low::u32(velocity.bits()) != 0) as u64)
}

/// The longest window that a mean may have with these accelerations, up and down, in microseconds; 0 for other ramps.
pub(super) fn window((acceleration, deceleration): (u32, u32), ramps: Ramps) -> u64 {
    let Ramps::MovingAverage(jerk) = ramps else {
        return 0;
    };
    let change = u64::from(acceleration).saturating_add(deceleration.into());
    let change = change.saturating_mul(1_000_000);
    change.div_ceil(jerk.max(1).into())
}

/// What the jerk adds to the time of a ramp, as a velocity: d²/j, or 2 · d · W where W, (a + d)/j, is the window of a mean, in force for at least so
/// many microseconds; and the deceleration that counts. In steps/s and steps/s².
///
/// At a steady velocity the plan is v·W/2 ahead of the mean. But where it has just got to v, it may be v·W ahead: it has had v for that long at
/// most.
fn rounding(accelerations: (u32, u32), ramps: Ramps, window: u64) -> (u64, u64) {
    let deceleration = u64::from(accelerations.1);
    match ramps {
        // A sin² ramp from a steady velocity goes as far as a linear one.
        Ramps::Linear | Ramps::SinSquared => (0, deceleration),
        #[cfg(feature = "limited-jerk")]
        Ramps::JerkLimited(jerk) => {
            let jerk = u64::from(jerk.max(1));
            let deceleration = deceleration.min(isqrt(jerk << 31).into());
            let square = deceleration.saturating_mul(deceleration);
            let velocity = square.checked_div(jerk).unwrap_or(0).saturating_add(1);
            (velocity, deceleration)
        }
        Ramps::MovingAverage(_) => {
            let window = window.max(self::window(accelerations, ramps));
            let twice = deceleration.saturating_mul(2);
            let velocity = twice.saturating_mul(window);
            (velocity.div_ceil(1_000_000), deceleration)
        }
    }
}

/// The distance to stop from a velocity with these accelerations, up and down, in steps.
pub(super) fn distance(velocity: Speed, accelerations: (u32, u32), ramps: Ramps) -> u64 {
    // A distance too long is on the safe side.
    let velocity = rounded_up(velocity);
    let (rounding, deceleration) = rounding(accelerations, ramps, 0);
    velocity
        .saturating_mul(velocity.saturating_add(rounding))
        .checked_div(deceleration.saturating_mul(2))
        .unwrap_or(0)
}

/// The velocity with which the motor may pass a target and still stop within so many steps behind it, a whole number of steps/s. The next command
/// comes a few control ticks after the target has been passed, so four milliseconds at this velocity are kept in reserve. A mean has a window of so
/// many microseconds at least.
pub(super) fn stoppable(accelerations: (u32, u32), ramps: Ramps, window: u64, steps: u64) -> Speed {
    let rounded = rounding(accelerations, ramps, window);
    let reserve = stopped_within(steps, rounded) / 250;
    let velocity = stopped_within(steps.saturating_sub(reserve), rounded);
    Speed::per_second(u32::try_from(velocity).unwrap_or(u32::MAX))
}

/// The velocity from which a ramp with this rounding and deceleration takes so many steps: v² + v·d²/j = 2·d·steps.
#[inline(never)]
fn stopped_within(steps: u64, (rounding, deceleration): (u64, u64)) -> u64 {
    let square = rounding.saturating_mul(rounding);
    let sum = deceleration.saturating_mul(8).saturating_mul(steps);
    let root = u64::from(isqrt(sum.saturating_add(square)));
    root.saturating_sub(rounding) / 2
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The distance of a ramp to rest, by the formulas.
    fn exact(velocity: f64, (acceleration, deceleration): (f64, f64), ramps: Ramps) -> f64 {
        match ramps {
            #[cfg(feature = "limited-jerk")]
            Ramps::JerkLimited(jerk) => {
                let jerk = f64::from(jerk);
                if velocity >= deceleration * deceleration / jerk {
                    velocity / 2.0 * (velocity / deceleration + deceleration / jerk)
                } else {
                    velocity * (velocity / jerk).sqrt()
                }
            }
            // The plan is a window ahead.
            Ramps::MovingAverage(jerk) => {
                let window = (acceleration + deceleration) / f64::from(jerk);
                velocity / 2.0 * (velocity / deceleration + 2.0 * window)
            }
            _ => velocity * velocity / 2.0 / deceleration,
        }
    }

    fn any_ramps() -> impl Strategy<Value = Ramps> {
        (0..4, 1u32..).prop_map(|(number, jerk)| match number {
            0 => Ramps::Linear,
            1 => Ramps::SinSquared,
            #[cfg(feature = "limited-jerk")]
            2 => Ramps::JerkLimited(jerk),
            _ => Ramps::MovingAverage(jerk),
        })
    }

    proptest! {
        #[test]
        fn the_motor_stops_within_the_distance(
            steps in 0u64..1 << 32,
            accelerations in (1u32..100_000_000, 1u32..100_000_000),
            ramps in any_ramps(),
        ) {
            let velocity = stoppable(accelerations, ramps, 0, steps);
            let (a, d) = accelerations;
            let goes = exact(velocity.whole().into(), (a.into(), d.into()), ramps);
            prop_assert!(goes <= steps as f64, "{goes} steps of {steps}");
            let said = distance(velocity, accelerations, ramps);
            prop_assert!(said as f64 + 1.0 >= goes, "{said} is less than {goes}");
        }
    }

    #[test]
    fn the_ramp_that_is_needed_is_no_longer_than_the_distance() {
        for (velocity, steps) in [(10_000_u32, 600), (1, 1), (4_000_000_000, 3), (7, u64::MAX)] {
            let deceleration = needed(velocity.into(), steps);
            assert!(
                distance(velocity.into(), (0, deceleration), Ramps::Linear) <= steps
                    || deceleration == u32::MAX,
                "{velocity} steps/s, {steps} steps"
            );
        }
        assert_eq!(needed(10_000.into(), 500), 100_000);
        assert_eq!(needed(10.into(), 0), 100);
    }

    #[test]
    fn a_linear_stop_is_the_root_of_twice_the_ramp() {
        assert_eq!(stoppable((0, 50_000), Ramps::Linear, 0, 1000), 9_797.into());
        assert_eq!(distance(10_000.into(), (0, 50_000), Ramps::Linear), 1000);
    }
}
