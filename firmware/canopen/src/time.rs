//! Time as the device sees it: a 64-bit count of microseconds since power-on, so nothing reasons about wrap-around.

/// A point in time, in microseconds since power-on.
pub type Instant = fugit::Instant<u64, 1, 1_000_000>;

/// A span of time in microseconds.
pub type Duration = fugit::Duration<u64, 1, 1_000_000>;

/// The deadline of something that will never happen by itself. A quarter of the range, not its end: instants compare by
/// wrapping difference, so the end of the range would count as earlier than every real moment.
pub const NEVER: Instant = Instant::from_ticks(u64::MAX / 4);

/// Whether a moment has come. Two comparisons of the counts; the operators of [`Instant`] compare by wrapping difference,
/// which costs more and which nothing here needs.
#[inline]
pub(crate) const fn has_come(moment: Instant, now: Instant) -> bool {
    now.ticks() >= moment.ticks()
}

/// The earlier of two moments.
#[inline]
pub(crate) const fn earlier(first: Instant, second: Instant) -> Instant {
    if second.ticks() < first.ticks() {
        second
    } else {
        first
    }
}

/// When a span ends that has begun before, now that its length is another one. The beginning of time stands for a span that
/// never began.
#[inline(never)]
pub(crate) const fn with_length(end: Instant, old: Duration, new: Duration) -> Instant {
    if end.ticks() == 0 {
        return end;
    }
    let begin = end.ticks().saturating_sub(old.ticks());
    Instant::from_ticks(begin.saturating_add(new.ticks()))
}
