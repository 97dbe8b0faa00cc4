//! Plays pulse records in ticks of the step clock.

use std::collections::VecDeque;

use cia402::{Compare, RatedMotor, ServoOrder, ServoPort, ServoReport};
use motion::step_interrupt::CAPACITY;
use motion::{PulseSink, Record, Ticks};

/// Pulses in one direction at one speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pulses {
    /// The position before them.
    pub from: i64,
    /// How many; negative if they are reverse.
    pub steps: i64,
    /// When the first of them leaves, in ticks from the call of [`PulsePlayer::play`].
    pub at: Ticks,
    /// Ticks from one to the next.
    pub period: u32,
}

/// An order to a servo, and when it was given, in ticks of all calls of [`PulsePlayer::play`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ordered {
    /// The order.
    pub order: ServoOrder,
    /// When.
    pub at: Ticks,
}

/// A queue of pulse records, with as much room as a board's ([`CAPACITY`]), and the counter of the pulses that left.
#[derive(Clone, Debug, Default)]
pub struct PulsePlayer {
    queue: VecDeque<Record>,
    /// Periods of the first record that are over.
    periods: u16,
    /// Ticks of its present period that are over.
    ticks: u64,
    pending: Ticks,
    position: i64,
    /// Ticks of all calls of [`PulsePlayer::play`] before the present one, and with it.
    began: Ticks,
    ends: Ticks,
    /// What a servo is told, and what it has told.
    order: Option<Ordered>,
    report: ServoReport,
    motor: Option<RatedMotor>,
    /// When each pulse left, if that is kept.
    times: Option<Vec<Ticks>>,
    comparison: Comparison,
}

/// So long is an output high that rose at a position, in ticks: a control tick.
const HIGH: Ticks = 84_000;

/// An output that rises at positions.
#[derive(Clone, Debug, Default)]
struct Comparison {
    set_up: Option<Compare>,
    next: i32,
    /// How often it is still to rise; for ever without a number.
    left: Option<u16>,
    /// Position and time of each time that it rose.
    edges: Vec<(i32, Ticks)>,
}

impl Comparison {
    /// A pulse has come to a position at this time.
    fn pass(&mut self, position: i32, at: Ticks) {
        let Some(set_up) = &self.set_up else { return };
        if self.left == Some(0) || position != self.next {
            return;
        }
        self.edges.push((position, at));
        self.left = self.left.map(|left| left - 1);
        self.next = self.next.wrapping_add(set_up.spacing);
        if set_up.spacing == 0 {
            self.left = Some(0);
        }
    }
}

impl PulsePlayer {
    /// Plays for so many ticks; time in which there is nothing to play passes too. Tells of the pulses that leave, in order.
    pub fn play(&mut self, span: Ticks, mut tell: impl FnMut(Pulses)) {
        self.began = self.ends;
        self.ends += span;
        let mut ticks = span;
        self.pending = self.pending.saturating_sub(ticks);
        while let Some(record) = self.queue.front().copied() {
            let period = u64::from(record.period.max(1));
            // The rest of a period whose pulse has been counted.
            if self.ticks > 0 {
                let rest = period - self.ticks;
                if ticks < rest {
                    self.ticks += ticks;
                    return;
                }
                ticks -= rest;
                self.ticks = 0;
                self.periods += 1;
            }
            let whole = (ticks / period).min(u64::from(record.repeat - self.periods)) as u16;
            self.count(record, whole.into(), span - ticks, &mut tell);
            self.periods += whole;
            ticks -= u64::from(whole) * period;
            if self.periods < record.repeat {
                if ticks > 0 {
                    self.count(record, 1, span - ticks, &mut tell);
                    self.ticks = ticks;
                }
                return;
            }
            self.queue.pop_front();
            self.periods = 0;
        }
    }

    /// Drops every record that has not been played to its end.
    pub fn drop_all(&mut self) {
        self.queue.clear();
        self.periods = 0;
        self.ticks = 0;
        self.pending = 0;
    }

    /// An output is to rise at positions, from now on.
    pub fn compare(&mut self, set_up: Option<Compare>) {
        if set_up != self.comparison.set_up {
            self.comparison.next = set_up.map_or(0, |set_up| set_up.position);
            let count = set_up.map(|set_up| set_up.count);
            self.comparison.left = count.filter(|count| *count != 0);
            self.comparison.set_up = set_up;
        }
    }

    /// Positions at which an output rose, with the time in ticks since the power came.
    pub fn compared(&self) -> &[(i32, Ticks)] {
        &self.comparison.edges
    }

    /// The outputs that are high for that.
    pub(super) fn outputs(&self) -> u8 {
        let comparison = &self.comparison;
        match (&comparison.set_up, comparison.edges.last()) {
            (Some(set_up), Some((_, at))) if self.ends < at + HIGH => set_up.output,
            _ => 0,
        }
    }

    /// The ticks of all calls of [`PulsePlayer::play`].
    pub(super) fn played(&self) -> Ticks {
        self.ends
    }

    /// What a servo was told last.
    pub(super) fn ordered(&self) -> Option<Ordered> {
        self.order
    }

    /// What a servo is, and what it has to tell.
    pub(super) fn tell(&mut self, motor: RatedMotor, report: ServoReport) {
        self.motor = Some(motor);
        self.report = report;
    }

    /// Pulses that left, forward minus reverse.
    pub fn position(&self) -> i64 {
        self.position
    }

    /// Keeps from now on when each pulse leaves; forgets what was kept before.
    pub fn record(&mut self) {
        self.times = Some(Vec::new());
    }

    /// When each pulse left since [`PulsePlayer::record`], in ticks since the power came.
    pub fn recorded(&self) -> &[Ticks] {
        self.times.as_deref().unwrap_or_default()
    }

    /// Adds steps that no pulse made.
    pub fn displace(&mut self, steps: i64) {
        self.position += steps;
    }

    fn count(&mut self, record: Record, pulses: i64, at: Ticks, tell: &mut impl FnMut(Pulses)) {
        if record.width > 0 && pulses > 0 {
            let steps = pulses * i64::from(record.direction.sign());
            tell(Pulses {
                from: self.position,
                steps,
                at,
                period: record.period,
            });
            if self.comparison.set_up.is_some() {
                let first = self.began + at;
                for n in 0..pulses {
                    let position = self.position + (n + 1) * steps.signum();
                    let at = first + n as u64 * u64::from(record.period);
                    self.comparison.pass(position as i32, at);
                }
            }
            self.position += steps;
            if let Some(times) = &mut self.times {
                let first = self.began + at;
                times.extend((0..pulses as u64).map(|n| first + n * u64::from(record.period)));
            }
        }
    }
}

impl ServoPort for PulsePlayer {
    fn motor(&self) -> RatedMotor {
        self.motor.unwrap_or(RatedMotor::NONE)
    }

    fn order(&mut self, order: &ServoOrder) {
        self.order = Some(Ordered {
            order: *order,
            at: self.ends,
        });
    }

    fn report(&self) -> ServoReport {
        self.report
    }

    fn forget(&mut self) {
        self.drop_all();
    }
}

impl PulseSink for PulsePlayer {
    fn push(&mut self, record: Record) -> Result<(), Record> {
        if self.queue.len() >= CAPACITY {
            return Err(record);
        }
        self.pending += u64::from(record.period.max(1)) * u64::from(record.repeat);
        self.queue.push_back(record);
        Ok(())
    }

    fn pending(&self) -> Ticks {
        self.pending
    }

    fn free(&self) -> usize {
        CAPACITY - self.queue.len()
    }
}
