//! Position and velocity over time: in the terminal, and as a picture.

use std::io::{self, Write};
use std::path::Path;

use crate::drive::MotionSample;
use master::chart::{self, BLUE, Chart, RED};

/// Velocity is the distance of this many control ticks.
const WINDOW: usize = 10;

/// The two curves, from the first to the last movement and a little around it. Time in s, steps, steps/s.
struct Curves {
    position: Vec<(f32, f32)>,
    velocity: Vec<(f32, f32)>,
}

impl Curves {
    fn of(samples: &[MotionSample]) -> Self {
        let samples = around_movement(samples);
        let start = samples.first().map_or(0, |sample| sample.at.ticks());
        let seconds = |ticks: u64| (ticks - start) as f32 / 1e6;
        let position = samples
            .iter()
            .map(|sample| (seconds(sample.at.ticks()), sample.position as f32));
        let velocity = samples.windows(WINDOW + 1).map(|window| {
            let (first, last) = (window[0], window[WINDOW]);
            let middle = (first.at.ticks() + last.at.ticks()) / 2;
            let span = (last.at.ticks() - first.at.ticks()) as f32 / 1e6;
            (
                seconds(middle),
                (last.position - first.position) as f32 / span,
            )
        });
        Self {
            position: position.collect(),
            velocity: velocity.collect(),
        }
    }

    fn end(&self) -> f32 {
        self.position.last().map_or(1.0, |(time, _)| *time)
    }
}

/// The samples from 50 ms before the first movement to 50 ms after the last.
fn around_movement(samples: &[MotionSample]) -> &[MotionSample] {
    const MARGIN: usize = 50;
    let moving = |pair: &[MotionSample]| pair[0].position != pair[1].position;
    let (Some(first), Some(last)) = (
        samples.windows(2).position(moving),
        samples.windows(2).rposition(moving),
    ) else {
        return samples;
    };
    &samples[first.saturating_sub(MARGIN)..(last + MARGIN).min(samples.len())]
}

/// Draws both curves with characters.
pub fn in_terminal(samples: &[MotionSample], output: &mut dyn Write) -> io::Result<()> {
    let curves = Curves::of(samples);
    for (name, curve) in [
        ("Position in steps", &curves.position),
        ("Velocity in steps/s", &curves.velocity),
    ] {
        let values = curve.iter().map(|(_, value)| f64::from(*value)).collect();
        let caption = format!("{name}, {:.2} s from left to right", curves.end());
        writeln!(output, "{}\n", chart::in_characters(values, Some(caption)))?;
    }
    Ok(())
}

/// Writes both curves as SVG.
pub fn as_svg(samples: &[MotionSample], path: &Path) -> Result<(), String> {
    let curves = Curves::of(samples);
    let end = curves.end();
    let charts = [
        Chart::new("Position in steps", BLUE, curves.position),
        Chart::new("Velocity in steps/s", RED, curves.velocity),
    ];
    chart::as_svg(&charts, end, path)
}
