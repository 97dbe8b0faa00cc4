//! Position and velocity over time: in the terminal, and as a picture.

use std::io::{self, Write};
use std::path::Path;

use plotters::prelude::*;
use rasciigraph::Config;

use crate::drive::MotionSample;
use crate::system_error::plain;

/// Velocity is the distance of this many control ticks.
const WINDOW: usize = 10;

/// Size of a plot in the terminal, in characters.
const COLUMNS: u32 = 100;
const ROWS: u32 = 12;

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
        let size = Config::default().with_width(COLUMNS).with_height(ROWS);
        writeln!(
            output,
            "{}\n",
            rasciigraph::plot(values, size.with_caption(caption))
        )?;
    }
    Ok(())
}

/// Writes both curves as SVG.
pub fn as_svg(samples: &[MotionSample], path: &Path) -> Result<(), String> {
    let mut picture = String::new();
    draw(&Curves::of(samples), &mut picture).map_err(|error| error.to_string())?;
    std::fs::write(path, picture).map_err(plain)
}

fn draw(curves: &Curves, picture: &mut String) -> Result<(), Box<dyn std::error::Error>> {
    let area = SVGBackend::with_string(picture, (960, 600)).into_drawing_area();
    area.fill(&WHITE)?;
    let halves = area.split_evenly((2, 1));
    let both = [
        ("Position in steps", &curves.position, BLUE),
        ("Velocity in steps/s", &curves.velocity, RED),
    ];
    for (half, (name, curve, colour)) in halves.iter().zip(both) {
        let low = curve.iter().map(|(_, value)| *value).fold(0.0, f32::min);
        let high = curve.iter().map(|(_, value)| *value).fold(0.0, f32::max);
        let margin = (high - low).max(1.0) / 20.0;
        let mut chart = ChartBuilder::on(half)
            .margin(16)
            .caption(name, ("sans-serif", 18))
            .x_label_area_size(32)
            .y_label_area_size(72)
            .build_cartesian_2d(0.0..curves.end(), low - margin..high + margin)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .x_desc("time in s")
            .y_label_formatter(&|value| format!("{value:.0}"))
            .draw()?;
        chart.draw_series(LineSeries::new(
            curve.iter().copied(),
            colour.stroke_width(2),
        ))?;
    }
    area.present()?;
    Ok(())
}
