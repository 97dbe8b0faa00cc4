//! The loop alone: sync events with jitter, with gaps, with strays.

use proptest::prelude::*;

use super::*;

const MICRO: i64 = 1 << POINT;

fn micros(time: i64) -> MicrosQ16 {
    time.unsigned_abs() << POINT
}

/// Gives the loop evenly spaced sync events, each so many microseconds off; returns the moments.
fn run(pll: &mut Pll, period: i64, offs: &[i64]) -> std::vec::Vec<MicrosQ16> {
    let begin = 1_000_000;
    (0..)
        .zip(offs)
        .map(|(k, off)| {
            let stamp = micros(begin + k * period + off);
            pll.on_sync_event(stamp, [micros(period), 0]);
            pll.at()
        })
        .collect()
}

proptest! {
    /// Once the loop has settled, moments are a period apart to 1 %, and never far from where sync events should be.
    #[test]
    fn y10_moments_are_even_whatever_the_jitter(
        period in prop::sample::select(std::vec![1_000_i64, 2_000, 2_500, 4_000, 10_000]),
        offs in prop::collection::vec(-120_i64..=120, 200..400),
    ) {
        let mut pll = Pll::new();
        let moments = run(&mut pll, period, &offs);
        for (k, pair) in (0..).zip(moments.windows(2)) {
            if k < 100 {
                continue;
            }
            let interval = span(pair[0], pair[1]);
            let off = (interval - period * MICRO).abs();
            prop_assert!(off * 100 <= period * MICRO, "{k}: {} us", interval / MICRO);
            let due = micros(1_000_000 + (k + 1) * period);
            let away = span(due, pair[1]).abs() / MICRO;
            prop_assert!(away < 100, "{k}: {away} us away");
        }
        prop_assert!(pll.is_locked());
        prop_assert_eq!(pll.missed(), 0);
    }

    /// Whatever comes whenever, the period stays within its bounds and time goes on.
    #[test]
    fn no_sync_event_breaks_the_loop(
        steps in prop::collection::vec((0_u64..3_000_000, any::<bool>()), 1..200),
        expected in 0_u64..5_000_000,
    ) {
        let mut pll = Pll::new();
        let mut now = 0_u64;
        for (step, is_beat) in steps {
            now += step;
            if is_beat {
                pll.on_sync_event(now << POINT, [expected << POINT, 0]);
            } else {
                for _ in 0..4 {
                    pll.count_missed(now << POINT);
                }
            }
            prop_assert!((SHORTEST..=LONGEST).contains(&pll.period()));
        }
    }
}

#[test]
fn a_stray_beat_is_not_measured_by() {
    let mut pll = Pll::new();
    let mut offs = [0; 200];
    offs[150] = 240;
    let moments = run(&mut pll, 1_000, &offs);
    assert_eq!(pll.rejected(), 1);
    let interval = span(moments[149], moments[150]);
    assert!(
        (interval - 1_000 * MICRO).abs() < 2 * MICRO,
        "as if it had been in time"
    );
}

#[test]
fn the_period_is_found_where_another_one_is_expected() {
    for (expected, period) in [(1_000, 10_000), (10_000, 1_000), (4_000, 2_500)] {
        let mut pll = Pll::new();
        for k in 0..300 {
            pll.on_sync_event(micros(k * period), [micros(expected), 0]);
        }
        assert!(pll.is_locked());
        assert!(pll.period().abs_diff(micros(period)) < micros(1));
    }
}

#[test]
fn another_period_is_found_after_a_while() {
    let mut pll = Pll::new();
    run(&mut pll, 4_000, &[0; 100]);
    let begin = 1_000_000 + 100 * 4_000;
    for k in 0..200 {
        let stamp = micros(begin + k * 1_000);
        pll.count_missed(stamp);
        pll.on_sync_event(stamp, [micros(4_000), 0]);
    }
    assert!(pll.is_locked());
    assert!(pll.period().abs_diff(micros(1_000)) < micros(1));
}

#[test]
fn m64_missed_beats_are_counted_and_do_not_move_the_moments() {
    let mut pll = Pll::new();
    let moments = run(&mut pll, 1_000, &[0; 200]);
    let last = moments[199];
    let now = last + micros(2_600);
    assert!(pll.count_missed(now));
    assert!(pll.count_missed(now));
    assert!(!pll.count_missed(now));
    assert_eq!(pll.missed(), 2);
    assert!((span(last, pll.at()) - 2_000 * MICRO).abs() < MICRO);
    assert_eq!(
        pll.on_sync_event(last + micros(3_000), [0, 0]),
        Arrival::InTurn
    );
    assert_eq!(
        pll.on_sync_event(last + micros(3_100), [0, 0]),
        Arrival::OutOfTurn,
        "twice"
    );
}

#[test]
fn silence_ends_the_lock_and_not_the_moments() {
    let mut pll = Pll::new();
    run(&mut pll, 1_000, &[0; 100]);
    let mut now = pll.at();
    for _ in 0..20 {
        now += micros(1_000);
        while pll.count_missed(now) {}
    }
    assert_eq!(pll.state(), 0);
    assert!(pll.is_running());
    assert_eq!(pll.missed(), u32::from(SILENCE));
}
