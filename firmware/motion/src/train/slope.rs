//! Pulses of a velocity that changes evenly: from one pulse to another.

use super::steady::{EARLY, STRETCHED};
use super::{LONGEST_RUN, Train};
use crate::clock::Ticks;
use crate::fixed::Position;
use crate::record::{Direction, SHORTEST_RECORD};

/// Where a run has fewer pulses than a period has so many ticks, its periods may be all alike: the last pulse is off by less than a 256th of a step.
const ROUGH: u32 = 128;

/// A stretch of such a velocity.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stretch {
    /// When it begins: the commit horizon.
    pub(crate) begin: Ticks,
    pub(crate) direction: Direction,
    /// In that direction: how far the axis is ahead of its steps there, and the way in the first `wanted` ticks; Q32 steps.
    pub(crate) ahead: i64,
    pub(crate) way: u64,
    /// The speed at the beginning and `wanted` ticks later, Q32 steps per tick.
    pub(crate) first_rate: u32,
    pub(crate) rate: u32,
    pub(crate) wanted: u32,
    /// It is shorter than that.
    pub(crate) left: Ticks,
    pub(crate) speeding_up: bool,
}

impl Train {
    /// The speed of a pulse in each segment, Q32 steps per tick.
    #[inline]
    pub(crate) const fn slowest(&self) -> u32 {
        self.slowest
    }

    /// How far `position` is ahead of the steps made, Q32 steps.
    #[inline]
    pub(crate) const fn ahead(&self, position: Position) -> i64 {
        let made = (self.steps as i64).wrapping_shl(32);
        position.bits().wrapping_sub(made)
    }

    /// Goes on along a stretch up to its first pulse `wanted` ticks after its beginning or later. Gives the ticks that it took; `None`, and nothing is
    /// made, if the pulses before were not where they belong, too little is left, or the driver needs longer periods.
    #[inline]
    pub(crate) fn climb(&mut self, stretch: &Stretch) -> Option<u32> {
        // From the middle before the last step made: less than a step, or a little before its beginning.
        let beyond = stretch.ahead.wrapping_add(1 << 31);
        let direction = stretch.direction;
        if beyond.wrapping_add(EARLY).cast_unsigned() >= (1 << 32) + EARLY.cast_unsigned()
            || self.direction != Some(direction)
        {
            return None;
        }
        let there = beyond.wrapping_add_unsigned(stretch.way);
        let pulses = ((there >> 32) as u32).wrapping_add(1);
        let rest = !(there as u32);
        let length = stretch.wanted.wrapping_add(rest.checked_div(stretch.rate)?);
        let fastest = u64::from(pulses).wrapping_mul(self.shortest.into());
        if Ticks::from(length.wrapping_add(STRETCHED)) >= stretch.left
            || !(1..=LONGEST_RUN).contains(&pulses)
            || u64::from(length).wrapping_add(SHORTEST_RECORD.into()) < fastest
        {
            return None;
        }
        if self.open_at(stretch.begin) == 0 && self.has_pulse() {
            // At the driver's highest rate it may be a tick more.
            let span = length.max(fastest as u32);
            self.share(pulses, span, stretch.speeding_up, direction);
        } else {
            self.begin_climb(*stretch, beyond, pulses, length)?;
        }
        let made = pulses.cast_signed().wrapping_mul(direction.sign());
        self.steps = self.steps.wrapping_add(made);
        Some((self.pen as u32).wrapping_sub(stretch.begin as u32))
    }

    /// The same where the stretch does not begin with a pulse: silence up to its first one, which is behind `beyond`.
    #[inline(never)]
    fn begin_climb(
        &mut self,
        stretch: Stretch,
        beyond: i64,
        pulses: u32,
        length: u32,
    ) -> Option<()> {
        let rest = !u32::try_from(beyond).ok()?;
        let first = rest.checked_div(stretch.first_rate)?;
        let gaps = pulses.wrapping_sub(1);
        let first = if gaps == 0 { length } else { first };
        let span = length.checked_sub(first)?;
        let silence = self.open_at(stretch.begin).checked_add_unsigned(first)?;
        let is_slow = u64::from(span) >= u64::from(gaps).wrapping_mul(self.shortest.into());
        if silence < self.least.cast_signed() || !is_slow {
            return None;
        }
        self.silence(silence.cast_unsigned(), stretch.direction);
        self.open_step = stretch.direction.sign();
        if gaps > 0 {
            self.space(gaps, span, stretch.speeding_up, stretch.direction);
        }
        Some(())
    }

    /// As [`Train::space`], in one run where that does not show.
    #[inline(always)]
    fn share(&mut self, gaps: u32, span: u32, speeding_up: bool, direction: Direction) {
        let period = span.wrapping_add(gaps >> 1).checked_div(gaps).unwrap_or(0);
        if gaps >= period / ROUGH {
            self.space(gaps, span, speeding_up, direction);
            return;
        }
        self.period = period;
        self.put(period, gaps, direction);
        let ticks = period.wrapping_mul(gaps);
        self.pen = self.pen.wrapping_add(ticks.into());
    }
}
