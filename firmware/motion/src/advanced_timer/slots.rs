//! From records to slots: what a timer of 16 bits with a repetition counter of 8 bits can do at a time.

use crate::{Direction, Record};

/// Longest period of a timer of 16 bits, in ticks. One less than it could be, so that a compare value above the reload value
/// exists: that keeps the direction high.
pub(super) const LONGEST_PERIOD: u32 = 0xFFFF;

/// Most periods of a run: the repetition counter has 8 bits.
pub(super) const MOST_PERIODS: u32 = 256;

/// Longest run of a record, in ticks. A slot can be written until the run before it begins, so short runs leave a late processor
/// more time. (What is silent behind the last record takes longer.)
pub(super) const LONGEST_RUN: u32 = 1 << 14;

/// What a DMA burst writes into ARR, RCR, CCR1 and CCR2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Words(pub(super) [u32; 4]);

impl Words {
    /// `repeat` (1 ..= 256) periods of `period` (1 ..= 65535) ticks; the registers hold one less.
    const fn run(period: u32, repeat: u32, width: u32, direction: u32) -> Self {
        Self([
            period.wrapping_sub(1),
            repeat.wrapping_sub(1),
            width,
            direction,
        ])
    }

    /// As long as a run can be, without a pulse.
    pub(super) const fn silent(direction: u32) -> Self {
        Self::run(LONGEST_PERIOD, MOST_PERIODS, 0, direction)
    }

    /// A silent period.
    pub(super) const fn pause(ticks: u32, direction: u32) -> Self {
        Self::run(ticks, 1, 0, direction)
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

/// What is left of a record on its way into slots. Ticks and pulses of its runs are those of the record, exactly.
#[derive(Clone, Copy, Debug)]
pub(super) struct Remainder {
    period: u32,
    /// Periods that have not begun.
    periods: u32,
    width: u32,
    direction: u32,
    /// Silence up to the end of the period under way.
    silence: u64,
}

impl Remainder {
    /// Nothing.
    pub(super) const NONE: Self = Self {
        period: 0,
        periods: 0,
        width: 0,
        direction: 0,
        silence: 0,
    };

    /// All of a record.
    pub(super) fn of(record: &Record) -> Self {
        let pulses = record.width > 0;
        Self {
            period: record.period,
            periods: if pulses { record.repeat.into() } else { 0 },
            width: record.width.into(),
            direction: level(record.direction),
            silence: if pulses { 0 } else { record.ticks() },
        }
    }

    /// Whether nothing is left.
    pub(super) const fn is_empty(&self) -> bool {
        self.silence == 0 && self.periods == 0
    }

    /// How long it takes, modulo 2³².
    pub(super) const fn ticks(&self) -> u32 {
        self.period
            .wrapping_mul(self.periods)
            .wrapping_add(self.silence as u32)
    }

    /// The level of the direction signal.
    pub(super) const fn direction(&self) -> u32 {
        self.direction
    }

    /// The next run.
    #[inline]
    pub(super) fn next(&mut self) -> Option<Words> {
        if self.silence > 0 {
            return Some(self.rest());
        }
        if self.periods == 0 {
            return None;
        }
        if self.period > LONGEST_RUN {
            return Some(self.long_period());
        }
        // In equal parts: a short one at the end might be over before the burst behind it. The product fits: a run has
        // 16 bits of periods.
        let run = self.period.wrapping_mul(self.periods);
        let repeat = if run <= LONGEST_RUN && self.periods <= MOST_PERIODS {
            self.periods
        } else {
            let parts = (run / LONGEST_RUN).max(self.periods / MOST_PERIODS);
            self.periods
                .div_ceil(parts.saturating_add(1).max(1))
                .clamp(1, MOST_PERIODS)
        };
        self.periods = self.periods.saturating_sub(repeat);
        Some(Words::run(self.period, repeat, self.width, self.direction))
    }

    /// A pulse, and as much of its period as the longest run holds; the rest is silence.
    #[cold]
    fn long_period(&mut self) -> Words {
        self.periods = self.periods.saturating_sub(1);
        // Neither part is short.
        let head = if self.width < LONGEST_RUN / 2 {
            (self.period / 2).min(LONGEST_RUN)
        } else if self.period <= LONGEST_PERIOD {
            self.period
        } else {
            LONGEST_PERIOD / 2 + 1
        };
        self.silence = self.period.saturating_sub(head).into();
        Words::run(head, 1, self.width, self.direction)
    }

    /// A run of silence.
    fn rest(&mut self) -> Words {
        let longest = u64::from(LONGEST_RUN);
        let ticks = if self.silence <= longest {
            self.silence
        } else {
            // Neither part is short.
            longest.min(self.silence / 2)
        };
        self.silence = self.silence.saturating_sub(ticks);
        Words::pause(ticks as u32, self.direction)
    }
}
