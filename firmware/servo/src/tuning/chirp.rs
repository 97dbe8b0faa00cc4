//! A sine whose frequency rises evenly, to be added to what is asked of the motor: for its frequency response.

use crate::Angle;
use crate::motor::Implausible;
use crate::number::{are_within, limit};
use crate::transform::direction;

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chirp {
    amplitude: f32,
    period: f32,
    phase: Angle,
    /// In Hz, and what it rises by in a period.
    frequency: f32,
    rise: f32,
    left: u32,
}

impl Chirp {
    /// With an amplitude, from one frequency to another in Hz, in a time in s, called with a period in s.
    ///
    /// # Errors
    /// With an amplitude of 0 or above 10⁴, frequencies outside 0.1 Hz to a tenth of the rate, a time outside 10 ms to 100 s, or a period outside 20 µs to 10 ms.
    pub fn new(
        amplitude: f32,
        (first, last): (f32, f32),
        time: f32,
        period: f32,
    ) -> Result<Self, Implausible> {
        let max = 0.1 / period;
        Implausible::unless(
            are_within(
                [period, amplitude, first, last, time],
                &[
                    (20e-6, 10e-3),
                    (1e-6, 1e4),
                    (0.1, 1e4),
                    (0.1, 1e4),
                    (0.01, 100.0),
                ],
            ) && first <= max
                && last <= max,
        )?;
        let periods = time / period;
        Ok(Self {
            amplitude,
            period,
            phase: Angle::ZERO,
            frequency: first,
            rise: (last - first) / periods,
            left: periods as u32,
        })
    }

    /// The next value; `None` once it is over.
    pub fn run(&mut self) -> Option<f32> {
        self.left = self.left.checked_sub(1)?;
        let (sine, _) = direction(self.phase);
        self.phase = self
            .phase
            .plus(Angle::from_turns(self.frequency * self.period));
        self.frequency += self.rise;
        Some(limit(self.amplitude * sine, self.amplitude))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn its_frequency_rises_evenly() {
        let mut chirp = Chirp::new(2.0, (10.0, 30.0), 1.0, 1e-4).unwrap();
        let mut crossings = std::vec::Vec::new();
        let mut last = -1.0;
        let mut count = 0;
        while let Some(value) = chirp.run() {
            assert!(value.abs() <= 2.0);
            if last < 0.0 && value >= 0.0 {
                crossings.push(f64::from(count) * 1e-4);
            }
            last = value;
            count += 1;
        }
        assert_eq!(count, 10_000);
        // f = 10 + 20 t: 10 t + 10 t² turns.
        for (turn, time) in crossings.iter().enumerate() {
            let turns = 10.0 * time + 10.0 * time * time;
            assert!((turns - turn as f64).abs() < 0.01, "{turn} at {time}");
        }
        assert_eq!(crossings.len(), 20);
    }

    #[test]
    fn bounds_of_its_data() {
        for (amplitude, first, last, time) in [
            (0.0, 10.0, 20.0, 1.0),
            (f32::NAN, 10.0, 20.0, 1.0),
            (1.0, 0.0, 20.0, 1.0),
            (1.0, 10.0, 2_000.0, 1.0),
            (1.0, 10.0, 20.0, f32::INFINITY),
        ] {
            assert!(Chirp::new(amplitude, (first, last), time, 250e-6).is_err());
        }
    }
}
