//! What is to be recorded, and what a master has ordered since the recorder looked last.

use canopen::cia301::sdo::AbortCode;
use canopen::od::{self, Dictionary};

use super::{CHANNEL_MAP, Edge, SCOPE, Signal, TRIGGER, Trigger, sub};

/// How many values a sample may have.
pub const CHANNELS: usize = 8;

/// A recording that is to be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Setup {
    /// What each channel records.
    pub channels: [Option<Signal>; CHANNELS],
    /// Every so many control ticks a sample; 1 is each tick, and 0 as well.
    pub divider: u16,
    /// How many samples in all; 0 for as many as there is room for.
    pub samples: u16,
    /// How many of them are older than the trigger, fewer than there are samples.
    pub before: u16,
    /// What the trigger is.
    pub trigger: Trigger,
    /// When the recording has been read to its end, the next one begins.
    pub is_repeated: bool,
}

impl Setup {
    /// A recording of nothing.
    pub const NONE: Self = Self {
        channels: [None; CHANNELS],
        divider: 1,
        samples: 0,
        before: 0,
        trigger: Trigger::NONE,
        is_repeated: false,
    };

    /// What the objects say. Values that no rule would have let through are left out.
    pub(crate) fn of<D: Dictionary>(dictionary: &D) -> Self {
        let mut channels = [None; CHANNELS];
        for (channel, sub) in channels.iter_mut().zip(1..) {
            *channel = od::read_u32(dictionary, CHANNEL_MAP, sub).and_then(Signal::mapped);
        }
        let u16_at = |sub| od::read_u16(dictionary, SCOPE, sub).unwrap_or(0);
        Self {
            channels,
            divider: u16_at(sub::DIVIDER),
            samples: u16_at(sub::SAMPLES),
            before: u16_at(sub::BEFORE),
            trigger: Trigger {
                signal: od::read_u32(dictionary, TRIGGER, 1).and_then(Signal::mapped),
                edge: od::read_u8(dictionary, TRIGGER, 2)
                    .and_then(Edge::from_code)
                    .unwrap_or(Edge::Rising),
                level: od::read_u32(dictionary, TRIGGER, 3)
                    .unwrap_or(0)
                    .cast_signed(),
                mask: od::read_u32(dictionary, TRIGGER, 4).unwrap_or(0),
            },
            is_repeated: od::read_u8(dictionary, SCOPE, sub::MODE) == Some(1),
        }
    }

    /// The values of a sample, in the order of the channels.
    pub(crate) fn signals(&self) -> impl Iterator<Item = Signal> {
        self.channels.iter().copied().flatten()
    }

    /// The length of a sample in words; 0 without channels.
    pub(crate) fn stride(&self) -> u32 {
        let bits: u32 = self.signals().map(Signal::length).sum();
        bits.div_ceil(32)
    }

    /// How many samples a memory of so many words gets to hold: as many as are asked for, or as many as fit.
    pub(crate) fn capacity(&self, words: u32) -> u16 {
        let fits = words.checked_div(self.stride()).unwrap_or(0);
        let fits = u16::try_from(fits).unwrap_or(u16::MAX);
        match self.samples {
            0 => fits,
            samples => samples.min(fits),
        }
    }

    /// The words of the ring.
    pub(crate) fn span(&self, words: u32) -> u32 {
        u32::from(self.capacity(words)).saturating_mul(self.stride())
    }

    /// Whether a memory of so many words can take it.
    ///
    /// # Errors
    /// 08000022h if no channel records anything, 05040005h if the samples do not fit, 06040043h if all of them would be older than the
    /// trigger.
    pub(crate) fn check(&self, words: u32) -> Result<(), AbortCode> {
        if self.stride() == 0 {
            return Err(AbortCode::DeviceState);
        }
        let capacity = self.capacity(words);
        if capacity == 0 || capacity < self.samples {
            return Err(AbortCode::OutOfMemory);
        }
        if self.before >= capacity {
            return Err(AbortCode::ParameterIncompatible);
        }
        Ok(())
    }
}

/// What a master has ordered since the recorder looked last; the newest order counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Orders {
    /// What goes on is to end, before anything else.
    pub stop: bool,
    /// A recording is to begin.
    pub arm: Option<Setup>,
    /// The trigger is now.
    pub trigger: bool,
}

impl Orders {
    /// Whether there is none.
    pub const fn is_empty(&self) -> bool {
        !self.stop && self.arm.is_none() && !self.trigger
    }

    /// These, behind earlier ones that nobody has taken yet.
    pub(crate) fn after(self, earlier: Self) -> Self {
        if self.stop || self.arm.is_some() {
            return self;
        }
        Self {
            trigger: self.trigger || earlier.trigger,
            ..earlier
        }
    }
}
