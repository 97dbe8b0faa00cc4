//! A switch at the axis, and the wire that leads from it to an input of the drive.

use std::collections::VecDeque;
use std::ops::RangeInclusive;

use canopen::Duration;
use cia402::inputs::{Edge, Edges};

use super::chance::Chance;

/// A limit or home switch. Positions are in steps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Switch {
    /// Where it is active.
    pub range: RangeInclusive<i64>,
    /// So many steps beyond its edge it changes, in either direction.
    pub hysteresis: u32,
    /// So long its contact bounces after each change.
    pub bounce: Duration,
    /// Its wire is low while it is active.
    pub normally_closed: bool,
}

impl Switch {
    /// Active from this position on downwards: a negative limit switch.
    pub fn up_to(edge: i64) -> Self {
        Self::within(i64::MIN / 2..=edge)
    }

    /// Active from this position on upwards: a positive limit switch.
    pub fn from(edge: i64) -> Self {
        Self::within(edge..=i64::MAX / 2)
    }

    /// Active in this range: a home switch.
    pub fn within(range: RangeInclusive<i64>) -> Self {
        Self {
            range,
            hysteresis: 0,
            bounce: Duration::from_ticks(0),
            normally_closed: false,
        }
    }

    /// The same with a hysteresis of so many steps to both sides of each edge.
    #[must_use]
    pub fn with_hysteresis(self, hysteresis: u32) -> Self {
        Self { hysteresis, ..self }
    }

    /// The same with a contact that bounces for so long.
    #[must_use]
    pub fn bouncing(self, bounce: Duration) -> Self {
        Self { bounce, ..self }
    }

    /// The same with a wire that is low while the switch is active.
    #[must_use]
    pub fn normally_closed(self) -> Self {
        Self {
            normally_closed: true,
            ..self
        }
    }

    /// Whether it is active at a position, after it was (not) active.
    fn is_active(&self, position: i64, was_active: bool) -> bool {
        let beyond = i64::from(self.hysteresis);
        let margin = if was_active { -beyond } else { beyond };
        self.range.start() + margin <= position && position <= self.range.end() - margin
    }
}

/// What an input has seen since the drive looked last.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sensed {
    /// The wire is high.
    pub level: bool,
    /// The rising edges, at the count of pulses or of the encoder.
    pub rose: Option<Edges>,
    /// The falling edges.
    pub fell: Option<Edges>,
}

impl Sensed {
    /// The wire goes to this level, at this count and at this time in nanoseconds.
    pub(super) fn see(&mut self, level: bool, (count, time): (i64, u64)) {
        if level != self.level {
            self.level = level;
            let edges = if level {
                &mut self.rose
            } else {
                &mut self.fell
            };
            // The counters of a board have 32 bits.
            let edge = Edge {
                position: count as i32,
                time: time as u32,
            };
            match edges {
                Some(edges) => edges.add(edge),
                None => *edges = Some(Edges::one(edge)),
            }
        }
    }

    /// What was seen. The edges are forgotten.
    pub(super) fn take(&mut self) -> Self {
        let level = self.level;
        std::mem::replace(
            self,
            Self {
                level,
                ..Self::default()
            },
        )
    }
}

/// A switch at work.
#[derive(Clone, Debug)]
pub(super) struct Contact {
    switch: Switch,
    active: bool,
    /// When the wire will go to its other level, in nanoseconds: an even number of times, as it ends as it began.
    bounces: VecDeque<u64>,
    wire: Sensed,
}

impl Contact {
    /// A switch mounted while the axis is at `position`.
    pub(super) fn new(switch: Switch, position: i64) -> Self {
        let active = switch.is_active(position, false);
        let level = active != switch.normally_closed;
        Self {
            switch,
            active,
            bounces: VecDeque::new(),
            wire: Sensed {
                level,
                ..Sensed::default()
            },
        }
    }

    pub(super) const fn is_active(&self) -> bool {
        self.active
    }

    /// The axis has come to `position` by one step; `seen` is what the drive counts there and when that was in nanoseconds.
    pub(super) fn follow(&mut self, position: i64, seen: (i64, u64), chance: &mut Chance) {
        self.bounce(seen);
        let active = self.switch.is_active(position, self.active);
        if active == self.active {
            return;
        }
        self.active = active;
        self.wire.see(active != self.switch.normally_closed, seen);
        let (_, now) = seen;
        self.bounces = bounces(now, self.switch.bounce, chance);
    }

    /// What the drive sees when it counts so and at this time in nanoseconds.
    pub(super) fn look(&mut self, seen: (i64, u64)) -> Sensed {
        self.bounce(seen);
        self.wire.take()
    }

    /// The wire does what was due until then.
    fn bounce(&mut self, (count, now): (i64, u64)) {
        while let Some(at) = self.bounces.pop_front_if(|at| *at <= now) {
            let level = !self.wire.level;
            self.wire.see(level, (count, at));
        }
    }
}

/// When a contact that closes or opens at `now` changes its level in the time it bounces, in nanoseconds.
fn bounces(now: u64, time: Duration, chance: &mut Chance) -> VecDeque<u64> {
    let nanoseconds = time.ticks() * 1_000;
    if nanoseconds == 0 {
        return VecDeque::new();
    }
    let changes = 2 * (1 + chance.next() % MAX_BOUNCES);
    let mut times: Vec<u64> = (0..changes)
        .map(|_| now + 1 + chance.next() % nanoseconds)
        .collect();
    times.sort_unstable();
    times.into()
}

/// How often a contact opens again at most.
const MAX_BOUNCES: u64 = 6;
