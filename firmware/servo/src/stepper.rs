//! A stepper that does not lose a step: the field leads the rotor by no more than a bound, whatever was demanded.
//!
//! A field that is ahead of the rotor pulls it, hardest a full step ahead (a quarter of an electrical turn); two ahead it pulls no more, and
//! beyond it pulls the rotor back to a wrong place, whole electrical turns away. With an encoder what is wanted is held within 1.1 to 1.7 full steps of the rotor, and the field itself within one, where it pulls hardest. What is held
//! back of the demand is kept, and made up: at once, or when the demand has come to rest, with a speed of its own. So the motor gives its
//! torque for as long as the load is too great, goes back with it if it must, and is where it was to be as soon as the load lets it.
//!
//! - Supervised, the field follows the demand whatever the rotor does, and a lead beyond the bound is reported.
//! - The current is by the load: from that at rest up to the whole as the lead comes to a full step, at once; down again slowly.
//! - The swinging of the rotor is damped: the field gives way to what the rotor is faster than the demand, until it brakes.
//! - What is kept back for good is left out of every demand that follows.
//! - A demand that turns back takes from what is held back first: the motor waits until it is where it was to be.
//! - At rest what a load or friction leaves of the lead is added to the field, slowly, until the rotor is where it was to be. Supervised it is not.
//! - A torque that was held before goes on: the field begins with the lead that gives it.
//!
//! Positions are counts of the encoder, in parts of 2¹⁶: the position is that of the encoder, always.

use crate::Angle;
use crate::motor::{Implausible, Motor};
use crate::number::{are_within, between, fade, greater, limit, root, whole};
use crate::transform;

/// Parts of a count.
const PARTS: f32 = 65_536.0;

/// The rate at which the field takes away the lead that is left at rest, in 1/s.
const TRIM: f32 = 30.0;

/// Full steps of an electrical rad.
const ARC: f32 = core::f32::consts::FRAC_2_PI;

/// What becomes of a lead beyond the bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beyond {
    /// The lead is reported, and nothing else happens: supervised.
    Reported,
    /// The field waits; what it is behind the demand is made up while the demand is at rest.
    MadeUpAtRest,
    /// The field waits; what it is behind the demand is made up at once.
    MadeUpAtOnce,
    /// The field waits, and what it is behind the demand stays.
    Kept,
}

/// How a stepper is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepperConfig {
    /// What becomes of a lead beyond the bound.
    pub beyond: Beyond,
    /// The greatest lead in full steps, 1.1 to 1.7.
    pub bound: f32,
    /// The speed with which steps that were held back are made up, beside the demand's own, in full steps/s.
    pub speed: f32,
    /// The greatest speed of both together, in full steps/s.
    pub max_speed: f32,
    /// The whole current, in A.
    pub current: f32,
    /// The share of it at rest without a load, 0.05 to 1.
    pub at_rest: f32,
    /// The current falls to a third in this time, in s.
    pub fall: f32,
}

/// What is demanded.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepperDemand {
    /// Counts in parts of 2¹⁶.
    pub position: i64,
    /// Its speed, in electrical rad/s.
    pub speed: f32,
    /// It does not move.
    pub is_at_rest: bool,
}

/// What the rotor does.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rotor {
    /// In counts.
    pub position: i64,
    /// The electrical angle there.
    pub angle: Angle,
    /// In electrical rad/s.
    pub speed: f32,
}

/// The field for a period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Field {
    /// The electrical angle along which the current flows.
    pub angle: Angle,
    /// In A.
    pub current: f32,
    /// The lead, in full steps.
    pub lead: f32,
    /// The lead would be beyond the bound.
    pub is_beyond: bool,
}

impl Field {
    /// The current seen from a rotor at this electrical angle, as the current loop is asked for it.
    pub fn seen_from(&self, angle: Angle) -> transform::Rotor {
        let (sine, cosine) = transform::direction(self.angle.minus(angle));
        transform::Rotor {
            d: self.current * cosine,
            q: self.current * sine,
        }
    }
}

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stepper {
    config: StepperConfig,
    period: f32,
    /// Electrical angle of a count, in parts of 2³² of a turn.
    angle_of_count: i64,
    /// In parts of a count.
    full_step: f32,
    /// How far the field gives way for an electrical rad/s, in full steps.
    damping: f32,
    fades: f32,
    /// What was added to the field at rest, in parts of a count.
    trim: i64,
    behind: i64,
    /// The demand of the period before.
    last: Option<i64>,
    current: f32,
    /// The lead, in full steps.
    lead: f32,
    is_beyond: bool,
}

impl Stepper {
    /// For a motor that was checked, with a period in s.
    ///
    /// # Errors
    /// With a bound outside 1.1 to 1.7 full steps, a speed outside 1 to 10⁵ full steps/s, a fastest one outside 1 to 10⁶, a current above the peak of the motor or below 1 mA, a share
    /// outside 0.05 to 1, a time of falling outside 1 ms to 100 s, or a period outside 5 µs to 1 ms; or if a full step is less than four counts.
    pub fn new(motor: &Motor, config: StepperConfig, period: f32) -> Result<Self, Implausible> {
        motor.check()?;
        let is_one = are_within(
            [
                config.bound,
                config.speed,
                config.max_speed,
                config.current,
                config.at_rest,
                config.fall,
                period,
            ],
            &[
                (1.1, 1.7),
                (1.0, 1e5),
                (1.0, 1e6),
                (1e-3, 1e3),
                (0.05, 1.0),
                (1e-3, 100.0),
                (5e-6, 1e-3),
            ],
        ) && config.current <= motor.peak_current;
        let pole_pairs = f32::from(motor.pole_pairs);
        let full_step = motor.counts as f32 / (4.0 * pole_pairs) * PARTS;
        Implausible::unless(is_one && full_step >= 4.0 * PARTS)?;
        let pull = pole_pairs * motor.torque_constant() * config.current / motor.inertia;
        // Half as much as damps the swinging in the field wholly, 2/ω electrical rad for a rad/s: what is seen of the speed comes late.
        let damping = 1.0 / root(pull);
        Ok(Self {
            config,
            period,
            angle_of_count: ((u64::from(motor.pole_pairs) << 32) / u64::from(motor.counts.max(1)))
                .cast_signed(),
            full_step,
            damping: damping * ARC,
            fades: fade(1.0 / config.fall, period),
            trim: 0,
            behind: 0,
            last: None,
            current: config.current,
            lead: 0.0,
            is_beyond: false,
        })
    }

    /// Takes over the state of `before`, which this one replaces while the motor is held.
    pub fn go_on_from(&mut self, before: &Self) {
        self.trim = before.trim;
        self.behind = before.behind;
        self.last = before.last;
        self.current = before.current;
        self.lead = before.lead;
        self.is_beyond = before.is_beyond;
    }

    /// Puts the field where it is demanded, with nothing held back.
    pub fn reset(&mut self) {
        self.behind = 0;
        self.trim = 0;
        self.last = None;
        self.current = self.config.current;
    }

    /// The field begins at the rotor, with the lead by which the whole current gives this one in q, in A. What it is behind the
    /// demand is made up.
    pub fn take_over(&mut self, torque: f32, demand: &StepperDemand, rotor: &Rotor) {
        self.reset();
        let sine = limit(torque / self.config.current, 1.0);
        let square = sine * sine;
        // The arc of it, within a tenth of a full step.
        let lead = sine * (ARC + (1.0 - ARC) * square * square);
        let ahead = self.parts(lead);
        self.behind = self.away(demand, rotor).wrapping_sub(ahead);
    }

    /// How far the field is behind the demand, in parts of a count.
    pub fn behind(&self) -> i64 {
        self.behind
    }

    /// The lead of the last period, in full steps.
    pub fn lead(&self) -> f32 {
        self.lead
    }

    /// Whether the lead is at its bound, or what was held back there is not made up yet.
    pub fn is_held_back(&self) -> bool {
        let is_kept = self.config.beyond == Beyond::Kept;
        self.is_beyond || !is_kept && within(self.behind, self.parts(1.0)) != self.behind
    }

    /// A period, in which no current is to be above `max` A.
    pub fn run(&mut self, demand: &StepperDemand, rotor: &Rotor, max: f32) -> Field {
        self.take_back(demand.position);
        let is_reported = self.config.beyond == Beyond::Reported;
        let away = self.away(demand, rotor);
        let wanted = away.wrapping_add(self.trim);
        let held = within(wanted, self.parts(self.config.bound));
        let is_beyond = held != wanted;
        let lead = if is_reported {
            wanted
        } else {
            self.behind = self.behind.wrapping_add(wanted.wrapping_sub(held));
            self.trim_field(away, demand.is_at_rest);
            held
        };
        let catches_up = self.make_up(demand) * core::f32::consts::FRAC_PI_2;
        let faster = limit(rotor.speed - demand.speed - catches_up, 1e5);
        let most = if is_reported {
            1.0
        } else {
            2.0 * self.config.bound
        };
        let gives_way = limit(self.damping * faster, most);
        let mut field = lead.wrapping_sub(self.parts(gives_way));
        if !is_reported {
            // A full step pulls hardest, also while it brakes.
            field = within(field, self.parts(1.0));
        }
        let steps = limit(lead as f32 / self.full_step, 1e4);
        (self.lead, self.is_beyond) = (steps, is_beyond);
        Field {
            angle: rotor.angle.plus(self.turned(field)),
            current: between(self.current_for(steps.abs()), 0.0, limit(max, 1e4)),
            lead: steps,
            is_beyond,
        }
    }

    /// How far the rotor is from the demand, but for what is held back, in parts of a count.
    fn away(&self, demand: &StepperDemand, rotor: &Rotor) -> i64 {
        // In the middle of a count it is.
        let middle = rotor.position.wrapping_shl(16).wrapping_add(1 << 15);
        demand
            .position
            .wrapping_sub(self.behind)
            .wrapping_sub(middle)
    }

    /// Takes from what is held back, if it is time for that. Returns with which speed, in full steps/s.
    fn make_up(&mut self, demand: &StepperDemand) -> f32 {
        let waits = match self.config.beyond {
            Beyond::MadeUpAtRest => !demand.is_at_rest,
            Beyond::Kept => true,
            Beyond::Reported | Beyond::MadeUpAtOnce => false,
        };
        if waits {
            return 0.0;
        }
        let sign = if self.behind < 0 { -1.0 } else { 1.0 };
        let left = self.config.max_speed - sign * demand.speed * ARC;
        let speed = between(left, 0.0, self.config.speed);
        let max = self.parts(speed * self.period).max(1);
        let back = within(self.behind, max);
        self.behind = self.behind.wrapping_sub(back);
        if back.wrapping_abs() == max {
            sign * speed
        } else {
            0.0
        }
    }

    /// What is left of the lead at rest goes to the field; in motion it fades.
    fn trim_field(&mut self, away: i64, is_at_rest: bool) {
        let left = if is_at_rest {
            away
        } else {
            self.trim.wrapping_neg()
        };
        let full_step = self.parts(1.0);
        // More than a full step is no rest.
        if within(left, full_step) == left {
            let change = whole(left as f32 * (TRIM * self.period));
            self.trim = within(self.trim.wrapping_add(change), full_step);
        }
    }

    /// A demand that turns back comes to where the field is held.
    fn take_back(&mut self, position: i64) {
        let last = self.last.replace(position).unwrap_or(position);
        let change = position.wrapping_sub(last);
        if (change < 0) != (self.behind < 0) {
            let back = within(change, self.behind.wrapping_abs());
            self.behind = self.behind.wrapping_add(back);
        }
    }

    /// Full steps in parts of a count.
    #[inline(never)]
    fn parts(&self, full_steps: f32) -> i64 {
        whole(full_steps * self.full_step)
    }

    /// Parts of a count as an electrical angle.
    fn turned(&self, parts: i64) -> Angle {
        // Whole electrical turns are nothing: what is left of the product is right.
        let bits = parts.wrapping_mul(self.angle_of_count) >> 16;
        Angle::from_bits(bits as u32)
    }

    /// Up at once, down slowly.
    fn current_for(&mut self, lead: f32) -> f32 {
        let share = self.config.at_rest + (1.0 - self.config.at_rest) * between(lead, 0.0, 1.0);
        let wanted = self.config.current * share;
        let fallen = wanted + self.fades * (self.current - wanted);
        self.current = greater(wanted, fallen);
        self.current
    }
}

/// The value within a bound on both sides; unlike `clamp` it cannot panic.
#[inline(never)]
fn within(value: i64, bound: i64) -> i64 {
    value.min(bound).max(bound.wrapping_neg())
}
