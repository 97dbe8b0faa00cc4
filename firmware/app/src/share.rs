//! The exchange of the drive behind RTIC's lock.

use cia402::{Exchange, Share};
use rtic::Mutex;

/// An exchange that two tasks share. The lock raises the priority to that of the control tick while a snapshot is copied.
pub struct Locked<'a, L>(pub &'a mut L);

impl<L: Mutex<T = Exchange>> Share for Locked<'_, L> {
    fn lock<R>(&mut self, f: impl FnOnce(&mut Exchange) -> R) -> R {
        self.0.lock(f)
    }
}
