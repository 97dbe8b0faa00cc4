//! What a measurement has found, in words and pictures.

use std::path::Path;

use super::{Found, Point};
use crate::axis402::{Console, Problem};
use crate::chart::{self, BLUE, Chart, GREEN};

/// 20C1h:2 in words.
pub(super) fn reason(failure: u32, fault: u32) -> String {
    let what = match failure {
        1 => return format!("the power stage went off, error {fault:04X}h"),
        2 => "no current flows, or the winding is none",
        3 => "the encoder does not see that the rotor turns: is it held, is the encoder connected?",
        4 => "the way of the encoder is no whole number of pole pairs: is its resolution right?",
        5 => "the current does not move the rotor",
        6 => "the rotor has gone further than it may",
        7 => "somebody else has ended the measurement",
        8 => "the drive cannot do that now",
        other => return format!("the measurement failed with {other}"),
    };
    what.to_owned()
}

pub(super) fn tell(node: u8, found: &Found, console: &mut Console<'_>) -> Result<(), Problem> {
    let [velocity, integral, position] = found.gains;
    for line in [
        format!("resistance         {:.4} Ohm", found.resistance),
        format!(
            "inductance         {:.4} mH along the magnet, {:.4} mH across it",
            found.inductance_along * 1e3,
            found.inductance_across * 1e3
        ),
        format!("flux               {:.4} mVs", found.flux * 1e3),
        format!("pole pairs         {}", found.pole_pairs),
        format!(
            "encoder            direction {:+}, {:.1} degrees electrical at 0",
            found.direction, found.angle
        ),
        format!("inertia            {:.3} kg mm2", found.inertia * 1e6),
        format!("friction           {:.2} mNm", found.friction * 1e3),
        format!("gains              60F9h {velocity} and {integral} 1/s, 60FBh {position} 1/s"),
    ] {
        console.say(&line)?;
    }
    if !found.response.is_empty() {
        let decibels = found.response.iter().map(decibels).collect();
        let ends = (found.response.first(), found.response.last());
        let (Some(first), Some(last)) = ends else {
            return Ok(());
        };
        let caption = format!(
            "speed for a torque, in dB of rad/s per Nm, {:.1} to {:.0} Hz on a scale of factors",
            first.frequency, last.frequency
        );
        console.say(&chart::in_characters(decibels, Some(caption)))?;
    }
    console.remark(&match found.is_written {
        true => format!("node {node}: written; `axis402 save {node}` keeps it"),
        false => format!("node {node}: nothing is written; --write does"),
    });
    Ok(())
}

fn decibels(point: &Point) -> f64 {
    20.0 * point.amplitude.log10()
}

/// Amplitude and phase over the frequency.
pub(super) fn draw(response: &[Point], path: &Path) -> Result<(), Problem> {
    let curve = |value: fn(&Point) -> f64| {
        let points = response.iter();
        points
            .map(|point| (point.frequency as f32, value(point) as f32))
            .collect()
    };
    let charts = [
        Chart::new(
            "speed for a torque, in dB of rad/s per Nm",
            BLUE,
            curve(decibels),
        ),
        Chart::new("phase in degrees", GREEN, curve(|point| point.phase)),
    ];
    let ends = (response.first(), response.last());
    let (Some(first), Some(last)) = ends else {
        return Err(Problem::Usage(
            "there is no frequency response to draw".to_owned(),
        ));
    };
    let frequencies = (first.frequency as f32, last.frequency as f32);
    chart::over_frequency_as_svg(&charts, frequencies, path).map_err(Problem::Usage)
}

/// What was wanted and what was, over time.
pub(super) fn draw_step(step: &[(f64, i32, i32)], path: &Path) -> Result<(), Problem> {
    let wanted = step
        .iter()
        .map(|(time, demand, _)| (*time as f32, *demand as f32));
    let was = step
        .iter()
        .map(|(time, _, actual)| (*time as f32, *actual as f32));
    let end = step.last().map_or(1.0, |(time, _, _)| *time as f32);
    let charts = [
        Chart::new("position demand in increments", GREEN, wanted.collect()),
        Chart::new("position in increments", BLUE, was.collect()),
    ];
    chart::as_svg(&charts, end, path).map_err(Problem::Usage)
}
