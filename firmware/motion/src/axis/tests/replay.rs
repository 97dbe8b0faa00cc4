//! The judge: plays records as a timer does, counts pulses and ticks, and checks every rule of the driver's inputs.

use crate::axis::Axis;
use crate::path::Path;
use crate::plan::phase::Phase;
use crate::{Direction, DriverTiming, Plan, Position, PulseSink, Record, State, Ticks};
use std::collections::VecDeque;
use std::vec::Vec;

/// What the axis follows from a tick on.
#[derive(Debug)]
pub(super) enum Curve {
    Plan(Plan),
    /// The mean of a plan: phases, and the tick from which the plan is followed.
    Mean(Vec<Phase>, Ticks, Plan),
    /// Set-points from the commit horizon on.
    Path(Path, Ticks),
}

impl Curve {
    /// What an axis follows from now on. A plan that is to be kept for long has few phases, and so has its mean.
    fn of(axis: &Axis) -> Self {
        if let Some(path) = &axis.path {
            return Self::Path(path.clone(), axis.horizon());
        }
        if !axis.is_averaged {
            return Self::Plan(axis.plan.clone());
        }
        let mut average = axis.average.clone();
        let mut phases: Vec<_> = [average.phase()].into();
        while average.until() < Ticks::MAX && !average.is_over(average.until()) {
            let until = average.until();
            average.polynomial_at(&axis.plan, until);
            phases.push(average.phase());
        }
        Self::Mean(phases, average.until(), axis.plan.clone())
    }

    fn start(&self) -> Ticks {
        match self {
            Self::Plan(plan) => plan.start(),
            Self::Mean(phases, ..) => phases[0].start(),
            Self::Path(_, start) => *start,
        }
    }

    pub(super) fn state_at(&self, t: Ticks) -> State {
        match self {
            Self::Plan(plan) => plan.state_at(t),
            Self::Path(path, _) => path.exact_at(t).rounded(),
            Self::Mean(_, end, plan) if t >= *end => plan.state_at(t),
            Self::Mean(phases, ..) => {
                let behind = phases.partition_point(|phase| phase.start() <= t);
                phases[behind - 1].at(t).rounded()
            }
        }
    }
}

#[derive(Debug)]
pub(super) struct Replay {
    timing: DriverTiming,
    time_slice: u64,
    pub(super) capacity: usize,
    ring: VecDeque<Record>,
    /// Ticks of the front record that are played.
    played: Ticks,
    /// Ticks and steps of all records taken.
    pub(super) ticks: Ticks,
    pub(super) position: i64,
    pub(super) pulses: u64,
    pub(super) records: u64,
    /// Of the signals, in ticks of the stream.
    last_pulse: Option<Ticks>,
    turned: Option<Ticks>,
    direction: Option<Direction>,
    /// What the axis followed; pulses are compared with it.
    pub(super) curves: Vec<Curve>,
    /// The steps allowed between pulses and plan, and the most there were.
    pub(super) tolerance: f64,
    pub(super) worst: f64,
    /// Compare the first pulses of every 64th record only: for moves of thousands of millions of pulses.
    pub(super) sparse: bool,
}

impl Replay {
    pub(super) fn new(timing: DriverTiming, time_slice: u64) -> Self {
        Self {
            timing,
            time_slice,
            capacity: 256,
            ring: VecDeque::new(),
            played: 0,
            ticks: 0,
            position: 0,
            pulses: 0,
            records: 0,
            last_pulse: None,
            turned: None,
            direction: None,
            curves: Vec::new(),
            tolerance: 1.0,
            worst: 0.0,
            sparse: false,
        }
    }

    /// Pulses are compared with what the axis follows from now on.
    pub(super) fn follow(&mut self, axis: &Axis) {
        self.curves.push(Curve::of(axis));
    }

    /// The sum of the pulses is the committed position, at any moment.
    pub(super) fn account(&self, axis: &Axis) {
        assert_eq!(self.position as i32, axis.committed_position() as i32);
        assert_eq!(self.ticks, axis.committed);
    }

    /// Time goes on. What is not there cannot be played.
    pub(super) fn play(&mut self, mut ticks: Ticks) {
        while let Some(front) = self.ring.front() {
            let left = front.ticks() - self.played;
            if left > ticks {
                self.played += ticks;
                return;
            }
            ticks -= left;
            self.played = 0;
            self.ring.pop_front();
        }
    }

    pub(super) fn play_out(&mut self) {
        self.play(Ticks::MAX);
    }

    /// The power is off: what is not played is gone, and the steps with it.
    pub(super) fn clear(&mut self) {
        self.ring.clear();
        self.played = 0;
        self.direction = None;
        self.last_pulse = None;
    }

    fn judge(&mut self, record: &Record) {
        let shortest = self.timing.pulse_high + self.timing.pulse_low;
        assert!(record.repeat > 0, "{record:?}");
        assert!(
            record.period >= shortest,
            "{record:?} is shorter than {shortest}"
        );
        // A run may begin with the last pulse before its chord, and one of a velocity that stays end with the first behind it.
        let period = u64::from(record.period);
        assert!(
            period <= self.time_slice && record.ticks() <= self.time_slice + 2 * period,
            "{record:?} is longer than a time slice"
        );
        let silent = record.width == 0;
        assert!(
            silent || u32::from(record.width) == self.timing.pulse_high,
            "{record:?}"
        );

        if self.direction != Some(record.direction) {
            assert!(silent, "{record:?} changes the direction with a pulse");
            if let Some(last) = self.last_pulse {
                let low = last + u64::from(self.timing.pulse_high);
                assert!(
                    self.ticks >= low + u64::from(self.timing.direction_hold),
                    "hold of {record:?}"
                );
            }
            self.direction = Some(record.direction);
            self.turned = Some(self.ticks);
        }
        if !silent {
            let setup = self.ticks - self.turned.unwrap();
            assert!(
                setup >= self.timing.direction_setup.into(),
                "setup of {record:?}"
            );
            let period = u64::from(record.period);
            let repeat = u64::from(record.repeat);
            let compared = if !self.sparse {
                repeat
            } else {
                u64::from(self.records.is_multiple_of(64))
            };
            for pulse in 0..compared {
                self.pulse(self.ticks + pulse * period, record.direction);
            }
            let others = repeat - compared;
            if others > 0 {
                self.position += others as i64 * i64::from(record.direction.sign());
                self.pulses += others;
                self.last_pulse = Some(self.ticks + (repeat - 1) * period);
            }
        }
        self.ticks += record.ticks();
        self.records += 1;
    }

    fn pulse(&mut self, at: Ticks, direction: Direction) {
        if let Some(last) = self.last_pulse {
            let shortest = self.timing.pulse_high + self.timing.pulse_low;
            assert!(
                at - last >= shortest.into(),
                "pulses {} ticks apart",
                at - last
            );
        }
        self.last_pulse = Some(at);
        let sign = i64::from(direction.sign());
        self.position += sign;
        self.pulses += 1;
        let Some(curve) = self.curves.iter().rev().find(|curve| curve.start() <= at) else {
            return;
        };
        let planned = curve.state_at(at).position;
        // Before and after the pulse, both within the tolerance.
        for steps in [self.position - sign, self.position] {
            let difference = Position::from_steps(steps)
                .bits()
                .wrapping_sub(planned.bits());
            let off = difference as f64 / 2f64.powi(32);
            self.worst = self.worst.max(off.abs());
            assert!(
                off.abs() <= self.tolerance,
                "pulse {} at {at}: {off} steps off",
                self.pulses
            );
        }
    }
}

impl PulseSink for Replay {
    fn push(&mut self, record: Record) -> Result<(), Record> {
        if self.free() == 0 {
            return Err(record);
        }
        self.judge(&record);
        self.ring.push_back(record);
        Ok(())
    }

    fn pending(&self) -> Ticks {
        self.ring.iter().map(Record::ticks).sum::<Ticks>() - self.played
    }

    fn free(&self) -> usize {
        self.capacity - self.ring.len()
    }
}
