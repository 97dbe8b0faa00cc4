//! Curves over time: as a picture, one below the other, and with characters.

use std::path::Path;

use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::prelude::*;
pub use plotters::style::{BLUE, GREEN, MAGENTA, RED, RGBColor};
use rasciigraph::Config;

use crate::system_error::plain;

/// Width of a picture and height of each of its charts, in pixels.
const WIDTH: u32 = 960;
const HEIGHT: u32 = 300;

/// Size of a curve in the terminal, in characters.
const COLUMNS: u32 = 100;
const ROWS: u32 = 12;

/// One curve.
#[derive(Debug)]
pub struct Chart {
    name: String,
    colour: RGBColor,
    curve: Vec<(f32, f32)>,
}

impl Chart {
    /// `curve` is time in seconds, and the value.
    pub fn new(name: impl Into<String>, colour: RGBColor, curve: Vec<(f32, f32)>) -> Self {
        Self {
            name: name.into(),
            colour,
            curve,
        }
    }
}

/// One curve with characters, with a line of words below it.
pub fn in_characters(values: Vec<f64>, caption: Option<String>) -> String {
    let mut config = Config::default().with_width(COLUMNS).with_height(ROWS);
    if let Some(caption) = caption {
        config = config.with_caption(caption);
    }
    rasciigraph::plot(values, config)
}

/// Writes the charts as SVG, from second 0 to second `end`.
///
/// # Errors
/// Why the file cannot be written.
pub fn as_svg(charts: &[Chart], end: f32, path: &Path) -> Result<(), String> {
    write(charts, 0.0..end, "time in s", path)
}

/// Writes charts of a frequency in Hz, from one to another on a scale of factors, as SVG.
///
/// # Errors
/// Why the file cannot be written.
pub fn over_frequency_as_svg(
    charts: &[Chart],
    (first, last): (f32, f32),
    path: &Path,
) -> Result<(), String> {
    write(charts, (first..last).log_scale(), "frequency in Hz", path)
}

fn write<X>(charts: &[Chart], across: X, name: &str, path: &Path) -> Result<(), String>
where
    X: AsRangedCoord<Value = f32> + Clone,
    X::CoordDescType: ValueFormatter<f32>,
{
    let mut picture = String::new();
    draw(charts, across, name, &mut picture).map_err(|error| error.to_string())?;
    od_gen::files::write(path, picture.as_bytes()).map_err(plain)
}

fn draw<X>(
    charts: &[Chart],
    across: X,
    across_name: &str,
    picture: &mut String,
) -> Result<(), Box<dyn std::error::Error>>
where
    X: AsRangedCoord<Value = f32> + Clone,
    X::CoordDescType: ValueFormatter<f32>,
{
    let height = HEIGHT * charts.len() as u32;
    let area = SVGBackend::with_string(picture, (WIDTH, height)).into_drawing_area();
    area.fill(&WHITE)?;
    let parts = area.split_evenly((charts.len(), 1));
    for (
        part,
        Chart {
            name,
            colour,
            curve,
        },
    ) in parts.iter().zip(charts)
    {
        let low = curve.iter().map(|(_, value)| *value).fold(0.0, f32::min);
        let high = curve.iter().map(|(_, value)| *value).fold(0.0, f32::max);
        let margin = (high - low).max(1.0) / 20.0;
        let mut chart = ChartBuilder::on(part)
            .margin(16)
            .caption(name, ("sans-serif", 18))
            .x_label_area_size(32)
            .y_label_area_size(72)
            .build_cartesian_2d(across.clone(), low - margin..high + margin)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .x_desc(across_name)
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
