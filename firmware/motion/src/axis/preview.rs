//! Where a stop would end, without ordering one.

use super::Axis;
use crate::average::{Average, Window};
use crate::plan::{Goal, Limits, PlanError, Ramps, Start};
use crate::speed::{SignedSpeed, Speed};

impl Axis {
    /// Where the axis would come to rest, in whole steps, if it were told now to stop at `deceleration` steps/s² with these ramps. A sin² ramp under
    /// way is finished if a stop is no harder than that; with `leaves` it is left, as it is for a target elsewhere.
    ///
    /// # Errors
    /// As [`Axis::stop`].
    pub fn stop_preview(
        &self,
        deceleration: u32,
        ramps: Ramps,
        leaves: bool,
    ) -> Result<i64, PlanError> {
        let stop = Goal::Velocity(SignedSpeed::ZERO);
        let limits = Limits {
            velocity: Speed::ZERO,
            acceleration: 0,
            deceleration,
        };
        let (clock, horizon) = (self.clock, self.horizon());
        let mut plan = self.plan;
        match ramps {
            Ramps::MovingAverage(jerk) => {
                let limits = Window::within(clock, limits, jerk);
                let fresh = self.average.fresh().filter(|_| self.is_averaged);
                if self.is_averaged && fresh.is_none() {
                    let joint = self.average.joint(horizon);
                    plan.replan(clock, joint, stop, limits, ramps)?;
                } else {
                    let mean = fresh.unwrap_or_else(|| self.exact_at(horizon));
                    let (a, d) = self.expected(limits, jerk);
                    let from = if mean.velocity == 0 {
                        mean
                    } else {
                        Average::ahead(self.window_for(a + d, jerk), mean)
                    };
                    let start = Start::steady(horizon, from);
                    plan.make(clock, &start, stop, limits, ramps)?;
                }
            }
            _ if self.path.is_some() || self.is_averaged => {
                plan.make(clock, &self.start(), stop, limits, ramps)?;
            }
            _ if leaves => plan.leave_ramp(clock, horizon, stop, limits, ramps)?,
            _ => plan.replan(clock, horizon, stop, limits, ramps)?,
        }
        let rest = plan.destination().unwrap_or_else(|| self.exact_at(horizon));
        Ok(rest.floor().whole_steps())
    }

    /// The motion at the commit horizon of a path or a mean, as a plan begins with it.
    pub(super) fn start(&self) -> Start {
        let mut start = Start::steady(self.horizon(), self.exact_at(self.horizon()));
        if self.is_averaged {
            start.acceleration = self.average.phase().acceleration_exact(self.horizon());
            start.sixth_jerk = self.clock.sixth_jerk(self.mean_jerk);
        }
        start
    }
}
