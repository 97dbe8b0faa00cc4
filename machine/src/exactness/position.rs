//! How far a pulse is from where the plan has it.
//!
//! A pulse belongs where the plan crosses the middle between two whole steps. How far the plan is from there when the pulse rises at
//! the pin is its error.

use motion::advanced_timer::Ring;
use motion::{Clock, Goal, Limits, Phase, Plan, PulseSink, Ramps, State, Ticks};

use super::FAST;
use crate::timer_model::Judge;
use crate::timer_model::rig::{HZ, Rig, TIME_SLICE};

/// The greatest error in steps of a move from rest to rest that reaches `velocity` (steps/s) with ramps of so many steps/s², and
/// keeps it for a fifth of a second. Of a moving average it is the mean from which it is counted.
///
/// # Panics
/// If a pulse is missing.
pub fn greatest_error(velocity: u32, ramp: u32, ramps: Ramps) -> f64 {
    let limits = Limits {
        velocity: velocity.into(),
        acceleration: ramp,
        deceleration: ramp,
    };
    let speed = u64::from(velocity);
    let target = (speed * speed / u64::from(ramp) + speed / 5).cast_signed();
    let clock = Clock::new(HZ).expect("a clock that motion can use");
    let goal = Goal::Rest(target);
    let plan = Plan::new(clock, 0, State::default(), goal, limits, ramps).expect("a move");

    let ring = Ring::new();
    let mut rig = Rig::new(&ring, FAST, Judge::new(FAST).logging());
    rig.axis.set_ramps(ramps);
    rig.axis.move_to(target, limits).expect("a move");
    let mean = rig.axis.mean();
    assert_eq!(mean.is_some(), matches!(ramps, Ramps::MovingAverage(_)));
    let mean: Option<Vec<Phase>> = mean.map(Iterator::collect);
    let at = |tick: Ticks| match &mean {
        Some(phases) => {
            let behind = phases.partition_point(|phase| phase.start() <= tick);
            phases[behind - 1].state_at(tick)
        }
        None => plan.state_at(tick),
    };
    rig.refill(TIME_SLICE.into());
    // A little silence comes before a train: the time of the pins at which the plan begins.
    let played = rig.axis.played(rig.output.pending());
    let begun = rig.model.time() - played;
    rig.finish(u64::MAX);

    let judge = rig.model.judge();
    let log = judge.log.as_deref().unwrap_or_default();
    assert_eq!(log.len(), target as usize, "pulses");
    let mut greatest = 0;
    for (step, (tick, _)) in (0i64..).zip(log) {
        let middle = (step << 32) + (1 << 31);
        let there = at(tick - begun).position.bits();
        greatest = greatest.max(there.abs_diff(middle));
    }
    greatest as f64 / 2f64.powi(32)
}
