//! A motor that is beyond a software limit.

use super::RELATIVE;
use crate::testing::Rig;

/// A drive that stands at 12,000 steps, where the limit is 10,000 (or both of them negative).
fn beyond(sign: i32) -> Rig {
    let mut rig = Rig::enabled();
    rig.set_point(12_000 * sign, 0);
    rig.rest();
    rig.configuration.position_limits = (-10_000, 10_000);
    rig.post();
    rig.ticks(2);
    rig
}

#[test]
fn m32_beyond_a_software_limit_a_relative_set_point_goes_its_way_or_nowhere() {
    for option in [0, 1, 2] {
        for sign in [1, -1] {
            for (way, end, is_cut) in [
                (100, 12_000, true),
                (-100, 11_900, false),
                (-2_000, 10_000, false),
                (-5_000, 7_000, false),
                (-25_000, -10_000, true),
            ] {
                let mut rig = beyond(sign);
                rig.commands.positioning_option = option;
                rig.set_point(way * sign, RELATIVE);
                assert_eq!(rig.rest(), i64::from(end * sign), "{way} by {option}");
                rig.ticks(20);
                assert_eq!(rig.limited(), is_cut, "bit 11, {way} by {option}");
                assert_eq!(rig.reached(), !is_cut, "bit 10, {way} by {option}");
            }
        }
    }
}

#[test]
fn m32_a_relative_set_point_from_within_still_ends_at_the_limit() {
    let mut rig = Rig::enabled();
    rig.configuration.position_limits = (-10_000, 10_000);
    rig.set_point(9_000, 0);
    rig.rest();
    rig.set_point(3_000, RELATIVE);
    assert_eq!(rig.rest(), 10_000);
    assert!(rig.limited() && !rig.reached());
}
