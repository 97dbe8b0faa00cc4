//! Where a move is to be at every tick: on its plan, or on the moving average of it.

use motion::{Axis, AxisConfig, Clock, Mean, Phase, Plan, State, Ticks};

/// So many curves between samples are kept; what needs more of them has ramps that last for an hour.
const MOST_CURVES: usize = 4_000_000;

/// A change of the acceleration by less than this part of the greatest one is rounding.
const ROUNDING: f64 = 1e-5;

/// What the axis follows.
pub(super) struct Curve {
    /// The axis at the first tick of the move.
    pub(super) axis: Axis,
    plan: Plan,
    /// Of a moving average: its curves, and the tick from which the plan is followed.
    mean: Option<(Vec<Phase>, Ticks)>,
}

impl Curve {
    /// That of a plan.
    pub(super) fn of(config: AxisConfig, plan: Plan) -> Self {
        Self {
            axis: Axis::on_plan(config, plan),
            plan,
            mean: None,
        }
    }

    /// That of the mean that `axis` is about to follow. The plan stands where the mean comes to rest.
    pub(super) fn averaged(axis: Axis, mut mean: Mean) -> Result<Self, String> {
        let rest = axis.target();
        let curves: Vec<_> = mean.by_ref().take(MOST_CURVES).collect();
        if curves.len() == MOST_CURVES {
            return Err("the ramps take too long for a moving average".to_owned());
        }
        let end = mean.until();
        Ok(Self {
            axis,
            plan: Plan::at_rest(rest, end),
            mean: Some((curves, end)),
        })
    }

    /// Of a mean: the tick from which it stands.
    pub(super) fn end(&self) -> Ticks {
        self.plan.start()
    }

    pub(super) fn state_at(&self, tick: Ticks) -> State {
        match &self.mean {
            Some((curves, end)) if tick < *end => {
                curve(curves, tick).map_or_else(State::default, |phase| phase.state_at(tick))
            }
            _ => self.plan.state_at(tick),
        }
    }

    /// The first ticks of all its curves.
    pub(super) fn corners(&self) -> Vec<Ticks> {
        self.curves().iter().map(Phase::start).collect()
    }

    /// The first tick of the curve behind a tick; `None` on the last one.
    pub(super) fn next_corner(&self, after: Ticks) -> Option<Ticks> {
        let Some((curves, end)) = &self.mean else {
            return self.plan.next_corner(after);
        };
        let behind = curves.partition_point(|phase| phase.start() <= after);
        let next = curves.get(behind).map_or(*end, Phase::start);
        (next > after).then_some(next)
    }

    fn curves(&self) -> &[Phase] {
        match &self.mean {
            Some((curves, _)) => curves,
            None => self.plan.phases(),
        }
    }

    /// In steps/s², at a tick.
    pub(super) fn acceleration_at(&self, clock: Clock, tick: Ticks) -> f64 {
        curve(self.curves(), tick).map_or(0.0, |phase| phase.acceleration_at(clock, tick) as f64)
    }

    /// The first ticks of its phases: of constant acceleration or jerk; of a mean, where that begins or ends to grow or to fall.
    pub(super) fn phases(&self, clock: Clock) -> Vec<Ticks> {
        let Some((curves, _)) = &self.mean else {
            return self.corners();
        };
        let accelerations: Vec<_> = (curves.iter())
            .map(|phase| phase.acceleration(clock) as f64)
            .collect();
        let least = accelerations
            .iter()
            .fold(0.0_f64, |most, a| most.max(a.abs()))
            * ROUNDING;
        let mut starts = Vec::new();
        let (mut before, mut trend) = (0.0, None);
        for (phase, acceleration) in curves.iter().zip(accelerations) {
            let change = acceleration - before;
            let now = if change.abs() <= least {
                0.0
            } else {
                change.signum()
            };
            if trend != Some(now) {
                starts.push(phase.start());
            }
            (before, trend) = (acceleration, Some(now));
        }
        starts
    }
}

/// The phase to which a tick belongs.
fn curve(phases: &[Phase], tick: Ticks) -> Option<&Phase> {
    let behind = phases.partition_point(|phase| phase.start() <= tick);
    phases.get(behind.checked_sub(1)?)
}
