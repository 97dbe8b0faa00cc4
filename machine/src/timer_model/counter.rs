//! The slave timer: what it has counted, and what its channels have captured of it.

use motion::advanced_timer::{Register, bits};

/// Capture channels.
const CHANNELS: usize = 4;

/// TIM2, as far as it does not depend on TIM1.
#[derive(Debug, Default)]
pub(super) struct Counter {
    /// CNT.
    pub(super) count: u32,
    /// CCR1 to CCR4.
    captured: [u32; CHANNELS],
    /// SR.
    status: u32,
    /// Edges that have passed the filter of a channel (counted from 0) at a time to come.
    edges: Vec<(u64, usize)>,
}

impl Counter {
    /// An edge at the pin of a channel gets through its filter at this time.
    pub(super) fn expect_edge(&mut self, at: u64, channel: usize) {
        self.edges.push((at, channel));
    }

    /// When the next edge is captured.
    pub(super) fn next_edge(&self) -> Option<u64> {
        self.edges.iter().map(|(at, _)| *at).min()
    }

    /// Captures the edges of this time.
    pub(super) fn capture(&mut self, now: u64) {
        for (at, channel) in std::mem::take(&mut self.edges) {
            if at == now {
                self.captured[channel] = self.count;
                self.status |= bits::CC1IF << channel;
            } else {
                self.edges.push((at, channel));
            }
        }
    }

    /// A read of one of its registers; that of a capture register clears its flag.
    pub(super) fn read(&mut self, register: Register) -> Option<u32> {
        let channel = match register {
            Register::CounterCnt => return Some(self.count),
            Register::CounterSr => return Some(self.status),
            Register::CounterCcr1 => 0,
            Register::CounterCcr2 => 1,
            Register::CounterCcr4 => 3,
            _ => return None,
        };
        self.status &= !(bits::CC1IF << channel);
        Some(self.captured[channel])
    }

    /// A write to SR: a flag is cleared by 0.
    pub(super) fn clear(&mut self, value: u32) {
        self.status &= value;
    }
}
