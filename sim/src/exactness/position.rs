//! How far a pulse is from where the plan has it.
//!
//! A pulse belongs where the plan crosses the middle between two whole steps. How far the plan is from there when the pulse rises at
//! the pin is its error.

use motion::advanced_timer::Ring;
use motion::{Clock, Limits, Plan, PulseSink, State};

use super::FAST;
use crate::timer_model::Judge;
use crate::timer_model::rig::{HZ, Rig, SEGMENT};

/// The greatest error in steps of a move from rest to rest that reaches `velocity` (steps/s) with ramps of so many steps/s², and
/// keeps it for a fifth of a second.
///
/// # Panics
/// If a pulse is missing.
pub fn greatest_error(velocity: u32, ramp: u32) -> f64 {
    let limits = Limits {
        velocity: velocity.into(),
        acceleration: ramp,
        deceleration: ramp,
    };
    let speed = u64::from(velocity);
    let target = (speed * speed / u64::from(ramp) + speed / 5).cast_signed();
    let clock = Clock::new(HZ).expect("a clock that motion can use");
    let plan = Plan::move_to(clock, 0, State::default(), target, limits).expect("a move");

    let ring = Ring::new();
    let mut rig = Rig::new(&ring, FAST, Judge::new(FAST).logging());
    rig.axis.move_to(target, limits).expect("a move");
    rig.refill(SEGMENT.into());
    // A little silence comes before a train: the time of the pins at which the plan begins.
    let played = rig.axis.played(rig.output.pending());
    let begun = rig.model.time() - played;
    rig.finish(u64::MAX);

    let judge = rig.model.judge();
    let log = judge.log.as_deref().unwrap_or_default();
    assert_eq!(log.len(), target as usize, "pulses");
    let mut greatest = 0;
    for (step, (at, _)) in (0i64..).zip(log) {
        let middle = (step << 32) + (1 << 31);
        let there = plan.state_at(at - begun).position.bits();
        greatest = greatest.max(there.abs_diff(middle));
    }
    greatest as f64 / 2f64.powi(32)
}
