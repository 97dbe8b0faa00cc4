//! When a straight line crosses the middles between steps.

use crate::divide::estimate;

/// When a chord passes a distance from its beginning. One division of 64 bits by 32 for all its crossings, and for those of the
/// chords behind it that are like it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Crossings {
    /// The chord's length in ticks.
    length: u32,
    /// How far ways are shifted so that 32 bits hold them and the chord's has no leading zeros: down, or up if it is less than a
    /// step.
    down: u32,
    up: u32,
    /// Ticks for 2³² units of a way so shifted. A tick is lost at most.
    pace: u32,
}

impl Crossings {
    /// Those of a chord of so many ticks that goes `way`, Q32 steps, less than 2³¹ of them.
    pub(crate) fn new(length: u32, way: u64) -> Self {
        let above = (way >> 32) as u32;
        let mut crossings = Self {
            length,
            down: 32_u32.wrapping_sub(above.leading_zeros()),
            up: 0,
            pace: 0,
        };
        if above == 0 {
            crossings.up = (way as u32).leading_zeros() & 31;
        }
        let leading = crossings.shifted(way);
        crossings.pace = estimate(u64::from(length) << 32, leading);
        crossings
    }

    /// 32 bits of a way, which is not longer than the chord's.
    #[inline]
    fn shifted(&self, way: u64) -> u32 {
        if self.down == 0 {
            (way as u32).wrapping_shl(self.up)
        } else {
            // A chord is shorter than 2³¹ steps.
            let above = ((way >> 32) as u32).wrapping_shl(32_u32.wrapping_sub(self.down));
            above | (way as u32).wrapping_shr(self.down)
        }
    }

    /// Ticks from the chord's beginning until it has gone `distance`, Q32 steps; 0 for what lies behind it.
    #[inline]
    pub(crate) fn after(&self, distance: i64) -> u32 {
        let part = self.shifted(distance.max(0).cast_unsigned());
        let ticks = u64::from(part).wrapping_mul(self.pace.into()) >> 32;
        (ticks as u32).min(self.length)
    }
}
