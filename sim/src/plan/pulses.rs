//! The pulses of a plan: made by an axis as in the drive, played record by record, and compared with the plan.
//!
//! A pulse belongs where the plan crosses the middle between two whole steps. How far the plan is from there when the pulse comes is
//! its position error; how far away in time the crossing is, its time error.
//!
//! Within a run of even periods the position error is greatest at its ends or where the plan is as fast as the run, so these pulses stand for
//! all of a long run. The plan can be as fast as the run more than once: at its corners, and where its acceleration changes sign, a run is
//! looked at in parts.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use motion::{PulseSink, Record, Ticks};

use super::curve::Curve;
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
    let mut axis = planned.curve.axis.clone();
    let mut line = Line::default();
    let expected = planned.end.div_ceil(planned.axis.time_slice.into());
    let mut judge = Judge {
        planned,
        played: Played {
            position: planned.origin,
            ..Played::default()
        },
    };
    let mut now = 0;
    // One time slice for each call, as in the drive; a few more to play what is left.
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
        line.pending = line.pending.saturating_sub(planned.axis.time_slice.into());
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
        for pulse in run.worst(&self.planned.curve) {
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
        let plan = &self.planned.curve;
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
    fn worst(&self, plan: &Curve) -> Vec<u64> {
        if self.pulses <= SHORT_RUN {
            return (0..self.pulses).collect();
        }
        let speed = |pulse: u64| plan.state_at(self.tick(pulse)).velocity.bits();
        let is_faster =
            |pulse| u128::from(speed(pulse).unsigned_abs()) * u128::from(self.period) >= 1 << 56;
        let is_rising = |pulse: u64| speed(pulse + 1) >= speed(pulse);
        let mut worst = Vec::new();
        let mut part = |from: u64, to: u64| {
            worst.extend([from, to]);
            worst.extend(change(from, to, is_faster).into_iter().flatten());
        };
        for (from, to) in self.between_corners(plan) {
            // Between two corners the acceleration changes its sign once at most.
            match change(from, to, is_rising) {
                Some([before, behind]) => {
                    part(from, before);
                    part(before, behind);
                    part(behind, to);
                }
                None => part(from, to),
            }
        }
        worst
    }

    /// The first and the last pulse between two corners of the plan each; neighbours have a pulse in common.
    fn between_corners(&self, plan: &Curve) -> Vec<(u64, u64)> {
        let last = self.pulses - 1;
        let mut parts = Vec::new();
        let mut from = 0;
        let mut corner = plan.next_corner(self.start);
        while let Some(tick) = corner.filter(|tick| *tick < self.tick(last)) {
            // The corner lies between two pulses, or on one: they are a part of their own.
            let before = (tick - self.start) / self.period;
            parts.extend([(from, before), (before, before + 1)]);
            from = before + 1;
            corner = plan.next_corner(self.tick(from));
        }
        parts.push((from, last));
        parts
    }
}

/// The two neighbours between `from` and `to` where `what` changes, if it does: it changes once at most.
fn change(from: u64, to: u64, what: impl Fn(u64) -> bool) -> Option<[u64; 2]> {
    let first = what(from);
    if from == to || first == what(to) {
        return None;
    }
    let (mut before, mut behind) = (from, to);
    while behind - before > 1 {
        let half = before.midpoint(behind);
        if what(half) == first {
            before = half;
        } else {
            behind = half;
        }
    }
    Some([before, behind])
}

/// The tick nearest to `tick` at which the plan has come to `middle` in the direction of `sign`; within a few million ticks.
fn crossing(plan: &Curve, tick: Ticks, middle: i64, sign: i64) -> Ticks {
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

#[cfg(test)]
mod tests {
    use motion::{AxisConfig, Clock, DriverTiming, Goal, Limits, Plan, Ramps, State, Ticks};
    use proptest::prelude::*;

    use super::{Curve, Run};

    proptest! {
        /// All of them are looked at here, one by one.
        #[test]
        fn no_pulse_of_a_run_is_worse_than_those_that_stand_for_it(
            way in 200i64..20_000,
            velocity in 20_000u32..1_000_000,
            (acceleration, deceleration) in (1_000_000u32..100_000_000, 1_000_000u32..100_000_000),
            ramps in prop_oneof![Just(Ramps::Linear), Just(Ramps::SinSquared)],
            (corner, share, speed) in (0usize..6, 0.0f64..1.0, 0.7f64..1.05),
            pulses in 25u64..2_000,
        ) {
            let clock = Clock::new(168_000_000).unwrap();
            let limits = Limits { velocity: velocity.into(), acceleration, deceleration };
            let plan = Plan::new(clock, 0, State::default(), Goal::Rest(way), limits, ramps).unwrap();
            // Around a corner, at nearly its speed.
            let phases: Vec<_> = plan.phases().collect();
            let corner = phases[corner % phases.len()].start();
            let there = plan.state_at(corner).velocity.bits().max(1 << 40) as f64 / 2f64.powi(56);
            let period = (1.0 / there / speed) as Ticks;
            let start = corner.saturating_sub((pulses as f64 * period as f64 * share) as Ticks);
            let run = Run { start, period, pulses };
            let origin = plan.state_at(start).position.bits();
            // From a line through the first pulse, in steps.
            let off = |pulse: u64| {
                let way = plan.state_at(run.tick(pulse)).position.bits() - origin;
                way as f64 / 2f64.powi(32) - pulse as f64
            };
            let worst = |pulses: &[u64]| {
                let least = pulses.iter().map(|pulse| off(*pulse)).fold(f64::INFINITY, f64::min);
                let most = pulses.iter().map(|pulse| off(*pulse)).fold(f64::NEG_INFINITY, f64::max);
                (least, most)
            };
            let every: Vec<u64> = (0..pulses).collect();
            let timing = DriverTiming { pulse_high: 17, pulse_low: 17, direction_setup: 4, direction_hold: 4 };
            let curve = Curve::of(AxisConfig { clock, time_slice: 42_000, timing }, plan.clone());
            let (shown, all) = (worst(&run.worst(&curve)), worst(&every));
            // Pulses next to the extreme one are as good but for rounding.
            prop_assert!(shown.0 - all.0 < 1e-6 && all.1 - shown.1 < 1e-6, "{shown:?} for {all:?}");
        }
    }
}
