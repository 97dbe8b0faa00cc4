//! What is pending, to the tick, and what an axis makes of it.

use super::*;
use crate::{AdvanceError, Axis, AxisConfig, Clock, Limits};

#[test]
fn the_period_under_way_counts_for_what_is_left_of_it() {
    let mut bench = Bench::starting_at(u32::MAX - 150);
    bench.push(record(100, 1, 0, Forward));
    bench.push(record(1_000, 3, 10, Forward));
    let end = NOW.get().wrapping_add(3_100);
    let mut checked = 0;
    while let Some((alarm, _)) = bench.timer.0.alarm.get() {
        while NOW.get() != alarm {
            assert_eq!(
                bench.queue.pending(),
                u64::from(end.wrapping_sub(NOW.get()))
            );
            pass(1);
            checked += 1;
        }
        bench.step(0);
    }
    assert_eq!(checked, 3_100);
    assert_eq!(bench.queue.pending(), 0);
}

#[test]
fn a_train_that_is_late_has_as_much_pending_as_it_still_plays() {
    let mut bench = Bench::new();
    bench.push(record(100, 1, 0, Forward));
    bench.push(record(100, 3, 10, Forward));
    bench.push(record(500, 1, 0, Forward));
    // The rise comes in time, its interrupt 250 ticks late.
    bench.step(0);
    bench.step(250);
    bench.step(0);
    let pending = bench.queue.pending();
    let before = NOW.get();
    bench.play(0);
    assert_eq!(u64::from(NOW.get() - before), pending);
    assert_eq!(bench.queue.pending(), 0);
}

#[test]
fn something_is_pending_until_the_last_interrupt_has_come() {
    let mut bench = Bench::new();
    bench.push(record(100, 1, 0, Forward));
    bench.step(0);
    for late in 0..50 {
        NOW.set(100 + late);
        assert_eq!(bench.queue.pending(), 1);
    }
    bench.step(60);
    assert_eq!(bench.queue.pending(), 0);
    // A pause of any length is no time played.
    pass(u32::MAX / 2 + 1_000);
    assert_eq!(bench.queue.pending(), 0);
    bench.push(record(100, 1, 0, Forward));
    assert_eq!(bench.queue.pending(), 100);
}

#[test]
fn what_comes_during_the_last_period_is_played_right_after_it() {
    let mut bench = Bench::new();
    bench.push(record(100, 1, 10, Forward));
    bench.step(0);
    bench.step(0);
    pass(20);
    bench.push(record(100, 1, 10, Forward));
    assert_eq!(bench.queue.pending(), 170);
    bench.play(0);
    let rises = bench.timer.rises();
    assert_eq!(rises[1] - rises[0], 100);
    assert_eq!(bench.queue.pending(), 0);
}

/// Plays a move with a control tick every millisecond that comes up to 20 µs late. The least that was left to play at a
/// tick, in ticks.
fn least_margin(velocity: u32, acceleration: u32, target: i64) -> u64 {
    const HZ: u32 = 84_000_000;
    const TICK: u32 = HZ / 1_000;
    let timing = DriverTiming {
        pulse_high: 210,
        pulse_low: 210,
        direction_setup: 420,
        direction_hold: 420,
    };
    let mut bench = Bench::with(0, timing);
    let mut axis = Axis::new(AxisConfig {
        clock: Clock::new(HZ).unwrap(),
        time_slice: TICK,
        timing,
    });
    let limits = Limits {
        velocity: velocity.into(),
        acceleration,
        deceleration: acceleration,
    };
    axis.move_to(target, limits).unwrap();
    let mut least = u64::MAX;
    let mut ticks = 0_u32;
    let mut random = 1_u64;
    while !axis.is_at_rest() || bench.queue.pending() > 0 {
        ticks += 1;
        assert!(ticks < 20_000, "the move does not end");
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let late = (random >> 33) as u32 % (HZ / 50_000);
        let at = ticks.wrapping_mul(TICK).wrapping_add(late);
        while let Some((alarm, _)) = bench.timer.0.alarm.get()
            && at.wrapping_sub(alarm) <= u32::MAX / 2
        {
            // The interrupt takes a microsecond to come.
            bench.step(84);
        }
        if at.wrapping_sub(NOW.get()) <= u32::MAX / 2 {
            NOW.set(at);
        }
        if ticks > 1 && !axis.is_at_rest() {
            least = least.min(bench.queue.pending());
        }
        let result = axis.advance(&mut bench.queue);
        assert_ne!(result, Err(AdvanceError::Underrun), "at tick {ticks}");
        bench.serve_raised();
    }
    assert_eq!(bench.queue.position(), target);
    least
}

#[test]
fn a_move_of_any_speed_never_runs_dry() {
    for (velocity, acceleration, target) in [
        (333, 1_000, 500),
        (3, 100, 12),
        (950, 1_000, 1_000),
        (700, 1_000, 1_000),
        (1_300, 1_000, 1_000),
        (77, 100_000, 100),
        (10_000, 100_000, -20_000),
    ] {
        let least = least_margin(velocity, acceleration, target);
        std::println!("{velocity} steps/s, {acceleration} steps/s², to {target}: {least} ticks");
        // Two time slices, less a control tick and its delay.
        assert!(least >= 82_000, "{velocity} steps/s: {least} ticks left");
    }
}
