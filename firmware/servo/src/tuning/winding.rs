//! Resistance and inductances, with the magnet pulled to the field.
//!
//! For two phases the field stands in the middle between them, for three along phase A: there no phase is without a current, where dead times take what nobody knows.
//!
//! A voltage grows until a current flows; then it is led, slowly, so that the current is what it is to be, once half of it and once the whole. What the voltage
//! grows by between the two is the resistance: what the dead time takes is in both. Around the half a square wave of voltage is added, first along the magnet, then across
//! it: the current changes by it as the inductance lets it.

use super::line::Line;
use super::{Failure, Measured, Next, Setup, along};
use crate::number::{between, greater, is_within, lesser, root};
use crate::transform::{Rotor, Stator, direction};
use crate::{Angle, Wiring};

/// The voltage begins at this share of what there is, and grows by e in this time, in s.
const FIRST: f32 = 0.002;
const GROWTH: f32 = 0.03;

/// The led current comes near by this share of the rest in a second.
const LED: f32 = 60.0;

/// Beyond this share of the current it is held back, as by so many times the resistance.
const MAX: f32 = 1.05;
const HELD_BACK: f32 = 5.0;

/// How long it settles at least, how long the rotor must stand while it is looked at, how long that is waited for, and how long one that swings still is looked at, in s.
const SETTLE: f32 = 0.08;
const LOOK: f32 = 0.04;
const WAIT: f32 = 1.0;
const SWINGS: f32 = 0.5;

/// How near the current must be, as a share of it.
const NEAR: f32 = 0.05;

/// What the rotor swings by no more while it stands, in counts.
pub(super) const STANDS: i32 = 1;

/// Periods of a half of the square wave.
const HALF_WAVE: u16 = 2;

/// The square wave grows until the current swings by this share, and is then looked at for so many periods.
const SWING: f32 = 0.3;
const LOOKED_AT: u16 = 400;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Stage {
    /// The voltage rises until a current flows.
    Rise,
    /// The current is held at half of what is allowed, and looked at.
    Half,
    /// The same with all that is allowed.
    Whole,
    /// Back at the half, the current settles.
    Back,
    /// A square wave of voltage along the magnet.
    Along,
    /// The same across the magnet.
    Across,
}

/// Where the field stands, in electrical turns.
pub(super) const fn field(wiring: Wiring) -> f32 {
    match wiring {
        Wiring::TwoPhase => 0.125,
        Wiring::ThreePhase => 0.0,
    }
}

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Winding {
    stage: Stage,
    /// Cosine and sine of where the field stands.
    field: (f32, f32),
    /// Since the stage began, in s.
    time: f32,
    /// Along the field and across it.
    voltage: Rotor,
    /// V/s for an ampere.
    gain: f32,
    /// Sums of voltage and current while they are looked at, and of how many.
    sums: (f32, f32, f32),
    /// Where the rotor was as the look began, and since when that is, in s.
    stood: (i32, f32),
    half: (f32, f32),
    /// The square wave: how large, and which period of it.
    wave: f32,
    period: u16,
    /// The least and the greatest current in this wave.
    swing: (f32, f32),
    is_grown: bool,
    /// What was seen at the last period, and the two voltages before.
    last: f32,
    voltages: (f32, f32),
    /// What the current changes by, in A/s, over the voltage for it: that is known better.
    line: Line,
}

impl Winding {
    pub(super) fn new(wiring: Wiring) -> Self {
        let (sine, cosine) = direction(Angle::from_turns(field(wiring)));
        Self {
            stage: Stage::Rise,
            field: (cosine, sine),
            time: 0.0,
            voltage: Rotor::ZERO,
            gain: 0.0,
            sums: (0.0, 0.0, 0.0),
            stood: (0, 0.0),
            half: (0.0, 0.0),
            wave: 0.0,
            period: 0,
            swing: (0.0, 0.0),
            is_grown: false,
            last: 0.0,
            voltages: (0.0, 0.0),
            line: Line::default(),
        }
    }

    pub(super) fn run(
        &mut self,
        setup: &Setup,
        (current, bus, position): (Stator, f32, i32),
        measured: &mut Measured,
    ) -> Result<Next, Failure> {
        let max = setup.modulation.max_voltage(bus);
        let (cosine, sine) = self.field;
        let current = current.from_rotor((sine, cosine));
        self.time += setup.period;
        if self.time > 4.0 * WAIT {
            return Err(Failure::Winding);
        }
        match self.stage {
            Stage::Rise => {
                self.rise(setup, current, max)?;
            }
            Stage::Half | Stage::Whole => {
                let is_half = self.stage == Stage::Half;
                let share = if is_half { 0.5 } else { 1.0 };
                let wanted = share * setup.current;
                if let Some(mean) = self.lead(setup, (current, position), wanted, max) {
                    if is_half {
                        self.half = mean;
                        self.enter(Stage::Whole);
                    } else {
                        let resistance = (mean.0 - self.half.0) / (mean.1 - self.half.1);
                        if !is_within(resistance, 1e-3, 1e3) {
                            return Err(Failure::Winding);
                        }
                        measured.resistance = resistance;
                        self.enter(Stage::Back);
                    }
                }
            }
            Stage::Back => {
                self.voltage = along(self.half.0);
                if self.time > LOOK {
                    self.begin_wave(Stage::Along, current.d, max);
                }
            }
            Stage::Along | Stage::Across => {
                let is_along = self.stage == Stage::Along;
                let seen = if is_along { current.d } else { current.q };
                if let Some(inductance) = self.shake(setup, seen, max, measured.resistance)? {
                    if !is_along {
                        measured.inductance_q = inductance;
                        return Ok(Next::Finished);
                    }
                    measured.inductance_d = inductance;
                    self.begin_wave(Stage::Across, current.q, max);
                }
            }
        }
        let voltage = self.held_back(setup, current);
        Ok(Next::Voltage(voltage.beside_stator((sine, cosine))))
    }

    /// The voltage, less what a current has too much: a rotor that swings into the field drives one.
    fn held_back(&self, setup: &Setup, current: Rotor) -> Rotor {
        let max = MAX * setup.current;
        let size = root(current.square());
        if size <= max {
            return self.voltage;
        }
        let resistance = self.gain * (1.0 / LED);
        let excess = HELD_BACK * resistance * (1.0 - max / size);
        Rotor {
            d: self.voltage.d - excess * current.d,
            q: self.voltage.q - excess * current.q,
        }
    }

    #[inline(never)]
    fn enter(&mut self, stage: Stage) {
        self.stage = stage;
        self.time = 0.0;
        self.sums = (0.0, 0.0, 0.0);
    }

    /// The voltage grows until half the current flows.
    fn rise(&mut self, setup: &Setup, current: Rotor, max: f32) -> Result<(), Failure> {
        let half = 0.5 * setup.current;
        if current.d >= half {
            self.gain = LED * self.voltage.d / half;
            self.enter(Stage::Half);
            return Ok(());
        }
        if self.voltage.d >= 0.95 * max {
            return Err(Failure::Winding);
        }
        let grown = self.voltage.d * (1.0 + setup.period / GROWTH);
        self.voltage.d = between(grown, FIRST * max, max);
        Ok(())
    }

    /// Leads the current. Gives the mean of voltage and current once both have been looked at while the rotor stood, or for as long as that is waited for.
    fn lead(
        &mut self,
        setup: &Setup,
        (seen, position): (Rotor, i32),
        wanted: f32,
        max: f32,
    ) -> Option<(f32, f32)> {
        let (stood, since) = self.stood;
        let away = position.wrapping_sub(stood).wrapping_abs();
        let waits = self.time < WAIT;
        let is_led = (seen.d - wanted).abs() < NEAR * wanted;
        if self.time < SETTLE || !is_led || (away > STANDS && waits) {
            self.stood = (position, self.time);
            self.sums = (0.0, 0.0, 0.0);
        } else {
            self.sums.0 += self.voltage.d;
            self.sums.1 += seen.d;
            self.sums.2 += 1.0;
        }
        let look = if waits { LOOK } else { SWINGS };
        let is_over = self.time - since > look && self.sums.2 > 0.0;
        let step = self.gain * setup.period;
        let d = self.voltage.d + step * (wanted - seen.d);
        let q = self.voltage.q - step * seen.q;
        self.voltage = Rotor {
            d: between(d, -max, max),
            q: between(q, -max, max),
        };
        let by = 1.0 / self.sums.2;
        is_over.then_some((self.sums.0 * by, self.sums.1 * by))
    }

    #[inline(never)]
    fn begin_wave(&mut self, stage: Stage, seen: f32, max: f32) {
        self.enter(stage);
        self.wave = 0.01 * max;
        self.period = 0;
        self.swing = (seen, seen);
        self.is_grown = false;
        self.last = seen;
        self.voltages = (0.0, 0.0);
        self.line = Line::default();
    }

    /// A period of the square wave. Gives the inductance in the end.
    fn shake(
        &mut self,
        setup: &Setup,
        seen: f32,
        max: f32,
        resistance: f32,
    ) -> Result<Option<f32>, Failure> {
        let (before, acting) = self.voltages;
        if self.is_grown {
            let change = (seen - self.last) / setup.period;
            let voltage = 0.5 * (before + acting) - resistance * 0.5 * (seen + self.last);
            self.line.add(voltage, change);
            if self.line.count >= f32::from(LOOKED_AT) {
                let (change, _) = self.line.solve();
                let inductance = 1.0 / change;
                return if is_within(inductance, 1e-6, 1.0) {
                    Ok(Some(inductance))
                } else {
                    Err(Failure::Winding)
                };
            }
        }
        self.last = seen;
        self.swing = (lesser(self.swing.0, seen), greater(self.swing.1, seen));
        // The first half of a wave is one period long, so that the current swings around where it was.
        let turn = (self.period + HALF_WAVE / 2) % (2 * HALF_WAVE);
        let wave = if turn < HALF_WAVE {
            self.wave
        } else {
            -self.wave
        };
        self.period += 1;
        if self.period == 4 * HALF_WAVE {
            self.period = 0;
            let swings = self.swing.1 - self.swing.0;
            let room = 0.9 * max - self.half.0;
            if swings >= SWING * setup.current || self.wave >= 0.5 * room {
                self.is_grown = true;
            } else if !self.is_grown {
                self.wave *= 1.2;
            }
            self.swing = (seen, seen);
        }
        let held = self.half.0;
        let is_along = self.stage == Stage::Along;
        let given = if is_along { held + wave } else { wave };
        self.voltage = if is_along {
            along(given)
        } else {
            Rotor { d: held, q: given }
        };
        self.voltages = (acting, given);
        Ok(None)
    }
}
