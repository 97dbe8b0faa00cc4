//! Positions, and distances in a period of set-points: what a velocity, an acceleration and a distance to stop within are in one.
//!
//! Positions have 16 bits behind the point, times are Q16 microseconds, or seconds in Q32.

use motion::{Position, Speed, low};

use super::{Knot, POINT};
use crate::cyclic::MicrosQ16;

/// How far the axis is from a position.
pub(super) const fn away(at: i64, position: Position) -> i64 {
    let away = position.bits().wrapping_sub(to(at).bits()) >> (32 - POINT);
    // What is rounded off does not count.
    if away == -1 || away == 1 { 0 } else { away }
}

/// The whole increments of a position, modulo 2³².
pub(super) const fn whole(at: i64) -> i32 {
    low::i32(at >> POINT)
}

/// A position for the axis.
pub(super) const fn to(at: i64) -> Position {
    Position::from_bits(at.wrapping_shl(32 - POINT))
}

/// A distance in so much time, over another time.
#[inline(never)]
pub(super) fn over(distance: i64, time: MicrosQ16, another: MicrosQ16) -> i64 {
    if distance == 0 || time == another {
        return distance;
    }
    let ratio = (another << POINT).checked_div(time).unwrap_or(0);
    low::i64(i128::from(distance).wrapping_mul(ratio.into()) >> POINT)
}

/// The velocity between two distances, as a distance: the mean of them, but so that no cubic passes its ends.
pub(super) fn slope(before: i64, behind: i64) -> i64 {
    if (before < 0) != (behind < 0) {
        return 0;
    }
    let least = before.saturating_abs().min(behind.saturating_abs());
    let max = least.saturating_mul(3);
    let mean = before.wrapping_add(behind) / 2;
    mean.max(max.wrapping_neg()).min(max)
}

/// A time in seconds, Q32.
pub(in crate::modes) fn seconds(time: MicrosQ16) -> u64 {
    const PER_TICK: u64 = (1 << 48) / 1_000_000;
    let (high, low) = (time >> 32, time & u64::from(u32::MAX));
    high.wrapping_mul(PER_TICK)
        .wrapping_add(low.wrapping_mul(PER_TICK) >> 32)
}

/// The distance at a velocity.
pub(in crate::modes) fn distance_at(velocity: Speed, seconds: u64) -> i64 {
    let distance = scaled(velocity.bits(), seconds);
    i64::try_from(distance >> (32 - POINT)).unwrap_or(i64::MAX)
}

/// By how much the distance in a period grows from one to the next, at an acceleration in increments/s².
pub(in crate::modes) fn gain(acceleration: u32, seconds: u64) -> i64 {
    let velocity = scaled(u64::from(acceleration) << (32 - POINT), seconds);
    let distance = scaled(velocity, seconds).min(1 << 61);
    distance.cast_signed().clamp(1, i64::MAX / 4)
}

/// A number times another in Q32. One too large for a number is the largest.
pub(super) fn scaled(number: u64, by: u64) -> u64 {
    if u32::try_from(by).is_err() {
        let product = u128::from(number).wrapping_mul(by.into()) >> 32;
        return u64::try_from(product).unwrap_or(u64::MAX);
    }
    let (high, low) = (number >> 32, number & u64::from(u32::MAX));
    high.wrapping_mul(by)
        .wrapping_add(low.wrapping_mul(by) >> 32)
}

/// Whether the motor can certainly stop within `available` after the distance s in a period: s² ≤ 2g·(available − s). False where it
/// cannot, and for distances too long to compute it.
pub(super) fn may_brake_behind(distance: u64, available: i64, gain: i64) -> bool {
    let (available, gain) = (available.max(0).unsigned_abs(), gain.max(1).unsigned_abs());
    let is_short = u32::try_from(distance).is_ok();
    is_short
        && available.checked_sub(distance).is_some_and(|behind| {
            distance.wrapping_mul(distance) <= gain.saturating_mul(2).saturating_mul(behind)
        })
}

/// Increments with their bits behind the point. What does not fit is the end of the numbers.
pub(super) const fn distance_q16(increments: i64) -> i64 {
    let distance = increments.wrapping_shl(POINT);
    if distance >> POINT == increments {
        distance
    } else if increments < 0 {
        i64::MIN
    } else {
        i64::MAX
    }
}

/// The longest distance in a period after which the motor can still stop within `available`, when the distance can be less by `gain` in each
/// period: s + s²/2g ≤ available.
pub(in crate::modes) fn braking_distance(available: i64, gain: i64) -> i64 {
    let (available, gain) = (available.max(0).unsigned_abs(), gain.max(1).unsigned_abs());
    let squares = u128::from(gain)
        .wrapping_mul(gain.into())
        .saturating_add(u128::from(gain).wrapping_mul(available.into()) << 1);
    isqrt(squares).saturating_sub(gain).cast_signed()
}

/// The square root, rounded down.
pub(super) fn isqrt(square: u128) -> u64 {
    let wide = 64u32.saturating_sub((square >> 64).leading_zeros().saturating_sub(64));
    let shift = wide.div_ceil(2).wrapping_mul(2);
    u64::from(motion::isqrt(low::u64(square >> shift))).wrapping_shl(shift / 2)
}

/// Whether a cubic that begins and ends with these velocities goes on in its direction all along, and no faster than it may.
pub(super) const fn is_monotone(first: i64, last: i64, knot: Knot) -> bool {
    let sign = knot.distance.signum();
    let distance = knot.distance.saturating_abs();
    let (first, last) = (first.saturating_mul(sign), last.saturating_mul(sign));
    let (within, max) = (distance.saturating_mul(3), knot.max_distance);
    // The middle one of the three points that span the velocity.
    let middle = within.saturating_sub(first).saturating_sub(last);
    0 <= first && first <= within && last <= within && first <= max && last <= max && middle <= max
}
