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
            for (distance, end, is_cut) in [
                (100, 12_000, true),
                (-100, 11_900, false),
                (-2_000, 10_000, false),
                (-5_000, 7_000, false),
                (-25_000, -10_000, true),
            ] {
                let mut rig = beyond(sign);
                rig.commands.positioning_option = option;
                rig.set_point(distance * sign, RELATIVE);
                assert_eq!(rig.rest(), i64::from(end * sign), "{distance} by {option}");
                rig.ticks(20);
                assert_eq!(rig.limited(), is_cut, "bit 11, {distance} by {option}");
                assert_eq!(rig.reached(), !is_cut, "bit 10, {distance} by {option}");
            }
        }
    }
}

#[test]
fn m32_beyond_a_software_limit_an_absolute_set_point_never_leads_the_other_way() {
    for sign in [1, -1] {
        for (target, end, is_cut) in [
            (15_000, 12_000, true),
            (12_001, 12_000, true),
            (12_000, 12_000, false),
            (11_900, 11_900, false),
            (10_000, 10_000, false),
            (7_000, 7_000, false),
            (-13_000, -10_000, true),
        ] {
            let mut rig = beyond(sign);
            rig.set_point(target * sign, 0);
            assert_eq!(rig.rest(), i64::from(end * sign), "{target}");
            rig.ticks(20);
            assert_eq!(rig.limited(), is_cut, "bit 11, {target}");
            assert_eq!(rig.reached(), !is_cut, "bit 10, {target}");
            // No trap: the way back is free.
            rig.set_point(5_000 * sign, 0);
            assert_eq!(rig.rest(), i64::from(5_000 * sign));
        }
    }
}

#[test]
fn m32_a_set_point_that_waits_goes_no_further_than_the_limit_that_cuts_the_one_before_it() {
    for (next, controlword) in [(30_000, 0), (10_000, RELATIVE), (-2_000, RELATIVE)] {
        let mut rig = Rig::enabled();
        rig.set_point(20_000, 0);
        rig.ticks(20);
        rig.set_point(next, controlword);
        rig.ticks(20);
        rig.configuration.position_limits = (-10_000, 10_000);
        rig.post();
        assert_eq!(rig.rest(), 10_000, "{next}");
        assert!(rig.limited() && !rig.reached());
    }
}

#[test]
fn m32_an_absolute_set_point_from_within_still_ends_at_the_limit() {
    let mut rig = Rig::enabled();
    rig.configuration.position_limits = (-10_000, 10_000);
    for (target, end) in [(13_000, 10_000), (14_000, 10_000), (-11_000, -10_000)] {
        rig.set_point(target, 0);
        assert_eq!(rig.rest(), end);
        assert!(rig.limited() && !rig.reached());
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
