//! The model of one axis of the rotor: what a voltage does to its current, and what of it is not known.

use core::hint::cold_path;

use super::{BITS_OF_RADIAN, CurrentConfig};
use crate::number::{greater, lesser};

/// The least and the greatest response of a winding, as a share of that of its data.
pub const STIFFEST: f32 = 0.6;
/// See [`STIFFEST`].
pub const SOFTEST: f32 = 1.7;

/// How much of a response that was other than foretold is taken over at once.
const TAKEN_OVER: f32 = 1.2;

/// From this share of the greatest current on a change tells of the response.
const TELLING: f32 = 0.02;

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Axis {
    pub(super) inductance: f32,
    /// ωe L in Ω, at the speed that turns by a part of 2³² of a turn in a period.
    pub(super) reactance: f32,
    /// What a volt beyond what keeps the current changes of it in half a period, in A: period / 2 L and the response.
    pub(super) changes: f32,
    /// The same with the least and with the greatest response.
    bounds: (f32, f32),
    /// The share of an error that is taken away in a period, half of it; and the volts for an A of it.
    half_share: f32,
    pub(super) corrects: f32,
    /// learning · L / period
    learning: f32,
    /// The voltage beyond what keeps the current, of both halves of a period, that tells of the response; and the change of the current by it, in A.
    telling: f32,
    told: f32,
    /// The current that the model has foretold for the next sample.
    pub(super) expected: f32,
    /// The voltage that the model does not know.
    pub(super) unknown: f32,
}

impl Axis {
    /// With the response of the data, and nothing unknown.
    pub(super) fn new(inductance: f32, config: &CurrentConfig) -> Self {
        let half = 0.5 * config.period / inductance;
        let mut axis = Self {
            inductance,
            reactance: inductance / (config.period * BITS_OF_RADIAN),
            changes: half,
            bounds: (STIFFEST * half, SOFTEST * half),
            half_share: 0.0,
            corrects: 0.0,
            learning: 0.0,
            telling: TELLING * config.max_current / half,
            told: TELLING * config.max_current,
            expected: 0.0,
            unknown: 0.0,
        };
        axis.set_share(config.share);
        axis.set_learning(config.learning, config.period);
        axis
    }

    /// With the response of the data and nothing unknown again; its gains stay.
    pub(super) fn restart(&mut self, config: &CurrentConfig) {
        let Self {
            half_share,
            learning,
            ..
        } = *self;
        *self = Self::new(self.inductance, config);
        self.set_share(2.0 * half_share);
        self.learning = learning;
    }

    pub(super) fn set_share(&mut self, share: f32) {
        self.half_share = 0.5 * share;
        self.corrects = self.half_share / self.changes;
    }

    pub(super) fn set_learning(&mut self, learning: f32, period: f32) {
        self.learning = learning * self.inductance / period;
    }

    /// Takes up what the model has not known of the last period, at whose beginning the current was the one `before`. That what is not known stays within the
    /// bus is left to who called.
    #[inline(always)]
    pub(super) fn learn(&mut self, current: f32, before: f32) {
        let away = current - self.expected;
        let foretold = self.expected - before;
        if foretold.abs() > self.told {
            cold_path();
            let (stiffest, softest) = self.bounds;
            let changes = self.changes + TAKEN_OVER * self.changes * (away / foretold);
            self.changes = lesser(greater(changes, stiffest), softest);
            self.corrects = self.half_share / self.changes;
            self.told = self.telling * self.changes;
        }
        self.unknown -= self.learning * away;
    }
}
