//! The power of a simulated flash, which can go at any byte.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The power of a [`super::Flash`]. Its clones are the same power: one feeds the flash, another is in the hands of a test.
#[derive(Clone, Debug)]
pub struct Power {
    /// Bytes that can still be programmed or erased; 0 if the power is off.
    left: Arc<AtomicU64>,
}

impl Power {
    /// Power that lasts.
    pub fn new() -> Self {
        Self {
            left: Arc::new(AtomicU64::new(u64::MAX)),
        }
    }

    /// Cuts the power at the `count`th byte that is programmed or erased from now on: that byte is left half done. 0 cuts it at
    /// once.
    pub fn cut_at_byte(&self, count: u64) {
        self.left.store(count, Ordering::Relaxed);
    }

    /// Gives power that lasts.
    pub fn restore(&self) {
        self.cut_at_byte(u64::MAX);
    }

    /// Whether there is power.
    pub fn is_on(&self) -> bool {
        self.left.load(Ordering::Relaxed) > 0
    }

    /// Takes what changing a byte costs. Returns whether there still is power after it.
    pub(super) fn spend(&self) -> bool {
        let left = self.left.load(Ordering::Relaxed).saturating_sub(1);
        self.left.store(left, Ordering::Relaxed);
        left > 0
    }
}

impl Default for Power {
    fn default() -> Self {
        Self::new()
    }
}
