//! The limits 607Fh, 6083h and 6084h in the cyclic modes, whatever becomes of the period of SYNC and of the set-points.

use canopen::Frame;
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;
use sim::drive::MotionSample;
use tests::drive::{INTERNAL_LIMIT, OPERATION_ENABLED};

use crate::cyclic_master::{FOLLOWS, Master, expedited};

/// 607Fh, in increments/s.
const FASTEST: i64 = 20_000;

/// 6083h to 6085h, in increments/s².
const RAMP: i64 = 100_000;

/// A motor in cyclic synchronous position that stands, with 607Fh and what becomes of lost set-points (2051h:2).
fn master(cycle: u64, is_cubic: bool, lost: u8) -> Master {
    let mut master = Master::new(8, cycle);
    master.drive.write_i16(0x60C0, 0, -i16::from(is_cubic));
    master.drive.write_u32(0x607F, 0, 20_000);
    master.drive.write_u32(0x6085, 0, 100_000);
    master.drive.write_u8(0x2051, 2, lost);
    master.next_in(cycle);
    master.steps([0; 60]);
    master.drive.record_motion();
    master
}

/// How far the motor is from one sample to a later one, and the microseconds in between.
fn distance(from: &MotionSample, to: &MotionSample) -> (i64, i64) {
    let time = (to.at - from.at).ticks().cast_signed();
    (to.position - from.position, time)
}

/// No two samples lie further apart than 607Fh leads, up to an increment at each.
fn is_within_607fh(samples: &[MotionSample]) -> Result<(), String> {
    for (first, from) in samples.iter().enumerate() {
        for to in samples.iter().skip(first + 1).take(40) {
            let (distance, time) = distance(from, to);
            let most = FASTEST * time / 1_000_000 + 2;
            if distance.abs() > most {
                return Err(format!("{distance} in {time} us from {:?}", from.at));
            }
        }
    }
    Ok(())
}

/// Where the motor was so many microseconds behind the first sample.
fn position_at(samples: &[MotionSample], time: i64) -> i64 {
    let is_before = |sample: &MotionSample| (sample.at - samples[0].at).ticks() as i64 <= time;
    let behind = samples.partition_point(is_before);
    let (Some(from), Some(to)) = (samples.get(behind - 1), samples.get(behind)) else {
        return samples[samples.len() - 1].position;
    };
    let (distance, length) = distance(from, to);
    let since = time - (from.at - samples[0].at).ticks() as i64;
    from.position + distance * since / length
}

/// The distance of 40 ms never differs from that of the 40 ms before by more than the ramp leads, where a set-point may take 60 ms
/// as long as the period gets longer.
fn is_on_the_ramp(samples: &[MotionSample]) -> Result<(), String> {
    const SPAN: i64 = 40_000;
    let end = distance(&samples[0], &samples[samples.len() - 1]).1;
    let most = RAMP * SPAN / 1_000_000 * (SPAN + 60_000) / 1_000_000 + 4;
    for time in (0..end - 2 * SPAN).step_by(1_000) {
        let [a, b, c] = [0, SPAN, 2 * SPAN].map(|span| position_at(samples, time + span));
        if (c - 2 * b + a).abs() > most {
            return Err(format!("{a}, {b}, {c} at {time} us"));
        }
    }
    Ok(())
}

#[test]
fn m62_a_period_that_gets_shorter_in_motion_passes_no_limit() {
    for (before, after) in [(10_000, 4_000), (20_000, 1_000), (4_000, 10_000)] {
        let mut master = master(before, false, 0);
        master.steps([10_000; 30]);
        master.change_cycle(after);
        master.steps([10_000; 600]);
        let samples = master.drive.axis().motion_samples();
        is_within_607fh(samples).unwrap_or_else(|why| panic!("{before} to {after} us: {why}"));
        assert_eq!(master.drive.position(), 10_000);
    }
}

/// What a master does in a cycle.
#[derive(Clone, Copy, Debug)]
enum Doing {
    /// It gives a set-point this far from the one before.
    Gives(i32),
    /// It gives it behind SYNC.
    IsLate(i32),
    /// It gives none.
    Forgets,
    /// SYNC is lost as well.
    LosesSync,
    /// Its period is another from now on, in milliseconds.
    Changes(u64),
}

fn doing(most: i32) -> impl Strategy<Value = Doing> {
    prop_oneof![
        12 => (-most..=most).prop_map(Doing::Gives),
        1 => (-most..=most).prop_map(Doing::IsLate),
        1 => Just(Doing::Forgets),
        1 => Just(Doing::LosesSync),
        1 => (1_u64..=20).prop_map(Doing::Changes),
    ]
}

/// Does all this around `target`, returns where it should end.
fn play(master: &mut Master, doings: &[Doing], mut target: i32) -> i32 {
    for doing in doings {
        let off = master.jitter();
        match *doing {
            Doing::Gives(distance) => {
                target += distance;
                master.cycle(target, off);
            }
            Doing::IsLate(distance) => {
                target += distance;
                master.sync(off);
                master.set_point(target);
            }
            Doing::Forgets => master.sync(off),
            Doing::LosesSync => {
                let cycle = master.cycle_time();
                master.next_in(2 * cycle);
            }
            Doing::Changes(milliseconds) => master.change_cycle(1_000 * milliseconds),
        }
    }
    target
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig { cases: 12, ..ProptestConfig::default() }))]

    #[test]
    fn m62_whatever_comes_and_however_often_607fh_is_kept_and_the_motor_arrives(
        begin in 1_u64..=20,
        doings in prop::collection::vec(doing(400), 1..120),
        is_cubic in any::<bool>(),
    ) {
        let mut master = master(1_000 * begin, is_cubic, 0);
        let target = play(&mut master, &doings, 0);
        for _ in 0..20 {
            master.steps([target; 20]);
            master.change_cycle(10_000);
        }
        let samples = master.drive.axis().motion_samples();
        prop_assert_eq!(is_within_607fh(samples), Ok(()));
        prop_assert_eq!(master.drive.position(), i64::from(target));
        prop_assert!(master.has(FOLLOWS) && !master.has(INTERNAL_LIMIT));
        prop_assert!(OPERATION_ENABLED.is_shown_by(master.drive.statusword()));
    }

    #[test]
    fn m62_what_is_caught_up_with_is_on_the_ramps_whatever_becomes_of_the_period(
        begin in 1_u64..=20,
        doings in prop::collection::vec(doing(0), 1..120),
        is_cubic in any::<bool>(),
    ) {
        let mut master = master(1_000 * begin, is_cubic, 2);
        let target = play(&mut master, &doings, 8_000);
        for _ in 0..20 {
            master.steps([target; 20]);
            master.change_cycle(10_000);
        }
        let samples = master.drive.axis().motion_samples();
        prop_assert_eq!(is_within_607fh(samples), Ok(()));
        prop_assert_eq!(is_on_the_ramp(samples), Ok(()));
        // Where SYNC stays away the motor goes on for 2 ms.
        let furthest = samples.iter().map(|sample| sample.position).max();
        prop_assert!(furthest <= Some(8_000 + FASTEST * 2 / 1_000), "{furthest:?}");
        prop_assert_eq!(master.drive.position(), 8_000);
    }
    #[test]
    fn m69_a_velocity_is_on_the_ramps_whatever_becomes_of_the_period(
        begin in 1_u64..=20,
        doings in prop::collection::vec(doing(20_000), 1..120),
    ) {
        let mut master = Master::new(9, 1_000 * begin);
        for limit in [0x60C5, 0x60C6, 0x6085] {
            master.drive.write_u32(limit, 0, 100_000);
        }
        master.drive.write_u32(0x607F, 0, 20_000);
        master.drive.write_u8(0x2051, 2, 2);
        for _ in 0..60 {
            master.sync(0);
        }
        master.drive.record_motion();
        for doing in doings {
            let off = master.jitter();
            match doing {
                Doing::Gives(velocity) | Doing::IsLate(velocity) => {
                    let write = expedited(0x60FF, velocity);
                    master.drive.send_frame(Frame::data_frame(0x604, &write));
                    master.sync(off);
                }
                Doing::Forgets => master.sync(off),
                Doing::LosesSync => master.next_in(2 * master.cycle_time()),
                Doing::Changes(milliseconds) => master.change_cycle(1_000 * milliseconds),
            }
        }
        let samples = master.drive.axis().motion_samples();
        prop_assert_eq!(is_within_607fh(samples), Ok(()));
        prop_assert_eq!(is_on_the_ramp(samples), Ok(()));
    }
}
