//! Ends.

use super::*;

#[test]
fn numbers_stop_at_the_ends_of_their_type() {
    assert_eq!(u32::nearest(-1), 0);
    assert_eq!(u32::nearest(1 << 40), u32::MAX);
    assert_eq!(i8::nearest(-200), -128);
    assert_eq!(i8::nearest(200), 127);
    assert_eq!(u64::nearest(-5), 0);
    assert_eq!(u64::MAX.number(), i64::MAX);
    assert!(bool::nearest(2));
}
