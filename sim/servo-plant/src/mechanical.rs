//! What turns: rotor and load, one body or two with a coupling between them.
//!
//! Dry friction is exact in each step: it takes away velocity until there is none, and then holds against any torque up to its own. A
//! coupling is a spring with a damper between two stops; the damper never pulls the load off a stop that it presses on.

use crate::STEP;
use crate::data::{Coupling, PlantData};
use crate::energy::Energy;

/// What a body is held by.
#[derive(Clone, Copy, Debug)]
struct Body {
    inertia: f64,
    coulomb: f64,
    /// What viscous friction leaves of a velocity in half a step, by the exact factor.
    fade: f64,
    /// The velocity that a torque makes in half a step, in rad/s of 1 N·m.
    reach: f64,
}

/// Half a step, in which torques act and nothing moves, in s.
const HALF: f64 = STEP / 2.0;

impl Body {
    fn new(inertia: f64, coulomb: f64, viscous: f64) -> Self {
        let rate = viscous / inertia;
        let fade = libm::exp(-rate * HALF);
        let reach = if rate * HALF < 1e-9 {
            HALF
        } else {
            (1.0 - fade) / rate
        };
        Self {
            inertia,
            coulomb,
            fade,
            reach: reach / inertia,
        }
    }

    /// A torque acts for half a step, and a brake with the friction. Gives the new velocity, and the heat of both.
    fn kick(self, velocity: f64, torque: f64, brake: f64) -> (f64, f64) {
        let drag = (self.coulomb + brake) * self.reach;
        let free = velocity * self.fade + torque * self.reach;
        let after = if free.abs() <= drag {
            0.0
        } else {
            free - drag.copysign(free)
        };
        let middle = f64::midpoint(velocity, after);
        let gained = self.inertia * (after - velocity) * middle;
        (after, torque * middle * HALF - gained)
    }
}

/// The bodies, and the coupling between them.
#[derive(Clone, Copy, Debug)]
pub struct Bodies {
    rotor: Body,
    load: Option<(Body, Coupling)>,
}

impl Bodies {
    pub(crate) fn new(data: &PlantData) -> Self {
        let (motor, load) = (&data.motor, &data.load);
        let (inertia, coulomb, viscous) = (
            motor.inertia,
            motor.coulomb_friction,
            motor.viscous_friction,
        );
        let driven = (load.inertia, load.coulomb_friction, load.viscous_friction);
        match data.coupling {
            Some(coupling) => Self {
                rotor: Body::new(inertia, coulomb, viscous),
                load: Some((Body::new(driven.0, driven.1, driven.2), coupling)),
            },
            None => Self {
                rotor: Body::new(inertia + driven.0, coulomb + driven.1, viscous + driven.2),
                load: None,
            },
        }
    }
}

/// What acts on the load from outside.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outside {
    /// Against positive motion, in N·m.
    pub(crate) torque: f64,
    /// As dry friction does, in N·m.
    pub(crate) brake: f64,
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

    /// Torques act for half a step, in which nothing moves.
    pub(crate) fn kick(
        &mut self,
        bodies: &Bodies,
        outside: Outside,
        torque: f64,
        energy: &mut Energy,
    ) {
        let Some((load, coupling)) = bodies.load else {
            let before = self.velocity;
            let (after, heat) = bodies
                .rotor
                .kick(before, torque - outside.torque, outside.brake);
            self.velocity = after;
            energy.friction += heat;
            energy.load += outside.torque * f64::midpoint(before, after) * HALF;
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
        let (rotor, heat) = bodies.rotor.kick(before.0, torque - held, 0.0);
        let (driven, more) = load.kick(before.1, held - outside.torque, outside.brake);
        (self.velocity, self.load_velocity) = (rotor, driven);
        let slipped = f64::midpoint(before.0, rotor) - f64::midpoint(before.1, driven);
        energy.friction += heat + more + (held - spring) * slipped * HALF;
        energy.load += outside.torque * f64::midpoint(before.1, driven) * HALF;
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
