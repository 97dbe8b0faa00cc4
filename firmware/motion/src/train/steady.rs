//! Pulses of a velocity that stays: from one pulse to another, with no chord to be looked at.

use super::{Chord, LONGEST_RUN, MANY, Train};
use crate::clock::Ticks;
use crate::fixed::Position;
use crate::record::{Direction, SHORTEST_RECORD};

/// How far before its tick the last pulse may have been made, in steps, Q32: at the highest rates it is a few ticks of not many.
pub(super) const EARLY: i64 = 1 << 30;

/// A run may be longer by so many ticks than it should be, where it would be too short for a record otherwise.
pub(super) const STRETCHED: u32 = 2 * SHORTEST_RECORD;

impl Train {
    /// Whether the last chord was steady and has all its pulses: [`Train::go_on`] can take over.
    #[inline]
    pub(crate) const fn is_even(&self) -> bool {
        self.even
    }

    /// Goes on as in the chord before, which was steady, from tick `begin`, where the axis is at `from`, with a step in `pace` ticks, Q32, less
    /// than 2³¹: up to the first pulse `wanted` ticks later or more, or where pulses are more than a segment apart, with silence for so many.
    /// Gives the ticks that it took, less than `left`; `None`, and nothing is made, if that is too few or the driver needs a longer period.
    ///
    /// The ticks are counted from where the axis is, so nothing that is rounded adds up.
    #[inline]
    pub(crate) fn go_on(
        &mut self,
        begin: Ticks,
        from: Position,
        pace: u64,
        wanted: u32,
        left: Ticks,
    ) -> Option<u32> {
        let direction = self.direction?;
        // As if it went forward: the way since the middle before the last step made, and the ticks for it, Q32.
        let ahead = from.bits().wrapping_sub(i64::from(self.steps) << 32);
        let beyond = match direction {
            Direction::Forward => ahead,
            Direction::Reverse => ahead.wrapping_neg(),
        };
        let beyond = beyond.wrapping_add(1 << 31);
        // Less than a step, or a little before its beginning.
        let is_before = beyond < 0;
        if (beyond >> 32) as i32 != 0 && !(is_before && beyond >= -EARLY) {
            return None;
        }
        let (whole, part) = ((pace >> 32) as u32, pace as u32);
        let way = u64::from(beyond as u32);
        let mut since = way
            .wrapping_mul(whole.into())
            .wrapping_add(way.wrapping_mul(part.into()) >> 32);
        if is_before {
            since = since.wrapping_sub(pace);
        }
        let first = pace.wrapping_sub(since);
        let next = (first >> 32) as u32;
        let open = self.open_at(begin).cast_unsigned();
        if next > self.segment.wrapping_add(self.least.wrapping_mul(2)) {
            return self.wait_on(open, wanted, left, direction);
        }
        // One at a time where they are more than a segment apart.
        let more = match wanted.checked_sub(next) {
            Some(wanted) if whole <= self.segment => wanted.checked_div(whole)?.wrapping_add(1),
            _ => 0,
        };
        let gaps = u64::from(more).wrapping_mul(pace);
        let length = (first.wrapping_add(gaps) >> 32) as u32;
        let pulses = more.wrapping_add(1);
        // At the driver's highest rate it may be a tick more than is left.
        let fastest = pulses.checked_mul(self.shortest)?;
        let span = open.wrapping_add(length);
        if Ticks::from(length.max(wanted).wrapping_add(STRETCHED)) >= left
            || pulses > LONGEST_RUN
            || span.wrapping_add(SHORTEST_RECORD) < fastest
        {
            return None;
        }
        let span = span.max(fastest);
        if more == 0 || !self.has_pulse() {
            let gaps = (gaps >> 32) as u32;
            let silence = span.wrapping_sub(gaps);
            if silence < self.least {
                return None;
            }
            self.silence(silence, direction);
            self.open_step = direction.sign();
            if more > 0 {
                self.space(more, gaps, true, direction);
            } else if wanted > next.wrapping_add(self.least) {
                // More than a segment to the next one, so there is silence behind it.
                let most = whole.saturating_sub(self.least.wrapping_mul(2));
                self.silence(wanted.wrapping_sub(next).min(most), direction);
            }
        } else {
            self.space(pulses, span, true, direction);
        }
        let made = pulses.cast_signed().wrapping_mul(direction.sign());
        self.steps = self.steps.wrapping_add(made);
        Some((self.pen as u32).wrapping_sub(begin as u32))
    }

    /// So many periods up to the last pulse, at `last`, where the run before has ended with a pulse that is where it belongs, and its periods were as
    /// long but for an eighth: then so is the open one, if the chord begins within it and not behind a slow stretch. Whether that is so.
    #[inline]
    pub(super) fn join(
        &mut self,
        chord: &Chord,
        direction: Direction,
        pulses: u32,
        last: u32,
    ) -> bool {
        // Where pulses are few there is nothing to be reckoned.
        if pulses < MANY {
            return false;
        }
        let open = self.open_at(chord.begin).cast_unsigned();
        let span = last.wrapping_add(open);
        let alike = self.period.saturating_mul(pulses);
        let joins = alike.abs_diff(span) <= span >> 3
            && open <= self.period.wrapping_add(self.period >> 3)
            && self.has_pulse()
            && self.direction == Some(direction)
            && pulses <= LONGEST_RUN
            && span >= pulses.saturating_mul(self.shortest);
        if joins {
            self.space(pulses, span, chord.speeding_up, direction);
            let steps = pulses.cast_signed().wrapping_mul(direction.sign());
            self.steps = self.steps.wrapping_add(steps);
        }
        joins
    }

    /// Silence while no pulse is due for more than a segment.
    fn wait_on(
        &mut self,
        open: u32,
        wanted: u32,
        left: Ticks,
        direction: Direction,
    ) -> Option<u32> {
        let length = wanted.min(self.segment).max(self.least);
        if Ticks::from(length) >= left {
            return None;
        }
        self.silence(open.wrapping_add(length), direction);
        Some(length)
    }
}
