//! What cannot go on: each period what is seen of the motor is held against what it should do.

use super::{ControlConfig, Fault};
use crate::interrupt::Snapshot;
use crate::motor::{Implausible, Motor, Wiring};
use crate::number::{between, fade, is_within, root};
use crate::protection::{Blocked, PhaseLoss};
use crate::transform::{Rotor, Stator};

/// An unknown voltage above this share of the rated voltage of the winding shows that the encoder is wrong.
const UNKNOWN: f32 = 0.35;

/// How long such a voltage is tolerated, in s.
const ASTRAY: f32 = 5e-3;

/// How large the sum of the phase currents may be, as a share of the rated current, and for how long it may be larger, in s.
const ADDED_UP: (f32, f32) = (0.2, 2e-3);

/// When the reading of a phase current counts as frozen: for so long, in s, it has changed by less than this share of the rated current, though it
/// was this share away from the demand, and the unknown voltage was this share of the bus.
const STILL: (f32, f32, f32, f32) = (0.4e-3, 0.01, 0.05, 0.25);

/// Above this share of the rated current a frozen reading is the fault of a sensor, below it a phase that carries nothing.
const NOTHING: f32 = 0.03;

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Watch {
    motor: Motor,
    period: f32,
    max_speed: f32,
    blocked: Blocked,
    phase_loss: PhaseLoss,
    /// For how long the unknown voltage has been too large, in s.
    astray: f32,
    /// The frozen reading of each phase, and for how long it has been so, in s.
    still: [(f32, f32); 3],
    /// For how long the sum of the phase currents has been too large, in s.
    unequal: f32,
    /// The current that the loop should have reached by now.
    due: Rotor,
}

impl Watch {
    /// # Errors
    /// With what [`Blocked::new`] and [`PhaseLoss::new`] refuse, or a greatest speed outside 1 to 10⁴ rad/s.
    pub(super) fn new(motor: &Motor, config: &ControlConfig) -> Result<Self, Implausible> {
        let (period, rated) = (config.period, motor.rated_current);
        let least = between(0.02 * rated, 1e-3, rated);
        let (speed, time) = config.blocked;
        let watch = Self {
            motor: *motor,
            period,
            max_speed: config.max_speed,
            blocked: Blocked::new(speed, time, period)?,
            phase_loss: PhaseLoss::new(motor.wiring, least, 0.02, period)?,
            astray: 0.0,
            still: [(0.0, 0.0); 3],
            unequal: 0.0,
            due: Rotor::ZERO,
        };
        let is_one = is_within(config.max_speed, 1.0, 1e4);
        is_one.then_some(watch).ok_or(Implausible)
    }

    /// The gates are about to be on.
    pub(super) fn start(&mut self) {
        self.astray = 0.0;
        self.still = [(0.0, 0.0); 3];
        self.unequal = 0.0;
        self.due = Rotor::ZERO;
        self.blocked.restart();
    }

    pub(super) fn set_blocked(
        &mut self,
        (speed, time): (f32, f32),
        period: f32,
    ) -> Result<(), Implausible> {
        self.blocked = Blocked::new(speed, time, period)?;
        Ok(())
    }

    /// A period.
    pub(super) fn run(
        &mut self,
        seen: &Snapshot,
        is_fed: bool,
        pushes: bool,
        velocity: f32,
    ) -> Option<Fault> {
        let current = seen.current;
        let is_held = velocity.abs() <= self.max_speed;
        if !is_held {
            return Some(Fault::OverSpeed);
        }
        let angle = seen.angle.sine_cosine();
        let asked = seen.demand;
        let keeps = fade(seen.rate, self.period);
        self.due = Rotor {
            d: asked.d + keeps * (self.due.d - asked.d),
            q: asked.q + keeps * (self.due.q - asked.q),
        };
        let asked = self.due.beside_stator(angle);
        let carried = current.beside_stator(angle);
        let phases = |stator: Stator| stator.phases(self.motor.wiring);
        let (share, time) = ADDED_UP;
        // Of two phases the sum says nothing.
        if self.motor.wiring == Wiring::TwoPhase
            || seen.sum.abs() <= share * self.motor.rated_current
        {
            self.unequal = 0.0;
        } else {
            self.unequal += self.period;
        }
        if self.unequal > time {
            return Some(Fault::CurrentSensor);
        }
        if is_fed && (self.phase_loss.run(phases(asked), phases(carried))).is_some() {
            return Some(Fault::PhaseLost);
        }
        let unknown = seen.unknown;
        let acts = unknown.beside_stator(angle);
        if let Some(reading) =
            self.stands_still(phases(carried), phases(asked), phases(acts), seen.bus)
        {
            if reading.abs() < NOTHING * self.motor.rated_current {
                return Some(Fault::PhaseLost);
            }
            // Of three the sum tells, and where one is cut the others may stand still.
            if self.motor.wiring == Wiring::TwoPhase {
                return Some(Fault::CurrentSensor);
            }
        }
        // A magnet that turns where the encoder stands drives what the model does not know.
        let unknown = unknown.square();
        let known = self.motor.resistance * self.motor.rated_current + 0.03 * seen.bus;
        let of_current = UNKNOWN * self.motor.resistance;
        // Most of the time it is below what needs no root.
        let is_astray =
            unknown > known * known && root(unknown) > known + of_current * root(current.square());
        self.astray = if is_astray {
            self.astray + self.period
        } else {
            0.0
        };
        if self.astray > ASTRAY {
            return Some(Fault::Encoder);
        }
        self.blocked.run(pushes, velocity).then_some(Fault::Blocked)
    }

    /// The reading of a phase that stands still though much acts on it.
    fn stands_still(
        &mut self,
        carried: [f32; 3],
        asked: [f32; 3],
        acts: [f32; 3],
        bus: f32,
    ) -> Option<f32> {
        let (time, within, away, share) = STILL;
        let rated = self.motor.rated_current;
        let mut found = None;
        let phases = self
            .still
            .iter_mut()
            .zip(carried)
            .zip(asked.iter().zip(acts));
        for (((reading, since), carried), (asked, acts)) in phases.take(self.motor.wiring.phases())
        {
            let is_still = (carried - *reading).abs() <= within * rated;
            let is_away = (carried - asked).abs() > away * rated;
            if is_still && is_away && acts.abs() > share * bus {
                *since += self.period;
            } else {
                (*reading, *since) = (carried, 0.0);
            }
            if *since > time {
                found = Some(*reading);
            }
        }
        found
    }
}
