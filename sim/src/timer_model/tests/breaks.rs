//! The break input: hardware cuts the pulses off, and the counter keeps the position.

use motion::advanced_timer::on_break;
use motion::{Limits, PulseSink};

use super::super::rig::{HZ, Rig, SEGMENT};
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
        rig.refill(SEGMENT.into());
    }
    let before = rig.model.judge().pulses;
    rig.model.set_break(true);
    rig.model.run(SEGMENT.into());
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
                rig.refill(SEGMENT.into());
            }
            rig.model.run(late);
            rig.model.set_break(true);
            rig.model.run(LATENCY);
            interrupt(&mut rig);
            for _ in 0..8 {
                rig.refill(SEGMENT.into());
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
        rig.refill(SEGMENT.into());
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
            rig.refill(SEGMENT.into());
            interrupt(&mut rig);
        }
        assert!(!rig.output.has_failed(), "{writes}");
        rig.finish(1_000);
        assert_eq!(rig.model.judge().position, 300, "{writes}");
    }
}
