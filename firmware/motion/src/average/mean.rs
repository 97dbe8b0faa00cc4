//! The mean of a plan as a sequence of phases, for a look ahead.

use super::Average;
use crate::clock::Ticks;
use crate::plan::Plan;
use crate::plan::phase::Phase;

/// The mean of a plan from a tick on, phase by phase: what an axis with [`Ramps::MovingAverage`](crate::Ramps) follows if no other order
/// comes. Behind the last phase it stands, or keeps its velocity.
#[derive(Debug, Clone)]
pub struct Mean {
    average: Average,
    plan: Plan,
}

impl Mean {
    pub(crate) const fn new(average: Average, plan: Plan) -> Self {
        Self { average, plan }
    }

    /// The first tick behind the last curve that was given; `Ticks::MAX` if that never ends.
    pub const fn until(&self) -> Ticks {
        self.average.until
    }
}

impl Iterator for Mean {
    type Item = Phase;

    fn next(&mut self) -> Option<Phase> {
        let until = self.average.until;
        if until == Ticks::MAX || self.average.is_over(until) {
            return None;
        }
        self.average.polynomial_at(&self.plan, until);
        Some(self.average.phase())
    }
}
