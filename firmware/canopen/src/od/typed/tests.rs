//! Numbers of odd sizes and times.

use proptest::prelude::*;

use super::*;

#[test]
fn bytes_are_read_and_put_where_they_are() {
    let mut ram = [1, 2, 3, 4, 5];
    assert_eq!(bytes_at::<1, 3, 5>(&ram), [2, 3, 4]);
    put_at::<3, 2, 5>(&mut ram, [9, 8]);
    assert_eq!(ram, [1, 2, 3, 9, 8]);
    assert_eq!(bytes_at::<5, 0, 5>(&ram), []);
}

#[test]
fn numbers_of_odd_sizes_keep_their_sign() {
    assert_eq!(signed([0xFF, 0xFF, 0xFF]), -1);
    assert_eq!(signed([0x00, 0x00, 0x80]), -0x80_0000);
    assert_eq!(signed([0xFF, 0xFF, 0xFF, 0xFF, 0x7F]), 0x7F_FFFF_FFFF);
    assert_eq!(unsigned([0xFF, 0xFF, 0xFF]), 0xFF_FFFF);
    assert_eq!(signed_bytes::<3>(-0x80_0000), Ok([0, 0, 0x80]));
    assert_eq!(signed_bytes::<3>(0x80_0000), Err(OutOfRange));
    assert_eq!(unsigned_bytes::<3>(0xFF_FFFF), Ok([0xFF; 3]));
    assert_eq!(unsigned_bytes::<3>(0x100_0000), Err(OutOfRange));
    let told = std::format!("{OutOfRange}");
    assert_eq!(told, "the number does not fit the type of its object");
}

#[test]
fn the_reserved_bits_of_a_time_are_0() {
    let noon = DayTime {
        days: 0x1234,
        milliseconds: 43_200_000,
    };
    assert_eq!(noon.to_le_bytes(), [0x00, 0x2E, 0x93, 0x02, 0x34, 0x12]);
    assert_eq!(
        DayTime::from_le_bytes([0x00, 0x2E, 0x93, 0xF2, 0x34, 0x12]),
        noon
    );
    let too_large = DayTime {
        days: 0,
        milliseconds: u32::MAX,
    };
    assert_eq!(too_large.to_le_bytes(), [0xFF, 0xFF, 0xFF, 0x0F, 0, 0]);
}

#[test]
fn values_are_made_of_as_many_bytes_as_there_are() {
    assert_eq!(i32::of(&[0xFE, 0xFF, 0xFF]), -2);
    assert_eq!(i32::of(&[0xFE, 0xFF, 0xFF, 0x7F]), 0x7FFF_FFFE);
    for bytes in [3, 5, 6, 7] {
        assert_eq!(u64::of(&[0xFF; 7][..bytes]), (1 << (8 * bytes)) - 1);
        assert_eq!(i64::of(&[0xFF; 7][..bytes]), -1);
    }
    assert_eq!(u8::of(&[]), 0);
    assert!(bool::of(&[1]));
    assert_eq!(f32::of(&1.5_f32.to_le_bytes()), 1.5);
    assert_eq!(f64::of(&(-1.5_f64).to_le_bytes()), -1.5);
    assert_eq!(DayTime::of(&[0, 0, 0, 0, 2, 0]).days, 2);
}

proptest! {
    #[test]
    fn numbers_come_back(number in any::<i64>()) {
        prop_assert_eq!(signed(number.to_le_bytes()), number);
        prop_assert_eq!(signed_bytes::<8>(number), Ok(number.to_le_bytes()));
        let unsigned_number = number.cast_unsigned();
        prop_assert_eq!(unsigned(number.to_le_bytes()), unsigned_number);
        let short = number >> 8;
        prop_assert_eq!(signed_bytes::<7>(short).map(signed), Ok(short));
        prop_assert_eq!(unsigned_bytes::<7>(unsigned_number >> 8).map(unsigned), Ok(unsigned_number >> 8));
    }
}
