//! Software limits: SWE1 and SWE2, which 607Dh:1 and :2 are too, and which of them count (SWCNFG).
//!
//! The manual gives no values of SWCNFG. Chosen: bit 0 is SWE1, bit 1 SWE2, and both count at first. What the drive obeys is an object of our own, 510Bh; none
//! counts where both are the same, as the manual has it with 0.

use canopen::cia301::sdo::AbortCode;
use canopen::od::{Dictionary, Entry};
use cia402::behaviour::{number, put_number};

use super::Seen;

/// 2000h: n06 and n07.
const BELOW: i64 = 1 << 5;
const ABOVE: i64 = 1 << 6;

const ACTS: u16 = 0x510B;
/// Objects that are the same number.
const PAIRS: [[(u16, u8); 2]; 2] = [[(0x607D, 1), (0x3604, 1)], [(0x607D, 2), (0x3606, 1)]];

pub(super) fn check(entry: &Entry, value: i64) -> Result<(), AbortCode> {
    let is_known = (entry.index, entry.sub) != (0x3600, 1) || (0..=3).contains(&value);
    is_known.then_some(()).ok_or(AbortCode::InvalidValue)
}

/// The same number goes into the other object of a pair.
pub(super) fn keep_same<D: Dictionary>(
    dictionary: &mut D,
    entry: &Entry,
    pairs: &[[(u16, u8); 2]],
) {
    let own = (entry.index, entry.sub);
    for [one, other] in pairs {
        let (index, sub) = match own {
            own if own == *one => *other,
            own if own == *other => *one,
            _ => continue,
        };
        let value = number(dictionary, own.0, own.1);
        put_number(dictionary, index, sub, value);
    }
}

/// Returns whether the limits are others now.
pub(super) fn written<D: Dictionary>(dictionary: &mut D, entry: &Entry) -> bool {
    if !matches!(entry.index, 0x607D | 0x3600 | 0x3604 | 0x3606) {
        return false;
    }
    keep_same(dictionary, entry, &PAIRS);
    let which = number(dictionary, 0x3600, 1);
    let [low, high] = [1, 2].map(|sub| number(dictionary, 0x607D, sub));
    let (low, high) = match which {
        1 => (low, i32::MAX.into()),
        2 => (i32::MIN.into(), high),
        3 => (low, high),
        _ => (0, 0),
    };
    put_number(dictionary, ACTS, 1, low);
    put_number(dictionary, ACTS, 2, high);
    true
}

/// The warnings of a motor that is at a limit or beyond.
pub(super) fn warnings<D: Dictionary>(dictionary: &D, seen: &Seen) -> i64 {
    let [low, high] = [1, 2].map(|sub| number(dictionary, ACTS, sub));
    let position = i64::from(seen.position);
    match (low, high) {
        (low, high) if low >= high => 0,
        (low, _) if position <= low => BELOW,
        (_, high) if position >= high => ABOVE,
        _ => 0,
    }
}
