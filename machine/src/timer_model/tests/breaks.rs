//! The break input: hardware cuts the pulses off, and the counter keeps the position.

use motion::advanced_timer::on_break;
use motion::{Limits, PulseSink};

use super::super::rig::{HZ, Rig, TIME_SLICE};
use super::{FAST, LIMITS, rig};

/// Between a break and what its interrupt does: two microseconds.
const LATENCY: u64 = HZ as u64 / 500_000;

fn fast() -> Limits {
    Limits {
        velocity: 1_000_000.into(),
        acceleration: 400_000_000,
        deceleration: 400_000_000,
    }
}

/// The interrupt, if there is one.
fn interrupt(rig: &mut Rig<'_>) {
    if rig.model.is_break_interrupt() {
        on_break(&mut rig.model);
        assert!(!rig.model.is_break_interrupt(), "it comes again and again");
    }
}

#[test]
fn the_break_input_cuts_the_pulses_by_hardware() {
    let mut rig = rig(FAST);
    rig.axis.ramp_to(100_000.into(), LIMITS).unwrap();
    for _ in 0..1_000 {
        rig.refill(TIME_SLICE.into());
    }
    let before = rig.model.judge().pulses;
    rig.model.set_break(true);
    rig.model.run(TIME_SLICE.into());
    assert_eq!(rig.model.judge().pulses, before);
    assert!(rig.output.is_broken());
    rig.output.drop_all();
    rig.output.mend();
    assert!(
        rig.output.is_broken(),
        "nothing mends what is still cut off"
    );
    rig.model.set_break(false);
    assert!(rig.output.is_broken(), "it is not let go on by itself");
    rig.output.mend();
    assert!(!rig.output.is_broken());
}

/// What the counter shows does not run away until the next control tick, refills in between make no train and no other fault.
#[test]
fn a_break_leaves_the_position_within_the_latency_of_its_interrupt() {
    for velocity in [-1_000_000, 100_000, 1_000_000] {
        for late in [0, 1_000, 20_000, 41_900] {
            let mut rig = rig(FAST);
            rig.axis.ramp_to(velocity.into(), fast()).unwrap();
            for _ in 0..40 {
                rig.refill(TIME_SLICE.into());
            }
            rig.model.run(late);
            rig.model.set_break(true);
            rig.model.run(LATENCY);
            interrupt(&mut rig);
            for _ in 0..8 {
                rig.refill(TIME_SLICE.into());
                interrupt(&mut rig);
                assert!(rig.output.is_broken() && !rig.output.has_failed());
            }
            assert_eq!(rig.output.pending(), 0);
            let left = rig.model.judge().position;
            let position = rig.output.position();
            assert!(
                (position - left).abs() <= 3,
                "{position} for {left} at {velocity} steps/s"
            );
            // And it goes on from there when the break is over.
            rig.axis.abort();
            rig.axis.set_position(position);
            rig.model.set_break(false);
            rig.output.mend();
            rig.axis.move_to(position + 300, fast()).unwrap();
            rig.finish(1_000);
            assert_eq!(rig.output.position(), position + 300);
            assert_eq!(rig.model.judge().position, left + 300);
        }
    }
}

/// Its flag is left over by no moment at which the break ends while it is being mended: the train behind it would end at once.
#[test]
fn a_break_that_ends_while_it_is_mended_leaves_no_fault() {
    for writes in 0..6 {
        let mut rig = rig(FAST);
        rig.refill(TIME_SLICE.into());
        rig.model.set_break(true);
        rig.output.drop_all();
        rig.model.end_break_behind(writes);
        // As the board does: as long as there is something to mend.
        for _ in 0..6 {
            if rig.output.is_broken() {
                rig.output.mend();
            }
        }
        assert!(!rig.output.is_broken(), "{writes}");
        rig.axis.move_to(300, fast()).unwrap();
        for _ in 0..40 {
            rig.refill(TIME_SLICE.into());
            interrupt(&mut rig);
        }
        assert!(!rig.output.has_failed(), "{writes}");
        rig.finish(1_000);
        assert_eq!(rig.model.judge().position, 300, "{writes}");
    }
}

/// A train that begins where something is left of a burst: TIM1 is reset, and with it what it knows of a break. No break is lost that lasts
/// longer than the two writes behind the reset, and none at all lets pulses leave that are not where the counter has them.
#[test]
fn a_break_in_the_reset_before_a_train_is_not_lost() {
    for begin in 0..50 {
        for writes in [1, 2, 3, 4, 8, 20] {
            let case = format!("from write {begin}, for {writes}");
            let mut rig = rig(FAST);
            rig.axis.ramp_to(100_000.into(), fast()).unwrap();
            for _ in 0..40 {
                rig.refill(TIME_SLICE.into());
            }
            // The train is dropped while the stream is still to serve it.
            rig.model.stall_stream(true);
            rig.model.run(20_000);
            rig.output.drop_all();
            rig.model.stall_stream(false);
            rig.axis.abort();
            let position = rig.output.position();
            assert_eq!(position, rig.model.judge().position);
            rig.axis.set_position(position);
            rig.axis.move_to(position + 300, fast()).unwrap();
            rig.model.begin_break_behind(begin);
            rig.model.end_break_behind(begin + writes);
            for _ in 0..9 {
                rig.refill(LATENCY);
                interrupt(&mut rig);
                rig.model.run(u64::from(TIME_SLICE) - LATENCY);
                assert!(!rig.output.has_failed(), "{case}");
            }
            let was_seen = rig.output.is_broken();
            assert!(
                was_seen || writes <= 3 || rig.model.is_break_planned(),
                "{case}"
            );
            if was_seen {
                rig.axis.abort();
                assert_eq!(rig.output.position(), rig.model.judge().position, "{case}");
                // All pulses of a break that comes as the train ends have left.
                rig.axis.set_position(rig.model.judge().position);
                rig.model.set_break(false);
                rig.output.mend();
                rig.axis.move_to(position + 300, fast()).unwrap();
            }
            rig.model.set_break(false);
            rig.finish(1_000);
            assert_eq!(rig.model.judge().position, position + 300, "{case}");
        }
    }
}

/// A break that comes together with an error of the stream: what needs the stream mended is told.
#[test]
fn a_break_hides_no_error_of_the_stream() {
    for is_serviced_between in [false, true] {
        let mut rig = rig(FAST);
        rig.axis.ramp_to((-100_000).into(), fast()).unwrap();
        for _ in 0..40 {
            rig.refill(TIME_SLICE.into());
        }
        rig.model.fail_stream();
        rig.model.set_break(true);
        interrupt(&mut rig);
        if is_serviced_between {
            rig.output.service();
        }
        rig.output.drop_all();
        rig.refill(TIME_SLICE.into());
        assert!(rig.output.has_failed() && rig.output.is_broken());
        let position = rig.output.position();
        assert_eq!(position, rig.model.judge().position);
        rig.model.set_break(false);
        rig.output.mend();
        assert!(!rig.output.has_failed() && !rig.output.is_broken());
        rig.axis.abort();
        rig.axis.set_position(position);
        rig.axis.move_to(position + 300, fast()).unwrap();
        rig.finish(1_000);
        assert_eq!(rig.model.judge().position, position + 300);
    }
}
