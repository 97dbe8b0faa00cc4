//! The rotor and what turns with it: a mass that torques set in motion and friction holds.

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use super::data::MotorData;
use super::sine::sine;

/// An end stop throws the motor back with this part of the force that pressed it in.
const RESTITUTION: f64 = 0.5;

/// Everything about the shaft that no current changes. Angles are in full steps, torques in N·m.
#[derive(Clone, Debug)]
pub(super) struct Mechanics {
    /// Radians in a full step.
    pub(super) radians: f64,
    /// In kg·m².
    pub(super) inertia: f64,
    /// Full steps/s² by 1 N·m.
    acceleration: f64,
    detent: f64,
    /// The torque that is always there.
    torque: f64,
    friction: f64,
    brake: f64,
    /// Per full step/s.
    drag: f64,
    /// Of an end stop, per full step.
    stiffness: f64,
    /// Where the stops are.
    stops: Option<RangeInclusive<f64>>,
}

impl Mechanics {
    pub(super) fn new(data: &MotorData, stops: Option<RangeInclusive<f64>>) -> Self {
        let radians = TAU / f64::from(data.full_steps);
        let load = &data.load;
        let inertia =
            (f64::from(data.rotor_inertia) + f64::from(load.inertia)) * GRAM_SQUARE_CENTIMETRE;
        let speed_of_drag = 1_000.0 / 60.0 * f64::from(data.full_steps);
        Self {
            radians,
            inertia,
            acceleration: 1.0 / (inertia * radians),
            detent: newton_metres(data.detent_torque),
            torque: f64::from(load.torque) / 1e3,
            friction: newton_metres(load.friction),
            brake: newton_metres(load.brake),
            drag: newton_metres(load.drag) / speed_of_drag,
            stiffness: f64::from(data.microsteps) / f64::from(load.compliance.max(1)),
            stops,
        }
    }

    /// The fastest that this can swing when a spring of so many N·m per full step is added, in radians/s.
    pub(super) fn natural_frequency(&self, stiffness: f64) -> f64 {
        (stiffness * self.acceleration).sqrt()
    }

    /// The stiffness of an end stop in N·m per full step.
    pub(super) const fn stop_stiffness(&self) -> f64 {
        self.stiffness
    }

    /// How far a position is pressed into an end stop; positive beyond the upper one.
    fn pressed(&self, position: f64) -> f64 {
        match &self.stops {
            Some(stops) if position > *stops.end() => position - stops.end(),
            Some(stops) if position < *stops.start() => position - stops.start(),
            _ => 0.0,
        }
    }
}

/// 1 g·cm² in kg·m².
const GRAM_SQUARE_CENTIMETRE: f64 = 1e-7;

pub(super) fn newton_metres(milli: u32) -> f64 {
    f64::from(milli) / 1e3
}

/// Where the rotor is, and how fast it turns, in full steps and full steps/s from where it was mounted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Rotor {
    pub(super) position: f64,
    pub(super) velocity: f64,
}

impl Rotor {
    /// A time in seconds goes by while a torque of the windings acts. Springs move it first, then friction takes from its speed, at
    /// most all of it: what is held by friction stands still.
    pub(super) fn step(
        &mut self,
        mechanics: &Mechanics,
        windings: f64,
        is_braked: bool,
        seconds: f64,
    ) {
        let torque = windings + mechanics.torque
            - mechanics.detent * sine(4.0 * self.position)
            - self.stop_torque(mechanics);
        let gain = mechanics.acceleration * seconds;
        let free = (self.velocity + gain * torque) / (1.0 + gain * mechanics.drag);
        let brake = if is_braked { mechanics.brake } else { 0.0 };
        let held = gain * (mechanics.friction + brake);
        self.velocity = if free.abs() <= held {
            0.0
        } else {
            free - held.copysign(free)
        };
        self.position += self.velocity * seconds;
    }

    /// Whether it is pressed into an end stop.
    pub(super) fn is_at_stop(&self, mechanics: &Mechanics) -> bool {
        mechanics.pressed(self.position) != 0.0
    }

    fn stop_torque(&self, mechanics: &Mechanics) -> f64 {
        let pressed = mechanics.pressed(self.position);
        let leaves = pressed * self.velocity < 0.0;
        mechanics.stiffness * pressed * if leaves { RESTITUTION } else { 1.0 }
    }

    /// The energy in it without current, in J: of its motion, of its place in the detents, at the stops and under the torque that
    /// is always there.
    #[cfg(test)]
    pub(super) fn energy(&self, mechanics: &Mechanics) -> f64 {
        let speed = self.velocity * mechanics.radians;
        let pressed = mechanics.pressed(self.position);
        let detents = mechanics.detent / TAU * (1.0 - sine(4.0 * self.position + 1.0));
        let spring = mechanics.stiffness * pressed * pressed / 2.0;
        let weight = mechanics.torque * self.position;
        mechanics.inertia * speed * speed / 2.0 + (detents + spring - weight) * mechanics.radians
    }
}
