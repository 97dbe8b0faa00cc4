//! What is told about a planned move: as text, as JSON, as a picture.

use std::fmt;
use std::path::Path;

use motion::{Ramps, State, Ticks};
use serde::Serialize;

use super::pulses::Played;
use super::request::Move;
use master::chart::{self, BLUE, Chart, GREEN, RED};

/// Points of a curve.
const POINTS: u64 = 1000;

/// The time slices of the drive, in seconds, but for a tick.
const DRIVE_SLICE: f64 = 250.5e-6;

/// A phase of so many ticks is there to join its neighbours.
const JOINT: Ticks = 2;

/// Accelerations that differ by less than this part of them are the same.
const ROUNDING: f64 = 1e-5;

/// A stretch of the move.
#[derive(Debug, Serialize)]
struct Phase {
    start_s: f64,
    duration_s: f64,
    /// At its start, in steps/s.
    velocity: f64,
    /// At its start, in steps/s².
    acceleration: f64,
    /// At its end, in steps/s.
    end_velocity: f64,
    /// At its end, in steps/s².
    end_acceleration: f64,
    /// The acceleration of the greatest amount, in steps/s².
    peak_acceleration: f64,
    kind: Kind,
    #[serde(skip)]
    ticks: Ticks,
}

/// What is the same all over a phase.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum Kind {
    /// The velocity.
    Cruise,
    /// The acceleration.
    Acceleration,
    /// The jerk.
    Jerk,
    /// Nothing: a sin² ramp, the acceleration of which is greatest in the middle.
    Sin2,
}

impl Phase {
    fn of(planned: &Move, start: Ticks, end: Ticks) -> Self {
        let rate = f64::from(planned.clock.hz());
        let [velocity, end_velocity] =
            [start, end].map(|tick| velocity(planned, planned.curve.state_at(tick)));
        let middle = start + (end - start) / 2;
        let pulls = [start, middle, end.saturating_sub(1).max(start)];
        let [first, half, last] = pulls.map(|tick| acceleration(planned, tick));
        let larger = |peak: f64, pull: f64| if pull.abs() > peak.abs() { pull } else { peak };
        let peak = [half, last].into_iter().fold(first, larger);
        // A mean comes to its cruise but for a rounding.
        let is_kept = (end_velocity - velocity).abs() <= velocity.abs() * 1e-9;
        let kind = match planned.ramps {
            _ if peak == 0.0 && is_kept => Kind::Cruise,
            Ramps::Linear if peak == 0.0 => Kind::Cruise,
            Ramps::Linear => Kind::Acceleration,
            Ramps::SinSquared => Kind::Sin2,
            // An acceleration below half a step/s² is shown as none, and it may be one that grows.
            _ if peak != 0.0 && (last - first).abs() <= peak.abs() * ROUNDING => Kind::Acceleration,
            // Of a moving average or of limited jerk.
            _ => Kind::Jerk,
        };
        Self {
            start_s: start as f64 / rate,
            duration_s: (end - start) as f64 / rate,
            velocity,
            acceleration: first,
            end_velocity,
            end_acceleration: last,
            peak_acceleration: peak,
            kind,
            ticks: end - start,
        }
    }
}

impl Phase {
    /// Whether the next phase is more of the same: a sin² ramp is made of cubic pieces.
    fn goes_on_in(&self, next: &Self) -> bool {
        let is_ramp =
            self.kind == Kind::Sin2 && self.peak_acceleration * next.peak_acceleration > 0.0;
        self.kind == next.kind && (is_ramp || self.kind == Kind::Cruise)
    }

    fn append(&mut self, next: Self) {
        self.duration_s += next.duration_s;
        self.ticks += next.ticks;
        self.end_velocity = next.end_velocity;
        self.end_acceleration = next.end_acceleration;
        if next.peak_acceleration.abs() > self.peak_acceleration.abs() {
            self.peak_acceleration = next.peak_acceleration;
        }
    }
}

impl fmt::Display for Phase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "from {:>14.9} s for {:>14.9} s: {:>17.9} to {:>17.9} steps/s, ",
            self.start_s, self.duration_s, self.velocity, self.end_velocity
        )?;
        match self.kind {
            Kind::Cruise => write!(f, "cruise"),
            Kind::Acceleration => write!(f, "{:.1} steps/s²", self.acceleration),
            Kind::Jerk => write!(
                f,
                "{:.1} to {:.1} steps/s²",
                self.acceleration, self.end_acceleration
            ),
            Kind::Sin2 => write!(f, "sin², {:.1} steps/s² at most", self.peak_acceleration),
        }
    }
}

/// Everything that is told.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    duration_s: f64,
    duration_ticks: Ticks,
    /// The greatest speed, in steps/s.
    peak_velocity: f64,
    pulses: u64,
    /// In steps from the start.
    final_position: i64,
    max_position_error_steps: f64,
    max_step_time_error_s: f64,
    /// The time slices of which the pulses were made.
    segment_s: f64,
    phases: Vec<Phase>,
}

impl Report {
    pub(super) fn of(planned: &Move, played: &Played) -> Self {
        let rate = f64::from(planned.clock.hz());
        let seconds = |ticks: Ticks| ticks as f64 / rate;
        let starts: Vec<Ticks> = (planned.curve.corners().into_iter())
            .filter(|start| *start < planned.end)
            .collect();
        let ends = starts.iter().skip(1).copied().chain([planned.end]);
        let mut phases: Vec<Phase> = Vec::new();
        for (&start, end) in starts.iter().zip(ends) {
            let phase = Phase::of(planned, start, end);
            match phases.last_mut() {
                Some(last) if last.goes_on_in(&phase) => last.append(phase),
                _ => phases.push(phase),
            }
        }
        // Between two corners the speed has no peak, but corners fall between two ticks.
        let corners = (planned.curve.corners().into_iter())
            .filter(|start| *start < planned.end)
            .flat_map(|start| [start.saturating_sub(1), start]);
        let peak_velocity = corners
            .chain([planned.end])
            .map(|tick| velocity(planned, planned.curve.state_at(tick)).abs())
            .fold(0.0, f64::max);
        Self {
            duration_s: seconds(planned.end),
            duration_ticks: planned.end,
            peak_velocity,
            pulses: played.pulses,
            final_position: played.position,
            max_position_error_steps: played.position_error,
            max_step_time_error_s: played.time_error / rate,
            segment_s: seconds(planned.axis.time_slice.into()),
            phases,
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "duration        {:.9} s, {} ticks",
            self.duration_s, self.duration_ticks
        )?;
        writeln!(f, "peak velocity   {:.9} steps/s", self.peak_velocity)?;
        writeln!(
            f,
            "pulses          {}, to step {}",
            self.pulses, self.final_position
        )?;
        writeln!(
            f,
            "greatest error  {:.4} steps, {:.3} µs",
            self.max_position_error_steps,
            self.max_step_time_error_s * 1e6
        )?;
        if self.segment_s > DRIVE_SLICE {
            writeln!(
                f,
                "                made in time slices of {:.6} s, longer than the drive's of 250 µs",
                self.segment_s
            )?;
        }
        // What only joins its neighbours is nothing to look at.
        for phase in self.phases.iter().filter(|phase| phase.ticks > JOINT) {
            writeln!(f, "{phase}")?;
        }
        Ok(())
    }
}

/// In steps/s.
fn velocity(planned: &Move, state: State) -> f64 {
    state.velocity.bits() as f64 / 2f64.powi(56) * f64::from(planned.clock.hz())
}

/// In steps/s², at a tick.
fn acceleration(planned: &Move, tick: Ticks) -> f64 {
    planned.curve.acceleration_at(planned.clock, tick)
}

/// Writes position, velocity and acceleration over time as SVG.
pub(super) fn plot(planned: &Move, path: &Path) -> Result<(), String> {
    let rate = f64::from(planned.clock.hz());
    // The corners themselves, and the tick before each, keep edges sharp.
    let mut ticks: Vec<Ticks> = (0..=POINTS)
        .map(|point| (u128::from(planned.end) * u128::from(point) / u128::from(POINTS)) as Ticks)
        .collect();
    for start in planned.curve.corners() {
        ticks.extend([start.saturating_sub(1), start]);
    }
    ticks.retain(|tick| *tick <= planned.end);
    ticks.sort_unstable();
    ticks.dedup();
    let curve = |value: &dyn Fn(Ticks) -> f64| {
        let points = ticks.iter().map(|&tick| (tick as f64 / rate, value(tick)));
        points
            .map(|(time, value)| (time as f32, value as f32))
            .collect()
    };
    let position = |tick| {
        let bits = planned.curve.state_at(tick).position.bits();
        bits as f64 / 2f64.powi(32) - planned.origin as f64
    };
    let last = planned.end.saturating_sub(1);
    let charts = [
        Chart::new("Position in steps", BLUE, curve(&position)),
        Chart::new(
            "Velocity in steps/s",
            RED,
            curve(&|tick| velocity(planned, planned.curve.state_at(tick))),
        ),
        Chart::new(
            "Acceleration in steps/s²",
            GREEN,
            curve(&|tick| acceleration(planned, tick.min(last))),
        ),
    ];
    let end = (planned.end as f64 / rate).max(1e-6) as f32;
    chart::as_svg(&charts, end, path)
}
