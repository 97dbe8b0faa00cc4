//! What a measurement has found, in words and pictures.

use std::path::Path;

use crate::axis402::{Console, Problem};
use crate::chart::{self, BLUE, Chart, GREEN};
use crate::tuning::{Found, Motor, Point};

pub(super) fn tell(node: u8, found: &Found, console: &mut Console<'_>) -> Result<(), Problem> {
    let lines = found.motor.iter().flat_map(lines);
    for line in lines {
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

fn lines(motor: &Motor) -> Vec<String> {
    let [velocity, integral, position] = motor.gains;
    vec![
        format!("resistance         {:.4} Ohm of a phase", motor.resistance),
        format!(
            "inductance         {:.4} mH along the magnet, {:.4} mH across it",
            motor.inductance_along * 1e3,
            motor.inductance_across * 1e3
        ),
        format!(
            "flux               {:.4} mVs of the magnet with a phase, peak",
            motor.flux * 1e3
        ),
        format!("pole pairs         {}", motor.pole_pairs),
        format!(
            "encoder            direction {:+}, {:.1} degrees electrical at 0",
            motor.direction, motor.angle
        ),
        format!(
            "inertia            {:.3} kg mm2 of all that turns",
            motor.inertia * 1e6
        ),
        format!("friction           {:.2} mNm, dry", motor.friction * 1e3),
        format!(
            "velocity gain      {velocity} 1/s (60F9h:1), its integral {integral} 1/s (60F9h:2)"
        ),
        format!("position gain      {position} 1/s (60FBh:1)"),
    ]
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
