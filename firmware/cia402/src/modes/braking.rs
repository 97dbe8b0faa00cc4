//! How far a motor goes while it brakes, and how fast it may be to stop within a distance; on the safe side where the jerk is limited.
//!
//! A jerk-limited ramp from v takes v/d + j⁻¹·d, over v/2 of that. Where d is not reached it is less than this formula says for any
//! d, so d is cut to what keeps the numbers within 64 bits.

use motion::{Ramps, Speed};

/// What the jerk adds to the time of a ramp, as a velocity: d²/j; and the deceleration that counts. In steps/s and steps/s².
fn rounding(deceleration: u32, ramps: Ramps) -> (u64, u64) {
    let deceleration = u64::from(deceleration);
    match ramps {
        // A sin² ramp from a steady velocity goes as far as a linear one.
        Ramps::Linear | Ramps::SinSquared => (0, deceleration),
        Ramps::JerkLimited(jerk) => {
            let jerk = u64::from(jerk.max(1));
            let deceleration = deceleration.min((jerk << 31).isqrt());
            let square = deceleration.saturating_mul(deceleration);
            let velocity = square.checked_div(jerk).unwrap_or(0).saturating_add(1);
            (velocity, deceleration)
        }
    }
}

/// The way to stop from a velocity, in steps.
pub(super) fn way(velocity: Speed, deceleration: u32, ramps: Ramps) -> u64 {
    // Rounded up: a way too long is on the safe side.
    let velocity = (velocity.bits() >> 32).saturating_add(u64::from(velocity.bits() as u32 != 0));
    let (rounding, deceleration) = rounding(deceleration, ramps);
    velocity
        .saturating_mul(velocity.saturating_add(rounding))
        .checked_div(deceleration.saturating_mul(2))
        .unwrap_or(0)
}

/// The velocity with which the motor may pass a target and still stop within so many steps behind it, a whole number of steps/s. The next command
/// comes a few control ticks after the target has been passed, so four milliseconds at this velocity are kept in reserve.
pub(super) fn stoppable(deceleration: u32, ramps: Ramps, steps: u64) -> Speed {
    let (rounding, deceleration) = rounding(deceleration, ramps);
    // v² + v·d²/j = 2·d·steps
    let velocity = |steps: u64| {
        let square = rounding.saturating_mul(rounding);
        let sum = deceleration.saturating_mul(8).saturating_mul(steps);
        let root = sum.saturating_add(square).isqrt();
        root.saturating_sub(rounding) / 2
    };
    let reserve = velocity(steps) / 250;
    let velocity = velocity(steps.saturating_sub(reserve));
    Speed::per_second(u32::try_from(velocity).unwrap_or(u32::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The way of a ramp to rest, by the formulas.
    fn exact(velocity: f64, deceleration: f64, ramps: Ramps) -> f64 {
        match ramps {
            Ramps::JerkLimited(jerk) => {
                let jerk = f64::from(jerk);
                if velocity >= deceleration * deceleration / jerk {
                    velocity / 2.0 * (velocity / deceleration + deceleration / jerk)
                } else {
                    velocity * (velocity / jerk).sqrt()
                }
            }
            _ => velocity * velocity / 2.0 / deceleration,
        }
    }

    proptest! {
        #[test]
        fn the_motor_stops_within_the_way(
            steps in 0u64..1 << 32,
            deceleration in 1u32..100_000_000,
            ramps in prop_oneof![
                Just(Ramps::Linear),
                Just(Ramps::SinSquared),
                (1u32..).prop_map(Ramps::JerkLimited),
            ],
        ) {
            let velocity = stoppable(deceleration, ramps, steps);
            let goes = exact(velocity.whole().into(), deceleration.into(), ramps);
            prop_assert!(goes <= steps as f64, "{goes} steps of {steps}");
            let said = way(velocity, deceleration, ramps);
            prop_assert!(said as f64 + 1.0 >= goes, "{said} is less than {goes}");
        }
    }

    #[test]
    fn a_linear_stop_is_the_root_of_twice_the_ramp() {
        assert_eq!(stoppable(50_000, Ramps::Linear, 1000), 9_797.into());
        assert_eq!(way(10_000.into(), 50_000, Ramps::Linear), 1000);
    }
}
