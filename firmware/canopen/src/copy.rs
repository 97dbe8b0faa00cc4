//! Copies of a few bytes, as few loads and stores: for so few a call of `memcpy` would cost more than the copy.

/// Copies as many bytes as both have; unlike `copy_from_slice` it cannot panic.
#[inline(never)]
pub(crate) fn copy(to: &mut [u8], from: &[u8]) {
    let length = to.len().min(from.len());
    if length <= 8 {
        // Most are numbers and full segments.
        match length {
            1 => {
                copy_chunk::<1>(to, from);
            }
            4 => {
                copy_chunk::<4>(to, from);
            }
            7 => {
                copy_chunk::<7>(to, from);
            }
            _ => copy_few(to, from, length),
        }
        return;
    }
    copy_many(to, from, length);
}

/// Copies more than eight bytes, two words at a time: the processor takes words from any address, and `memcpy` would spend most of
/// its time on those that are not at whole words.
#[inline(never)]
fn copy_many(to: &mut [u8], from: &[u8], length: usize) {
    let (pairs, _) = to.as_chunks_mut::<8>();
    for (to, from) in pairs.iter_mut().zip(from.as_chunks::<8>().0) {
        // Word by word: of eight bytes the compiler would make a call of `memcpy` for all of them.
        let (to, from) = copy_chunk::<4>(to, from);
        copy_chunk::<4>(to, from);
    }
    let done = length & !7;
    if done != length
        && let (Some(to), Some(from)) = (to.get_mut(done..), from.get(done..))
    {
        copy_few(to, from, length & 7);
    }
}

/// Copies up to eight bytes, if both have them.
#[inline(never)]
pub(crate) fn copy_few(to: &mut [u8], from: &[u8], length: usize) {
    if length == 8 {
        copy_chunk::<8>(to, from);
        return;
    }
    let (mut to, mut from) = (to, from);
    if length & 4 != 0 {
        (to, from) = copy_chunk::<4>(to, from);
    }
    if length & 2 != 0 {
        (to, from) = copy_chunk::<2>(to, from);
    }
    if length & 1 != 0 {
        copy_chunk::<1>(to, from);
    }
}

/// Copies `N` bytes if both have them; returns what is behind them.
#[inline]
pub(crate) fn copy_chunk<'a, const N: usize>(
    to: &'a mut [u8],
    from: &'a [u8],
) -> (&'a mut [u8], &'a [u8]) {
    match (
        to.split_first_chunk_mut::<N>(),
        from.split_first_chunk::<N>(),
    ) {
        (Some((to, to_rest)), Some((from, from_rest))) => {
            *to = *from;
            (to_rest, from_rest)
        }
        _ => (&mut [], &[]),
    }
}

#[cfg(test)]
mod tests {
    use std::vec;

    use super::copy;

    #[test]
    fn as_many_bytes_as_both_have_are_copied() {
        let from = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11];
        for room in 0..=12 {
            for length in 0..=from.len() {
                let mut to = vec![0; room];
                copy(&mut to, &from[..length]);
                let copied = room.min(length);
                assert_eq!(to[..copied], from[..copied]);
                assert!(to[copied..].iter().all(|byte| *byte == 0));
            }
        }
    }
}
