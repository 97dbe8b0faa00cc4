//! Where the entries of an object begin: found by its index at once, not by a search.
//!
//! A bucket holds the position of the first entry of an object. The index tells the bucket (multiplicative hashing, which spreads
//! neighbours far apart); an object whose bucket is taken is in the next one that was free.

use super::Entry;

/// A bucket of no object.
pub(super) const EMPTY: u16 = u16::MAX;

/// 2^32 divided by the golden ratio.
const SPREAD: u32 = 0x9E37_79B1;

/// The buckets of a table of entries, for [`super::Table::buckets`]. `N` is a power of two, at least 2, and more than there are
/// objects; where a quarter is empty, most objects are found at once.
///
/// # Panics
/// When it is compiled: `N` is another number, or there are more than 65,535 entries.
pub const fn buckets<const N: usize>(entries: &[Entry]) -> [u16; N] {
    assert!(N >= 2 && N.is_power_of_two(), "not a power of two");
    assert!(entries.len() <= EMPTY as usize, "too many entries");
    let mut buckets = [EMPTY; N];
    let (mut position, mut objects, mut rest) = (0, 0, entries);
    // No object has index 0.
    let mut last = 0;
    while let [entry, behind @ ..] = rest {
        if entry.index != last {
            last = entry.index;
            objects += 1;
            assert!(objects < N, "too few buckets");
            put(&mut buckets, last, position);
        }
        position += 1;
        rest = behind;
    }
    buckets
}

/// Puts an object into the first bucket from its own on that is free.
const fn put(buckets: &mut [u16], index: u16, position: u16) {
    let mut bucket = first(index, buckets.len());
    while let Some((_, [taken, ..])) = buckets.split_at_mut_checked(bucket) {
        if *taken == EMPTY {
            *taken = position;
            return;
        }
        bucket = next(bucket, buckets.len());
    }
}

/// The bucket that an object of this index is in, if it was free.
#[inline]
pub(super) const fn first(index: u16, count: usize) -> usize {
    // The highest bits, as many as a bucket's number has.
    let unused = (count as u32).leading_zeros().wrapping_add(1);
    (index as u32).wrapping_mul(SPREAD).wrapping_shr(unused) as usize
}

/// The one behind it; the first one is behind the last.
#[inline]
pub(super) const fn next(bucket: usize, count: usize) -> usize {
    bucket.wrapping_add(1) & count.wrapping_sub(1)
}
