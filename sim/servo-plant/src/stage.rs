//! The power stage: what it makes of the bus and of what its gates are told.
//!
//! While it switches, a half bridge gives its share of the bus, less the dead time, in which the current chooses the diode: it takes
//! away `dead time / period` of the bus in the direction of the current. While it is off, the diodes take the current down against the bus until
//! there is none; of three phases that is the fundamental of a diode bridge, 2/π of the bus. A motor that turns fast enough feeds through them.

use std::f64::consts::FRAC_2_PI;

use crate::data::{MotorData, Phases, PlantData};
use crate::electrical::{Facing, Winding, of_phases};

/// What the gates are told.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Gates {
    /// All are off.
    #[default]
    Off,
    /// How much of the period each of three half bridges is high, 0 to 1; of two full bridges what share of the bus each gives, −1 to 1,
    /// and the third number is nothing.
    On([f64; 3]),
}

/// The stage in one step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bridge {
    gates: Gates,
    bus: f64,
    /// What the dead time takes away at most, in V.
    dead: f64,
    ripple: f64,
}

impl Bridge {
    pub(crate) fn new(data: &PlantData, gates: Gates, bus: f64) -> Self {
        Self {
            gates,
            bus,
            dead: bus * data.stage.dead_time / data.stage.period,
            ripple: data.stage.ripple,
        }
    }

    /// The voltage beside the stator in a step that begins with the rotor looking there, at this electrical speed.
    pub(crate) fn voltage(
        &self,
        motor: &MotorData,
        winding: &Winding,
        facing: Facing,
        speed: f64,
    ) -> [f64; 2] {
        match self.gates {
            Gates::On(duties) => {
                let currents = winding.phases(motor, facing);
                let phase = |at: usize| self.leg(motor.phases, duties[at], currents[at]);
                of_phases(motor.phases, [phase(0), phase(1), phase(2)])
            }
            Gates::Off => {
                let mut current = facing.to_stator(winding.current);
                if current == [0.0; 2] {
                    // What the magnet would drive, if it can.
                    current = facing.to_stator([0.0, -speed * motor.flux]);
                }
                self.through_diodes(motor.phases, current)
            }
        }
    }

    /// Between the first wire of a phase and the negative side of the bus, while the wire carries a positive current.
    pub(crate) fn of_wire(&self, phases: Phases, phase: usize, currents: [f64; 3]) -> f64 {
        let Gates::On(duties) = self.gates else {
            // The lower diode.
            return 0.0;
        };
        let voltage = self.leg(phases, duties[phase], currents[phase]);
        match phases {
            Phases::Three => voltage,
            Phases::Two => f64::midpoint(self.bus, voltage),
        }
    }

    /// What a phase gets.
    fn leg(&self, phases: Phases, duty: f64, current: f64) -> f64 {
        let lost = self.dead * (current / self.ripple).clamp(-1.0, 1.0);
        match phases {
            // What does not switch loses nothing.
            Phases::Three if duty <= 0.0 || duty >= 1.0 => duty.clamp(0.0, 1.0) * self.bus,
            Phases::Three => (duty * self.bus - lost).clamp(0.0, self.bus),
            Phases::Two if duty.abs() >= 1.0 => self.bus.copysign(duty),
            // Both sides of a full bridge switch.
            Phases::Two => (duty * self.bus - 2.0 * lost).clamp(-self.bus, self.bus),
        }
    }

    fn through_diodes(&self, phases: Phases, current: [f64; 2]) -> [f64; 2] {
        match phases {
            Phases::Two => current.map(|current| {
                if current == 0.0 {
                    0.0
                } else {
                    -self.bus.copysign(current)
                }
            }),
            Phases::Three => {
                let size = libm::hypot(current[0], current[1]);
                if size == 0.0 {
                    return [0.0; 2];
                }
                current.map(|current| -FRAC_2_PI * self.bus * current / size)
            }
        }
    }

    /// Diodes do not carry a current backwards: what has begun to flow with the voltage of the step, not against it, is none.
    pub(crate) fn block(
        &self,
        motor: &MotorData,
        winding: &mut Winding,
        voltage: [f64; 2],
        facing: Facing,
    ) {
        if self.gates != Gates::Off {
            return;
        }
        let now = facing.to_stator(winding.current);
        let with = [now[0] * voltage[0], now[1] * voltage[1]];
        let left = match motor.phases {
            Phases::Two => std::array::from_fn(|at| if with[at] > 0.0 { 0.0 } else { now[at] }),
            Phases::Three if with[0] + with[1] > 0.0 => [0.0; 2],
            Phases::Three => now,
        };
        winding.current = facing.to_rotor(left);
    }
}
