//! Software limits 607Dh: their units, their polarity, the home offset and 20E0h.

use super::{Factors, NONE, ratio, rig};
use crate::configuration::{HomingConfiguration, PositionLimitOptions};
use crate::testing::Rig;

/// Homing by method 37: the present position is home, and is called `offset`.
fn home(rig: &mut Rig, offset: i32) {
    rig.configuration.homing.method = 37;
    rig.configuration.homing.offset = offset;
    let name = rig.configuration.homing.position_at_home();
    rig.commands.mode = 6;
    rig.write(0x0F);
    rig.ticks(2);
    rig.write(0x1F);
    rig.ticks(5);
    rig.write(0x0F);
    rig.tick();
    assert_eq!(rig.actuals().position_actual, name);
    rig.commands.mode = 1;
    rig.write(0x0F);
    rig.ticks(2);
}

/// How far the motor goes towards a target that it is cut from, or not.
fn go(rig: &mut Rig, target: i32) -> (i64, bool) {
    rig.set_point(target, 0);
    (rig.rest(), rig.limited())
}

#[test]
fn m57_limits_are_in_units_of_the_user() {
    let mut rig = rig(ratio(10, 3));
    rig.configuration.position_limits = (-100, 200);
    rig.post();
    assert_eq!(go(&mut rig, 1_000), (667, true));
    assert_eq!(rig.actuals().position_actual, 200);
    assert_eq!(go(&mut rig, 200), (667, false));
    assert_eq!(go(&mut rig, -101), (-333, true));
    assert_eq!(rig.actuals().position_actual, -100);
}

#[test]
fn m57_limits_are_off_while_the_minimum_is_not_below_the_maximum() {
    for limits in [(0, 0), (500, -500), (7, 7)] {
        let mut rig = rig(NONE);
        rig.configuration.position_limits = limits;
        rig.post();
        assert_eq!(go(&mut rig, 1_000), (1_000, false));
    }
}

#[test]
fn m57_limits_stay_where_they_are_when_home_gets_another_name() {
    let mut rig = rig(NONE);
    rig.configuration.position_limits = (-500, 500);
    home(&mut rig, 1_000);
    assert_eq!(go(&mut rig, 2_000), (500, true));
    assert_eq!(rig.actuals().position_actual, 1_500);
    assert_eq!(go(&mut rig, -2_000), (-500, true));
    assert_eq!(rig.actuals().position_actual, 500);
}

#[test]
fn m57_limits_less_607ch_where_that_is_subtracted() {
    let mut rig = rig(NONE);
    rig.configuration.position_limits = (-500, 500);
    rig.configuration.homing.options |= 1;
    home(&mut rig, 1_000);
    assert_eq!(go(&mut rig, 2_000), (500, true));
    assert_eq!(rig.actuals().position_actual, -500);
}

#[test]
fn m57_limits_are_as_shown_by_20e0h_bit_1() {
    let mut rig = rig(NONE);
    rig.configuration.position_limits = (-500, 1_500);
    rig.configuration.position_limit_options = PositionLimitOptions {
        are_as_shown: true,
        need_home: false,
    };
    home(&mut rig, 1_000);
    assert_eq!(go(&mut rig, 2_000), (500, true));
    assert_eq!(rig.actuals().position_actual, 1_500);
}

#[test]
fn m57_limits_wait_for_the_home_position_by_20e0h_bit_0() {
    let mut rig = rig(NONE);
    rig.configuration.position_limits = (-500, 500);
    rig.configuration.position_limit_options = PositionLimitOptions {
        need_home: true,
        are_as_shown: false,
    };
    rig.post();
    assert_eq!(go(&mut rig, 2_000), (2_000, false));
    home(&mut rig, 0);
    assert_eq!(go(&mut rig, 2_000), (2_500, true));
}

#[test]
fn m57_a_new_offset_counts_from_the_next_homing_on() {
    let mut rig = rig(NONE);
    rig.configuration.position_limits = (-500, 500);
    home(&mut rig, 100);
    rig.configuration.homing.offset = 9_000;
    rig.post();
    assert_eq!(go(&mut rig, 2_000), (500, true));
    assert_eq!(rig.actuals().position_actual, 600);
}

/// In degrees of ten steps, as 60F2h bits 7 and 6 say.
fn turn_to(rig: &mut Rig, target: i32, code: u16) -> i64 {
    rig.commands.positioning_option = code << 6;
    rig.set_point(target, 0);
    rig.rest()
}

#[test]
fn m57_a_cable_ends_after_two_turns() {
    let mut rig = rig(Factors {
        range: (0, 359),
        ..ratio(10, 1)
    });
    rig.configuration.position_limits = (-720, 720);
    home(&mut rig, 0);
    for turn in [1_200, 2_400, 3_600, 4_800, 6_000, 7_200] {
        let target = turn / 10 % 360;
        assert_eq!(turn_to(&mut rig, target, 2), i64::from(turn));
        assert!(!rig.limited());
    }
    assert_eq!(turn_to(&mut rig, 120, 2), 7_200);
    assert!(rig.limited());
    // Written once more, they are where they were.
    rig.configuration.position_limits = (-720, 719);
    assert_eq!(turn_to(&mut rig, 120, 2), 7_200, "no way back unasked");
    assert_eq!(turn_to(&mut rig, 300, 1), 6_600);
    assert_eq!(turn_to(&mut rig, 120, 2), 7_190);
}

#[test]
fn m57_before_homing_limits_are_those_between_which_the_motor_stands() {
    let mut rig = rig(Factors {
        range: (-180, 179),
        ..ratio(10, 1)
    });
    assert_eq!(turn_to(&mut rig, 185, 0), 1_850);
    rig.configuration.position_limits = (150, 190);
    assert_eq!(turn_to(&mut rig, 160, 3), 1_600);
    assert_eq!(turn_to(&mut rig, -100, 3), 1_900);
    // Beyond them in every turn: those of the turn in which it stands.
    rig.configuration.position_limits = (-20, 20);
    assert_eq!(turn_to(&mut rig, -10, 0), 3_500);
}

#[test]
fn m58_limits_turn_with_the_polarity() {
    let mut rig = rig(Factors {
        polarity: 0x80,
        ..ratio(2, 1)
    });
    rig.configuration.position_limits = (-100, 300);
    rig.post();
    assert_eq!(go(&mut rig, 1_000), (-600, true));
    assert_eq!(go(&mut rig, -1_000), (200, true));
    rig.commands.mode = 3;
    rig.commands.target_velocity = (-5_000).into();
    rig.post();
    rig.ticks(1_000);
    assert_eq!(rig.motor.position, -600);
    assert_eq!(rig.actuals().position_actual, 300);
    assert!(rig.limited());
}

#[test]
fn m44_a_velocity_stops_at_a_limit_further_away_than_one_motion() {
    let mut rig = rig(ratio(u32::MAX, 1));
    rig.configuration.position_limits = (-10, 10);
    rig.commands.mode = 3;
    rig.commands.target_velocity = 5_000.into();
    rig.post();
    rig.ticks(100);
    assert!(rig.speed() > 0);
    assert!(!rig.limited());
}

#[test]
fn m58_homing_looks_for_its_switches_in_increments() {
    let mut rig = rig(Factors {
        polarity: 0xC0,
        ..ratio(10, 1)
    });
    rig.configuration.inputs.home = 1;
    rig.configuration.homing = HomingConfiguration {
        method: 19,
        search_speed: 10_000.into(),
        zero_speed: 1_000.into(),
        acceleration: 200_000,
        offset: 7,
        ..HomingConfiguration::NONE
    };
    rig.commands.mode = 6;
    rig.write(0x0F);
    rig.ticks(2);
    rig.write(0x1F);
    for _ in 0..20_000 {
        rig.digital.levels = u8::from(rig.motor.position >= 400);
        rig.tick();
        if rig.has(crate::statusword::HOMING_ATTAINED) {
            break;
        }
    }
    // The switch lies in positive direction, as it would without polarity.
    assert!((300..=400).contains(&rig.motor.position));
    let behind = 400 - i32::try_from(rig.motor.position).unwrap();
    // At home 6064h is 607Ch; towards smaller increments it grows.
    let shown = rig.actuals().position_actual;
    assert!(
        (shown - 7 - behind / 10).abs() <= 1,
        "{shown}, {behind} steps behind"
    );
    assert_eq!(rig.actuals().position_actual_internal, -70 - behind);
}
