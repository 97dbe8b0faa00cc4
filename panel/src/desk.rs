//! What windows and the session share: who may write, and the orders that may not wait in a queue.
//!
//! Stop and release are counts, so none can be lost and none has to wait for room. A beat says that a jog button is still held.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Shared by all windows and the session.
#[derive(Debug, Default)]
pub struct Desk {
    stops: AtomicU64,
    releases: AtomicU64,
    beats: AtomicU64,
    windows: Mutex<Windows>,
}

#[derive(Debug, Default)]
struct Windows {
    open: BTreeSet<u64>,
    last: u64,
    emptied: u64,
    writer: Option<u64>,
}

/// How often each was ordered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Stops.
    pub stops: u64,
    /// Releases.
    pub releases: u64,
    /// Beats.
    pub beats: u64,
}

impl Desk {
    /// Stop at once.
    pub fn stop(&self) {
        self.stops.fetch_add(1, Ordering::SeqCst);
    }

    /// The jog button is held no longer.
    pub fn release(&self) {
        self.releases.fetch_add(1, Ordering::SeqCst);
    }

    /// The jog button is still held.
    pub fn beat(&self) {
        self.beats.fetch_add(1, Ordering::SeqCst);
    }

    /// How often each was ordered.
    pub fn counts(&self) -> Counts {
        Counts {
            stops: self.stops.load(Ordering::SeqCst),
            releases: self.releases.load(Ordering::SeqCst),
            beats: self.beats.load(Ordering::SeqCst),
        }
    }

    /// A window opens; returns its number. The first one may write.
    pub fn open(&self) -> u64 {
        let mut windows = self.windows();
        windows.last += 1;
        let number = windows.last;
        windows.open.insert(number);
        windows.writer.get_or_insert(number);
        number
    }

    /// A window is closed, or its connection lost. What it holds, it releases; nobody takes its place without being asked.
    pub fn close(&self, number: u64) {
        let mut windows = self.windows();
        if windows.open.remove(&number) && windows.open.is_empty() {
            windows.emptied += 1;
        }
        if windows.writer == Some(number) {
            windows.writer = None;
            self.release();
        }
    }

    /// This window is the one that may write now. What another has held is released.
    pub fn take(&self, number: u64) {
        let mut windows = self.windows();
        if windows.open.contains(&number) && windows.writer.replace(number) != Some(number) {
            self.release();
        }
    }

    /// The window that may write.
    pub fn writer(&self) -> Option<u64> {
        self.windows().writer
    }

    /// How often the last window was closed.
    pub fn emptied(&self) -> u64 {
        self.windows().emptied
    }

    /// How many windows are open.
    pub fn open_windows(&self) -> usize {
        self.windows().open.len()
    }

    fn windows(&self) -> MutexGuard<'_, Windows> {
        // Nothing in here can be half done.
        self.windows.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_window_writes_and_any_number_watch() {
        let desk = Desk::default();
        let (first, second) = (desk.open(), desk.open());
        assert_eq!(desk.writer(), Some(first));
        assert_eq!(desk.counts().releases, 0);
        desk.take(second);
        assert_eq!((desk.writer(), desk.counts().releases), (Some(second), 1));
        // Whoever has it already releases nothing.
        desk.take(second);
        assert_eq!(desk.counts().releases, 1);
        desk.close(second);
        assert_eq!((desk.writer(), desk.counts().releases), (None, 2));
        assert_eq!(desk.open_windows(), 1);
        desk.take(second);
        assert_eq!(desk.writer(), None, "it is closed");
        desk.close(first);
        assert_eq!((desk.open_windows(), desk.counts().releases), (0, 2));
        assert_eq!(desk.emptied(), 1);
    }
}
