//! What bounds a set-point and the distance to it: one motion, the software limits, and what rounding makes of them.

use super::period::distance_q16;
use super::{Context, POINT, Types};
use crate::motor::REACH;
use crate::travel::Travel;

/// A set-point, no farther away than one motion may lead.
pub(super) fn within_reach(target: i64, here: i64) -> i64 {
    let (away, is_beyond) = target.overflowing_sub(here);
    if !is_beyond && away.unsigned_abs() <= REACH.unsigned_abs() {
        return target;
    }
    if target < here {
        here.saturating_sub(REACH)
    } else {
        here.saturating_add(REACH)
    }
}

/// The distance that stays within the software limits, or leads back to them.
pub(super) fn within_travel(at: i64, required: i64, travel: Travel) -> i64 {
    let (low, high) = travel.increments;
    let low = distance_q16(low).min(at);
    let high = distance_q16(high).max(at);
    at.saturating_add(required)
        .max(low)
        .min(high)
        .saturating_sub(at)
}

/// Twice a unit of the user and an increment: what rounding four ends may make of the difference between two distances.
pub(super) fn rounding(context: &Context<'_, impl Types>) -> i64 {
    let unit = context.units().position(1).saturating_abs();
    let max = unit.max(1).saturating_add(1).saturating_mul(2);
    max.min(1 << 40) << POINT
}
