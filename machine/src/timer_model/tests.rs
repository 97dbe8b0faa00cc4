//! The advanced timer's output, judged by its pins.

mod board;
mod breaks;
mod capture;
mod differential;
mod interrupted;
mod leftovers;
mod random;
mod slow;
mod starvation;
mod wrap;

use motion::advanced_timer::{Register, Registers, Ring, bits};
use motion::{Direction, DriverTiming, Limits, PulseSink, Record, Speed};

use super::rig::{HZ, Rig, TIME_SLICE};
use super::{Judge, TimerModel};

/// 100 ns high, 100 ns low, 20 ns direction: a TMC2209 at 168 MHz.
const FAST: DriverTiming = DriverTiming {
    pulse_high: 17,
    pulse_low: 17,
    direction_setup: 4,
    direction_hold: 4,
};

/// 1.9 µs high and low, 650 ns direction: a DRV8825 at 168 MHz.
const SLOW: DriverTiming = DriverTiming {
    pulse_high: 320,
    pulse_low: 320,
    direction_setup: 110,
    direction_hold: 110,
};

const LIMITS: Limits = Limits {
    velocity: Speed::per_second(100_000),
    acceleration: 500_000,
    deceleration: 500_000,
};

/// Slots of the ring as it is on a board.
fn ring() -> &'static Ring {
    // A test is short; its memory may stay.
    Box::leak(Box::new(Ring::new()))
}

fn rig(timing: DriverTiming) -> Rig<'static> {
    Rig::new(ring(), timing, Judge::new(timing))
}

#[test]
fn a_move_sends_its_pulses_and_stops_the_timer() {
    for (target, velocity) in [
        (100_000, 100_000),
        (-3, 10),
        (20_000, 1_000_000),
        (1, 1_000),
        (-70_000, 1_000_000),
    ] {
        let mut rig = rig(FAST);
        rig.axis
            .move_to(
                target,
                Limits {
                    velocity: velocity.into(),
                    acceleration: 5_000_000,
                    deceleration: 5_000_000,
                },
            )
            .unwrap();
        rig.finish(20_000);
        rig.account();
        assert_eq!(rig.model.judge().position, target);
        assert_eq!(rig.model.judge().pulses, target.unsigned_abs());
        assert_eq!(rig.underruns, 0, "to {target}");
        rig.output.service();
        assert_eq!(rig.model.read(Register::Cr1) & bits::CEN, 0);
    }
}

#[test]
fn a_train_is_played_without_a_gap() {
    let mut rig = rig(FAST);
    *rig.model.judge_mut() = Judge::new(FAST).logging();
    rig.axis.ramp_to(200_000.into(), LIMITS).unwrap();
    for _ in 0..4_000 {
        rig.refill(TIME_SLICE.into());
    }
    assert_eq!(rig.underruns, 0);
    let judge = rig.model.judge();
    let log = judge.log.as_ref().unwrap();
    // 100,000 steps/s are 1,680 ticks, once the ramp of 200 ms is over.
    let cruise = log.iter().filter(|(at, _)| *at > u64::from(HZ) / 4);
    let times: Vec<_> = cruise.map(|(at, _)| *at).collect();
    assert!(times.len() > 70_000);
    for pair in times.windows(2) {
        let period = pair[1] - pair[0];
        assert!((1_679..=1_681).contains(&period), "{period} ticks");
    }
}

#[test]
fn turning_round_keeps_the_times_of_the_driver() {
    for timing in [
        FAST,
        SLOW,
        DriverTiming {
            direction_setup: 3_000,
            direction_hold: 5_000,
            ..SLOW
        },
    ] {
        let mut rig = rig(timing);
        let sharp = Limits {
            velocity: 200_000.into(),
            acceleration: 400_000_000,
            deceleration: 400_000_000,
        };
        for target in [10, -10, 1, 0, -1, 500, 0, -2_000] {
            rig.axis.move_to(target, sharp).unwrap();
            for _ in 0..3 {
                rig.refill(u64::from(TIME_SLICE) / 2);
            }
        }
        rig.finish(1_000);
        rig.account();
        assert_eq!(rig.model.judge().position, -2_000);
    }
}

#[test]
fn starving_is_silence_that_is_told_and_loses_nothing() {
    for velocity in [50, 3_000, 100_000, 1_000_000] {
        for pause in [1, 2, 3, 5, 17, 400, 3_900] {
            let mut rig = rig(FAST);
            rig.axis
                .ramp_to(
                    velocity.into(),
                    Limits {
                        velocity: 1_000_000.into(),
                        acceleration: 50_000_000,
                        deceleration: 50_000_000,
                    },
                )
                .unwrap();
            for _ in 0..50 {
                rig.refill(TIME_SLICE.into());
            }
            let before = rig.underruns;
            assert_eq!(before, 0);
            // The processor stands still.
            rig.model.run(pause * u64::from(TIME_SLICE));
            let committed = rig.axis.committed_position();
            assert!(
                rig.model.judge().position <= committed,
                "more pulses than were asked for"
            );
            if pause >= 5 {
                assert_eq!(rig.model.judge().position, committed);
                assert_eq!(rig.output.pending(), 0);
            }
            rig.refill(TIME_SLICE.into());
            rig.refill(TIME_SLICE.into());
            if pause >= 5 {
                assert_eq!(
                    rig.underruns,
                    before + 1,
                    "{velocity} steps/s, {pause} time slices"
                );
            }
            rig.axis.stop(50_000_000).unwrap();
            rig.finish(4_000);
            rig.account();
        }
    }
}

#[test]
fn a_refill_that_is_late_within_the_horizon_is_not_noticed() {
    for velocity in [50, 3_000, 100_000, 1_000_000_u32] {
        let mut rig = rig(FAST);
        *rig.model.judge_mut() = Judge::new(FAST).logging();
        let limits = Limits {
            velocity: 1_000_000.into(),
            acceleration: 50_000_000,
            deceleration: 50_000_000,
        };
        rig.axis
            .ramp_to(velocity.cast_signed().into(), limits)
            .unwrap();
        for refill in 0..200 {
            // Two time slices less a slot, which cannot be changed once it is preloaded.
            let late = if refill % 10 == 9 { TIME_SLICE / 2 } else { 0 };
            rig.refill(u64::from(TIME_SLICE + late));
        }
        assert_eq!(rig.underruns, 0, "{velocity} steps/s");
        let judge = rig.model.judge();
        let log = judge.log.as_ref().unwrap();
        let cruise = log.iter().filter(|(at, _)| *at > u64::from(HZ) / 40);
        let times: Vec<_> = cruise.map(|(at, _)| *at).collect();
        let period = u64::from(HZ / velocity);
        let is_even = |pair: &[u64]| (pair[1] - pair[0]).abs_diff(period) <= 1;
        assert!(times.windows(2).all(is_even), "{velocity} steps/s");
    }
}

/// A change of direction that was on its way when the stream stopped: what left meanwhile went the old way, and is counted so.
#[test]
fn a_stream_that_stands_still_before_a_turn_is_counted_as_it_went() {
    for refills in 1..5 {
        let mut rig = rig(FAST);
        let limits = Limits {
            velocity: 20_000.into(),
            acceleration: 400_000_000,
            deceleration: 400_000_000,
        };
        rig.axis.ramp_to(20_000.into(), limits).unwrap();
        for _ in 0..100 {
            rig.refill(TIME_SLICE.into());
        }
        rig.axis.ramp_to((-20_000).into(), limits).unwrap();
        for _ in 0..refills {
            rig.refill(u64::from(TIME_SLICE) / 4);
        }
        rig.model.stall_stream(true);
        for _ in 0..6 {
            rig.refill(TIME_SLICE.into());
        }
        assert!(rig.output.has_failed());
        assert_eq!(rig.output.position(), rig.model.judge().position);
    }
}

#[test]
fn a_processor_that_hangs_has_six_seconds_of_silence() {
    let mut rig = rig(FAST);
    rig.axis
        .ramp_to(
            1_000_000.into(),
            Limits {
                velocity: 1_000_000.into(),
                ..LIMITS
            },
        )
        .unwrap();
    for _ in 0..8_500 {
        rig.refill(TIME_SLICE.into());
    }
    let committed = rig.axis.committed_position();
    rig.model.run(6 * u64::from(HZ));
    assert_eq!(rig.model.judge().position, committed);
}

/// The same at the ceiling, where the ring is fullest.
#[test]
fn a_processor_that_hangs_at_the_ceiling_has_six_seconds_too() {
    let mut rig = rig(FAST);
    let limits = Limits {
        velocity: 4_900_000.into(),
        acceleration: 50_000_000,
        deceleration: 50_000_000,
    };
    rig.axis.ramp_to(4_900_000.into(), limits).unwrap();
    for _ in 0..600 {
        rig.refill(TIME_SLICE.into());
    }
    let committed = rig.axis.committed_position();
    rig.model.run(6 * u64::from(HZ));
    assert_eq!(rig.model.judge().position, committed);
}

#[test]
fn a_stream_that_stands_still_is_cut_within_a_millisecond() {
    for velocity in [3_000, 100_000, 1_000_000] {
        let mut rig = rig(FAST);
        let limits = Limits {
            velocity: 1_000_000.into(),
            acceleration: 50_000_000,
            deceleration: 50_000_000,
        };
        rig.axis.ramp_to(velocity.into(), limits).unwrap();
        for _ in 0..400 {
            rig.refill(TIME_SLICE.into());
        }
        assert!(!rig.output.has_failed());
        rig.model.stall_stream(true);
        for _ in 0..4 {
            rig.refill(TIME_SLICE.into());
        }
        assert!(rig.output.has_failed(), "{velocity} steps/s");
        let pulses = rig.model.judge().pulses;
        rig.refill(u64::from(HZ) / 10);
        rig.refill(TIME_SLICE.into());
        assert_eq!(rig.model.judge().pulses, pulses, "{velocity} steps/s");
        // The counter has seen what left, and with the stream at work again pulses are made as before.
        let position = rig.output.position();
        assert_eq!(position, rig.model.judge().position);
        rig.model.stall_stream(false);
        rig.output.mend();
        rig.axis.abort();
        rig.axis.set_position(position);
        rig.axis.move_to(position - 500, limits).unwrap();
        rig.finish(1_000);
        assert_eq!(rig.model.judge().position, position - 500);
    }
}

#[test]
fn dropping_keeps_the_count_of_pulses_that_left() {
    for late in 0..200u64 {
        let mut rig = rig(FAST);
        rig.axis
            .ramp_to(
                (-300_000).into(),
                Limits {
                    velocity: 300_000.into(),
                    acceleration: 50_000_000,
                    ..LIMITS
                },
            )
            .unwrap();
        for _ in 0..40 {
            rig.refill(TIME_SLICE.into());
        }
        rig.model.run(late * 7);
        rig.output.drop_all();
        rig.axis.abort();
        let position = rig.output.position();
        rig.axis.set_position(position);
        assert_eq!(rig.output.pending(), 0);
        let left = rig.model.judge().position;
        assert_eq!(position, left);
        rig.model.run(HZ.into());
        assert_eq!(
            rig.model.judge().position,
            left,
            "a pulse came after the drop"
        );
        // And it goes on from there.
        rig.axis.move_to(100, LIMITS).unwrap();
        rig.finish(10_000);
        rig.account();
        assert_eq!(rig.model.judge().position, 100);
    }
}

#[test]
fn a_train_after_a_drop_inside_a_pulse_begins_with_its_own() {
    // Inside a pulse of the first train, then between two of its pulses.
    for (late, is_inside) in [(3, true), (FAST.pulse_high / 2, true), (100, false)] {
        let mut rig = rig(FAST);
        for (repeat, width) in [(1, 0), (100, FAST.pulse_high as u16)] {
            let record = Record {
                period: 10_000,
                repeat,
                width,
                direction: Direction::Forward,
            };
            rig.output.push(record).unwrap();
        }
        while rig.model.judge().pulses < 5 {
            rig.model.run(1);
        }
        rig.model.run(late.into());
        rig.output.drop_all();
        rig.model.run(HZ.into());
        assert_eq!(rig.model.is_inside_pulse(), is_inside);
        rig.axis.set_position(5);
        rig.axis.move_to(7, LIMITS).unwrap();
        rig.finish(1_000);
        rig.account();
        assert_eq!(rig.model.judge().position, 7);
    }
}

#[test]
fn a_step_a_minute_needs_no_other_mode() {
    let mut rig = rig(FAST);
    *rig.model.judge_mut() = Judge::new(FAST).logging();
    // A record takes a time slice at most, so a minute is very many of them.
    let push = |rig: &mut Rig<'_>, record: Record| {
        let mut record = Some(record);
        while let Some(wanted) = record.take() {
            rig.output.service();
            if let Err(refused) = rig.output.push(wanted) {
                record = Some(refused);
                rig.model.run(4_000);
            }
        }
    };
    let pulse = Record {
        period: TIME_SLICE,
        repeat: 1,
        width: 17,
        direction: Direction::Forward,
    };
    let silence = Record {
        period: 1 << 28,
        repeat: 1,
        width: 0,
        direction: Direction::Forward,
    };
    let minute = 60 * u64::from(HZ);
    push(&mut rig, pulse);
    let mut left = minute - u64::from(TIME_SLICE);
    while left > 0 {
        let period = left.min(1 << 28) as u32;
        push(&mut rig, Record { period, ..silence });
        left -= u64::from(period);
    }
    push(&mut rig, pulse);
    rig.model.run(1 << 29);
    let judge = rig.model.judge();
    let log = judge.log.as_ref().unwrap();
    assert_eq!(log.len(), 2);
    assert_eq!(log[1].0 - log[0].0, minute);
}

/// The model holds every register against the manual when a train begins, whatever a boot loader has left there.
#[test]
fn what_a_boot_loader_has_left_is_no_matter() {
    let model = TimerModel::new(ring(), Judge::new(FAST));
    assert_ne!(model.read(Register::CounterArr), u32::MAX);
    let mut rig = rig(FAST);
    rig.axis.move_to(10, LIMITS).unwrap();
    rig.finish(1_000);
    rig.account();
}
