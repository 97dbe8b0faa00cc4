//! What cannot go on: each period what is seen of the motor is held against what it should do.

use super::{ControlConfig, Fault};
use crate::interrupt::Snapshot;
use crate::motor::{Implausible, Motor, Wiring};
use crate::number::{between, fade, is_within, root};
use crate::protection::{Blocked, PhaseLoss};
use crate::transform::{Rotor, direction};

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
    period: f32,
    max_speed: f32,
    blocked: Blocked,
    phase_loss: PhaseLoss,
    /// For how long the unknown voltage has been too large, in s.
    astray: f32,
    readings: [Reading; 3],
    /// For how long the sum of the phase currents has been too large, in s.
    unequal: f32,
    /// The current that the loop should have reached by now.
    due: Rotor,
}

impl Watch {
    /// # Errors
    /// With what [`Blocked::new`] and [`PhaseLoss::new`] refuse, or a greatest speed outside 1 to 10⁴ rad/s.
    pub(super) fn new(motor: &Motor, config: &ControlConfig) -> Result<Self, Implausible> {
        Implausible::unless(is_within(config.max_speed, 1.0, 1e4))?;
        let (period, rated) = (config.period, motor.rated_current);
        let least = between(0.02 * rated, 1e-3, rated);
        let (speed, time) = config.blocked;
        Ok(Self {
            period,
            max_speed: config.max_speed,
            blocked: Blocked::new(speed, time, period)?,
            phase_loss: PhaseLoss::new(motor.wiring, least, 0.02, period)?,
            astray: 0.0,
            readings: [Reading::default(); 3],
            unequal: 0.0,
            due: Rotor::ZERO,
        })
    }

    /// The gates are about to be on.
    pub(super) fn start(&mut self) {
        self.astray = 0.0;
        self.readings = [Reading::default(); 3];
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
        motor: &Motor,
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
        let angle = direction(seen.angle);
        let asked = seen.demand;
        let keeps = fade(seen.rate, self.period);
        self.due = self.due.fading_to(asked, keeps);
        let unknown = seen.unknown;
        let [asked, carried, acts] = &[
            phases(self.due, angle, motor),
            phases(current, angle, motor),
            phases(unknown, angle, motor),
        ];
        let (share, time) = ADDED_UP;
        let rated = motor.rated_current;
        // Of two phases the sum says nothing.
        if motor.wiring == Wiring::TwoPhase || seen.sum.abs() <= share * rated {
            self.unequal = 0.0;
        } else {
            self.unequal += self.period;
        }
        if self.unequal > time {
            return Some(Fault::CurrentSensor);
        }
        if is_fed && self.phase_loss.run(*asked, *carried).is_some() {
            return Some(Fault::PhaseLost);
        }
        if let Some(reading) = self.stands_still(motor, carried, asked, acts, seen.bus) {
            if reading.abs() < NOTHING * rated {
                return Some(Fault::PhaseLost);
            }
            // Of three the sum tells, and where one is cut the others may stand still.
            if motor.wiring == Wiring::TwoPhase {
                return Some(Fault::CurrentSensor);
            }
        }
        // A magnet that turns where the encoder stands drives what the model does not know.
        let unknown = unknown.square();
        let known = motor.resistance * rated + 0.03 * seen.bus;
        let of_current = UNKNOWN * motor.resistance;
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
        motor: &Motor,
        carried: &[f32; 3],
        asked: &[f32; 3],
        acts: &[f32; 3],
        bus: f32,
    ) -> Option<f32> {
        let (time, _, away, share) = STILL;
        let mut found = None;
        let phases = carried.iter().zip(asked).zip(acts);
        let phases = self.readings.iter_mut().zip(phases);
        for (reading, ((carried, asked), acts)) in phases.take(motor.wiring.phases()) {
            let is_away = (carried - asked).abs() > away * motor.rated_current;
            let is_acted_on = is_away && acts.abs() > share * bus;
            reading.look(*carried, is_acted_on, motor.rated_current, self.period);
            if reading.since > time {
                found = Some(reading.frozen);
            }
        }
        found
    }
}

/// The reading of a phase.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Reading {
    frozen: f32,
    /// How long it has been so, in s.
    since: f32,
}

impl Reading {
    #[inline(never)]
    fn look(&mut self, carried: f32, is_acted_on: bool, rated: f32, period: f32) {
        let is_still = (carried - self.frozen).abs() <= STILL.1 * rated;
        if is_still && is_acted_on {
            self.since += period;
        } else {
            (self.frozen, self.since) = (carried, 0.0);
        }
    }
}

#[inline(never)]
fn phases(vector: Rotor, angle: (f32, f32), motor: &Motor) -> [f32; 3] {
    vector.beside_stator(angle).phases(motor.wiring)
}
