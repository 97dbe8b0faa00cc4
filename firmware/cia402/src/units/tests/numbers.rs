//! Conversions by themselves.

use motion::Speed;
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;

use super::{NONE, ratio};
use crate::parameters::{ALL, Features, Parameter};
use crate::units::{Factors, Units};

#[test]
fn m73_the_factors_are_multiplied_as_cia_402_says() {
    // 3200 steps a revolution, a gear of 5:2, a screw that moves 4 mm, shown in micrometres.
    let units = Units::new(Factors {
        position_encoder: Some((3_200, 1)),
        gear: (5, 2),
        feed: (4_000, 1),
        // Velocities in mm/min, accelerations in mm/s².
        velocity: (60, 1_000),
        acceleration: (1, 60),
        ..NONE
    })
    .unwrap();
    assert_eq!(units.position(4_000), 8_000);
    assert_eq!(units.position_in_units(8_000), 4_000);
    // 240 mm/min are 4 mm/s.
    assert_eq!(units.velocity(240), 8_000.into());
    assert_eq!(units.velocity_in_units((-8_000).into()), -240);
    assert_eq!(units.acceleration(4), 8_000);
    assert_eq!(units.motor_speed(60), 3_200.into());
}

#[test]
fn m73_velocities_have_an_encoder_of_their_own_if_it_is_told() {
    let units = Units::new(Factors {
        velocity_encoder: (500, 1),
        ..ratio(1_000, 1)
    })
    .unwrap();
    assert_eq!(
        (units.position(3), units.velocity(3)),
        (3_000, 1_500.into())
    );
}

#[test]
fn m73_without_an_encoder_6080h_is_in_increments() {
    let units = Units::new(Factors {
        position_encoder: None,
        ..NONE
    })
    .unwrap();
    assert_eq!(units.motor_speed(1_234), 1_234.into());
    assert_eq!(units, Units::NONE);
}

#[test]
fn m73_an_amount_does_not_become_nothing() {
    let units = Units::new(ratio(1, 1_000)).unwrap();
    let thousandth = Speed::from_bits((1 << 32) / 1_000);
    assert_eq!([units.speed(0), units.speed(1)], [Speed::ZERO, thousandth]);
    assert_eq!([units.acceleration(0), units.acceleration(1)], [0, 1]);
    assert_eq!(units.velocity(-1), thousandth.signed(true));
    let tiny = Units::new(ratio(1, u32::MAX)).unwrap();
    assert_eq!(tiny.speed(1), Speed::LEAST);
    let tiny = Units::new(Factors {
        velocity: (1_000, 1),
        ..ratio(1, u32::MAX)
    })
    .unwrap();
    assert_eq!(tiny.velocity(1), Speed::LEAST.signed(false), "not nothing");
    assert_eq!(tiny.speed_window(1), Speed::ZERO, "a window is rounded");
}

#[test]
fn m73_a_unit_may_be_a_step_in_an_hour() {
    let units = Units::new(Factors {
        velocity: (3_600, 1),
        ..NONE
    })
    .unwrap();
    let hour = Speed::from_bits(((1 << 32) + 1_800) / 3_600);
    assert_eq!(units.velocity(1), hour.signed(false));
    assert_eq!(units.velocity(-3_600), (-1).into());
    for user in [0, 1, -1, 7, 3_599, -86_400_000, i32::MAX, i32::MIN] {
        assert_eq!(units.velocity_in_units(units.velocity(user)), user);
    }
}

#[test]
fn m60_a_window_that_is_off_stays_off_and_no_other_becomes_it() {
    let units = Units::new(ratio(1_000, 1)).unwrap();
    assert_eq!(units.window(u32::MAX), u32::MAX);
    assert_eq!(units.window(u32::MAX - 1), u32::MAX - 1);
    assert_eq!(units.window(7), 7_000);
}

#[test]
fn m58_each_polarity_turns_its_own_kind() {
    for (polarity, position, velocity) in [(0, 5, 7), (0x80, -5, 7), (0x40, 5, -7), (0xC0, -5, -7)]
    {
        let units = Units::new(Factors { polarity, ..NONE }).unwrap();
        assert_eq!(units.position(5), position);
        assert_eq!(units.position_in_units(position), 5);
        assert_eq!(units.velocity(7), velocity.into());
        assert_eq!(units.velocity_in_units(velocity.into()), 7);
        assert_eq!(units.speed(7), 7.into(), "amounts have no sign");
    }
}

#[test]
fn m73_factors_that_make_no_ratio_are_none() {
    let large = Some((u32::MAX, 1));
    for factors in [
        Factors {
            gear: (0, 1),
            ..NONE
        },
        Factors {
            feed: (1, 0),
            ..NONE
        },
        Factors {
            position_encoder: large,
            gear: (u32::MAX, 1),
            feed: (1, u32::MAX),
            ..NONE
        },
        Factors {
            position_encoder: large,
            velocity: (1, u32::MAX),
            acceleration: (1, u32::MAX),
            ..NONE
        },
    ] {
        assert_eq!(Units::new(factors), None);
    }
}

fn factors() -> impl Strategy<Value = Factors> {
    let factor = || (any::<u32>(), 0u32..32).prop_map(|(number, shift)| (number >> shift).max(1));
    let pair = move || (factor(), factor());
    (
        (pair(), pair(), pair()),
        (pair(), pair(), any::<u8>()),
        (any::<i32>(), any::<i32>()),
    )
        .prop_map(
            |((encoder, gear, feed), (velocity, acceleration, polarity), range)| Factors {
                position_encoder: Some(encoder),
                velocity_encoder: (0, 1),
                gear,
                feed,
                velocity,
                acceleration,
                polarity,
                range,
            },
        )
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig::with_cases(4096)))]

    #[test]
    fn m73_positions_come_back(factors in factors(), user: i32) {
        let Some(units) = Units::new(factors) else {
            return Ok(());
        };
        let user = i64::from(user);
        let increments = units.position(user);
        prop_assert_eq!(units.position(-user), -increments);
        let product = |factors: [u32; 3]| factors.map(u128::from).into_iter().product::<u128>();
        let encoder = factors.position_encoder.unwrap();
        // A unit is an increment at least.
        let is_coarse = product([encoder.0, factors.gear.0, factors.feed.1]) >= product([encoder.1, factors.gear.1, factors.feed.0]);
        if is_coarse && increments.unsigned_abs() < 1 << 62 {
            prop_assert_eq!(units.position_in_units(increments), user);
        }
    }

    #[test]
    fn m73_positions_come_back_from_units_of_little_more_than_an_increment(unit in 1u32..1 << 31, more in 0u32..1 << 30, user: i32) {
        let units = Units::new(ratio(unit + more % unit / 2, unit)).unwrap();
        prop_assert_eq!(units.position_in_units(units.position(user.into())), user.into());
    }

    #[test]
    fn m73_extremes_never_panic(factors in factors(), number: u32) {
        let Some(units) = Units::new(factors) else {
            return Ok(());
        };
        for number in [0, 1, number, u32::MAX] {
            units.speed(number);
            units.acceleration(number);
            units.motor_speed(number);
            units.window(number);
            let signed = number.cast_signed();
            units.velocity(signed);
            units.velocity_in_units(signed.into());
            units.distance_in_units(signed);
        }
        for number in [i32::MIN, i32::MAX, number.cast_signed()] {
            let increments = units.position(number.into());
            units.range().shown(units.position_in_units(increments));
        }
        units.position_in_units(i64::MIN);
        units.position(i64::MIN);
    }
}

#[test]
fn m73_without_an_object_of_the_units_a_unit_is_an_increment() {
    let factors = Factors::of(&crate::objects::Everything);
    assert_eq!(Units::new(factors), Some(Units::NONE));
    let has = |parameter| Features::of(&[parameter], 0, false).units;
    assert!(has(Parameter::Feed) && has(Parameter::Polarity));
    assert!(!has(Parameter::TargetPosition));
    let factors = ALL.iter().map(|description| description.parameter);
    assert!(factors.filter(|one| Factors::has(*one)).all(has));
}
