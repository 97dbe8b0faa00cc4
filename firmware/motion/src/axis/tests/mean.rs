//! The invariants for an axis that follows the moving average of its plan.

use super::{FAST, HZ, axis};
use crate::axis::Axis;
use crate::{Direction, Limits, PulseSink, Ramps, Record, Speed, Ticks};
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;

/// Counts pulses, and has always played all it has.
#[derive(Debug, Default)]
struct Count {
    position: i64,
    lowest: i64,
    highest: i64,
    turns: u32,
    last: Option<Direction>,
}

impl PulseSink for Count {
    fn push(&mut self, record: Record) -> Result<(), Record> {
        if record.steps() != 0 {
            self.turns += u32::from(self.last.is_some_and(|last| last != record.direction));
            self.last = Some(record.direction);
        }
        self.position += i64::from(record.steps());
        self.lowest = self.lowest.min(self.position);
        self.highest = self.highest.max(self.position);
        Ok(())
    }

    fn pending(&self) -> Ticks {
        0
    }

    fn free(&self) -> usize {
        usize::MAX
    }
}

fn limits() -> impl Strategy<Value = Limits> {
    (1_000u32..400_000, 14u32..24, 14u32..24, any::<u16>()).prop_map(|(velocity, a, d, noise)| {
        Limits {
            velocity: velocity.into(),
            acceleration: (1 << a) + u32::from(noise),
            deceleration: (1 << d) + u32::from(noise),
        }
    })
}

/// The jerk with which the window is so many milliseconds, or twice as many where ramps come one behind the other.
fn jerk(limits: Limits, milliseconds: u32) -> u32 {
    let hardest = u64::from(limits.acceleration.max(limits.deceleration));
    u32::try_from(hardest * 1_000 / u64::from(milliseconds)).unwrap_or(u32::MAX)
}

fn averaged(jerk: u32) -> (Axis, Count) {
    let (mut axis, _) = axis(FAST);
    axis.set_ramps(Ramps::MovingAverage(jerk));
    (axis, Count::default())
}

/// Until tick `t` is committed, or to the end. The sink is always empty, which the axis says.
fn fly(axis: &mut Axis, sink: &mut Count, t: Ticks) {
    while axis.committed < t && !axis.is_at_rest() {
        let _ = axis.advance(sink);
    }
}

/// So much of the motion that was planned.
fn part(axis: &Axis, cut: u64) -> Ticks {
    let end = axis.plan.end().unwrap() + u64::from(axis.window());
    ((u128::from(end) * u128::from(cut)) >> 32) as Ticks
}

/// The span of the plan from here on, in whole steps.
fn span(axis: &Axis) -> (i64, i64) {
    let phases = axis.plan.phases();
    let corners = phases.map(|phase| phase.start()).chain(axis.plan.end());
    let steps = |t: Ticks| axis.plan.state_at(t).position.whole_steps();
    corners.fold((i64::MAX, i64::MIN), |(low, high), t| {
        (low.min(steps(t)), high.max(steps(t)))
    })
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() }))]

    /// From rest to rest there is no step back and none beyond, and never more velocity than allowed.
    #[test]
    fn i02_i03_an_average_from_rest_goes_straight_to_its_target(
        target in -100_000i64..100_000,
        limits in limits(),
        milliseconds in 1u32..1_000,
    ) {
        let (mut axis, mut sink) = averaged(jerk(limits, milliseconds));
        axis.move_to(target, limits).unwrap();
        while !axis.is_at_rest() {
            let _ = axis.advance(&mut sink);
            let speed = axis.committed_velocity().unsigned_abs();
            prop_assert!(speed <= limits.velocity, "{speed:?}");
        }
        prop_assert_eq!(sink.position, target);
        prop_assert_eq!((sink.lowest, sink.highest, sink.turns), (target.min(0), target.max(0), 0));
    }

    /// Turned on its way it goes no further than its plan, which is half a window ahead, and turns once.
    #[test]
    fn i02_i03_an_average_goes_beyond_its_ends_only_with_its_plan_and_turns_once(
        targets in (-100_000i64..100_000, -100_000i64..100_000),
        limits in limits(),
        milliseconds in 1u32..1_000,
        cut in 0u64..1 << 32,
    ) {
        let (mut axis, mut sink) = averaged(jerk(limits, milliseconds));
        axis.move_to(targets.0, limits).unwrap();
        let at = part(&axis, cut);
        fly(&mut axis, &mut sink, at);
        prop_assert_eq!(sink.turns, 0);
        axis.move_to(targets.1, limits).unwrap();
        let (low, high) = span(&axis);
        let (low, high) = (low.min(sink.lowest), high.max(sink.highest));
        fly(&mut axis, &mut sink, Ticks::MAX);
        prop_assert_eq!(sink.position, targets.1);
        prop_assert!(sink.lowest >= low && sink.highest <= high, "{sink:?} outside {low}..{high}");
        prop_assert!(sink.turns <= 1, "{} turns", sink.turns);
    }

    /// The mirror image of two orders is the mirror image of their motion, tick by tick, but for the last bits.
    #[test]
    fn i05_a_mirrored_average_is_the_mirror_image(
        targets in (-100_000i64..100_000, -100_000i64..100_000),
        limits in limits(),
        milliseconds in 1u32..1_000,
        cut in 0u64..1 << 32,
    ) {
        let (mut one, mut pulses) = averaged(jerk(limits, milliseconds));
        let (mut other, mut mirrored) = averaged(jerk(limits, milliseconds));
        one.move_to(targets.0, limits).unwrap();
        other.move_to(-targets.0, limits).unwrap();
        let at = part(&one, cut);
        let (mut is_turned, mut is_late) = (false, false);
        loop {
            // The horizon may lie at a pulse, which is rounded to a tick: behind the first that differs so all may come a little later.
            let late = one.horizon().abs_diff(other.horizon());
            prop_assert!(late <= one.stepper.time_slice().into(), "{late} ticks apart at {}", one.horizon());
            is_late |= late != 0;
            if !is_late {
                let (here, there) = (one.state_at(one.horizon()), other.state_at(other.horizon()));
                // A mean is rounded downwards, in either direction.
                let apart = here.position.bits() + there.position.bits();
                prop_assert!(apart.abs() <= 1, "{apart} Q32 steps apart at {}", one.horizon());
                let apart = here.velocity.bits() + there.velocity.bits();
                prop_assert!(apart.abs() <= 1, "{apart} Q56 apart at {}", one.horizon());
            }
            if one.horizon() >= at && !is_turned {
                one.move_to(targets.1, limits).unwrap();
                other.move_to(-targets.1, limits).unwrap();
                is_turned = true;
            } else if one.is_at_rest() && other.is_at_rest() {
                break;
            }
            let _ = one.advance(&mut pulses);
            let _ = other.advance(&mut mirrored);
        }
        prop_assert_eq!((pulses.position, mirrored.position), (targets.1, -targets.1));
    }

    /// Planning again to the same target, at any moments, moves the end by no more than a tick for each order.
    #[test]
    fn i06_planning_an_average_again_does_not_change_the_end(
        target in -100_000i64..100_000,
        limits in limits(),
        milliseconds in 1u32..1_000,
        cuts in prop::collection::vec(0u64..1 << 32, 1..6),
    ) {
        prop_assume!(target != 0);
        let jerk = jerk(limits, milliseconds);
        let (mut axis, mut sink) = averaged(jerk);
        axis.move_to(target, limits).unwrap();
        let window = axis.window();
        let planned = axis.plan.end().unwrap();
        fly(&mut axis, &mut sink, Ticks::MAX);
        let end = axis.committed;

        let (mut axis, mut sink) = averaged(jerk);
        axis.move_to(target, limits).unwrap();
        let mut cuts: std::vec::Vec<_> = cuts.iter().map(|cut| part(&axis, *cut)).collect();
        cuts.sort_unstable();
        let mut orders = 0;
        for at in cuts {
            fly(&mut axis, &mut sink, at);
            // Behind the plan's end only its mean is under way: the order is one that changes nothing.
            if axis.is_averaged && axis.horizon() > 0 {
                axis.move_to(target, limits).unwrap();
                orders += 1;
                prop_assert_eq!(axis.window(), window);
                prop_assert!(axis.plan.end().unwrap() <= planned.max(axis.horizon()) + orders);
            }
        }
        fly(&mut axis, &mut sink, Ticks::MAX);
        prop_assert_eq!(sink.position, target);
        let moved = axis.committed.abs_diff(end);
        prop_assert!(moved <= orders, "{moved} ticks after {orders} orders");
    }

    /// In a cruise a lower limit is a deceleration from the first tick on. In a ramp the mean goes on to speed up, to what its plan had.
    #[test]
    fn i09_an_average_with_a_lowered_limit_never_accelerates_first(
        limits in limits(),
        milliseconds in 1u32..300,
        share in 1u64..1_000,
        is_moving: bool,
    ) {
        let (mut axis, mut sink) = averaged(jerk(limits, milliseconds));
        axis.ramp_to(limits.velocity.signed(false), limits).unwrap();
        let hardest = u64::from(limits.acceleration.min(limits.deceleration));
        let ramp = u64::from(limits.velocity.whole()) * u64::from(HZ) / hardest;
        let settled = ramp + 2 * u64::from(axis.window()) + u64::from(HZ) / 100;
        fly(&mut axis, &mut sink, settled);
        let lower = Limits { velocity: Speed::from_bits(limits.velocity.bits() / 1_000 * share), ..limits };
        let mut before = axis.committed_velocity();
        if is_moving {
            axis.move_to(axis.committed_position() + 100_000, lower).unwrap();
        } else {
            axis.ramp_to(lower.velocity.signed(false), lower).unwrap();
        }
        let until = axis.committed + settled;
        while axis.committed < until && !axis.is_at_rest() && before.unsigned_abs() > lower.velocity {
            let _ = axis.advance(&mut sink);
            let now = axis.committed_velocity();
            prop_assert!(now.bits() - before.bits() <= 1, "{now:?} behind {before:?}");
            before = now;
        }
        let left = before.unsigned_abs().signed(false).abs_diff(lower.velocity.signed(false));
        prop_assert!(before.unsigned_abs() < lower.velocity || left <= Speed::from_bits(1 << 16), "{before:?}");
    }

    /// In any motion anything at all is planned or refused, and it can be stopped.
    #[test]
    fn i10_no_order_breaks_an_average(
        orders in prop::collection::vec((any::<(i64, i32, u32)>(), any::<(u32, u32, u32, u32)>(), (0u32..33, 0..8), 0u16..200), 1..6),
    ) {
        let (mut axis, mut sink) = averaged(1);
        for ((target, velocity, end), rates, (shift, kind), ticks) in orders {
            let shrunk = |number: u32| number.checked_shr(shift).unwrap_or(0);
            axis.set_ramps(Ramps::MovingAverage(shrunk(rates.3)));
            let limits = Limits {
                velocity: rates.0.into(),
                acceleration: shrunk(rates.1),
                deceleration: shrunk(rates.2),
            };
            let result = match kind {
                0 => axis.move_to(target, limits),
                1 | 2 => axis.move_to(target >> 32, limits),
                3 => axis.move_through(target >> 32, end.into(), limits),
                4 => axis.stop(shrunk(rates.2)),
                _ => axis.ramp_to(velocity.into(), limits),
            };
            let zero = shrunk(rates.3) == 0 || kind != 4 && rates.0 == 0 || shrunk(rates.2) == 0;
            prop_assert!(!zero || result.is_err(), "{result:?}");
            for _ in 0..ticks {
                let _ = axis.advance(&mut sink);
                prop_assert_eq!(axis.committed_position() as i32, sink.position as i32);
            }
        }
        // Stopped with hard linear ramps.
        axis.set_ramps(Ramps::Linear);
        axis.stop(u32::MAX).unwrap();
        fly(&mut axis, &mut sink, Ticks::MAX);
        prop_assert_eq!(axis.committed_position() as i32, sink.position as i32);
    }
}

#[test]
fn i10_extremes_of_an_average_are_planned_or_refused() {
    let extremes = [0u32, 1, 1 << 31, u32::MAX];
    let places = [i64::from(i32::MIN), -1, 0, 1, i64::from(i32::MAX)];
    for velocity in extremes {
        for acceleration in extremes {
            for deceleration in extremes {
                for jerk in extremes {
                    let limits = Limits {
                        velocity: velocity.into(),
                        acceleration,
                        deceleration,
                    };
                    let is_zero = [velocity, acceleration, deceleration, jerk].contains(&0);
                    for (from, target) in places.into_iter().zip(places.into_iter().rev()) {
                        let (mut axis, mut sink) = averaged(jerk);
                        axis.set_position(from);
                        let planned = axis.move_to(target, limits);
                        assert_eq!(planned.is_err(), is_zero, "{limits:?}, {jerk}");
                        for _ in 0..5 {
                            let _ = axis.advance(&mut sink);
                        }
                        if !is_zero {
                            assert_eq!(axis.target(), target);
                            assert_eq!(axis.is_at_rest(), sink.position == target - from);
                        }
                    }
                }
            }
        }
    }
}
