//! Flux, inertia and friction: a torque pushes the rotor one way until it is fast enough or halfway, the same torque the other way brings it to a standstill; and back again.
//!
//! With a current q, a friction f and the inertia J, all as currents of the motor, the rotor goes
//!
//! ```text
//! J · x(t) = ∬ q − f · ∬ sign(ω)
//! ```
//!
//! from where it stood. Both integrals are known where the torque turns round and where the rotor stands again, so two such points are two equations, and all strokes
//! together a line through them. Positions are exact, and at a standstill it does not matter when that is seen. The voltage of the magnet is what the loop needed beyond
//! the resistance.

use super::line::Line;
use super::{Failure, Measured, Next, Seen, Setup};
use crate::current_loop::Sample;
use crate::feedback::{Incremental, Observer};
use crate::motor::Implausible;
use crate::number::{between, greater, is_within, lesser};
use crate::transform::Rotor;
use crate::{Angle, CurrentLoop, Motor};

/// The torque begins with this share of the current, and grows by this factor until the rotor moves.
const FIRST: f32 = 0.05;
const GROWTH: f32 = 1.3;

/// Once it moves, the strokes are that much stronger, but not so strong that a light rotor is fast enough within so many periods.
const STRONGER: f32 = 2.5;
const PUSH: f32 = 70.0;

/// A rotor that has not moved by a part of a turn in this time is held, in s; a stroke that takes longer than this is too weak.
const HELD: f32 = 0.025;
const MOVED: f32 = 1.0 / 400.0;
const LONGEST: f32 = 0.3;

/// The rotor goes back when it is so many counts from its furthest point.
const BACK: i32 = 3;

/// How many strokes are looked at.
const STROKES: u8 = 6;

/// The share of the voltage that a push may take.
const VOLTAGE: f32 = 0.6;

/// Current and observer have settled after so many periods.
const SETTLED: u16 = 40;

/// Of the observer of the angle, in rad/s.
const OBSERVER: f32 = 2_000.0;

/// What has come together since the rotor stood.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Sums {
    time: f32,
    /// ∫ and ∬ of the current.
    once: f32,
    twice: f32,
}

impl Sums {
    fn add(&mut self, current: f32, period: f32) {
        self.time += period;
        self.once += current * period;
        self.twice += self.once * period;
    }

    /// With a current that was the same for so long.
    fn since(time: f32, current: f32) -> Self {
        Self {
            time,
            once: current * time,
            twice: 0.5 * current * time * time,
        }
    }
}

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Strokes {
    current: CurrentLoop,
    encoder: Incremental,
    observer: Observer,
    /// rad of a count.
    count: f32,
    level: f32,
    /// The rotor has moved; what it does now counts.
    counts: bool,
    done: u8,
    is_forward: bool,
    brakes: bool,
    /// Where the stroke began, and how far it has come, when that was reached first and last.
    begin: i32,
    furthest: i32,
    reached: f32,
    left: f32,
    sums: Sums,
    /// As it was when the torque turned round, and when it had come furthest.
    turned: (Sums, i32),
    stood: Sums,
    settled: u16,
    /// Through all points: current / (rad/s²) upwards over s² / rad.
    line: Line,
    /// Sums of voltage × speed and of speed².
    voltage: f32,
    square: f32,
}

impl Strokes {
    /// With a motor of which winding and pole pairs are known, whose rotor stands at this electrical angle, with the timer at this count, and in this position.
    #[inline(never)]
    pub(super) fn new(
        setup: &Setup,
        motor: &Motor,
        current: CurrentLoop,
        (angle, timer, position): (Angle, u16, i32),
    ) -> Result<Self, Implausible> {
        let mut encoder = Incremental::new(motor, timer, 2);
        encoder.set_angle(angle);
        let max = 1.0 / setup.period;
        let mut observer = Observer::new(lesser(OBSERVER, max), setup.period)?;
        observer.stand_at(angle);
        Ok(Self {
            current,
            encoder,
            observer,
            count: core::f32::consts::TAU / setup.counts as f32,
            level: FIRST * setup.current,
            counts: false,
            done: 0,
            is_forward: true,
            brakes: false,
            begin: position,
            furthest: 0,
            reached: 0.0,
            left: 0.0,
            sums: Sums::default(),
            turned: (Sums::default(), 0),
            stood: Sums::default(),
            settled: 0,
            line: Line::default(),
            voltage: 0.0,
            square: 0.0,
        })
    }

    /// The timer and the position, in counts, go the right way.
    pub(super) fn run(
        &mut self,
        setup: &Setup,
        seen: &Seen,
        (timer, position): (u16, i32),
        measured: &mut Measured,
    ) -> Result<Next, Failure> {
        self.encoder.look(timer);
        self.observer.look(self.encoder.angle());
        let speed = self.observer.speed();
        let acted = self.current.voltage();
        let sign = if self.is_forward { 1.0 } else { -1.0 };
        let push = if self.brakes { -sign } else { sign } * self.level;
        let sample = Sample {
            currents: seen.currents,
            bus: seen.bus,
            angle: self.observer.angle(),
            turn: self.observer.turn(),
        };
        let widths = self.current.run(&sample, Rotor { d: 0.0, q: push })?;
        let current = self.current.current();
        self.settled = self.settled.saturating_add(1);
        if self.counts && self.settled > SETTLED {
            let coupled = speed * measured.inductance_d * current.d;
            let magnet = acted.q - measured.resistance * current.q - coupled;
            self.voltage += magnet * speed;
            self.square += speed * speed;
        }
        self.sums.add(sign * current.q, setup.period);
        let distance = self.distance(position);
        if distance > self.furthest {
            self.furthest = distance;
            self.reached = self.sums.time;
            self.stood = self.sums;
        }
        if distance >= self.furthest {
            self.left = self.sums.time;
        }
        let max = setup.distance * setup.counts as f32;
        if (distance as f32).abs() > 1.2 * max {
            return Err(Failure::TooFar);
        }
        if self.brakes {
            if distance < self.furthest - BACK {
                if self.end_stroke(setup, sign * current.q, measured)? {
                    return Ok(Next::Finished);
                }
            } else if self.sums.time - self.reached > HELD {
                // What the brake has stopped is held there.
                self.grow(setup, distance)?;
            }
        } else {
            let turns = speed.abs() / f32::from(measured.pole_pairs.max(1));
            let is_moved = distance as f32 > MOVED * setup.counts as f32;
            let needed = self.current.voltage();
            let most = VOLTAGE * setup.modulation.max_voltage(seen.bus);
            let has_most = needed.square() > most * most;
            let is_fast = has_most || turns > 0.5 * setup.max_speed;
            if is_moved && (is_fast || distance as f32 > 0.5 * max) {
                self.brakes = true;
                self.settled = 0;
                self.turned = (self.sums, distance);
            } else if (!is_moved && self.sums.time > HELD) || self.sums.time > LONGEST {
                self.grow(setup, distance)?;
            }
        }
        Ok(Next::Widths(widths))
    }

    /// Since the stroke began, in counts.
    fn distance(&self, position: i32) -> i32 {
        self.along(position.wrapping_sub(self.begin))
    }

    /// Counts of the encoder in the direction of the stroke, and back.
    fn along(&self, counts: i32) -> i32 {
        if self.is_forward {
            counts
        } else {
            counts.wrapping_neg()
        }
    }

    /// The torque does not do: it grows, and the stroke begins anew from here.
    fn grow(&mut self, setup: &Setup, distance: i32) -> Result<(), Failure> {
        let max = setup.current;
        if self.level >= max {
            return Err(Failure::Held);
        }
        self.level = lesser(self.level * GROWTH, max);
        self.counts = false;
        let is_forward = self.is_forward != (distance > 0);
        // What has gone one way comes back.
        self.begin_stroke(distance, is_forward, Sums::default());
        Ok(())
    }

    /// The rotor stood a moment ago and goes back: so begins the next stroke. Returns whether this was the last one.
    fn end_stroke(
        &mut self,
        setup: &Setup,
        current: f32,
        measured: &mut Measured,
    ) -> Result<bool, Failure> {
        if self.counts {
            let (turned, distance) = self.turned;
            for (sums, counts) in [(turned, distance), (self.stood, self.furthest)] {
                let by = 1.0 / (counts as f32 * self.count);
                let square = 0.5 * sums.time * sums.time;
                self.line.add(square * by, sums.twice * by);
            }
            self.done += 1;
        } else {
            self.counts = true;
            // (level − friction) · push = (level + friction) · brake: what the rotor has of either.
            let push = self.turned.0.time;
            let brake = self.stood.time - push;
            let longer = 2.0 * push * brake / (PUSH * setup.period);
            let stronger = between((push - brake + longer) / (push + brake), 1.0, STRONGER);
            self.level = lesser(self.level * stronger, setup.current);
        }
        // It stood in the middle between coming to its furthest point and leaving it.
        let since = self.sums.time - 0.5 * (self.reached + self.left);
        let sums = Sums::since(since, -current);
        self.begin_stroke(self.furthest, !self.is_forward, sums);
        if self.done < STROKES {
            return Ok(false);
        }
        let (_, inertia) = self.line.solve();
        measured.flux = self.voltage / self.square;
        let known = is_within(measured.flux, 1e-6, 10.0) && inertia > 0.0;
        if !known {
            return Err(Failure::Held);
        }
        Ok(true)
    }

    /// A stroke from so many counts on from where the last one began.
    fn begin_stroke(&mut self, distance: i32, is_forward: bool, sums: Sums) {
        self.begin = self.begin.wrapping_add(self.along(distance));
        self.is_forward = is_forward;
        self.brakes = false;
        self.furthest = 0;
        self.reached = sums.time;
        self.left = sums.time;
        self.sums = sums;
        self.settled = 0;
    }

    /// Inertia and friction by what the motor makes of a current.
    pub(super) fn loads(&self, torque_constant: f32) -> (f32, f32) {
        let (friction, inertia) = self.line.solve();
        (
            inertia * torque_constant,
            greater(friction, 0.0) * torque_constant,
        )
    }
}
