//! What a loop follows: where the plan is, how fast, and what it is about to do.

use super::Axis;
use crate::clock::Ticks;
use crate::fixed::Position;
use crate::low;
use crate::speed::SignedSpeed;

/// Where the plan is at a moment, finer than [`Demand`](super::Demand), for who follows it with a loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Reference {
    /// In steps, parts of a step included; it wraps as positions do.
    pub position: Position,
    /// In steps/s.
    pub velocity: SignedSpeed,
    /// In steps/s², the mean of a time slice around the moment.
    pub acceleration: i32,
}

impl Axis {
    /// What is being played now, if the sink still has `pending` ticks to play, finer than
    /// [`Axis::demand`]; the acceleration as far as the motion is committed.
    pub fn reference(&self, pending: Ticks) -> Reference {
        let now = self.played(pending);
        let half = u64::from(self.stepper.time_slice() / 2);
        let end = now.saturating_add(half).min(self.committed);
        let begin = now.saturating_sub(half);
        let speed = |at| self.trace.at(at).velocity.speed(self.clock);
        let change = i128::from(speed(end).minus(speed(begin)).bits());
        // Behind the last record the motor stands, or keeps its velocity: the ramp is over.
        let ticks = if now < self.committed {
            i128::from(end.saturating_sub(begin))
        } else {
            0
        };
        let in_second = change * i128::from(self.clock.hz());
        let acceleration = in_second.checked_div(ticks).unwrap_or(0) >> 32;
        let state = self.trace.at(now);
        Reference {
            position: state.position,
            velocity: state.velocity.speed(self.clock),
            acceleration: low::i32(low::i64(
                acceleration.clamp(i32::MIN.into(), i32::MAX.into()),
            )),
        }
    }
}
