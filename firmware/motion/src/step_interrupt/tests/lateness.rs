//! What a driver sees when interrupts and calls come late: its times are kept, and every pulse that left is counted.

use super::*;

/// A driver that is slower with everything than an interrupt is.
const SLOW: DriverTiming = DriverTiming {
    pulse_high: 20,
    pulse_low: 30,
    direction_setup: 100,
    direction_hold: 10,
};

/// The last two edges that are followed by another one: how long the signal was high and low at least.
fn shortest(bench: &Bench) -> (u32, u32) {
    let log = bench.timer.0.log.borrow();
    let edges: Vec<_> = log
        .iter()
        .filter(|(_, what)| matches!(what, What::Rise | What::Fall))
        .collect();
    let (mut high, mut low) = (u32::MAX, u32::MAX);
    for pair in edges.windows(2) {
        let length = pair[1].0.wrapping_sub(pair[0].0);
        match pair[0].1 {
            What::Rise => high = high.min(length),
            _ => low = low.min(length),
        }
    }
    (high, low)
}

#[test]
fn a_late_turn_keeps_the_set_up_time() {
    for latency in 0..300 {
        let mut bench = Bench::with(0, SLOW);
        bench.push(record(100, 1, 0, Forward));
        bench.push(record(100, 1, 20, Forward));
        bench.push(record(30, 1, 0, Forward));
        bench.push(record(100, 1, 0, Reverse));
        bench.push(record(100, 1, 20, Reverse));
        bench.play(latency);
        let log = bench.timer.0.log.borrow();
        let turn = log
            .iter()
            .position(|(_, what)| *what == What::Turn(Reverse))
            .unwrap();
        assert_eq!(log[turn + 1].1, What::Rise);
        let setup = log[turn + 1].0 - log[turn].0;
        assert!(setup >= 100, "{setup} after {latency}");
    }
}

#[test]
fn a_silent_record_that_turns_nothing_waits_for_nothing() {
    let mut bench = Bench::with(0, SLOW);
    bench.push(record(100, 1, 0, Forward));
    bench.push(record(60, 1, 20, Forward));
    bench.push(record(60, 1, 0, Forward));
    bench.push(record(60, 1, 20, Forward));
    bench.play(7);
    let rises = bench.timer.rises();
    assert_eq!(rises[1] - rises[0], 120);
}

#[test]
fn a_pulse_that_is_late_is_as_wide_as_the_others() {
    for slowness in 0..80 {
        let mut bench = Bench::with(0, SLOW);
        bench.push(record(200, 1, 0, Forward));
        bench.push(record(50, 20, 20, Forward));
        // The time has passed when the timer is told.
        bench.timer.0.slowness.set(slowness);
        bench.play(5);
        let (high, low) = shortest(&bench);
        assert!(high >= 20, "high for {high}, slow by {slowness}");
        assert!(low >= 30, "low for {low}, slow by {slowness}");
        assert_eq!(bench.queue.position(), 20);
        assert_eq!(bench.queue.pending(), 0);
    }
}

proptest! {
    #[test]
    fn high_and_low_are_never_shorter_than_the_driver_allows(
        records in prop::collection::vec((50..300u32, 1..6u16), 1..40),
        latencies in prop::collection::vec(prop_oneof![0..8u32, 0..100u32, 0..2_000u32], 1..20),
        slowness in prop::collection::vec(0..60u32, 1..20),
    ) {
        let mut bench = Bench::with(0, SLOW);
        bench.push(record(200, 1, 0, Forward));
        for (period, repeat) in &records {
            bench.push(record(*period, *repeat, 20, Forward));
        }
        let mut latency = latencies.iter().cycle();
        let mut slowness = slowness.iter().cycle();
        loop {
            bench.timer.0.slowness.set(*slowness.next().unwrap());
            if !bench.step(*latency.next().unwrap()) {
                break;
            }
        }
        let (high, low) = shortest(&bench);
        prop_assert!(high >= 20 && low >= 30, "high for {}, low for {}", high, low);
        let pulses: i64 = records.iter().map(|(_, repeat)| i64::from(*repeat)).sum();
        prop_assert_eq!(bench.queue.position(), pulses);
        prop_assert_eq!(bench.queue.pending(), 0);
    }
}

#[test]
fn a_pulse_that_falls_due_while_the_timer_is_stopped_counts_if_it_left() {
    for ahead in 0..12 {
        for before in 0..6 {
            let mut bench = Bench::new();
            bench.push(record(100, 1, 0, Forward));
            bench.push(record(100, 3, 10, Forward));
            // Up to the fall of the first pulse; the second is scheduled.
            for _ in 0..3 {
                bench.step(1);
            }
            let (rise, edge) = bench.timer.0.alarm.get().unwrap();
            assert_eq!(edge, Some(Edge::Rise));
            NOW.set(rise - ahead);
            bench.timer.0.stopping.set((before, 5));
            bench.queue.drop_all();
            bench.serve_raised();
            let left = bench.timer.rises().len();
            assert_eq!(left, if before >= ahead { 2 } else { 1 });
            assert_eq!(
                bench.queue.position(),
                left as i64,
                "{ahead} ahead, {before} before"
            );
            assert_eq!(bench.queue.pending(), 0);
        }
    }
}
