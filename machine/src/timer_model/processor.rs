//! The processor that writes the registers: what it does takes time, and interrupts come in between.

use motion::advanced_timer::Register;

/// How long it takes.
#[derive(Debug)]
pub(super) struct Processor {
    /// Ticks of an access to a register.
    pub(super) access: u64,
    /// Behind the next write to this register, an interrupt of so many ticks.
    pub(super) behind: Option<(Register, u64)>,
    /// About one access in so many is followed by an interrupt, of up to so many ticks.
    pub(super) interrupts: Option<(u64, u64)>,
    /// What says when (an xorshift generator).
    random: u64,
}

impl Default for Processor {
    fn default() -> Self {
        Self {
            access: 2,
            behind: None,
            interrupts: None,
            random: 0x9E37_79B9_7F4A_7C15,
        }
    }
}

impl Processor {
    /// Ticks up to an access to a register.
    pub(super) fn access(&mut self) -> u64 {
        let Some((seldom, longest)) = self.interrupts else {
            return self.access;
        };
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        let is_interrupted = self.random.is_multiple_of(seldom);
        let interrupt = if is_interrupted {
            (self.random >> 32) % longest
        } else {
            0
        };
        self.access + interrupt
    }

    /// Ticks behind a write to this register.
    pub(super) fn behind(&mut self, written: Register) -> u64 {
        let interrupt = (self.behind).take_if(|(register, _)| *register == written);
        interrupt.map_or(0, |(_, ticks)| ticks)
    }
}
