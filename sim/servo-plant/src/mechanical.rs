//! What turns: rotor and load, one body or two with a coupling between them.
//!
//! Dry friction is exact in each step: it takes away velocity until there is none, and then holds against any torque up to its own. A
//! coupling is a spring with a damper between two stops; the damper never pulls the load off a stop that it presses on.

use crate::data::{Coupling, LoadData, MotorData, PlantData};
use crate::energy::Energy;

/// What a body is held by.
#[derive(Clone, Copy, Debug)]
struct Body {
    inertia: f64,
    coulomb: f64,
    viscous: f64,
}

impl Body {
    /// A torque acts for a time. Gives the new velocity, and the heat of friction.
    fn kick(self, velocity: f64, torque: f64, time: f64) -> (f64, f64) {
        // Viscous friction fades it, by the exact factor.
        let rate = self.viscous / self.inertia;
        let fade = libm::exp(-rate * time);
        let reach = if rate * time < 1e-9 {
            time
        } else {
            (1.0 - fade) / rate
        };
        let drag = self.coulomb / self.inertia * reach;
        let free = velocity * fade + torque / self.inertia * reach;
        let after = if free.abs() <= drag {
            0.0
        } else {
            free - drag.copysign(free)
        };
        let middle = f64::midpoint(velocity, after);
        let gained = self.inertia * (after - velocity) * middle;
        (after, torque * middle * time - gained)
    }
}

/// The bodies, the coupling between them, and the torque on the load.
#[derive(Clone, Copy, Debug)]
pub struct Bodies {
    rotor: Body,
    load: Option<(Body, Coupling)>,
    load_torque: f64,
}

impl Bodies {
    pub(crate) fn new(
        motor: &MotorData,
        load: &LoadData,
        coupling: Option<Coupling>,
        load_torque: f64,
    ) -> Self {
        let rotor = Body {
            inertia: motor.inertia,
            coulomb: motor.coulomb_friction,
            viscous: motor.viscous_friction,
        };
        let driven = Body {
            inertia: load.inertia,
            coulomb: load.coulomb_friction,
            viscous: load.viscous_friction,
        };
        let both = Body {
            inertia: rotor.inertia + driven.inertia,
            coulomb: rotor.coulomb + driven.coulomb,
            viscous: rotor.viscous + driven.viscous,
        };
        Self {
            rotor: if coupling.is_some() { rotor } else { both },
            load: coupling.map(|coupling| (driven, coupling)),
            load_torque,
        }
    }
}

/// Where rotor and load are, and how fast they are. Without a coupling the load is part of the rotor.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Mechanics {
    pub(crate) angle: f64,
    pub(crate) velocity: f64,
    pub(crate) load_angle: f64,
    pub(crate) load_velocity: f64,
}

impl Mechanics {
    pub(crate) fn turning(angle: f64, velocity: f64) -> Self {
        Self {
            angle,
            velocity,
            load_angle: angle,
            load_velocity: velocity,
        }
    }

    /// Torques act for a time, in which nothing moves.
    pub(crate) fn kick(&mut self, bodies: &Bodies, torque: f64, time: f64, energy: &mut Energy) {
        let Some((load, coupling)) = bodies.load else {
            let before = self.velocity;
            let (after, heat) = bodies.rotor.kick(before, torque - bodies.load_torque, time);
            self.velocity = after;
            energy.friction += heat;
            energy.load += bodies.load_torque * f64::midpoint(before, after) * time;
            return;
        };
        let before = (self.velocity, self.load_velocity);
        let twist = twist(self.angle - self.load_angle, coupling.backlash);
        let slip = self.velocity - self.load_velocity;
        let spring = coupling.stiffness * twist;
        let held = if twist > 0.0 {
            (spring + coupling.damping * slip).max(0.0)
        } else if twist < 0.0 {
            (spring + coupling.damping * slip).min(0.0)
        } else {
            0.0
        };
        let (rotor, heat) = bodies.rotor.kick(before.0, torque - held, time);
        let (driven, more) = load.kick(before.1, held - bodies.load_torque, time);
        (self.velocity, self.load_velocity) = (rotor, driven);
        let slipped = f64::midpoint(before.0, rotor) - f64::midpoint(before.1, driven);
        energy.friction += heat + more + (held - spring) * slipped * time;
        energy.load += bodies.load_torque * f64::midpoint(before.1, driven) * time;
    }

    /// Both turn on for a time.
    pub(crate) fn drift(&mut self, time: f64) {
        self.angle += self.velocity * time;
        self.load_angle += self.load_velocity * time;
    }

    pub(crate) fn kinetic_energy(&self, data: &PlantData) -> f64 {
        let (rotor, load) = (data.motor.inertia, data.load.inertia);
        let driven = match data.coupling {
            Some(_) => self.load_velocity,
            None => self.velocity,
        };
        (rotor * self.velocity * self.velocity + load * driven * driven) / 2.0
    }

    pub(crate) fn spring_energy(&self, coupling: Option<&Coupling>) -> f64 {
        coupling.map_or(0.0, |coupling| {
            let twist = twist(self.angle - self.load_angle, coupling.backlash);
            coupling.stiffness * twist * twist / 2.0
        })
    }
}

/// By how much a coupling is twisted beyond its backlash.
fn twist(angle: f64, backlash: f64) -> f64 {
    angle - angle.clamp(-backlash / 2.0, backlash / 2.0)
}
