//! Along a path, from one straight line to the next: what a cyclic mode does in each of its periods.

use super::Axis;
use super::leg::Leg;
use crate::clock::Ticks;
use crate::fixed::{State, Velocity};
use crate::train::Chord;

impl Axis {
    /// The next chord, and the state at its end, if the axis is on a straight line of a path. None on a cubic, behind the last set-point, on
    /// a plan, and where it goes so slowly that the tick of a pulse must be looked for.
    #[inline(never)]
    pub(super) fn chord_on_line(&mut self) -> Option<(Chord, State)> {
        let path = self.path.as_ref()?;
        let begin = self.horizon;
        let line = path.line_at(begin)?;
        let from = line.begin;
        let length = self.train.chord(from.velocity, u32::MAX);
        let left = line.end.wrapping_sub(begin);
        let to = if Ticks::from(length) < left {
            let exact = path.exact_on_line(&line, begin.wrapping_add(length.into()));
            self.leg = Some(Leg::on_line(exact, line.end));
            exact.rounded()
        } else {
            self.leg = None;
            path.behind_line(&line)
        };
        if to.velocity.creeps() && to.velocity != Velocity::ZERO {
            return None;
        }
        // The lesser of them, so 32 bits hold it.
        let length = left.min(length.into()) as u32;
        Some((Chord::between((begin, from), (length, to)), to))
    }
}
