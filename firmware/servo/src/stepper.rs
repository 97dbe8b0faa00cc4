//! A stepper that does not lose a step: the field leads the rotor by no more than a bound, whatever was demanded.
//!
//! A field that is ahead of the rotor pulls it, hardest a full step ahead (a quarter of an electrical turn); two ahead it pulls no more, and
//! beyond it pulls the rotor back to a wrong place, whole electrical turns away. With an encoder what is wanted is held within 1.1 to 1.7 full steps of the rotor, and the field itself within one, where it pulls hardest. What is held
//! back of the demand is kept, and made up: at once, or when the demand has come to rest, with a speed of its own. So the motor gives its
//! torque for as long as the load is too great, goes back with it if it must, and is where it was to be as soon as the load lets it.
//!
//! - Supervised, the field follows the demand whatever the rotor does, and a lead beyond the bound is told.
//! - The current is by the load: from that at rest up to the whole as the lead comes to a full step, at once; down again slowly.
//! - The swinging of the rotor is damped: the field gives way to what the rotor is faster than the demand, until it brakes.
//!
//! Positions are counts of the encoder, in parts of 2¹⁶: the position is that of the encoder, always.

use crate::Angle;
use crate::motor::{Implausible, Motor};
use crate::number::{between, fade, is_within, limit, root};
use crate::transform;

/// Parts of a count.
const PARTS: f32 = 65_536.0;

/// What becomes of a lead beyond the bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beyond {
    /// It is told, and nothing is done: supervised.
    Told,
    /// The field waits; what it is behind the demand is made up while the demand is at rest.
    MadeUpAtRest,
    /// The field waits; what it is behind the demand is made up at once.
    MadeUpAtOnce,
}

/// How a stepper is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepperConfig {
    /// What becomes of a lead beyond the bound.
    pub beyond: Beyond,
    /// The greatest lead in full steps, 1.1 to 1.7.
    pub bound: f32,
    /// With so many full steps/s what was held back is made up, beside the demand's own speed.
    pub speed: f32,
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
        let (sine, cosine) = self.angle.minus(angle).sine_cosine();
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
    /// Electrical angle of a count, in parts of 2³² of a turn.
    angle_of_count: i64,
    /// Full steps of a part of a count.
    full_steps: f32,
    /// The bound, and what is made up in a period, in parts of a count.
    bound: i64,
    made_up: i64,
    /// By so many parts the field gives way for an electrical rad/s.
    damping: f32,
    fades: f32,
    behind: i64,
    current: f32,
}

impl Stepper {
    /// For a motor that was checked, with a period in s.
    ///
    /// # Errors
    /// With a bound outside 1.1 to 1.7 full steps, a speed outside 1 to 10⁵ full steps/s, a current above the peak of the motor or below 1 mA, a share
    /// outside 0.05 to 1, a time of falling outside 1 ms to 100 s, or a period outside 5 µs to 1 ms; or if a full step is less than four counts.
    pub fn new(motor: &Motor, config: StepperConfig, period: f32) -> Result<Self, Implausible> {
        let motor = motor.checked()?;
        let is_one = is_within(config.bound, 1.1, 1.7)
            && is_within(config.speed, 1.0, 1e5)
            && is_within(config.current, 1e-3, motor.peak_current)
            && is_within(config.at_rest, 0.05, 1.0)
            && is_within(config.fall, 1e-3, 100.0)
            && is_within(period, 5e-6, 1e-3);
        let pole_pairs = f32::from(motor.pole_pairs);
        let full_step = motor.counts as f32 / (4.0 * pole_pairs) * PARTS;
        if !is_one || full_step < 4.0 * PARTS {
            return Err(Implausible);
        }
        let pull = pole_pairs * motor.torque_constant() * config.current / motor.inertia;
        // As much as damps the swinging in the field wholly: 2/ω electrical rad for a rad/s.
        let damping = 2.0 / root(pull);
        Ok(Self {
            config,
            angle_of_count: ((u64::from(motor.pole_pairs) << 32) / u64::from(motor.counts.max(1)))
                .cast_signed(),
            full_steps: 1.0 / full_step,
            bound: (config.bound * full_step) as i64,
            made_up: ((config.speed * full_step * period) as i64).max(1),
            damping: damping * full_step / core::f32::consts::FRAC_PI_2,
            fades: fade(1.0 / config.fall, period),
            behind: 0,
            current: config.current,
        })
    }

    /// The field is where it is demanded, and nothing is behind.
    pub fn reset(&mut self) {
        self.behind = 0;
        self.current = self.config.current;
    }

    /// How far the field is behind the demand, in parts of a count.
    pub fn behind(&self) -> i64 {
        self.behind
    }

    /// A period.
    pub fn run(&mut self, demand: &StepperDemand, rotor: &Rotor) -> Field {
        let middle = (rotor.position.wrapping_shl(16)).wrapping_add(1 << 15);
        let wanted = demand
            .position
            .saturating_sub(self.behind)
            .saturating_sub(middle);
        let held = within(wanted, self.bound);
        let is_beyond = held != wanted;
        let lead = if self.config.beyond == Beyond::Told {
            wanted
        } else {
            self.behind = self.behind.saturating_add(wanted.saturating_sub(held));
            if self.config.beyond == Beyond::MadeUpAtOnce || demand.is_at_rest {
                let back = within(self.behind, self.made_up);
                self.behind = self.behind.saturating_sub(back);
            }
            held
        };
        let faster = limit(rotor.speed - demand.speed, 1e5);
        let full_step = 1.0 / self.full_steps;
        let field = if self.config.beyond == Beyond::Told {
            lead.saturating_sub(limit(self.damping * faster, full_step) as i64)
        } else {
            // A full step pulls hardest, also while it brakes.
            let most = 2.0 * self.config.bound * full_step;
            let gives_way = limit(self.damping * faster, most) as i64;
            within(held.saturating_sub(gives_way), full_step as i64)
        };
        let steps = between(
            lead.clamp(-(1 << 40), 1 << 40) as f32 * self.full_steps,
            -1e4,
            1e4,
        );
        Field {
            angle: rotor.angle.plus(self.turned(field)),
            current: self.current_for(steps.abs()),
            lead: steps,
            is_beyond,
        }
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
        self.current = if wanted > fallen { wanted } else { fallen };
        self.current
    }
}

/// The value within a bound on both sides; unlike `clamp` it cannot panic.
fn within(value: i64, bound: i64) -> i64 {
    value.min(bound).max(bound.saturating_neg())
}
