//! Sensors that know where the magnet is: Hall sensors beside the encoder, or an absolute encoder in its place. Part of the current interrupt.

use servo::control::Fault;
use servo::feedback::{Absolute, Commutation, Hall, hall};
use servo::{Angle, Implausible, Motor};

use super::ServoSettings;
use super::current::{Current, Work};
use super::data::{Feedback, ServoData};

/// What the encoder and the sensors beside it mean, of the settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SensorSettings {
    hall: [u8; 6],
    is_searched: bool,
    pub(super) offset: Angle,
    is_turned: bool,
    encoder: u32,
}

impl SensorSettings {
    /// As the axis has them.
    pub(super) const NONE: Self = Self {
        hall: ServoSettings::NONE.hall,
        is_searched: false,
        offset: Angle::ZERO,
        is_turned: false,
        encoder: 0,
    };
}

impl From<&ServoSettings> for SensorSettings {
    fn from(settings: &ServoSettings) -> Self {
        Self {
            hall: settings.hall,
            is_searched: settings.is_searched,
            offset: Angle::from_bits(u32::from(settings.offset) << 16),
            is_turned: settings.is_turned,
            encoder: settings.encoder,
        }
    }
}

/// See the module.
#[derive(Clone, Debug)]
pub(super) enum Sensor {
    None,
    Hall(Hall),
    Absolute(Single),
}

/// An absolute encoder.
#[derive(Clone, Debug)]
pub(super) struct Single {
    absolute: Absolute,
    /// A word has come, and the position counts from the zero of the encoder.
    is_placed: bool,
    /// Whether the count has the angle of the word.
    is_aligned: bool,
}

impl Sensor {
    /// # Errors
    /// With what [`Absolute::new`] refuses.
    pub(super) fn new(data: &ServoData, motor: &Motor) -> Result<Self, Implausible> {
        Ok(match data.feedback {
            Feedback::Incremental => Self::None,
            Feedback::Hall => Self::Hall(Hall::default()),
            Feedback::Absolute {
                bits,
                table,
                offset,
            } => {
                // Twice the greatest speed, and what noise makes of two words.
                let fastest = 2.0 * data.speed as f32 / 60.0 * data.stage.period;
                let shift = 32_u32.saturating_sub(bits.into());
                let noise = Angle::from_bits(2_u32.checked_shl(shift).unwrap_or(0));
                let reach = Angle::from_turns(fastest.min(0.4)).plus(noise);
                let mut absolute = Absolute::new(motor, bits, reach)?.with_table(table);
                absolute.set_angle(offset);
                Self::Absolute(Single {
                    absolute,
                    is_placed: false,
                    is_aligned: false,
                })
            }
        })
    }

    /// The power comes or goes: the angle is that of the next word. What Hall sensors have told stays.
    pub(super) fn align(&mut self) {
        if let Self::Absolute(single) = self {
            single.is_aligned = false;
        }
    }

    /// What they tell means something else, or the encoder counts otherwise, so its angle is none any more.
    pub(super) fn restart(&mut self) {
        if let Self::Hall(hall) = self {
            *hall = Hall::default();
        }
        self.align();
    }

    /// It counts the other way: so does the position from its zero.
    pub(super) fn turn(&mut self) {
        if let Self::Absolute(single) = self {
            single.is_placed = false;
        }
        self.restart();
    }
}

impl Single {
    /// From the zero of the encoder within the turn of the first word on, where a turn has so many counts.
    fn counted(&self, counts: u32) -> i64 {
        self.absolute.position().wrapping_mul(counts.into()) >> 32
    }

    /// What the timer of an incremental encoder in its place would show. Whole turns wrap as that does.
    fn timer(&self, counts: u32) -> u16 {
        self.counted(counts) as u16
    }
}

/// A Hall word as the axis has it, of one in the order of the settings. What is not in it is none.
fn known(order: [u8; 6], word: u8) -> u8 {
    if order == ServoSettings::NONE.hall {
        return word;
    }
    let mut pairs = order.iter().zip(hall::ORDER);
    let found = pairs.find(|(own, _)| **own == word);
    found.map_or(0, |(_, known)| known)
}

impl Current {
    /// What the encoder and the sensors beside it mean, while there is no power; so many counts of the encoder are a turn.
    pub(super) fn set_sensors(&mut self, settings: SensorSettings, counts: u32) {
        let before = core::mem::replace(&mut self.settings, settings);
        let encoder = &mut self.interrupt.encoder;
        if settings.is_turned != before.is_turned {
            encoder.turn(settings.is_turned);
        }
        if settings.encoder != before.encoder {
            encoder.set_counts(counts);
        }
        if settings.offset != before.offset {
            let change = settings.offset.minus(before.offset);
            encoder.set_angle(encoder.angle().plus(change));
            self.stand_still();
        }
        let told = |settings: &SensorSettings| (settings.hall, settings.is_searched);
        let is_told_anew = told(&settings) != told(&before);
        if settings.is_turned != before.is_turned {
            self.sensor.turn();
        } else if is_told_anew || settings.encoder != before.encoder {
            self.sensor.restart();
        }
        if is_told_anew && !matches!(self.sensor, Sensor::None) {
            let search = Commutation::new(&self.motor, self.motor.rated_current, self.period).ok();
            self.search = search.filter(|_| settings.is_searched);
        }
    }

    /// Positions in a turn, once an absolute encoder has told where in it the rotor is: [`Current::position`] counts from its zero. 0 before, and with any
    /// other encoder, which counts from where it began.
    pub fn absolute_turn(&self) -> u32 {
        match &self.sensor {
            Sensor::Absolute(single) if single.is_placed => self.motor.counts,
            _ => 0,
        }
    }

    /// What the Hall sensors A, B and C say in bits 0 to 2, before each [`Current::period`] with [`Feedback::Hall`]. While there is power it is a fault that
    /// they all say the same, or another angle than the encoder.
    pub fn hall(&mut self, word: u8) {
        let Sensor::Hall(sensor) = &mut self.sensor else {
            return;
        };
        if self.settings.is_searched {
            return;
        }
        let word = known(self.settings.hall, word);
        let offset = self.settings.offset;
        let encoder = &mut self.interrupt.encoder;
        let before = encoder.angle();
        match sensor.look(word, before.minus(offset)) {
            Ok(None) => {}
            Ok(Some(angle)) => {
                let angle = angle.plus(offset);
                encoder.set_angle(angle);
                self.interrupt.observer.shift(angle.minus(before));
            }
            // What is measured may have other pole pairs, or turn the other way.
            Err(fault) if self.is_on && self.work != Work::Measurement => self.fail(fault.into()),
            Err(_) => {}
        }
    }

    /// The word of the absolute encoder, before each [`Current::period`] with [`Feedback::Absolute`]; `None` where the line is broken or its check fails.
    /// Returns what takes the place of the timer in [`Counts`](servo::interrupt::Counts); the position is the angle within the turn at the first word, and
    /// goes on from there. While there is power it is a fault that there is no word, or one further away than the rotor can have come.
    pub fn word(&mut self, word: Option<u32>) -> u16 {
        let Sensor::Absolute(single) = &mut self.sensor else {
            return 0;
        };
        let counts = self.motor.counts;
        let Some(word) = word else {
            let timer = single.timer(counts);
            if self.is_on {
                self.fail(Fault::Encoder);
            }
            return timer;
        };
        if let Err(fault) = single.absolute.look(word) {
            if self.is_on {
                let timer = single.timer(counts);
                self.fail(fault.into());
                return timer;
            }
            single.absolute.resume(word);
            single.is_aligned = false;
        }
        let timer = single.timer(counts);
        if !single.is_placed {
            single.is_placed = true;
            let counted = single.counted(counts);
            let counted = match self.settings.is_turned {
                true => counted.wrapping_neg(),
                false => counted,
            };
            self.interrupt.encoder.begin_at(timer, counted);
        }
        if !single.is_aligned && !self.settings.is_searched {
            single.is_aligned = true;
            single.absolute.set_pole_pairs(self.motor.pole_pairs);
            let told = single.absolute.angle();
            let angle = if self.settings.is_turned {
                Angle::ZERO.minus(told)
            } else {
                told
            };
            let encoder = &mut self.interrupt.encoder;
            encoder.look(timer);
            encoder.set_angle(angle.plus(self.settings.offset));
            self.stand_still();
        }
        timer
    }
}

#[cfg(test)]
mod tests;
