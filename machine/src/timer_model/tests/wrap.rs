//! The counter of 32 bits goes over its end.

use motion::{Limits, PulseSink};

use super::super::rig::TIME_SLICE;
use super::{FAST, rig};

#[test]
fn the_counter_may_wrap_in_a_run_at_a_turn_and_behind_an_edge() {
    let limits = Limits {
        velocity: 900_000.into(),
        acceleration: 200_000_000,
        deceleration: 200_000_000,
    };
    // The end of the counter in the first ramp, in the cruise, exactly at the turns, and in the way back.
    for left in [1, 2, 500, 9_999, 10_000, 10_001, 20_000, 20_001, 35_000] {
        let mut rig = rig(FAST).with_count(0_u32.wrapping_sub(left));
        let mut captured = Vec::new();
        for target in [10_000, 0, 10_001, 0] {
            rig.axis.move_to(target, limits).unwrap();
            while !rig.is_finished() {
                rig.refill(u64::from(TIME_SLICE));
                let position = rig.output.position();
                let count = rig.model.count();
                captured.push((count, position));
                assert_eq!(position, rig.model.judge().position, "{left}");
                // A few changes of direction back, the same counts are the same positions.
                let from = captured.len().saturating_sub(20);
                for (count, position) in &captured[from..] {
                    assert_eq!(rig.output.position_at(*count), *position, "{left}");
                }
            }
            rig.account();
            assert_eq!(rig.output.position(), target);
            assert_eq!(rig.output.pending(), 0);
        }
    }
}
