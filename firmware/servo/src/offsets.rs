//! What the converter says, in amperes; and what it says when there is no current, which is learnt before the gates are on.

use crate::motor::Implausible;
use crate::number::is_within;

/// How many samples make an offset.
const SAMPLES: u16 = 256;

/// The measurement of the currents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurrentSense {
    /// Amperes of a count; below 0 where a current into the motor makes less.
    scale: f32,
    /// How far an offset may be from the middle, in counts.
    spread: u16,
    middle: u16,
    /// What each phase has in it without a current, in A.
    offsets: [f32; 3],
    sums: [u32; 3],
    taken: u16,
}

/// Where the learning of the offsets is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Calibration {
    /// It wants more samples, with the gates off.
    Running,
    /// It is done.
    Done,
    /// A sensor is not near its middle: it is broken, or a current flows.
    Failed,
}

impl CurrentSense {
    /// With amperes of a count, the count in the middle, and how far from it an offset may be.
    ///
    /// # Errors
    /// With a scale of 0, beyond 10 A a count, or that is NaN.
    pub fn new(scale: f32, middle: u16, spread: u16) -> Result<Self, Implausible> {
        Implausible::unless(is_within(scale.abs(), 1e-6, 10.0))?;
        Ok(Self {
            scale,
            spread,
            middle,
            offsets: [f32::from(middle) * scale; 3],
            sums: [0; 3],
            taken: 0,
        })
    }

    /// Forgets what was learnt.
    pub fn restart(&mut self) {
        (self.sums, self.taken) = ([0; 3], 0);
    }

    /// Learns from a sample with the gates off.
    pub fn learn(&mut self, counts: [u16; 3]) -> Calibration {
        if self.taken < SAMPLES {
            for (sum, count) in self.sums.iter_mut().zip(counts) {
                *sum = sum.saturating_add(u32::from(count));
            }
            self.taken += 1;
        }
        if self.taken < SAMPLES {
            return Calibration::Running;
        }
        let mut is_near = true;
        for (offset, sum) in self.offsets.iter_mut().zip(self.sums) {
            let mean = sum as f32 * (1.0 / SAMPLES as f32);
            let away = (mean - f32::from(self.middle)).abs();
            is_near &= away <= f32::from(self.spread);
            *offset = mean * self.scale;
        }
        if is_near {
            Calibration::Done
        } else {
            Calibration::Failed
        }
    }

    /// The currents in A.
    #[inline]
    pub fn amperes(&self, counts: [u16; 3]) -> [f32; 3] {
        let [a, b, c] = counts.map(f32::from);
        let [x, y, z] = self.offsets;
        [a * self.scale - x, b * self.scale - y, c * self.scale - z]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_offset_is_the_mean_of_what_is_seen_without_a_current() {
        let mut sense = CurrentSense::new(-0.02, 2048, 100).unwrap();
        for sample in 0..SAMPLES {
            let noise = sample % 3;
            let state = sense.learn([2050 + noise, 2000 - noise, 2048]);
            let wanted = if sample + 1 < SAMPLES {
                Calibration::Running
            } else {
                Calibration::Done
            };
            assert_eq!(state, wanted);
        }
        let [a, b, c] = sense.amperes([2051, 1999, 2148]);
        assert!(a.abs() < 1e-3 && b.abs() < 1e-3);
        assert_eq!(c, -2.0);
    }

    #[test]
    fn a_sensor_that_is_off_its_middle_is_broken() {
        let mut sense = CurrentSense::new(0.02, 2048, 100).unwrap();
        let mut state = Calibration::Running;
        while state == Calibration::Running {
            state = sense.learn([2048, 2149, 2048]);
        }
        assert_eq!(state, Calibration::Failed);
        sense.restart();
        while sense.learn([2048; 3]) == Calibration::Running {}
        assert_eq!(sense.amperes([2048; 3]), [0.0; 3]);
        assert_eq!(CurrentSense::new(f32::NAN, 0, 0), Err(Implausible));
    }
}
