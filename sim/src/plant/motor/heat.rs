//! How warm the motor gets: one body that loses heat in proportion to how much warmer than its surroundings it is.

use super::data::Heat;

/// The temperature at work, in °C.
#[derive(Clone, Debug)]
pub(super) struct Temperature {
    ambient: f64,
    /// By the rated current, in K.
    rise: f64,
    /// In seconds.
    time_constant: f64,
    now: f64,
}

impl Temperature {
    pub(super) fn new(heat: &Heat) -> Self {
        let ambient = heat.ambient.into();
        Self {
            ambient,
            rise: heat.rise.into(),
            time_constant: heat.time_constant.ticks() as f64 / 1e6,
            now: ambient,
        }
    }

    /// A time in seconds goes by with this part of the rated current.
    pub(super) fn step(&mut self, part: f64, seconds: f64) {
        let end = self.ambient + self.rise * part * part;
        self.now += (end - self.now) * (seconds / self.time_constant).min(1.0);
    }

    /// In tenths of a degree.
    pub(super) fn tenths(&self) -> i16 {
        (self.now * 10.0).round() as i16
    }
}
