//! The figures are within their goals.

use canopen::Duration;
use motion::Ramps;

use super::count::{Counted, long_moves, sequences};
use super::reaction::{Order, Profile, longest};
use super::{duration, position, rate};

#[test]
fn no_pulse_is_too_many_or_too_few() {
    // Four moves, one with each kind of ramps.
    let moves = long_moves(13_000_000);
    assert!(moves.pulses >= 13_000_000);
    assert_eq!((moves.error, moves.underruns), (0, 0));
    let Counted { pulses, error, .. } = sequences(40);
    assert!(pulses > 1_000);
    assert_eq!(error, 0);
}

#[test]
fn moves_end_on_the_tick() {
    let linear = duration::linear();
    let smooth = duration::jerk_limited();
    assert_eq!((linear.moves, smooth.moves), (22, 6));
    assert!(linear.ticks <= 1.0, "{linear:?}");
    assert!(smooth.ticks <= 1.0, "{smooth:?}");
}

#[test]
fn pulses_leave_where_the_plan_has_them() {
    let jerk = 1_000_000_000;
    for ramps in [
        Ramps::Linear,
        Ramps::SinSquared,
        Ramps::JerkLimited(jerk),
        Ramps::MovingAverage(jerk),
    ] {
        for (velocity, goal) in [(100_000, 0.1), (500_000, 0.1), (1_000_000, 0.5)] {
            let error = position::greatest_error(velocity, super::STEEP, ramps);
            assert!(
                0.0 < error && error <= goal,
                "{ramps:?} {velocity}: {error}"
            );
        }
    }
}

#[test]
fn a_million_steps_a_second_on_a_full_bus() {
    let served = rate::at(1_000_000, 1).unwrap();
    assert_eq!((served.rate, served.error), (1_000_000, 0));
    assert!(served.samples >= 2_000 && served.transfers >= 2_000);
    assert!(served.frames > 10_000);
}

#[test]
fn the_ceiling_is_that_of_the_driver() {
    let served = rate::at(4_941_176, 1).unwrap();
    assert_eq!((served.rate, served.error), (4_941_176, 0));
}

#[test]
fn a_stop_is_felt_within_a_millisecond_of_its_frame() {
    for (order, profile, phase, ramp) in [
        (Order::Halt, Profile::Linear, 0, 5_000_000),
        (Order::Halt, Profile::SinSquared, 200, 5_000_000),
        (Order::QuickStop, Profile::Linear, 125, 4_960_000),
        (Order::QuickStop, Profile::JerkLimited, 100, 5_000_000),
        (Order::DisableOperation, Profile::Linear, 150, 4_970_000),
        (Order::DisableOperation, Profile::SinSquared, 25, 5_000_000),
    ] {
        let reaction = longest(order, profile, Duration::micros(phase), ramp).unwrap();
        let case = format!("{order:?}, {profile:?}: {reaction:?}");
        assert!(reaction.from_frame <= 1_000, "{case}");
        // It is not felt before the pulses have left that are handed out.
        assert!(reaction.from_frame > 500, "{case}");
    }
}
