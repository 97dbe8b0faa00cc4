//! Where a move is to be at every tick: on its plan, or on the moving average of it.

use motion::{Axis, AxisConfig, Clock, Mean, Phase, Plan, State, Ticks};

/// What the axis follows.
pub(super) struct Curve {
    /// The axis at the first tick of the move.
    pub(super) axis: Axis,
    plan: Plan,
    /// Up to a tick it follows these, then it is where the plan is.
    curves: Vec<Phase>,
    until: Ticks,
    /// They are those of the moving average of a plan.
    is_mean: bool,
}

impl Curve {
    /// That of a plan.
    pub(super) fn of(config: AxisConfig, plan: Plan) -> Self {
        Self {
            axis: Axis::on_plan(config, plan.clone()),
            curves: plan.phases().collect(),
            until: plan.end().unwrap_or(Ticks::MAX),
            is_mean: false,
            plan,
        }
    }

    /// That of the mean that `axis` is about to follow. The plan stands where the mean comes to rest.
    pub(super) fn averaged(axis: Axis, mut mean: Mean) -> Self {
        let rest = axis.target();
        let curves = mean.by_ref().collect();
        let end = mean.until();
        Self {
            axis,
            plan: Plan::at_rest(rest, end),
            curves,
            until: end,
            is_mean: true,
        }
    }

    /// Of a mean: the tick from which it stands.
    pub(super) fn end(&self) -> Ticks {
        self.plan.start()
    }

    pub(super) fn state_at(&self, tick: Ticks) -> State {
        let curve = self.curve(tick).filter(|_| tick < self.until);
        curve.map_or_else(|| self.plan.state_at(tick), |phase| phase.state_at(tick))
    }

    /// The first ticks of its phases: of constant acceleration or jerk.
    pub(super) fn corners(&self) -> Vec<Ticks> {
        self.curves.iter().map(Phase::start).collect()
    }

    /// The first tick of the curve behind a tick; `None` on the last one.
    pub(super) fn next_corner(&self, after: Ticks) -> Option<Ticks> {
        if !self.is_mean {
            return self.plan.next_corner(after);
        }
        let behind = self.behind(after);
        let next = self.curves.get(behind).map_or(self.until, Phase::start);
        (next > after).then_some(next)
    }

    /// How many curves begin at a tick or before it.
    fn behind(&self, tick: Ticks) -> usize {
        self.curves.partition_point(|phase| phase.start() <= tick)
    }

    /// The curve to which a tick belongs.
    fn curve(&self, tick: Ticks) -> Option<&Phase> {
        self.curves.get(self.behind(tick).checked_sub(1)?)
    }

    /// In steps/s², at a tick.
    pub(super) fn acceleration_at(&self, clock: Clock, tick: Ticks) -> f64 {
        self.curve(tick)
            .map_or(0.0, |phase| phase.acceleration_at(clock, tick) as f64)
    }
}
