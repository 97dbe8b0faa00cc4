//! When a move ends, beside when it ends in theory.
//!
//! The theory is `firmware/motion/tests/motion-vectors.json`: moves with all there is to a move, computed to 40 digits.

use motion::{
    Axis, AxisConfig, Clock, Goal, Limits, Plan, Position, PulseSink, Ramps, Record, State, Ticks,
    Velocity,
};
use serde_json::Value;

use super::FAST;
use crate::timer_model::rig::{HZ, TIME_SLICE};

/// Moves that last longer are planned, and not played time slice by time slice.
const LONGEST: f64 = 20.0;

/// How far off the ends of the reference moves are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ends {
    /// The most ticks of 168 MHz between an end and the exact one.
    pub ticks: f64,
    /// So many moves.
    pub moves: u32,
}

/// The moves T01 to T22, with linear ramps.
///
/// # Panics
/// If a move cannot be planned, or its pulses end elsewhere than its plan.
pub fn linear() -> Ends {
    ends("trapezoid", |vector| {
        let limits = Limits {
            velocity: (whole(&vector["vmax"]) as u32).into(),
            acceleration: whole(&vector["a"]) as u32,
            deceleration: whole(&vector["d"]) as u32,
        };
        let v0 = whole(&vector["v0"]) as i32;
        (
            planned(vector, v0, limits, Ramps::Linear),
            real(&vector["T"]),
        )
    })
}

fn ends(kind: &str, plan: impl Fn(&Value) -> (Plan, f64)) -> Ends {
    let vectors = include_str!("../../../firmware/motion/tests/motion-vectors.json");
    let vectors: Value = serde_json::from_str(vectors).expect("the vectors are JSON");
    let mut ends = Ends::default();
    for vector in vectors[kind].as_array().expect("a list of moves") {
        let (plan, seconds) = plan(vector);
        let end = plan.end().expect("a move ends");
        if seconds <= LONGEST {
            assert_eq!(played(plan), end, "{}", vector["name"]);
        }
        let late = end as f64 - seconds * f64::from(HZ);
        ends.ticks = ends.ticks.max(late.abs());
        ends.moves += 1;
    }
    ends
}

fn clock() -> Clock {
    Clock::new(HZ).expect("a clock that motion can use")
}

fn planned(vector: &Value, v0: i32, limits: Limits, ramps: Ramps) -> Plan {
    let distance = whole(&vector["S"]);
    // Only the move over the full span needs the full span.
    let origin = if distance > i64::from(i32::MAX) {
        i64::from(i32::MIN)
    } else {
        0
    };
    let from = State {
        position: Position::from_steps(origin),
        velocity: Velocity::from_speed(clock(), v0.into()),
    };
    let goal = Goal::Rest(origin + distance);
    Plan::new(clock(), 0, from, goal, limits, ramps).expect("a move that can be")
}

/// The ticks of all records of a move.
fn played(plan: Plan) -> Ticks {
    let config = AxisConfig {
        clock: clock(),
        time_slice: TIME_SLICE,
        timing: FAST,
    };
    let mut axis = Axis::on_plan(config, plan);
    let mut sum = Sum::default();
    while !axis.is_at_rest() {
        // The sum is never full, and never runs empty.
        let _ = axis.advance(&mut sum);
        sum.pending = sum.pending.saturating_sub(TIME_SLICE.into());
    }
    sum.ticks
}

/// Adds up records.
#[derive(Default)]
struct Sum {
    ticks: Ticks,
    pending: Ticks,
}

impl PulseSink for Sum {
    fn push(&mut self, record: Record) -> Result<(), Record> {
        self.ticks += record.ticks();
        self.pending += record.ticks();
        Ok(())
    }

    fn pending(&self) -> Ticks {
        self.pending
    }

    fn free(&self) -> usize {
        usize::MAX
    }
}

fn whole(value: &Value) -> i64 {
    let text = value.as_str().map(|text| text.parse().ok());
    text.unwrap_or_else(|| value.as_i64())
        .expect("a whole number")
}

fn real(value: &Value) -> f64 {
    let text = value.as_str().and_then(|text| text.parse().ok());
    text.expect("a decimal")
}
