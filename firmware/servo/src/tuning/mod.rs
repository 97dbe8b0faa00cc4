//! What a motor is, found out by moving it a little.
//!
//! It takes the place of the current interrupt: each period it is given what was measured, and gives pulse widths. Nothing of the motor need be known but how it is
//! wired, what current it may have, and the counts of its encoder.
//!
//! ```text
//! Winding   R from two currents along a field, which the magnet comes to; L along and across from a square wave of voltage
//! Turning   the field turns the rotor on and back: pole pairs, direction and angle of the encoder
//! Strokes   a torque one way and the other, until the rotor stands again: flux, inertia, friction
//! ```
//!
//! The current stays within [`Setup::current`], the travel of the rotor within an electrical turn and a tenth of a turn of the motor while the field turns it, and within
//! [`Setup::distance`] for each stroke. A motor that lifts something is not for this: nothing holds its load between the strokes.

mod chirp;
mod line;
mod strokes;
mod turning;
mod winding;

use crate::current_loop::{CurrentConfig, Trip};
use crate::modulation::{Modulation, Widths};
use crate::motor::Implausible;
use crate::number::{are_within, is_within};
use crate::transform::{Rotor, Stator};
use crate::{Angle, CurrentLoop, Motor, Wiring};
pub use chirp::Chirp;
use strokes::Strokes;
use turning::Turning;
use winding::Winding;

/// What has to be known before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setup {
    /// How the motor is wired.
    pub wiring: Wiring,
    /// Counts of the encoder in a turn.
    pub counts: u32,
    /// Of the modulation, in s.
    pub period: f32,
    /// The current that the measurement may take, as the peak of a phase, in A.
    pub current: f32,
    /// The current of a phase at which the gates go off, in A.
    pub trip: f32,
    /// The least and the greatest voltage of the bus at which the gates are on, in V.
    pub bus: (f32, f32),
    /// The power stage.
    pub modulation: Modulation,
    /// How far the rotor may go in a stroke, in turns of the motor.
    pub distance: f32,
    /// How fast it may become, in rad/s.
    pub max_speed: f32,
}

/// What was found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// Of a phase, in Ω.
    pub resistance: f32,
    /// Along the magnet, in H.
    pub inductance_d: f32,
    /// Across it, in H.
    pub inductance_q: f32,
    /// Of the magnet with a phase, in V·s.
    pub flux: f32,
    /// Electrical turns in a turn.
    pub pole_pairs: u16,
    /// The encoder counts the other way.
    pub is_reversed: bool,
    /// The electrical angle of the rotor where the encoder was at its first look, with a count that goes the right way.
    pub angle: Angle,
    /// Of all that turns, in kg·m².
    pub inertia: f32,
    /// The torque of dry friction, in N·m.
    pub friction: f32,
}

impl Measured {
    /// A motor with this rated and peak current and encoder.
    ///
    /// # Errors
    /// If it can be none.
    pub fn motor(&self, setup: &Setup, currents: (f32, f32)) -> Result<Motor, Implausible> {
        let motor = Motor {
            wiring: setup.wiring,
            pole_pairs: self.pole_pairs,
            resistance: self.resistance,
            inductance_d: self.inductance_d,
            inductance_q: self.inductance_q,
            flux: self.flux,
            rated_current: currents.0,
            peak_current: currents.1,
            inertia: self.inertia,
            counts: setup.counts,
        };
        motor.check()?;
        Ok(motor)
    }
}

/// Why nothing was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// The power stage went off.
    Tripped(Trip),
    /// No current flows, or the winding is none.
    Winding,
    /// The encoder does not see that the field turns the rotor.
    NotFollowed,
    /// The travel of the encoder is no whole number of pole pairs, or a pole pair has fewer than 20 counts.
    PolePairs,
    /// The current does not move the rotor.
    Held,
    /// The rotor went further than it may.
    TooFar,
}

/// What comes of a period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// Pulse widths, as [`CurrentLoop::run`] gives them.
    Widths(Widths),
    /// It is over: the gates are to be off, or the loops to go on.
    Done(Measured),
    /// The gates are to be off.
    Failed(Failure),
}

/// What is measured in a period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Of the phases, in A.
    pub currents: [f32; 3],
    /// In V.
    pub bus: f32,
    /// Of the timer of the encoder.
    pub timer: u16,
}

/// Which part is under way.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Part {
    Winding(Winding),
    Turning(Turning),
    Strokes(Strokes),
    Over(Result<(), Failure>),
}

/// What a part makes of a period.
enum Next {
    Widths(Widths),
    Voltage(Stator),
    Finished,
}

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tuning {
    setup: Setup,
    measured: Measured,
    part: Part,
    /// The part has ended. The next is made in a period that does nothing else: what it takes is long beside a period.
    has_ended: bool,
    /// The timer at the last look, and what it has counted since the first, the right way once that is known.
    timer: Option<u16>,
    position: i32,
}

impl Tuning {
    /// With the motor at rest.
    ///
    /// # Errors
    /// With counts outside 16 to 2²⁴, a period outside 5 µs to 1 ms, a current outside 1 mA to the trip or a trip above 10 kA, a bus below 1 V or above 2 kV,
    /// a distance outside a hundredth of a turn to ten turns, or a speed outside 1 to 10⁴ rad/s.
    pub fn new(setup: Setup) -> Result<Self, Implausible> {
        Implausible::unless(
            (16..=1 << 24).contains(&setup.counts)
                && are_within(
                    [
                        setup.period,
                        setup.current,
                        setup.trip,
                        setup.bus.0,
                        setup.bus.1,
                        setup.distance,
                        setup.max_speed,
                    ],
                    &[
                        (5e-6, 1e-3),
                        (1e-3, 1e4),
                        (1e-3, 1e4),
                        (1.0, 2e3),
                        (1.0, 2e3),
                        (0.01, 10.0),
                        (1.0, 1e4),
                    ],
                )
                && setup.current <= setup.trip
                && setup.bus.0 <= setup.bus.1,
        )?;
        Ok(Self {
            setup,
            measured: Measured::default(),
            part: Part::Winding(Winding::new(setup.wiring)),
            has_ended: false,
            timer: None,
            position: 0,
        })
    }

    /// How much of it is done: 0 the winding, 1 the field turns, 2 strokes, 3 over.
    pub fn stage(&self) -> u8 {
        match self.part {
            Part::Winding(_) => 0,
            Part::Turning(_) => 1,
            Part::Strokes(_) => 2,
            Part::Over(_) => 3,
        }
    }

    /// A period has passed.
    pub fn run(&mut self, seen: &Seen) -> Step {
        let timer = if self.measured.is_reversed {
            seen.timer.wrapping_neg()
        } else {
            seen.timer
        };
        let moved = timer.wrapping_sub(self.timer.replace(timer).unwrap_or(timer));
        self.position = self.position.wrapping_add(moved.cast_signed().into());
        let step = match self.step(seen, timer) {
            Ok(Next::Widths(widths)) => return Step::Widths(widths),
            Ok(Next::Voltage(voltage)) => return self.widths(voltage, seen),
            Ok(Next::Finished) if !self.has_ended => {
                self.has_ended = true;
                return self.widths(Stator::default(), seen);
            }
            Ok(Next::Finished) => {
                self.has_ended = false;
                self.go_on(timer)
            }
            Err(failure) => Err(failure),
        };
        if let Err(failure) = step {
            self.part = Part::Over(Err(failure));
        }
        match self.part {
            Part::Over(Ok(())) => Step::Done(self.measured),
            Part::Over(Err(failure)) => Step::Failed(failure),
            // The next part begins with its own voltage a period later.
            _ => self.widths(Stator::default(), seen),
        }
    }

    #[inline(never)]
    fn widths(&self, voltage: Stator, seen: &Seen) -> Step {
        let by_bus = 1.0 / seen.bus;
        Step::Widths(self.setup.modulation.widths(voltage, seen.currents, by_bus))
    }

    fn step(&mut self, seen: &Seen, timer: u16) -> Result<Next, Failure> {
        let setup = &self.setup;
        let (least, max) = setup.bus;
        let is_held = |current: &f32| current.abs() <= setup.trip;
        let phases = seen.currents.iter().take(setup.wiring.phases());
        if !phases.clone().all(is_held) {
            return Err(Failure::Tripped(Trip::OverCurrent));
        }
        if seen.bus > max {
            return Err(Failure::Tripped(Trip::OverVoltage));
        }
        if !is_within(seen.bus, least, max) {
            return Err(Failure::Tripped(Trip::UnderVoltage));
        }
        match &mut self.part {
            _ if self.has_ended => Ok(Next::Finished),
            Part::Winding(winding) => {
                let current = Stator::of_phases(setup.wiring, seen.currents);
                winding.run(
                    setup,
                    (current, seen.bus, self.position),
                    &mut self.measured,
                )
            }
            Part::Turning(turning) => turning.run(setup, seen, self.position, &mut self.measured),
            Part::Strokes(strokes) => {
                strokes.run(setup, seen, (timer, self.position), &mut self.measured)
            }
            Part::Over(Ok(())) => Ok(Next::Finished),
            Part::Over(Err(failure)) => Err(*failure),
        }
    }

    /// The next part.
    fn go_on(&mut self, timer: u16) -> Result<(), Failure> {
        match &self.part {
            Part::Winding(_) => {
                let current = self.current_loop()?;
                let turning = Turning::new(current, self.position, self.setup.wiring);
                self.part = Part::Turning(turning);
            }
            Part::Turning(turning) => {
                let zero = turning.zero();
                self.measured.is_reversed = turning.is_reversed();
                let timer = if self.measured.is_reversed {
                    self.position = self.position.wrapping_neg();
                    timer.wrapping_neg()
                } else {
                    timer
                };
                self.timer = Some(timer);
                let share = f32::from(self.measured.pole_pairs) / self.setup.counts as f32;
                self.measured.angle = Angle::from_turns(-zero * share);
                let now = Angle::from_turns((self.position as f32 - zero) * share);
                let motor = self.motor()?;
                // Resistance and inductances are what they were.
                let current = turning.current_loop();
                let at = (now, timer, self.position);
                self.part = Part::Strokes(Strokes::new(&self.setup, &motor, current, at)?);
            }
            Part::Strokes(strokes) => {
                let Measured {
                    pole_pairs, flux, ..
                } = self.measured;
                let constant = self.setup.wiring.torque_constant(pole_pairs, flux);
                (self.measured.inertia, self.measured.friction) = strokes.loads(constant);
                self.part = Part::Over(Ok(()));
            }
            Part::Over(_) => {}
        }
        Ok(())
    }

    /// The motor as far as it is known: the least flux and one pole pair in place of what is not.
    #[inline(never)]
    fn motor(&self) -> Result<Motor, Implausible> {
        let known = Measured {
            flux: 1e-6,
            pole_pairs: self.measured.pole_pairs.max(1),
            inertia: 1e-6,
            ..self.measured
        };
        let max = self.setup.current;
        known.motor(&self.setup, (max, max))
    }

    #[inline(never)]
    fn current_loop(&self) -> Result<CurrentLoop, Implausible> {
        let setup = &self.setup;
        let motor = self.motor()?;
        let config = CurrentConfig {
            share: 0.5,
            learning: 0.3,
            ..CurrentConfig::quick(&motor, setup.period, setup.trip, setup.bus)
        };
        CurrentLoop::new(&motor, config, setup.modulation)
    }
}

impl From<Implausible> for Failure {
    fn from(_: Implausible) -> Self {
        Self::Winding
    }
}

impl From<Trip> for Failure {
    fn from(trip: Trip) -> Self {
        Self::Tripped(trip)
    }
}

/// A current along d.
const fn along(current: f32) -> Rotor {
    Rotor { d: current, q: 0.0 }
}
