//! Pole pairs, direction and angle of the encoder: a current in d turns the rotor with the field, on and back.
//!
//! ```text
//! electrical turns   0 ─► −¼ ─► 0 ─► 1 ─► n ─► n + ¼ ─► n ─► 0
//!                              ↑    ↑    ↑             ↑    ↑
//! ```
//!
//! Dry friction holds the rotor behind the field, the same way at each look after a turn on; so the way between two of these is whole electrical turns. Back it holds
//! it the other way, and the mean of both is where the magnet is.

use super::winding::{STANDS, field};
use super::{Failure, Measured, Next, Seen, Setup, along};
use crate::current_loop::Sample;
use crate::number::{between, is_within, limit, root};
use crate::{Angle, CurrentLoop, Wiring};

/// What an electrical turn takes, and how long the shortest way takes, in s: for ten pole pairs and more. A motor of less swings more slowly in the field, and has more time.
const TURN: f32 = 0.1;
const SHORTEST: f32 = 0.06;

/// How long the rotor must stand while it is looked at, and how long that is waited for, in s.
const LOOK: f32 = 0.025;
const WAIT: f32 = 0.3;

/// How much more time one has that has one pole pair, or it is not known how many.
const SLOWEST: f32 = 3.2;

/// The field goes on for an electrical turn for each so many pole pairs: at most a tenth of a turn of the motor, but a whole electrical one.
const POLE_PAIRS_OF_TURN: f32 = 10.0;

/// The rotor is never so far from where it began, in turns of the motor.
const FURTHEST: f32 = 1.5;

/// Counts that an electrical turn has at least: with less of them the current is not where the magnet is.
const COUNTS: f32 = 20.0;

/// How far the way may be from whole pole pairs.
const WHOLE: f32 = 0.3;

/// The legs: 0 is where the field begins.
const LEGS: usize = 7;

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Turning {
    current: CurrentLoop,
    leg: usize,
    time: f32,
    /// By how much all takes longer.
    slow: f32,
    /// In electrical turns: where the field was when the leg began, and where it goes.
    from: f32,
    to: f32,
    turns: f32,
    begin: i32,
    /// Where the rotor was as the look began, and when that was.
    stood: i32,
    since: f32,
    sum: f32,
    count: f32,
    /// Where the rotor was at the end of each leg, in counts.
    looks: [f32; LEGS],
    zero: f32,
    is_reversed: bool,
}

impl Turning {
    pub(super) fn new(current: CurrentLoop, position: i32, wiring: Wiring) -> Self {
        Self {
            current,
            leg: 0,
            time: 0.0,
            slow: SLOWEST,
            from: field(wiring),
            to: -0.25,
            turns: 1.0,
            begin: position,
            stood: 0,
            since: 0.0,
            sum: 0.0,
            count: 0.0,
            looks: [0.0; LEGS],
            zero: 0.0,
            is_reversed: false,
        }
    }

    /// Where the magnet is at phase A, in counts from the first look on, the right way.
    pub(super) fn zero(&self) -> f32 {
        self.zero
    }

    /// The loop, as with no voltage acting.
    pub(super) fn current_loop(&self) -> CurrentLoop {
        let mut current = self.current;
        current.start();
        current
    }

    /// The encoder counts the other way.
    pub(super) fn is_reversed(&self) -> bool {
        self.is_reversed
    }

    pub(super) fn run(
        &mut self,
        setup: &Setup,
        seen: &Seen,
        position: i32,
        measured: &mut Measured,
    ) -> Result<Next, Failure> {
        let distance = self.to - self.from;
        let turn = distance.abs() * TURN;
        let span = self.slow * if turn > SHORTEST { turn } else { SHORTEST };
        self.time += setup.period;
        let part = limit(self.time / span, 1.0);
        // It begins and ends without a jerk in the acceleration, which would let the rotor swing.
        let eased = part * part * part * (10.0 + part * (6.0 * part - 15.0));
        let turned = self.from + distance * eased;
        let rise = part * (1.0 - part);
        let speed = 30.0 * rise * rise * distance / span * core::f32::consts::TAU;
        let moved = position.wrapping_sub(self.begin);
        // A field that a heavy rotor has lost may throw it on.
        if moved.unsigned_abs() as f32 > FURTHEST * setup.counts as f32 {
            return Err(Failure::TooFar);
        }
        if self.looks_at(moved, span) {
            let seen = self.sum / self.count;
            if self.end_leg(seen, setup, measured)? {
                self.place();
                return Ok(Next::Finished);
            }
        }
        let sample = Sample {
            currents: seen.currents,
            bus: seen.bus,
            angle: Angle::from_turns(turned),
            turn: self.current.turned_in_period(speed),
        };
        let widths = self.current.run(&sample, along(setup.current))?;
        Ok(Next::Widths(widths))
    }

    /// Adds up where the rotor is once it stands; one that swings on is looked at all the same. Returns whether that is enough.
    fn looks_at(&mut self, position: i32, span: f32) -> bool {
        let waits = self.time < span + WAIT;
        let away = position.wrapping_sub(self.stood).wrapping_abs();
        if self.time < span || (away > STANDS && waits) {
            self.stood = position;
            self.since = self.time;
            self.sum = 0.0;
            self.count = 0.0;
            return false;
        }
        self.sum += position as f32;
        self.count += 1.0;
        let look = if waits { LOOK } else { WAIT };
        self.time - self.since > look
    }

    /// Returns whether it was the last.
    fn end_leg(
        &mut self,
        look: f32,
        setup: &Setup,
        measured: &mut Measured,
    ) -> Result<bool, Failure> {
        if let Some(place) = self.looks.get_mut(self.leg) {
            *place = look;
        }
        let counts = setup.counts as f32;
        let [_, start, once, far, _, back, end] = self.looks;
        let next = match self.leg {
            0 => 0.0,
            1 => 1.0,
            2 => {
                let moved = (once - start).abs();
                // As many pole pairs as there can be, and not less than one.
                if !is_within(moved, counts / 700.0, 1.5 * counts) {
                    return Err(Failure::NotFollowed);
                }
                let pole_pairs = counts / moved;
                // Half a pole pair more, as the twenty of a motor may look like a little less.
                let turns = (pole_pairs + 0.5) / POLE_PAIRS_OF_TURN;
                self.turns = limit((turns as u16 + 1).into(), 64.0);
                self.slow = between(root(POLE_PAIRS_OF_TURN / pole_pairs), 1.0, SLOWEST);
                self.turns
            }
            3 => {
                self.is_reversed = far < start;
                self.turns + 0.25
            }
            4 => self.turns,
            5 => 0.0,
            _ => {
                // It has followed back as well.
                let share = (back - end) / (far - start);
                if !is_within(share, 0.8, 1.2) {
                    return Err(Failure::NotFollowed);
                }
                // On and back, as where it comes to rest is not the same each time.
                let pole_pairs = 2.0 * counts * self.turns / (far - start + back - end).abs();
                let whole = pole_pairs + 0.5;
                if !is_within(whole, 1.0, 501.0) {
                    return Err(Failure::PolePairs);
                }
                measured.pole_pairs = whole as u16;
                let whole = f32::from(measured.pole_pairs);
                if (pole_pairs - whole).abs() > WHOLE || counts < COUNTS * whole {
                    return Err(Failure::PolePairs);
                }
                return Ok(true);
            }
        };
        self.leg += 1;
        self.from = self.to;
        self.to = next;
        self.time = 0.0;
        self.sum = 0.0;
        self.count = 0.0;
        Ok(false)
    }

    fn place(&mut self) {
        let [_, start, _, far, _, back, end] = self.looks;
        let counts_of_turns = 0.5 * (far + back - start - end);
        // Both ends are known alike; the middle of the field's way is the middle of the rotor's.
        let middle = 0.25 * (start + far + back + end);
        let zero = middle - 0.5 * counts_of_turns + self.begin as f32;
        self.zero = if self.is_reversed { -zero } else { zero };
    }
}
