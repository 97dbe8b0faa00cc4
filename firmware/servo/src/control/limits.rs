//! What may be asked of the motor: the least of all limits, what of it weakens the field, and what is left for the torque.

use super::{Control, Holder};
use crate::cascade::Limits;
use crate::number::{between, limit, root};

/// The share of the greatest current that may weaken the field: what is left across the magnet is 0.43 of it.
const FOR_WEAKENING: f32 = 0.9;

impl Control {
    /// By how many A the field may be weakened until the next period. A field that leads the rotor is not weakened.
    pub fn weakening(&self) -> f32 {
        match self.holder {
            Holder::Field => 0.0,
            Holder::Current | Holder::Loops => FOR_WEAKENING * self.greatest(),
        }
    }

    /// The greatest current in all, by the heat and the order.
    fn greatest(&self) -> f32 {
        let ordered = self.order.map_or(0.0, |order| order.max_current);
        between(ordered, 0.0, self.by_heat)
    }

    /// What of the greatest current is left across the magnet while so many A weaken its field.
    pub(super) fn across(&mut self, weakening: f32) -> f32 {
        if weakening <= 0.0 {
            self.weakened_constant = self.torque_constant;
            return self.by_heat;
        }
        self.weakened_constant = self.torque_constant * self.by_saliency(-weakening);
        let max = self.greatest();
        // Where the limit has just fallen below the current that weakens nothing is left.
        root((max - weakening) * (max + weakening))
    }

    /// What a current along the magnet makes of the torque.
    pub(super) fn by_saliency(&self, along: f32) -> f32 {
        let saliency = self.motor.inductance_d - self.motor.inductance_q;
        1.0 + saliency * along / self.motor.flux
    }

    /// The least of all limits, as currents.
    pub(super) fn limits(&self, across: f32, velocity: f32, bus: f32) -> Limits {
        let (positive, negative) = self.order.map_or((0.0, 0.0), |order| order.max_torque);
        let by_torque = 1.0 / self.weakened_constant;
        let braking = self.bus.braking(bus);
        // Slow motion gives nothing back: what brakes there is lost in the winding.
        let brakes = velocity.abs() > 1.0;
        let within = |torque: f32, is_braking: bool| {
            let max = between(torque * by_torque, 0.0, across);
            if is_braking && brakes {
                max * braking
            } else {
                max
            }
        };
        Limits {
            positive: within(positive, velocity < 0.0),
            negative: within(negative, velocity > 0.0),
        }
    }

    /// What is left of the limits before a speed, in counts/s, at a velocity that has changed by `gained` in a period. Below nine tenths of
    /// the speed what is given grows: where the speed is so low that the loop would take less than the limit, a rotor that stands has all of it.
    pub(super) fn below_speed(
        &self,
        limits: Limits,
        speed: f32,
        (velocity, gained): (f32, f32),
    ) -> Limits {
        let max = limit(speed, 1e12) * self.cascade.count;
        let push = self.cascade.push();
        let rate = 0.25 * self.cascade.gains.velocity * self.period;
        // What brakes has the limit of its own direction.
        let left = |room: f32, given: f32, gained: f32, brakes: f32, limit: f32| {
            let grown = given + push * (rate * (room - 0.1 * max) - gained);
            between(grown.max(push * room), -brakes, limit)
        };
        let Limits { positive, negative } = limits;
        let wanted = self.wanted;
        Limits {
            positive: left(max - velocity, wanted, gained, negative, positive),
            negative: left(max + velocity, -wanted, -gained, positive, negative),
        }
    }
}
