//! The numbers behind following: distances, ramps and what is left of a distance before an end.

use proptest::prelude::*;

use super::period::*;
use super::*;

#[test]
fn a_distance_is_velocity_times_time() {
    let millisecond = seconds(1_000 << POINT);
    assert_eq!(distance_at(1_000_000.into(), millisecond) >> POINT, 999);
    assert_eq!(
        distance_at(2_000_000.into(), seconds(500_000 << POINT)) >> POINT,
        999_999
    );
    // 100,000 increments/s² in a period of 10 ms: 10 more in each.
    let gain = gain(100_000, seconds(10_000 << POINT));
    assert!((gain - (10 << POINT)).abs() < 4, "{gain}");
}

#[test]
fn the_root_is_that_of_large_numbers_too() {
    for number in [0, 1, 2, 65_536, u64::MAX >> 1] {
        let square = u128::from(number) * u128::from(number);
        let found = isqrt(square);
        assert!(found <= number);
        assert!(number - found <= number >> 20, "{number}: {found}");
    }
}

proptest! {
    /// The short ways to work out are those of wide numbers.
    #[test]
    fn products_of_half_the_width_are_those_of_the_whole(
        (number, narrow) in (any::<u64>(), 0..64_u32),
        time in 0_u64..40_000_000 << POINT,
        acceleration: u32,
    ) {
        let number = number >> narrow;
        let per_tick = (1_u128 << 48) / 1_000_000;
        let seconds = seconds(time);
        prop_assert_eq!(u128::from(seconds), (u128::from(time) * per_tick) >> 32);
        let product = (u128::from(number) * u128::from(seconds)) >> 32;
        prop_assert_eq!(scaled(number, seconds), u64::try_from(product).unwrap_or(u64::MAX));
        let velocity = (u128::from(acceleration) * u128::from(seconds)) >> POINT;
        let change = ((velocity * u128::from(seconds)) >> 32).clamp(1, (i64::MAX / 4) as u128);
        prop_assert_eq!(u128::from(gain(acceleration, seconds).unsigned_abs()), change);
        prop_assert_eq!(distance_q16(number.cast_signed()), number.cast_signed().saturating_mul(1 << POINT));
    }

    /// Where there is plainly enough no root is needed: the distance is within it, and the root says so too where it is exact.
    #[test]
    fn m44_room_that_is_plainly_enough_is_what_the_root_allows(
        (distance, available, gain) in (any::<u64>(), 0_i64..i64::MAX, 1_i64..1 << 61),
        (short, tight, gentle) in (0..64_u32, 0..63_u32, 0..61_u32),
    ) {
        let (distance, available, gain) = (distance >> short, available >> tight, (gain >> gentle).max(1));
        let is_enough = may_brake_behind(distance, available, gain);
        let (s, r, g) = (u128::from(distance), available as u128, gain as u128);
        let fits = s <= r && s.checked_mul(s).is_some_and(|square| {
            square <= 2 * g * (r - s)
        });
        prop_assert_eq!(is_enough, fits && distance <= u64::from(u32::MAX));
        if g * g + 2 * g * r < 1 << 64 {
            let allowed = s <= u128::from(braking_distance(available, gain).unsigned_abs());
            prop_assert_eq!(is_enough, allowed);
        }
    }

    /// A motor that begins with the longest distance allowed, and takes the longest in each period, ends within what is available.
    #[test]
    fn m44_braking_never_needs_more_room_than_there_is(
        available in 0_i64..1 << 40,
        gain in 1_i64..1 << 30,
        begin in 0_i64..1 << 36,
    ) {
        let mut left = available;
        let mut distance = begin;
        for _ in 0..200 {
            let max = braking_distance(left, gain);
            let slowest = distance.saturating_sub(gain).max(0);
            // After the first period the ramp is gentle enough to be kept.
            distance = max.min(distance);
            prop_assert!(distance <= left);
            left -= distance;
            if slowest == 0 {
                break;
            }
        }
        prop_assert!(left >= 0);
    }

    #[test]
    fn m44_a_way_never_leads_out_of_the_travel(
        at in -1_000_i64..1_000,
        required in -5_000_i64..5_000,
        ends in (-500_i64..0, 0_i64..500),
    ) {
        let travel = Travel { user: ends, increments: ends };
        let at = at << POINT;
        let end = at + within_travel(at, required << POINT, travel);
        let (low, high) = (ends.0 << POINT, ends.1 << POINT);
        prop_assert!(end >= low.min(at) && end <= high.max(at));
    }
}
