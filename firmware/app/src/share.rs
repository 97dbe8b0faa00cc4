//! What tasks share, behind RTIC's locks: the exchange of the drive, and the mailboxes of the CAN controller.

use canopen::outbox::{Mailboxes, Room};
use canopen::Frame;
use cia402::{Exchange, Share};
use rtic::Mutex;

/// An exchange that two tasks share. The lock raises the priority to that of the control tick while a snapshot is copied.
pub struct Locked<'a, L>(pub &'a mut L);

impl<L: Mutex<T = Exchange>> Share for Locked<'_, L> {
    fn lock<R>(&mut self, f: impl FnOnce(&mut Exchange) -> R) -> R {
        self.0.lock(f)
    }
}

/// The mailboxes of a bus whose interrupts are other tasks. The lock is held for one question or one frame, and not while the device
/// makes it.
pub struct LockedBus<'a, L>(pub &'a mut L);

impl<B: Mailboxes, L: Mutex<T = B>> Mailboxes for LockedBus<'_, L> {
    fn room(&mut self, cob_id: u16) -> Room {
        self.0.lock(|bus| bus.room(cob_id))
    }

    fn put(&mut self, frame: &Frame) -> Option<Frame> {
        self.0.lock(|bus| bus.put(frame))
    }
}
