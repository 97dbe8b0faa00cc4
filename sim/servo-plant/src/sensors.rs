//! What the loops see: encoder, Hall sensors, absolute angle, currents and the voltage of the bus.

use std::f64::consts::{FRAC_1_PI, TAU};

use crate::data::SensorData;
use crate::noise::Noise;

/// Turns of a rad.
const TURNS_OF_RADIAN: f64 = 0.5 * FRAC_1_PI;

/// What is wrong with the sensors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SensorFaults {
    /// The encoder counts no more, its index does not come, and the absolute angle stands still.
    pub encoder_is_cut: bool,
    /// So many counts of the encoder got lost.
    pub lost_counts: i64,
    /// The index comes so many counts late.
    pub slipped_index: i64,
    /// The Hall sensors whose wires are cut read 0: sensor `n` in bit `n`.
    pub cut_hall: u8,
    /// Those whose wires touch their supply read 1.
    pub high_hall: u8,
    /// The Hall sensors are those of another motor: high for the other half of a turn, and with B and C exchanged.
    pub other_hall: bool,
    /// The magnet of the absolute encoder has slipped by so much on the shaft, in rad.
    pub slipped_magnet: f64,
    /// The absolute encoder does not answer.
    pub line_is_broken: bool,
    /// The current sensor of this phase says this, in A, whatever flows.
    pub stuck_current: Option<(usize, f64)>,
}

impl SensorFaults {
    fn of_hall(&self, word: u8) -> u8 {
        let [a, b, c] = [0, 1, 2].map(|sensor| word >> sensor & 1);
        let word = if self.other_hall {
            0b111 ^ (a | c << 1 | b << 2)
        } else {
            word
        };
        word & !self.cut_hall | self.high_hall
    }
}

/// What the sensors say.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Readings {
    /// Of each phase, in A.
    pub currents: [f64; 3],
    /// Of the bus, in V.
    pub bus_voltage: f64,
    /// Of the incremental encoder, from where it was at angle 0.
    pub count: i64,
    /// The count at the index, if that was passed since the last measurement.
    pub index: Option<i64>,
    /// Hall sensors A, B and C in bits 0 to 2.
    pub hall: u8,
    /// The absolute angle within a turn, of as many bits as it has; `None` where the encoder does not answer.
    pub word: Option<u32>,
}

/// What sensors remember.
#[derive(Clone, Debug)]
pub(crate) struct Sensors {
    /// The currents of the last steps, the newest at `newest`.
    past: [[f64; 3]; SensorData::MAX_DELAY + 1],
    newest: usize,
    /// Turns of the index at the last step, and the count where it was passed.
    turns: f64,
    index: Option<i64>,
    last_angle: f64,
}

impl Sensors {
    /// Sensors of a rotor that is at this angle.
    pub(crate) fn new(data: &SensorData, angle: f64) -> Self {
        Self {
            past: [[0.0; 3]; SensorData::MAX_DELAY + 1],
            newest: 0,
            turns: turns_of_index(data, angle),
            index: None,
            last_angle: angle,
        }
    }

    /// A step has ended with these currents and this angle.
    pub(crate) fn look(&mut self, data: &SensorData, currents: [f64; 3], angle: f64) {
        self.newest = (self.newest + 1) % self.past.len();
        self.past[self.newest] = currents;
        let turns = turns_of_index(data, angle);
        if turns != self.turns {
            let at = turns.max(self.turns) * TAU + data.index;
            self.index = Some(count(data, at));
            self.turns = turns;
        }
    }

    pub(crate) fn measure(
        &mut self,
        data: &SensorData,
        pole_pairs: u16,
        angle: f64,
        faults: &SensorFaults,
        noise: &mut Noise,
    ) -> Readings {
        if !faults.encoder_is_cut {
            self.last_angle = angle;
        }
        let seen = self.last_angle;
        let delay = data.current_delay.min(SensorData::MAX_DELAY);
        let oldest = (self.newest + self.past.len() - delay) % self.past.len();
        let true_currents = self.past[oldest];
        let mut currents: [f64; 3] = std::array::from_fn(|phase| {
            let current = true_currents[phase]
                + data.current_offset[phase]
                + noise.normal(data.current_noise);
            let shown = if data.current_count > 0.0 {
                libm::round(current / data.current_count) * data.current_count
            } else {
                current
            };
            shown.clamp(-data.current_range, data.current_range)
        });
        if let Some((phase, current)) = faults.stuck_current {
            currents[phase] = current;
        }
        let index = self.index.take().filter(|_| !faults.encoder_is_cut);
        let jitter = noise.normal(data.count_noise) * TAU / f64::from(data.counts);
        Readings {
            currents,
            bus_voltage: 0.0,
            count: count(data, seen + jitter) - faults.lost_counts,
            index: index.map(|count| count - faults.lost_counts + faults.slipped_index),
            hall: faults.of_hall(hall(angle * f64::from(pole_pairs))),
            word: (!faults.line_is_broken)
                .then(|| word(data, seen + jitter + faults.slipped_magnet)),
        }
    }
}

fn turns_of_index(data: &SensorData, angle: f64) -> f64 {
    libm::floor((angle - data.index) * TURNS_OF_RADIAN)
}

fn count(data: &SensorData, angle: f64) -> i64 {
    libm::floor(angle / TAU * f64::from(data.counts)) as i64
}

/// The absolute angle, as a magnet off its centre shows it.
fn word(data: &SensorData, angle: f64) -> u32 {
    let true_angle = angle - data.zero;
    let shown = true_angle + data.eccentricity * libm::sin(true_angle);
    let turn = shown / TAU - libm::floor(shown / TAU);
    let words = 1u32 << data.bits.min(31);
    libm::floor(turn * f64::from(words)) as u32 % words
}

/// Three sensors a third of an electrical turn apart, each high for half a turn: A from −90° to 90°.
fn hall(electrical: f64) -> u8 {
    (0..3).fold(0, |bits, sensor| {
        let angle = electrical - f64::from(sensor) * TAU / 3.0;
        bits | u8::from(libm::cos(angle) > 0.0) << sensor
    })
}
