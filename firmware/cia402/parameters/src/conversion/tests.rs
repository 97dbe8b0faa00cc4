//! Scales.

use proptest::prelude::*;

use super::*;

#[test]
fn numbers_are_scaled_and_moved() {
    let tenths = Conversion::new(1, 10, 0);
    assert_eq!(tenths.to_parameter(1234), 123);
    assert_eq!(tenths.to_object(123), 1230);
    let mirrored = Conversion::new(-256, 1, 1000);
    assert_eq!(mirrored.to_parameter(3), 232);
    assert_eq!(mirrored.to_object(232), 3);
}

#[test]
fn halves_are_rounded_away_from_zero() {
    let half = Conversion::new(1, 2, 0);
    for (object, parameter) in [(1, 1), (-1, -1), (3, 2), (-3, -2), (4, 2), (0, 0)] {
        assert_eq!(half.to_parameter(object), parameter, "{object}");
    }
    let minus_half = Conversion::new(1, -2, 0);
    assert_eq!(minus_half.to_parameter(1), -1);
    assert_eq!(minus_half.to_parameter(-1), 1);
}

proptest! {
    #[test]
    fn the_result_is_the_nearest(object in any::<i32>(), numerator in 1..i32::MAX, denominator in 1..i32::MAX) {
        let result = Conversion::new(numerator, denominator, 0).to_parameter(object.into());
        let exact = i128::from(object) * i128::from(numerator);
        let error = (i128::from(result) * i128::from(denominator) - exact).abs();
        prop_assert!(2 * error <= i128::from(denominator));
    }

    #[test]
    fn nothing_overflows(value in any::<i64>(), numerator in any::<i32>(), denominator in any::<i32>(), offset in any::<i64>()) {
        prop_assume!(numerator != 0 && denominator != 0);
        let conversion = Conversion::new(numerator, denominator, offset);
        let _ = (conversion.to_parameter(value), conversion.to_object(value));
    }

    #[test]
    fn a_whole_scale_comes_back(object in -1_000_000_i64..1_000_000, scale in 1..1000, offset in -1000_i64..1000) {
        let conversion = Conversion::new(scale, 1, offset);
        prop_assert_eq!(conversion.to_object(conversion.to_parameter(object)), object);
    }
}
