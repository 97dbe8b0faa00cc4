//! Positions are counted modulo 2³²: motions go on across the end of that span.

use super::behaviour::{T01, fly, ms};
use super::{FAST, HZ, axis, run};
use crate::{Limits, Ramps};

#[test]
fn a_velocity_crosses_the_end_of_the_span() {
    let (mut axis, mut sink) = axis(FAST);
    axis.set_position(i32::MAX.into());
    sink.position = i32::MAX.into();
    axis.ramp_to(50_000.into(), T01).unwrap();
    sink.follow(&axis);
    fly(&mut axis, &mut sink, ms(200));
    axis.stop(500_000).unwrap();
    sink.follow(&axis);
    run(&mut axis, &mut sink);
    // The judge counts without wrapping.
    assert!(sink.position > i64::from(i32::MAX) + 9_000);
    assert_eq!(axis.committed_position(), sink.position - (1 << 32));
    // And back over the end.
    axis.ramp_to((-50_000).into(), T01).unwrap();
    sink.follow(&axis);
    fly(&mut axis, &mut sink, ms(500));
    axis.stop(500_000).unwrap();
    sink.follow(&axis);
    run(&mut axis, &mut sink);
    assert!(sink.position < i64::from(i32::MAX));
    assert_eq!(axis.committed_position(), sink.position);
}

#[test]
fn a_move_goes_on_across_the_end_of_the_span() {
    let (mut axis, mut sink) = axis(FAST);
    for (from, distance) in [
        (i64::from(i32::MAX) - 10, 1_000_i64),
        (i64::from(i32::MIN) + 10, -1_000),
    ] {
        axis.set_position(from);
        sink.position = from;
        axis.move_to(from + distance, T01).unwrap();
        run(&mut axis, &mut sink);
        assert_eq!(sink.position, from + distance);
        assert_eq!(
            axis.committed_position(),
            i64::from((from + distance) as i32)
        );
    }
}

#[test]
fn a_target_is_as_far_as_its_number_says_where_the_plan_has_wrapped() {
    let forms = [
        (Ramps::Linear, 1_000),
        (Ramps::SinSquared, 1_000),
        (Ramps::MovingAverage(5_000_000), 100_000),
    ];
    let limited = Ramps::limited(5_000_000).map(|ramps| (ramps, 1_000));
    for (ramps, velocity) in forms.into_iter().chain(limited) {
        let limits = Limits {
            velocity: velocity.into(),
            ..T01
        };
        let distance = i64::from(velocity) / 2;
        for forward in [true, false] {
            let towards = |distance: i64| if forward { distance } else { -distance };
            let (mut axis, mut sink) = axis(FAST);
            axis.set_ramps(ramps);
            let begin = if forward {
                (1 << 31) - 1 - distance
            } else {
                distance - (1 << 31)
            };
            axis.set_position(begin);
            let far = begin + towards(2 * distance);
            axis.move_to(far, limits).unwrap();
            let mut apart = 0;
            for _ in 0..10_000 {
                axis.advance(&mut sink).unwrap();
                let planned = axis.plan.exact_at(axis.horizon()).position;
                let committed = axis.committed_position();
                if (planned.steps() < 0) != (committed < 0) {
                    apart += 1;
                    for distance in [2 * distance, 50, -50] {
                        let mut axis = axis.clone();
                        let target = committed + towards(distance);
                        axis.move_to(target, limits).unwrap();
                        let end = axis.plan.end().unwrap();
                        let gone = axis.plan.state_at(end).position.whole_steps();
                        assert_eq!(gone as i32, target as i32, "{ramps:?}, {distance}");
                        let time = end - axis.horizon();
                        assert!(
                            time < 4 * u64::from(HZ),
                            "{ramps:?}, {distance}: {time} ticks"
                        );
                    }
                }
                sink.play(u64::from(axis.stepper.time_slice() / 4));
            }
            assert!(apart > 0, "{ramps:?}, {forward}");
        }
    }
}
