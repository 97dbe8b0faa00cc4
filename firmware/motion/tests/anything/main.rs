//! Orders made of any bytes, here of random ones; the fuzz targets `plan` and `axis` look for those that break something.

mod axis;
mod bytes;
mod plan;

use motion::{Clock, Goal, Limits, Plan, Position, Ramps, Speed, State, Ticks, Velocity};
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() }))]

    #[test]
    fn no_plan_breaks_a_rule(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        plan::check(&bytes);
    }

    #[test]
    fn the_pulses_of_an_axis_add_up(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        axis::check(&bytes);
    }
}

/// Found by the fuzz target `plan`: the last ramp lies beyond the end of 64-bit time, and began as if it lay before it.
#[test]
fn a_ramp_that_time_ends_in_begins_without_a_jump() {
    let clock = Clock::new(168_000_000).unwrap();
    let limits = Limits {
        velocity: Speed::per_second(1_000_000),
        acceleration: 1_000,
        deceleration: 1_000,
    };
    let velocity = Velocity::from_speed(clock, limits.velocity.signed(false));
    let from = State {
        position: Position::from_steps(0),
        velocity,
    };
    let start = Ticks::MAX - 1_000_000;
    for goal in [
        Goal::Rest(500_003_000),
        Goal::Velocity(Speed::ZERO.signed(false)),
    ] {
        let plan = Plan::new(clock, start, from, goal, limits, Ramps::Linear).unwrap();
        for tick in [start, start + 1, Ticks::MAX - 2] {
            let lost = velocity.bits() - plan.state_at(tick).velocity.bits();
            assert!((0..1 << 42).contains(&lost), "{goal:?}: {lost} at {tick}");
        }
    }
}

/// Found by it too.
#[test]
fn a_ramp_of_few_ticks_ends_at_its_velocity() {
    let mut bytes = vec![
        0x53, 0x53, 0, 0, 0, 0, 0, 0x25, 0x53, 0x53, 0x53, 0x53, 0, 0, 0, 0, 0,
    ];
    bytes.extend([0xe1; 17]);
    bytes.extend([0xff; 5]);
    bytes.extend([0x41; 50]);
    plan::check(&bytes);
}
