//! The pulses of a plan: made by an axis as in the drive, played record by record, and compared with the plan.
//!
//! A pulse belongs where the plan crosses the middle between two whole steps. How far the plan is from there when the pulse comes is
//! its position error; how far away in time the crossing is, its time error.
//!
//! Within a run of even periods the position error is greatest at its ends or where the plan is as fast as the run, so these pulses stand for
//! all of a long run.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use motion::{Axis, Plan, PulseSink, Record, Ticks};

use super::request::Move;

/// Runs of so many pulses are compared pulse by pulse.
const SHORT_RUN: u64 = 24;

/// Gets the tick of every pulse and the position after it, counted from the start.
type Note<'a> = &'a mut dyn FnMut(Ticks, i64) -> io::Result<()>;

/// What the pulses did.
#[derive(Debug, Default)]
pub(super) struct Played {
    /// How many there were.
    pub(super) pulses: u64,
    /// Where they led, in steps.
    pub(super) position: i64,
    /// The greatest position error in steps.
    pub(super) position_error: f64,
    /// The greatest time error in ticks.
    pub(super) time_error: f64,
}

/// The records as they come from the axis.
#[derive(Default)]
struct Line {
    waiting: Vec<Record>,
    pending: Ticks,
}

impl PulseSink for Line {
    fn push(&mut self, record: Record) -> Result<(), Record> {
        self.pending += record.ticks();
        self.waiting.push(record);
        Ok(())
    }

    fn pending(&self) -> Ticks {
        self.pending
    }

    fn free(&self) -> usize {
        usize::MAX
    }
}

/// Plays the move and writes every pulse of it to a file.
pub(super) fn write(planned: &Move, path: &Path) -> io::Result<Played> {
    let mut file = BufWriter::new(File::create(path)?);
    writeln!(file, "tick,position")?;
    let mut note = |tick, position| writeln!(file, "{tick},{position}");
    let played = play(planned, Some(&mut note))?;
    file.flush()?;
    Ok(played)
}

/// Plays the move up to its end.
pub(super) fn play(planned: &Move, mut note: Option<Note<'_>>) -> io::Result<Played> {
    let mut axis = Axis::on_plan(planned.axis, planned.plan);
    let mut line = Line::default();
    let expected = planned.end.div_ceil(planned.axis.segment.into());
    let mut judge = Judge {
        planned,
        played: Played {
            position: planned.origin,
            ..Played::default()
        },
    };
    let mut now = 0;
    // One segment for each call, as in the drive; a few more to play what is left.
    for _ in 0..expected.saturating_mul(64).saturating_add(64) {
        // The sink is never full, and never runs empty before the end.
        let _ = axis.advance(&mut line);
        for record in line.waiting.drain(..) {
            judge.record(now, record, &mut note)?;
            now += record.ticks();
        }
        if axis.is_at_rest() || now > planned.end {
            break;
        }
        line.pending = line.pending.saturating_sub(planned.axis.segment.into());
    }
    let mut played = judge.played;
    played.position -= planned.origin;
    Ok(played)
}

/// Compares pulses with the plan.
struct Judge<'a> {
    planned: &'a Move,
    played: Played,
}

impl Judge<'_> {
    fn record(
        &mut self,
        start: Ticks,
        record: Record,
        note: &mut Option<Note<'_>>,
    ) -> io::Result<()> {
        if record.width == 0 {
            return Ok(());
        }
        let sign = i64::from(record.direction.sign());
        let origin = self.played.position;
        // Behind a target that is passed with a velocity there is more to come.
        let period = u64::from(record.period);
        let in_time = (self.planned.end + period).saturating_sub(start) / period;
        let pulses = in_time.min(record.repeat.into());
        let run = Run {
            start,
            period,
            pulses,
        };
        for pulse in run.worst(&self.planned.plan) {
            self.compare(run.tick(pulse), origin + pulse as i64 * sign, sign);
        }
        if let Some(note) = note {
            for pulse in 0..pulses {
                let position = origin + (pulse + 1) as i64 * sign;
                note(run.tick(pulse), position - self.planned.origin)?;
            }
        }
        self.played.position += pulses as i64 * sign;
        self.played.pulses += pulses;
        Ok(())
    }

    /// The pulse at `tick` leaves `position` in the direction of `sign`.
    fn compare(&mut self, tick: Ticks, position: i64, sign: i64) {
        let plan = &self.planned.plan;
        let middle = (position << 32).wrapping_add(sign << 31);
        let state = plan.state_at(tick);
        let error = state.position.bits().wrapping_sub(middle).unsigned_abs();
        let steps = error as f64 / 2f64.powi(32);
        self.played.position_error = self.played.position_error.max(steps);
        // The search for the crossing is dear, and most pulses are much better than the worst.
        let speed = state.velocity.bits().unsigned_abs() as f64 / 2f64.powi(56);
        if steps > speed * self.played.time_error / 4.0 {
            let off = crossing(plan, tick, middle, sign).abs_diff(tick) as f64;
            self.played.time_error = self.played.time_error.max(off);
        }
    }
}

/// Pulses of one period.
struct Run {
    start: Ticks,
    period: Ticks,
    pulses: u64,
}

impl Run {
    const fn tick(&self, pulse: u64) -> Ticks {
        self.start + pulse * self.period
    }

    /// The pulses one of which is the furthest from the plan.
    fn worst(&self, plan: &Plan) -> Vec<u64> {
        if self.pulses <= SHORT_RUN {
            return (0..self.pulses).collect();
        }
        let is_faster = |pulse: u64| {
            let speed = plan.state_at(self.tick(pulse)).velocity.bits();
            u128::from(speed.unsigned_abs()) * u128::from(self.period) >= 1 << 56
        };
        let last = self.pulses - 1;
        let mut worst = vec![0, last];
        let first = is_faster(0);
        if first != is_faster(last) {
            let (mut before, mut behind) = (0, last);
            while behind - before > 1 {
                let half = before.midpoint(behind);
                if is_faster(half) == first {
                    before = half;
                } else {
                    behind = half;
                }
            }
            worst.extend([before, behind]);
        }
        worst
    }
}

/// The tick nearest to `tick` at which the plan has come to `middle` in the direction of `sign`; within a few million ticks.
fn crossing(plan: &Plan, tick: Ticks, middle: i64, sign: i64) -> Ticks {
    let is_behind = |t: Ticks| {
        let way = plan.state_at(t).position.bits().wrapping_sub(middle);
        way.wrapping_mul(sign) >= 0
    };
    // Widen until the crossing lies within, then halve.
    let late = is_behind(tick);
    let mut width = 1;
    while width < 1 << 32 {
        let edge = if late {
            tick.saturating_sub(width)
        } else {
            tick.saturating_add(width)
        };
        if is_behind(edge) != late || edge == 0 {
            break;
        }
        width *= 2;
    }
    let (mut before, mut behind) = if late {
        (tick.saturating_sub(width), tick)
    } else {
        (tick, tick.saturating_add(width))
    };
    while behind - before > 1 {
        let half = before + (behind - before) / 2;
        if is_behind(half) {
            behind = half;
        } else {
            before = half;
        }
    }
    behind
}
