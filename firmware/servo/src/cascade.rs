//! The loops above the current: position, then velocity, at the rate of the control.
//!
//! ```text
//! velocity wanted = velocity ahead + Kp · position error
//! current         = (acceleration ahead + Kv · velocity error) · J / kt + friction ahead + integral of the velocity error
//! ```
//!
//! The position is a whole number of counts all the way to the error. The integral grows only as far as the limits leave room, so it does not wind up. A loop that
//! takes over begins with the current that flows: there is no bump, whatever the errors are then.

use crate::filter::Filter;
use crate::motor::{Implausible, Motor};
use crate::number::{are_within, between, limit, within};

/// The greatest position error that is told apart, in counts.
const FARTHEST: i64 = 1 << 23;

/// The fastest that is reckoned with, in rad/s.
const FASTEST: f32 = 1e4;

/// The greatest acceleration that is reckoned with, in rad/s².
const QUICKEST: f32 = 1e7;

/// How stiff the loops are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains {
    /// Of the position, in 1/s (60FBh).
    pub position: f32,
    /// Of the velocity, in 1/s: its bandwidth in rad/s (60F9h).
    pub velocity: f32,
    /// Of the integral, in 1/s.
    pub integral: f32,
}

impl Gains {
    /// For a bandwidth of the velocity loop in rad/s; the loops around it are a third as fast.
    pub const fn from_bandwidth(bandwidth: f32) -> Self {
        Self {
            position: bandwidth / 3.0,
            velocity: bandwidth,
            integral: bandwidth / 3.0,
        }
    }

    /// # Errors
    /// With a gain below 0, above 10⁴, or that is NaN.
    fn check(&self) -> Result<(), Implausible> {
        let gains = [self.position, self.velocity, self.integral];
        Implausible::unless(are_within(gains, &[(0.0, 1e4); 3]))
    }
}

/// What is wanted in this period.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Demand {
    /// In counts; `None` leaves the position alone.
    pub position: Option<i64>,
    /// Parts of a count beyond it, 0 to 1.
    pub part: f32,
    /// In rad/s.
    pub velocity: f32,
    /// In rad/s².
    pub acceleration: f32,
    /// A current ahead, in A.
    pub current: f32,
}

/// What the motor does.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Actual {
    /// In counts.
    pub position: i64,
    /// In rad/s.
    pub velocity: f32,
}

/// What may be asked for: each at least 0, in A.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Of a positive current.
    pub positive: f32,
    /// Of a negative one.
    pub negative: f32,
}

impl Limits {
    /// The same both ways.
    pub const fn both(max: f32) -> Self {
        Self {
            positive: max,
            negative: max,
        }
    }
}

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cascade {
    pub(crate) gains: Gains,
    period: f32,
    /// rad of a count.
    pub(crate) count: f32,
    /// J / kt, in A per rad/s².
    inertia: f32,
    /// In A, in the direction of the motion.
    friction: f32,
    filters: [Filter; 2],
    /// The integral, in A.
    sum: f32,
    /// The error of the position, in rad; 0 while that is left alone.
    away: f32,
    /// What the velocity is to change by, in rad/s.
    velocity_error: f32,
    is_limited: bool,
}

impl Cascade {
    /// For a motor that was checked and the current that its dry friction takes, in A, with a period in s.
    ///
    /// # Errors
    /// With a period outside 20 µs to 10 ms, with invalid gains, or with a friction below 0 or that is NaN.
    pub fn new(
        motor: &Motor,
        gains: Gains,
        friction: f32,
        period: f32,
    ) -> Result<Self, Implausible> {
        motor.check()?;
        gains.check()?;
        let inertia = motor.inertia / motor.torque_constant();
        Implausible::unless(are_within(
            [period, friction, inertia],
            &[(20e-6, 10e-3), (0.0, 1e3), (0.0, 1e3)],
        ))?;
        Ok(Self {
            gains,
            period,
            count: core::f32::consts::TAU / motor.counts as f32,
            inertia,
            friction,
            filters: [Filter::NONE; 2],
            sum: 0.0,
            away: 0.0,
            velocity_error: 0.0,
            is_limited: false,
        })
    }

    /// Other gains, from the next period on. The integral takes the step that they would make in the current.
    ///
    /// # Errors
    /// With invalid gains; those of before stay.
    pub fn set_gains(&mut self, gains: Gains) -> Result<(), Implausible> {
        gains.check()?;
        let before = self.gains.velocity * self.velocity_error;
        self.velocity_error += (gains.position - self.gains.position) * self.away;
        let after = gains.velocity * self.velocity_error;
        self.sum = limit(self.sum + (before - after) * self.inertia, FASTEST);
        self.gains = gains;
        Ok(())
    }

    /// Another low-pass and notch, from the next period on, settled at this current in A.
    pub fn set_filters(&mut self, low_pass: Filter, notch: Filter, current: f32) {
        self.filters = [low_pass, notch];
        for filter in &mut self.filters {
            filter.settle(current);
        }
    }

    /// Begins with the current that flows, in A.
    pub fn take_over(&mut self, current: f32, demand: &Demand, actual: Actual) {
        let at_once = self.at_once(demand, actual);
        self.sum = limit(limit(current, FASTEST) - at_once, FASTEST);
        let [low_pass, notch] = self.filters;
        self.set_filters(low_pass, notch, current);
    }

    /// The current for a velocity error, in A per rad/s.
    pub(crate) fn push(&self) -> f32 {
        self.gains.velocity * self.inertia
    }

    /// Whether the last current was cut to its limits.
    pub fn is_limited(&self) -> bool {
        self.is_limited
    }

    /// The current for this period, in A, within the limits.
    pub fn run(&mut self, demand: &Demand, actual: Actual, limits: Limits) -> f32 {
        let at_once = self.at_once(demand, actual);
        let least = -within(limits.negative, 0.0, FASTEST);
        let max = within(limits.positive, 0.0, FASTEST);
        let growth = self.gains.integral * self.period * self.push();
        let sum = self.sum + growth * self.velocity_error;
        // The integral grows within the limits only, or back towards them.
        let wanted = at_once + sum;
        let is_away = (wanted > max && sum > self.sum) || (wanted < least && sum < self.sum);
        if !is_away {
            self.sum = limit(sum, FASTEST);
        }
        let mut current = between(wanted, least, max);
        self.is_limited = current != wanted;
        for filter in &mut self.filters {
            current = filter.run(current);
        }
        between(current, least, max)
    }

    /// Takes the errors of position and velocity. Gives all but the integral, in A.
    #[inline(never)]
    fn at_once(&mut self, demand: &Demand, actual: Actual) -> f32 {
        self.away = demand.position.map_or(0.0, |position| {
            let away = position.saturating_sub(actual.position);
            let away = away.clamp(-FARTHEST, FARTHEST) as i32 as f32;
            // The middle of a count is where the rotor is, as far as it is known.
            self.count * (away + within(demand.part, 0.0, 1.0) - 0.5)
        });
        let ahead = limit(demand.velocity, FASTEST);
        let wanted = limit(ahead + self.gains.position * self.away, FASTEST);
        self.velocity_error = wanted - limit(actual.velocity, FASTEST);
        let acceleration = limit(demand.acceleration, QUICKEST);
        let friction = limit(ahead * 1e3, 1.0) * self.friction;
        let pushes = acceleration * self.inertia + self.push() * self.velocity_error;
        pushes + friction + limit(demand.current, FASTEST)
    }
}
