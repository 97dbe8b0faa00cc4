//! What tasks share, behind RTIC's locks: the exchange of the drive, and the CAN controller. A lock is held for one copy, one question or one
//! frame, and not while the device makes it.

use canopen::outbox::{Mailbox, Mailboxes};
use canopen::{BitRate, ControllerState, Frame, Instant};
use cia402::{Exchange, Share};
use rtic::Mutex;
use runtime::{Controller, Host, Unreachable};

use crate::clock;

/// An exchange that two tasks share. The lock raises the priority to that of the control tick while a snapshot is copied.
pub struct Locked<'a, L>(pub &'a mut L);

impl<L: Mutex<T = &'static mut Exchange>> Share for Locked<'_, L> {
    fn lock<R>(&mut self, f: impl FnOnce(&mut Exchange) -> R) -> R {
        self.0.lock(|exchange| once(f, exchange))
    }
}

/// What is around the node: the exchange, the clock, and a call for the early tick.
pub struct Around<'a, L, S> {
    pub exchange: &'a mut L,
    pub stop: S,
}

impl<L: Mutex<T = &'static mut Exchange>, S> Share for Around<'_, L, S> {
    fn lock<R>(&mut self, f: impl FnOnce(&mut Exchange) -> R) -> R {
        self.exchange.lock(|exchange| once(f, exchange))
    }
}

impl<L: Mutex<T = &'static mut Exchange>, S: FnMut()> Host for Around<'_, L, S> {
    fn now(&self) -> Instant {
        clock::now()
    }

    fn stop(&mut self) {
        (self.stop)();
    }
}

/// A CAN controller whose interrupts are other tasks.
pub struct LockedBus<'a, L>(pub &'a mut L);

impl<B, L: Mutex<T = B>> LockedBus<'_, L> {
    fn with<R>(&mut self, f: impl FnOnce(&mut B) -> R) -> R {
        self.0.lock(|bus| once(f, bus))
    }
}

impl<B: Mailboxes, L: Mutex<T = B>> Mailboxes for LockedBus<'_, L> {
    fn mailbox_for(&mut self, cob_id: u16) -> Mailbox {
        self.with(|bus| bus.mailbox_for(cob_id))
    }

    fn holds(&mut self, cob_id: u16) -> bool {
        self.with(|bus| bus.holds(cob_id))
    }

    fn put(&mut self, frame: &Frame) -> Option<Frame> {
        self.with(|bus| bus.put(frame))
    }

    fn withdraw(&mut self) {
        self.with(B::withdraw);
    }
}

impl<B: Controller, L: Mutex<T = B>> Controller for LockedBus<'_, L> {
    const BIT_RATES: &'static [BitRate] = B::BIT_RATES;

    fn resume(&mut self) {
        self.with(B::resume);
    }

    fn leave(&mut self) -> bool {
        self.with(B::leave)
    }

    fn start(&mut self, bit_rate: BitRate) -> Result<(), Unreachable> {
        self.with(|bus| bus.start(bit_rate))
    }

    fn listen(&mut self, bit_rate: BitRate) -> Result<(), Unreachable> {
        self.with(|bus| bus.listen(bit_rate))
    }

    fn error_seen(&mut self) -> bool {
        self.with(B::error_seen)
    }

    fn state(&mut self) -> ControllerState {
        self.with(|bus| bus.state())
    }
}

/// RTIC's lock runs what it is given in one of several places, each of which would have it inlined.
#[inline(never)]
fn once<T, R>(f: impl FnOnce(&mut T) -> R, shared: &mut T) -> R {
    f(shared)
}
