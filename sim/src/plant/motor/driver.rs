//! The driver: it counts pulses, points the field of the motor where they say, and chops its current.
//!
//! How much current it gets into a phase depends on what the supply has left at this speed: the back-EMF grows with
//! the speed of the rotor, the impedance with that of the field. So there is less torque the faster the motor turns, and more with a
//! higher supply.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::data::MotorData;

/// Over what time the speed of the field is taken, in seconds.
const SMOOTHING: f64 = 0.001;

/// Slower than this the field rests, in full steps/s.
const REST: f64 = 0.001;

/// What a winding does with a voltage.
#[derive(Clone, Debug)]
pub(super) struct Winding {
    /// In Ω.
    resistance: f64,
    /// In Ω at one full step/s.
    reactance: f64,
    /// In V at one full step/s of the rotor.
    back_emf: f64,
}

impl Winding {
    pub(super) fn new(data: &MotorData) -> Self {
        // The torque of a current and the voltage of a speed are two sides of one constant, in N·m/A and V·s.
        let constant = f64::from(data.holding_torque) / f64::from(data.rated_current);
        Self {
            resistance: f64::from(data.resistance) / 1e3,
            reactance: f64::from(data.inductance) / 1e6 * FRAC_PI_2,
            back_emf: constant * TAU / f64::from(data.full_steps),
        }
    }

    /// The most current in A that goes in at these speeds (in full steps/s, of field and rotor) from this supply in V.
    fn max(&self, supply: f64, field: f64, rotor: f64) -> f64 {
        let left = supply - self.back_emf * rotor.abs();
        let reactance = self.reactance * field;
        let square = self.resistance * self.resistance + reactance * reactance;
        left.max(0.0) / square.sqrt()
    }

    /// What a current in A turns into heat, in W: the squares of the two phases add up to that of the peak.
    pub(super) fn loss(&self, current: f64) -> f64 {
        self.resistance * current * current
    }
}

/// The driver at work.
#[derive(Clone, Debug)]
pub(super) struct Driver {
    /// Where the field points, in full steps from where the motor was mounted.
    field: f64,
    /// Its speed in full steps/s.
    velocity: f64,
}

impl Driver {
    pub(super) const fn new() -> Self {
        Self {
            field: 0.0,
            velocity: 0.0,
        }
    }

    /// It begins anew: its counter is at its first phase, which is one of those places where the motor was mounted.
    pub(super) fn reset(&mut self, rotor: f64) {
        self.field = 4.0 * (rotor / 4.0).round();
        self.velocity = 0.0;
    }

    /// So many pulses arrive, each such a part of a full step.
    pub(super) fn take(&mut self, pulses: i64, microsteps: u16) -> f64 {
        let way = pulses as f64 / f64::from(microsteps.max(1));
        self.field += way;
        way
    }

    /// A time in seconds goes by, in which the field went on by so many full steps.
    pub(super) fn pass(&mut self, way: f64, seconds: f64) {
        self.velocity += (way - self.velocity * seconds) / SMOOTHING;
        if self.velocity.abs() < REST {
            self.velocity = 0.0;
        }
    }

    /// Where the field points, in full steps.
    pub(super) const fn field(&self) -> f64 {
        self.field
    }

    /// How fast the field turns, in full steps/s.
    pub(super) const fn velocity(&self) -> f64 {
        self.velocity
    }

    /// The current in A that flows when `demand` is wanted.
    pub(super) fn current(&self, demand: f64, winding: &Winding, supply: f64, rotor: f64) -> f64 {
        demand.min(winding.max(supply, self.velocity, rotor))
    }
}
