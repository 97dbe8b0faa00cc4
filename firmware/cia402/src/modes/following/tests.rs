//! The numbers behind following: ways, ramps and what is left of a way before an end.

use proptest::prelude::*;

use super::*;

#[test]
fn a_way_is_velocity_times_time() {
    let millisecond = seconds(1_000 << POINT);
    assert_eq!(way_at(1_000_000.into(), millisecond) >> POINT, 999);
    assert_eq!(
        way_at(2_000_000.into(), seconds(500_000 << POINT)) >> POINT,
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
        let found = root(square);
        assert!(found <= number);
        assert!(number - found <= number >> 20, "{number}: {found}");
    }
}

proptest! {
    /// A motor that begins with the longest way allowed, and takes the longest in each period, ends within the room.
    #[test]
    fn m44_braking_never_needs_more_room_than_there_is(
        room in 0_i64..1 << 40,
        gain in 1_i64..1 << 30,
        begin in 0_i64..1 << 36,
    ) {
        let mut left = room;
        let mut way = begin;
        for _ in 0..200 {
            let most = braking_way(left, gain);
            let slowest = way.saturating_sub(gain).max(0);
            // After the first period the ramp is gentle enough to be kept.
            way = most.min(way);
            prop_assert!(way <= left);
            left -= way;
            if slowest == 0 {
                break;
            }
        }
        prop_assert!(left >= 0);
    }

    #[test]
    fn m44_a_way_never_leads_out_of_the_travel(
        at in -1_000_i64..1_000,
        need in -5_000_i64..5_000,
        ends in (-500_i64..0, 0_i64..500),
    ) {
        let travel = Travel { user: ends, increments: ends };
        let at = at << POINT;
        let end = at + within_travel(at, need << POINT, travel);
        let (low, high) = (ends.0 << POINT, ends.1 << POINT);
        prop_assert!(end >= low.min(at) && end <= high.max(at));
    }
}
