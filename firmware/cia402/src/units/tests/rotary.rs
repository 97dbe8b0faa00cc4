//! Axes whose positions wrap (607Bh).

use super::{Factors, Units, ratio, rig};
use crate::testing::Rig;

/// A rotary table in degrees: 3200 steps a turn.
const TABLE: Factors = Factors {
    range: (0, 359),
    ..Factors {
        position_encoder: Some((3_200, 1)),
        feed: (360, 1),
        ..super::NONE
    }
};

fn at(rig: &Rig) -> (i32, i64) {
    (rig.actuals().position_actual, rig.motor.position)
}

/// Goes to a position by this code of 60F2h bits 7 and 6, and returns how many steps that took.
fn go(rig: &mut Rig, target: i32, code: u16) -> i64 {
    let before = rig.motor.position;
    rig.commands.positioning_option = code << 6;
    rig.set_point(target, 0);
    rig.rest();
    rig.ticks(20);
    assert!(rig.reached());
    rig.motor.position - before
}

#[test]
fn m59_from_350_to_10_degrees_by_each_code() {
    for (code, distance) in [(0, -340), (1, -340), (2, 20), (3, 20)] {
        let mut rig = rig(TABLE);
        go(&mut rig, 350, 0);
        assert_eq!(at(&rig), (350, 3_111));
        let steps = go(&mut rig, 10, code);
        assert_eq!(rig.actuals().position_actual, 10, "code {code}");
        let total = i64::from(350 + distance) * 80;
        assert_eq!(
            rig.motor.position,
            (total * 2 + 9) / 18,
            "code {code}, {steps} steps"
        );
    }
}

#[test]
fn m59_turns_add_up_without_drift() {
    let mut rig = rig(TABLE);
    for turn in 1..=50 {
        go(&mut rig, 120, 2);
        go(&mut rig, 240, 2);
        go(&mut rig, 0, 2);
        assert_eq!(at(&rig), (0, turn * 3_200));
    }
    go(&mut rig, 359, 3);
    assert_eq!(rig.actuals().position_actual, 359);
    go(&mut rig, 0, 1);
    assert_eq!(at(&rig), (0, 49 * 3_200));
}

#[test]
fn m59_relative_set_points_and_code_0_may_go_over_several_turns() {
    let mut rig = rig(TABLE);
    rig.set_point(800, 0x40);
    assert_eq!(rig.rest(), 7_111);
    assert_eq!(rig.actuals().position_actual, 80);
    // As on a linear axis: within the turn where it stands.
    go(&mut rig, 350, 0);
    assert_eq!(rig.actuals().position_actual, 350);
    assert_eq!(rig.motor.position, 9_511);
    go(&mut rig, 370, 0);
    assert_eq!(
        (rig.actuals().position_actual, rig.motor.position),
        (10, 9_689)
    );
}

#[test]
fn m59_a_target_where_the_axis_stands_is_no_turn() {
    let mut rig = rig(TABLE);
    go(&mut rig, 90, 0);
    for code in 0..4 {
        assert_eq!(go(&mut rig, 90, code), 0, "code {code}");
    }
}

#[test]
fn m59_one_direction_is_not_half_a_unit_the_other_way() {
    for (polarity, sign) in [(0, 1), (0x80, -1)] {
        for (steps, code, distance) in [
            (104, 2, 3_596),
            (104, 1, -4),
            (104, 3, -4),
            (96, 2, 4),
            (96, 1, -3_596),
            (96, 3, 4),
            (100, 2, 0),
            (100, 1, 0),
        ] {
            let mut rig = rig(super::NONE);
            rig.set_point(steps * sign, 0);
            rig.rest();
            // Between two numbers of a master that counts otherwise.
            rig.configuration.units = Units::new(Factors {
                range: (0, 359),
                polarity,
                ..ratio(10, 1)
            })
            .unwrap();
            rig.post();
            rig.tick();
            assert_eq!(rig.actuals().position_actual, 10);
            let moved = go(&mut rig, 10, code);
            assert_eq!(moved, distance * i64::from(sign), "from {steps} by {code}");
            assert_eq!(go(&mut rig, 10, code), 0, "there it is exactly");
        }
    }
}

#[test]
fn m59_one_direction_holds_in_motion_too() {
    let mut rig = rig(TABLE);
    rig.commands.profile_velocity = 20_000.into();
    rig.commands.profile_acceleration = 100_000;
    rig.commands.profile_deceleration = 100_000;
    rig.commands.positioning_option = 2 << 6;
    rig.set_point(350, 0);
    rig.until("on its way", |rig| rig.actuals().position_actual > 150);
    // Too near to stop at it: a turn more.
    let here = rig.actuals().position_actual;
    rig.set_point(here + 10, 0x20);
    let mut before = rig.motor.position;
    for _ in 0..2_000 {
        rig.tick();
        assert!(rig.motor.position >= before);
        before = rig.motor.position;
    }
    assert_eq!(rig.actuals().position_actual, here + 10);
    assert!(rig.motor.position > 3_200);
}

#[test]
fn m59_a_velocity_turns_for_ever_and_shows_the_range() {
    let mut rig = rig(TABLE);
    rig.commands.mode = 3;
    rig.commands.target_velocity = 20_000.into();
    rig.post();
    let mut wraps = 0;
    let mut last = 0;
    for _ in 0..5_000 {
        let actuals = rig.tick();
        assert!((0..360).contains(&actuals.position_actual));
        wraps += i32::from(actuals.position_actual < last);
        last = actuals.position_actual;
    }
    assert!(wraps > 25, "{wraps} turns");
}

#[test]
fn m59_a_range_about_zero_wraps_on_both_sides() {
    let mut rig = rig(Factors {
        range: (-180, 179),
        ..ratio(10, 1)
    });
    go(&mut rig, 170, 3);
    assert_eq!(go(&mut rig, -170, 3), 200);
    assert_eq!(rig.actuals().position_actual, -170);
    assert_eq!(go(&mut rig, 170, 3), -200);
}

#[test]
fn m32_a_linear_axis_goes_on_behind_32_bits_where_it_is_shown() {
    let mut rig = rig(ratio(1, 100_000));
    rig.commands.mode = 3;
    rig.commands.target_velocity = 20_000.into();
    rig.post();
    rig.until("behind the end", |rig| rig.actuals().position_actual < 0);
    rig.commands.mode = 1;
    rig.post();
    rig.ticks(50);
    // 2³² units are no whole number of increments, and still nothing jumps.
    let steps = rig.rest();
    rig.set_point(i32::MIN + 500_000, 0);
    let end = rig.rest();
    assert_eq!(rig.actuals().position_actual, i32::MIN + 500_000);
    assert_eq!(end, 21_480);
    assert!((steps - end).abs() < 3_000);
}
