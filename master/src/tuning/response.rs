//! The frequency response of a motor: what its speed makes of a torque, out of a recording of both.

use std::f64::consts::TAU;

/// One frequency of it.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Point {
    /// In Hz.
    pub frequency: f64,
    /// In rad/s for 1 N·m.
    pub amplitude: f64,
    /// In degrees, −180 to 180.
    pub phase: f64,
}

/// How many frequencies there are, and how many lines of the spectrum each is made of.
const POINTS: u32 = 40;
const LINES: u32 = 9;

/// What one of them reaches over, to both sides.
const REACH: f64 = 0.04;

/// The share of all samples in which they grow, and in which they go back.
const TAPER: f64 = 0.02;

/// The response from one frequency to another in Hz, of a torque in N·m and an angle in rad, both sampled at this period in s.
///
/// The cross spectrum over that of the torque: what is no answer to the torque averages out.
pub fn response(
    torque: &[f64],
    angle: &[f64],
    period: f64,
    (first, last): (f64, f64),
) -> Vec<Point> {
    // The speed, from the angle before to that behind: slow and wide motions would drown the others in an angle.
    let speed: Vec<f64> = (angle.windows(3))
        .map(|near| (near[2] - near[0]) / (2.0 * period))
        .collect();
    let torque = torque.get(1..=speed.len()).unwrap_or_default();
    let (torque, speed) = (windowed(torque), windowed(&speed));
    let points = (0..POINTS).map(|point| {
        let frequency = first * (last / first).powf(f64::from(point) / f64::from(POINTS - 1));
        let (mut cross, mut power) = ((0.0, 0.0), 0.0);
        for line in 0..LINES {
            let part = 2.0 * f64::from(line) / f64::from(LINES - 1) - 1.0;
            let near = frequency * (1.0 + REACH * part);
            let (u, v) = line_of(&torque, near * period);
            let (x, y) = line_of(&speed, near * period);
            // What the difference takes of a sine.
            let turned = TAU * near * period;
            let by = turned / turned.sin();
            let (x, y) = (x * by, y * by);
            cross = (cross.0 + x * u + y * v, cross.1 + y * u - x * v);
            power += u * u + v * v;
        }
        let (x, y) = (cross.0 / power, cross.1 / power);
        Point {
            frequency,
            amplitude: x.hypot(y),
            phase: y.atan2(x).to_degrees(),
        }
    });
    points.filter(|point| point.amplitude.is_finite()).collect()
}

/// Without its mean, and growing from nothing at its begin and back at its end (Tukey): what is told of the first frequencies comes first.
fn windowed(samples: &[f64]) -> Vec<f64> {
    let count = samples.len().max(2) as f64;
    let mean = samples.iter().sum::<f64>() / count;
    let window = |n: usize| {
        let from_end = (n as f64).min(count - 1.0 - n as f64) / (TAPER * count);
        0.5 - 0.5 * (TAU * 0.5 * from_end.min(1.0)).cos()
    };
    let samples = samples.iter().enumerate();
    samples
        .map(|(n, sample)| (sample - mean) * window(n))
        .collect()
}

/// A line of the spectrum, at a frequency in turns of a sample.
fn line_of(samples: &[f64], turns: f64) -> (f64, f64) {
    let (mut real, mut imaginary) = (0.0, 0.0);
    for (n, sample) in samples.iter().enumerate() {
        let (sine, cosine) = (-TAU * turns * n as f64).sin_cos();
        real += sample * cosine;
        imaginary += sample * sine;
    }
    (real, imaginary)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_inertia_with_friction_answers_as_one() {
        let (inertia, friction, period) = (2e-5, 4e-4, 1e-3);
        let (first, last, time) = (2.0, 100.0, 2.0);
        let (mut torque, mut angle) = (Vec::new(), Vec::new());
        let (mut speed, mut turned) = (0.0, 0.0);
        for sample in 0..2_000 {
            let now = f64::from(sample) * period;
            torque.push(0.1 * (TAU * (first + (last - first) * now / time / 2.0) * now).sin());
            angle.push(turned);
            for part in 0..100 {
                let at = now + f64::from(part) * period / 100.0;
                let push = 0.1 * (TAU * (first + (last - first) * at / time / 2.0) * at).sin();
                speed += (push - friction * speed) / inertia * period / 100.0;
                turned += speed * period / 100.0;
            }
        }
        let points = response(&torque, &angle, period, (10.0, 80.0));
        assert_eq!(points.len(), 40);
        for point in points {
            let reactance = TAU * point.frequency * inertia;
            let amplitude = 1.0 / friction.hypot(reactance);
            let phase = -(reactance / friction).atan().to_degrees();
            let away = point.amplitude / amplitude - 1.0;
            assert!(away.abs() < 0.1, "{point:?}: {amplitude}");
            assert!((point.phase - phase).abs() < 6.0, "{point:?}: {phase}");
        }
    }

    #[test]
    fn nothing_makes_nothing() {
        assert!(response(&[0.0; 50], &[0.0; 50], 1e-3, (1.0, 100.0)).is_empty());
        assert!(response(&[], &[], 1e-3, (1.0, 100.0)).is_empty());
    }
}
