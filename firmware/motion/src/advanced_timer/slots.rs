//! From records to slots: what a timer of 16 bits with a repetition counter of 8 bits can do at a time.

use super::ring::{Slot, fill};
use crate::low;
use crate::record::SHORTEST_RECORD;
use crate::{Direction, Record};

/// Longest period of a timer of 16 bits, in ticks. One less than it could be, so that a compare value above the reload value
/// exists: that keeps the direction high.
pub(super) const LONGEST_PERIOD: u32 = 0xFFFF;

/// Most periods of a run: the repetition counter has 8 bits.
pub(super) const MAX_PERIODS: u32 = 256;

/// Longest run of a record, in ticks. A slot can be written until the run before it begins, so short runs leave a late processor
/// more time. (What is silent behind the last record takes longer.)
pub(super) const LONGEST_RUN: u32 = 1 << 14;

/// Pulses from this width on do not fit into half of the longest run.
const WIDEST: u16 = low::u16(LONGEST_RUN / 2);

/// What a DMA burst writes into ARR, RCR, CCR1 and CCR2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Words(pub(super) [u32; 4]);

impl Words {
    /// `repeat` (1 ..= 256) periods of `period` (1 ..= 65535) ticks; the registers hold one less.
    #[inline]
    pub(super) const fn run(period: u32, repeat: u32, width: u32, direction: u32) -> Self {
        Self([
            period.wrapping_sub(1),
            repeat.wrapping_sub(1),
            width,
            direction,
        ])
    }

    /// As long as a run can be, without a pulse.
    pub(super) const fn silent(direction: u32) -> Self {
        Self::run(LONGEST_PERIOD, MAX_PERIODS, 0, direction)
    }

    /// The level of the direction signal.
    pub(super) const fn level(self) -> u32 {
        let [.., level] = self.0;
        level
    }

    /// How long the run takes.
    pub(super) const fn ticks(self) -> u32 {
        let [reload, repetitions, ..] = self.0;
        reload
            .wrapping_add(1)
            .wrapping_mul(repetitions.wrapping_add(1))
    }
}

/// The level of the direction signal as a compare value of channel 2.
pub(super) const fn level(direction: Direction) -> u32 {
    match direction {
        Direction::Forward => LONGEST_PERIOD,
        Direction::Reverse => 0,
    }
}

/// A record in equal runs: a short one at the end might be over before the burst behind it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Runs {
    /// The periods of each, and how many have one more.
    repeat: u32,
    more: u32,
}

impl Runs {
    /// Of so many periods; `None` if one is longer than a run may be.
    #[inline]
    pub(super) fn of(period: u32, periods: u32) -> Option<Self> {
        let count = number_of_runs(period, periods)?;
        let repeat = periods.checked_div(count).unwrap_or(0);
        let more = periods.wrapping_sub(repeat.wrapping_mul(count));
        Some(Self { repeat, more })
    }

    /// The periods of the next run.
    #[inline]
    pub(super) fn next(&mut self) -> u32 {
        if self.more == 0 {
            return self.repeat;
        }
        self.more = self.more.wrapping_sub(1);
        self.repeat.wrapping_add(1)
    }
}

/// How many runs so many periods take, if none is longer than a run may be; `None` if a single period is longer.
#[inline]
fn number_of_runs(period: u32, periods: u32) -> Option<u32> {
    let max = LONGEST_RUN.checked_div(period)?.min(MAX_PERIODS);
    periods.checked_add(max)?.wrapping_sub(1).checked_div(max)
}

/// Where slots are written, one behind the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place<'a> {
    /// Those that may still be written.
    pub(super) free: &'a [Slot],
    /// The level of the direction signal in all of them.
    level: u32,
    /// Ticks of the last one written.
    pub(super) last: u32,
}

impl<'a> Place<'a> {
    pub(super) const fn new(free: &'a [Slot], level: u32) -> Self {
        Self {
            free,
            level,
            last: 0,
        }
    }

    /// Writes a record, in equal runs, and gives its ticks, modulo 2³²; `None` if there was no room for all of it.
    #[inline]
    pub(super) fn put(&mut self, record: &Record) -> Option<u32> {
        let (period, repeat) = (record.period, u32::from(record.repeat));
        // The product fits where a period has 15 bits: there are 16 bits of them.
        let ticks = period.wrapping_mul(repeat);
        if period > LONGEST_RUN {
            // Pulses below 10 kHz, and silence.
            if repeat != 1 || period > 3 * LONGEST_RUN || record.width >= WIDEST {
                self.pass(put_long(self.free, record, self.level)?)?;
            } else if period > 2 * LONGEST_RUN {
                self.put_parts::<3>(record)?;
            } else {
                self.put_parts::<2>(record)?;
            }
        } else {
            let runs = number_of_runs(period, repeat)?;
            match runs {
                1 => self.put_runs::<1>(record)?,
                2 => self.put_runs::<2>(record)?,
                3 => self.put_runs::<3>(record)?,
                _ => self.pass(put_many(self.free, record, (runs, self.level))?)?,
            }
        }
        Some(ticks)
    }

    /// So many have been written, and the last takes so many ticks.
    #[inline]
    fn pass(&mut self, (written, last): (usize, u32)) -> Option<()> {
        self.free = self.free.get(written..)?;
        self.last = last;
        Some(())
    }

    /// One period in so many parts of equal length: none is short, and the pulse has room in the first.
    #[inline]
    fn put_parts<const PARTS: usize>(&mut self, record: &Record) -> Option<()> {
        let (slots, free) = self.free.split_first_chunk::<PARTS>()?;
        self.free = free;
        let (mut left, mut width) = (record.period, record.width.into());
        for (slot, parts) in slots.iter().zip((1..=low::word(PARTS)).rev()) {
            let part = left / parts;
            left = left.wrapping_sub(part);
            fill(slot, Words::run(part, 1, width, self.level));
            width = 0;
            self.last = part;
        }
        Some(())
    }

    /// In one run, two or three, each with a period at least, as none is longer than a run. Each is written out: loops around them are longer.
    #[inline]
    fn put_runs<const RUNS: usize>(&mut self, record: &Record) -> Option<()> {
        let (slots, free) = self.free.split_first_chunk::<RUNS>()?;
        self.free = free;
        let repeat = u32::from(record.repeat);
        match slots.as_slice() {
            [slot] => self.put_run(slot, record, repeat),
            [first, last] => {
                let half = repeat / 2;
                self.put_run(first, record, half);
                self.put_run(last, record, repeat - half);
            }
            [first, second, last] => {
                let third = repeat / 3;
                let half = (repeat - third) / 2;
                self.put_run(first, record, third);
                self.put_run(second, record, half);
                self.put_run(last, record, repeat - third - half);
            }
            _ => return None,
        }
        Some(())
    }

    #[inline(always)]
    fn put_run(&mut self, slot: &Slot, record: &Record, periods: u32) {
        let width = u32::from(record.width);
        fill(slot, Words::run(record.period, periods, width, self.level));
        self.last = record.period.wrapping_mul(periods);
    }
}

/// In more of them. Gives how many were written, and the ticks of the last one.
#[inline(never)]
fn put_many(slots: &[Slot], record: &Record, (runs, level): (u32, u32)) -> Option<(usize, u32)> {
    let (period, repeat) = (record.period, u32::from(record.repeat));
    let slots = slots.get(..runs as usize)?;
    let (mut left, mut share) = (repeat, 0);
    for (slot, runs) in slots.iter().zip((1..=runs).rev()) {
        share = left.checked_div(runs).unwrap_or(0);
        left = left.wrapping_sub(share);
        fill(slot, Words::run(period, share, record.width.into(), level));
    }
    Some((slots.len(), period.wrapping_mul(share)))
}

/// The same for periods that take several slots each.
#[inline(never)]
fn put_long(slots: &[Slot], record: &Record, level: u32) -> Option<(usize, u32)> {
    let (period, repeat) = (record.period, u32::from(record.repeat));
    let width = u32::from(record.width);
    // Silence is one period.
    let (period, repeat) = if width == 0 {
        (period.saturating_mul(repeat), 1)
    } else {
        (period, repeat)
    };
    let parts = period.div_ceil(LONGEST_RUN);
    if record.width >= WIDEST {
        return None;
    }
    let slots = slots.get(..parts.saturating_mul(repeat) as usize)?;
    if parts == 0 {
        // No time takes no slots.
        return Some((0, 0));
    }
    // Parts of equal length: none is short, and the pulse has room in the first.
    let part = period.checked_div(parts).unwrap_or(0);
    let rest = part.wrapping_add(period.wrapping_sub(part.wrapping_mul(parts)));
    for slots in slots.chunks_exact(parts as usize) {
        let mut width = width;
        if let Some((slot, slots)) = slots.split_last() {
            for slot in slots {
                fill(slot, Words::run(part, 1, width, level));
                width = 0;
            }
            fill(slot, Words::run(rest, 1, width, level));
        }
    }
    Some((slots.len(), rest))
}

/// What is left of a record on its way into slots. Ticks and pulses of its runs are those of the record, exactly.
#[derive(Clone, Copy, Debug)]
pub(super) struct Remainder {
    period: u32,
    width: u32,
    direction: u32,
    /// Periods that have not begun.
    periods: u32,
    /// How they are shared out; `None` where a period is longer than a run.
    runs: Option<Runs>,
    /// Silence up to the end of the period under way.
    silence: u32,
}

impl Remainder {
    /// Nothing.
    pub(super) const NONE: Self = Self {
        period: 0,
        width: 0,
        direction: 0,
        periods: 0,
        runs: None,
        silence: 0,
    };

    /// All of a record.
    #[inline]
    pub(super) fn of(record: &Record) -> Self {
        let (mut period, mut periods) = (record.period, u32::from(record.repeat));
        // Silence is one period if it can be.
        if record.width == 0
            && let Ok(ticks) = u32::try_from(record.ticks())
        {
            (period, periods) = (ticks, 1);
        }
        Self {
            period,
            width: record.width.into(),
            direction: level(record.direction),
            periods,
            runs: Runs::of(period, periods),
            silence: 0,
        }
    }

    /// Whether nothing is left.
    #[inline]
    pub(super) const fn is_empty(&self) -> bool {
        self.silence | self.periods == 0
    }

    /// How long it takes, modulo 2³².
    #[inline]
    pub(super) const fn ticks(&self) -> u32 {
        self.period
            .wrapping_mul(self.periods)
            .wrapping_add(self.silence)
    }

    /// The level of the direction signal.
    #[inline]
    pub(super) const fn direction(&self) -> u32 {
        self.direction
    }

    /// The next run. There must be something left.
    #[inline]
    pub(super) fn next(&mut self) -> Words {
        let Some(runs) = &mut self.runs else {
            return self.part_of_period();
        };
        let repeat = runs.next();
        self.periods = self.periods.saturating_sub(repeat);
        Words::run(self.period, repeat, self.width, self.direction)
    }

    /// The next run of a period that is longer than a run: the pulse with as much of the period as the longest run holds, or a part of
    /// the silence behind it.
    #[cold]
    #[inline(never)]
    fn part_of_period(&mut self) -> Words {
        if self.silence > 0 {
            return self.silent_run();
        }
        self.periods = self.periods.saturating_sub(1);
        // Neither part is short, and the pulse has room in the first: only then is that longer than a run may be.
        let half = (self.period / 2).min(LONGEST_RUN);
        let head = half.max(self.width.saturating_add(SHORTEST_RECORD));
        let head = if self.period < head.saturating_add(SHORTEST_RECORD) {
            self.period
        } else {
            head
        };
        self.silence = self.period.saturating_sub(head);
        Words::run(head, 1, self.width, self.direction)
    }

    /// A run of silence.
    fn silent_run(&mut self) -> Words {
        let ticks = if self.silence <= LONGEST_RUN {
            self.silence
        } else {
            // Neither part is short.
            LONGEST_RUN.min(self.silence / 2)
        };
        self.silence = self.silence.saturating_sub(ticks);
        Words::run(ticks, 1, 0, self.direction)
    }
}
