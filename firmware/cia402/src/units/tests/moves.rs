//! Profile position and profile velocity in units of the user.

use proptest::prelude::*;
use proptest::test_runner::contextualize_config;

use super::{Factors, NONE, Units, ratio, rig};
use crate::testing::Rig;

const RELATIVE_AT_ONCE: u16 = 0x60;

#[test]
fn r4_m31_ten_thousand_moves_of_a_unit_are_one_of_ten_thousand() {
    let mut rig = rig(ratio(10, 3));
    for _ in 0..10_000 {
        rig.set_point(1, RELATIVE_AT_ONCE);
        rig.tick();
    }
    assert_eq!(rig.rest(), 33_333);
    assert_eq!(rig.actuals().position_actual, 10_000);
    assert_eq!(rig.actuals().position_demand, 10_000);
    assert_eq!(rig.actuals().position_actual_internal, 33_333);
    rig.ticks(20);
    assert!(rig.reached());
}

#[test]
fn m73_at_rest_positions_read_as_they_were_given() {
    // Ten units are an increment: no increment lies on most of them.
    let mut rig = rig(ratio(1, 10));
    for (target, increments) in [(104, 10), (105, 11), (-1_234, -123), (0, 0), (3, 0)] {
        rig.set_point(target, 0);
        assert_eq!(rig.rest(), increments);
        let actuals = rig.actuals();
        assert_eq!(
            (actuals.position_demand, actuals.position_actual),
            (target, target)
        );
        assert_eq!(actuals.following_error, 0);
    }
}

#[test]
fn m31_what_relative_set_points_count_from_is_in_units_too() {
    for option in [0, 1, 2] {
        let mut rig = rig(ratio(1, 10));
        rig.commands.positioning_option = option;
        rig.set_point(104, 0);
        rig.rest();
        rig.set_point(104, RELATIVE_AT_ONCE);
        assert_eq!(rig.rest(), 21);
        assert_eq!(rig.actuals().position_actual, 208, "option {option}");
    }
}

#[test]
fn m32_a_relative_target_beyond_32_bits_is_cut_in_units() {
    let mut rig = rig(ratio(1, 100_000));
    rig.set_point(i32::MAX, 0);
    assert_eq!(rig.rest(), 21_475);
    assert!(!rig.limited());
    rig.set_point(100_000, RELATIVE_AT_ONCE);
    assert_eq!(rig.rest(), 21_475);
    assert!(rig.limited() && !rig.reached());
    assert_eq!(rig.actuals().position_actual, i32::MAX);
    rig.set_point(i32::MIN, RELATIVE_AT_ONCE);
    assert_eq!(rig.rest(), 0);
    assert_eq!(rig.actuals().position_actual, -1);
}

#[test]
fn m32_a_target_too_many_increments_away_is_cut() {
    let mut rig = rig(ratio(1_000, 1));
    rig.set_point(i32::MAX, 0);
    rig.ticks(5);
    assert!(rig.limited());
    assert!(rig.actuals().velocity_demand > 0);
    rig.set_point(i32::MIN, 0x20);
    rig.ticks(100);
    assert!(rig.limited());
    assert!(rig.actuals().velocity_demand < 0);
}

#[test]
fn m73_velocities_are_shown_in_units() {
    let mut rig = rig(Factors {
        velocity: (60, 1),
        ..ratio(10, 1)
    });
    rig.set_point(10_000, 0);
    rig.ticks(100);
    // 20,000 increments/s are 2,000 units/s, or 120,000 in a minute.
    assert_eq!(rig.actuals().velocity_demand, 120_000);
    assert_eq!(rig.actuals().velocity_actual, 120_000);
}

#[test]
fn m58_velocity_polarity_turns_profile_velocity() {
    let mut rig = rig(Factors {
        polarity: 0x40,
        ..NONE
    });
    rig.commands.mode = 3;
    // As the hooks hand it over: in increments.
    rig.commands.target_velocity = rig.configuration.units.velocity(5_000);
    rig.post();
    rig.ticks(20);
    assert!(rig.speed() < 0);
    assert_eq!(rig.actuals().velocity_demand, 5_000);
    assert!(
        rig.actuals().position_actual < 0,
        "positions are not turned"
    );
}

#[test]
fn m73_other_units_show_the_same_place() {
    let mut rig = rig(ratio(1, 10));
    rig.set_point(104, 0);
    rig.rest();
    rig.write(0x06);
    rig.ticks(3);
    rig.configuration.units = Units::new(ratio(2, 1)).unwrap();
    rig.post();
    rig.ticks(2);
    assert_eq!(rig.actuals().position_actual, 5);
    assert_eq!(rig.actuals().position_actual_internal, 10);
}

#[test]
fn i11_a_velocity_crosses_the_end_of_32_bits_of_units_without_a_jump() {
    // An increment is ten units, so they come to their end first.
    for sign in [1, -1] {
        let mut rig = Rig::new();
        rig.configuration.units = Units::new(ratio(1, 10)).unwrap();
        rig.commands.mode = 3;
        rig.commands.profile_acceleration = 10_000_000;
        rig.motor.position = i64::from(sign) * (i64::from(i32::MAX) / 10 - 5_000);
        rig.enable();
        rig.commands.target_velocity = (20_000 * sign).into();
        rig.post();
        rig.ticks(100);
        let mut before = rig.actuals().position_actual;
        assert_eq!(before.signum(), sign, "not there yet");
        for _ in 0..500 {
            assert_eq!(rig.speed(), i64::from(20 * sign));
            let now = rig.actuals().position_actual;
            assert_eq!(now.wrapping_sub(before), 200 * sign);
            before = now;
        }
        assert_eq!(before.signum(), -sign, "wrapped");
    }
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig::with_cases(64)))]

    #[test]
    fn i07_m31_relative_moves_add_up_to_the_absolute_one(
        increments in 1u32..300, units in 1u32..300, polarity: u8,
        distances in prop::collection::vec(-300i32..300, 1..12),
    ) {
        let factors = Factors { polarity, ..ratio(increments, units) };
        let mut relative = rig(factors);
        for distance in &distances {
            relative.set_point(*distance, RELATIVE_AT_ONCE);
            relative.ticks(3);
        }
        let mut absolute = rig(factors);
        let sum: i32 = distances.iter().sum();
        absolute.set_point(sum, 0);
        prop_assert_eq!(relative.rest(), absolute.rest());
        prop_assert_eq!(relative.actuals().position_actual, sum);
        prop_assert_eq!(absolute.actuals().position_actual, sum);
    }

    /// With numbers that have nothing in common: a unit is between a third of an increment and three.
    #[test]
    fn i07_relative_moves_add_up_with_any_ratio(
        increments in 1u32 << 30..=u32::MAX, units in 1u32 << 30..=u32::MAX, polarity: u8,
        distances in prop::collection::vec(-300i32..300, 1..12),
    ) {
        let factors = Factors { polarity, ..ratio(increments, units) };
        let mut relative = rig(factors);
        for distance in &distances {
            relative.set_point(*distance, RELATIVE_AT_ONCE);
            relative.ticks(3);
        }
        let sum: i32 = distances.iter().sum();
        let exact = f64::from(sum) * f64::from(increments) / f64::from(units);
        let real = relative.rest() as f64 * if polarity & 0x80 == 0 { 1.0 } else { -1.0 };
        prop_assert!((real - exact).abs() <= 0.500_001, "{} for {}", real, exact);
        prop_assert_eq!(relative.actuals().position_actual, sum);
    }

    #[test]
    fn m58_polarity_mirrors_the_motion(
        increments in 1u32..100, units in 1u32..100, targets in prop::array::uniform3(-3_000i32..3_000),
        bits in prop::array::uniform3(0u16..4),
    ) {
        let mut plain = rig(ratio(increments, units));
        let mut turned = rig(Factors { polarity: 0xC0, ..ratio(increments, units) });
        for (target, bits) in targets.into_iter().zip(bits) {
            plain.set_point(-target, bits << 5);
            turned.set_point(target, bits << 5);
            for _ in 0..40 {
                plain.tick();
                turned.tick();
                prop_assert_eq!(plain.motor.position, turned.motor.position);
                prop_assert_eq!(
                    plain.actuals().position_actual,
                    -turned.actuals().position_actual
                );
                prop_assert_eq!(
                    plain.actuals().velocity_demand,
                    -turned.actuals().velocity_demand
                );
            }
        }
    }
}
