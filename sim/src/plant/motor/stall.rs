//! The sense of a driver for a motor that does not follow: it looks at the load angle, and so needs a field that turns.
//!
//! Once the load is too much, the rotor falls back and is caught again by each electrical turn of the field. So the sense tells of a
//! stall until a whole electrical turn has gone by without one.

use super::sine::within_turn;

/// From this load angle on it is a stall, in full steps; at 1 the torque is at its greatest.
const TOO_FAR: f64 = 0.9;
/// An electrical turn.
const TURN: f64 = 4.0;
/// After so many seconds without a pulse nothing is sensed.
const BLIND: f64 = 0.05;

/// The sense at work.
#[derive(Clone, Debug)]
pub(super) struct StallSense {
    /// How far the field has turned since the last stall.
    way: f64,
    /// For how long there was no pulse.
    rest: f64,
}

impl StallSense {
    pub(super) const fn new() -> Self {
        Self {
            way: TURN,
            rest: BLIND,
        }
    }

    /// The field went on by `way` and leads the rotor by `lead`, in full steps.
    pub(super) fn observe(&mut self, way: f64, lead: f64, seconds: f64) {
        if way == 0.0 {
            self.rest = (self.rest + seconds).min(BLIND);
        } else {
            self.rest = 0.0;
        }
        if within_turn(lead).abs() > TOO_FAR {
            self.way = 0.0;
        } else {
            self.way = (self.way + way.abs()).min(TURN);
        }
    }

    /// Whether there is a stall.
    pub(super) fn tells(&self) -> bool {
        self.way < TURN && self.rest < BLIND
    }
}
