//! One step in an hour on the modelled timers, and from there to a million in a second and back.

use motion::{Axis, AxisConfig, Clock, Limits, Plan, Position, Speed, State, Velocity};

use super::{FAST, rig};
use crate::timer_model::Judge;
use crate::timer_model::rig::{HZ, Rig, TIME_SLICE};

/// One step in an hour.
pub(super) const HOURLY: Speed = Speed::from_bits((1 << 32) / 3_600);

pub(super) const fn limits(velocity: Speed) -> Limits {
    Limits {
        velocity,
        acceleration: 1_000_000_000,
        deceleration: 1_000_000_000,
    }
}

fn logging() -> Rig<'static> {
    let rig = rig(FAST);
    *rig.model.judge_mut() = Judge::new(FAST).logging();
    rig
}

/// When pulses left, in ticks.
fn log(rig: &Rig<'_>) -> Vec<u64> {
    let judge = rig.model.judge();
    judge.log.iter().flatten().map(|(at, _)| *at).collect()
}

fn refill(rig: &mut Rig<'_>, refills: u32) {
    for _ in 0..refills {
        rig.refill(TIME_SLICE.into());
        assert_eq!(rig.underruns, 0);
    }
}

#[test]
fn a_step_in_an_hour_leaves_at_its_time() {
    // The last two seconds of the hour.
    let mut rig = logging();
    let clock = Clock::new(HZ).unwrap();
    let before = 2 * i64::try_from(HOURLY.bits()).unwrap();
    let from = State {
        position: Position::from_bits((1 << 31) - before),
        velocity: Velocity::from_speed(clock, HOURLY.signed(false)),
    };
    let plan = Plan::velocity(clock, 0, from, HOURLY.signed(false), limits(HOURLY)).unwrap();
    let config = AxisConfig {
        clock,
        time_slice: TIME_SLICE,
        timing: FAST,
    };
    rig.axis = Axis::on_plan(config, plan);
    refill(&mut rig, 3 * 4_000);
    let pulses = log(&rig);
    assert_eq!(pulses.len(), 1);
    // The timer begins with a silence of its own, much less than a millisecond.
    let late = pulses[0].checked_sub(2 * u64::from(HZ)).unwrap();
    assert!(late < u64::from(HZ) / 1_000, "{late} ticks late");
    // It ends on the ramp, with the step that it has made.
    rig.axis.stop(1_000).unwrap();
    rig.finish(10);
    rig.account();
    assert_eq!(rig.axis.committed_position(), 1);
}

#[test]
fn from_a_step_in_an_hour_straight_to_a_megahertz_and_back() {
    let mut rig = logging();
    let fast = Speed::per_second(1_000_000);
    rig.axis
        .ramp_to(HOURLY.signed(false), limits(HOURLY))
        .unwrap();
    refill(&mut rig, 4_000);
    assert!(log(&rig).is_empty());
    for reverse in [false, true] {
        let so_far = log(&rig).len();
        let ordered = rig.model.time();
        rig.axis
            .ramp_to(fast.signed(reverse), limits(fast))
            .unwrap();
        refill(&mut rig, 80);
        let pulses = log(&rig).split_off(so_far);
        let felt = pulses[0] - ordered;
        assert!(
            felt < u64::from(HZ) / 1_000,
            "{felt} ticks to the first pulse"
        );
        let gaps = pulses.windows(2).skip(pulses.len() / 2);
        assert!(gaps.into_iter().all(|pair| pair[1] - pair[0] == 168));
        rig.axis
            .ramp_to(HOURLY.signed(reverse), limits(HOURLY))
            .unwrap();
        refill(&mut rig, 40);
        let so_far = log(&rig).len();
        refill(&mut rig, 4_000);
        assert_eq!(log(&rig).len(), so_far, "a second is no hour");
        assert!(!rig.axis.is_at_rest());
    }
    rig.axis.stop(1_000_000).unwrap();
    rig.finish(10);
    rig.account();
}

#[test]
fn a_halt_in_the_silence_of_an_hour_is_done_within_a_millisecond() {
    let mut rig = logging();
    rig.axis
        .ramp_to(HOURLY.signed(false), limits(HOURLY))
        .unwrap();
    refill(&mut rig, 8_000);
    rig.axis.stop(1_000).unwrap();
    // Four refills are a millisecond.
    rig.finish(4);
    rig.account();
    assert!(log(&rig).is_empty());
}
