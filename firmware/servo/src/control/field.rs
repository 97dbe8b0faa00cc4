//! A position that is held by a field that leads the rotor.

use super::Control;
use crate::cascade::{Demand, Limits};
use crate::interrupt::Snapshot;
use crate::number::{between, root};
use crate::stepper::{self, StepperDemand};
use crate::transform::Rotor;

/// The share of the bus that the magnet, what lies along it and across may drive together.
const FOR_FIELD: f32 = 0.75;

/// Turns of a rad.
const TURN_OF_RADIAN: f32 = 0.5 * core::f32::consts::FRAC_1_PI;

impl Control {
    /// The current of a field that leads the rotor.
    pub(super) fn lead(
        &mut self,
        demand: &Demand,
        seen: &Snapshot,
        is_new: bool,
        limits: Limits,
    ) -> Rotor {
        let Some(stepper) = &mut self.stepper else {
            return Rotor::ZERO;
        };
        let position = demand.position.unwrap_or_default();
        let part = (demand.part * 65_536.0) as i32;
        let demand = StepperDemand {
            position: position.wrapping_shl(16).wrapping_add(part.into()),
            speed: demand.velocity * f32::from(self.motor.pole_pairs),
            is_at_rest: demand.velocity == 0.0 && demand.acceleration == 0.0,
        };
        let rotor = stepper::Rotor {
            position: seen.position,
            angle: seen.count,
            speed: seen.speed,
        };
        if is_new {
            stepper.take_over(self.wanted, &demand, &rotor);
        }
        let max = limits.positive.max(limits.negative);
        let field = stepper.run(&demand, &rotor, max);
        let from = seen.angle;
        // Beside the stator it pulls back at once a rotor that swings; a rotor that runs away from it leads it, so that it is never beyond where it pulls hardest.
        let away = (demand.speed - rotor.speed).abs() * self.period * TURN_OF_RADIAN;
        let ahead = field.angle.minus(rotor.angle).turns().abs();
        let stands = away < 0.05 && ahead + 2.0 * away < 0.25;
        self.field = stands.then_some((from, demand.speed));
        let asked = field.seen_from(from);
        let q = between(asked.q, -limits.negative, limits.positive);
        self.is_limited = stepper.is_held_back() || q != asked.q;
        // What lies along the magnet gives way where the bus has not the voltage for it: it holds at rest, and gives no torque.
        let speed = rotor.speed.abs().max(1.0);
        let across = q.abs().max(seen.current.q.abs());
        let across = speed * self.motor.inductance_q * across;
        let max = FOR_FIELD * seen.bus;
        let room = root(max * max - across * across) / speed - self.motor.flux;
        let max = between(room / self.motor.inductance_d, 0.0, 1e4);
        let d = between(asked.d, -max, max);
        Rotor { d, q }
    }
}
