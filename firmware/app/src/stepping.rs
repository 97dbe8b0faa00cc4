//! The emitter and the pulses, which control tick and refill share.
//!
//! The refill stands above the tick. Each of the two is locked for a question, a copy or the pulses of a few time slices; a refill that comes meanwhile
//! does not wait: who opens the lock makes up for it. So nothing is masked, and no interrupt is later for it.

use core::sync::atomic::{AtomicBool, Ordering};

use cia402::{Emitter, EmitterLock, RatedMotor, ServoOrder, ServoPort, ServoReport};
use motion::{PulseSink, Record, Ticks};
use spin::{Mutex, MutexGuard};

use crate::board::{Board, Pulses, Selected};

/// The pulses of the board.
type BoardPulses = <Selected as Board>::Pulses;

/// An emitter and its pulses.
pub struct Stepping {
    /// A refill has found one of them locked.
    is_due: AtomicBool,
    pulses: Mutex<BoardPulses>,
    emitter: Mutex<&'static mut Emitter>,
}

impl Stepping {
    /// Both are locked by nobody.
    pub const fn new(emitter: &'static mut Emitter, pulses: BoardPulses) -> Self {
        Self {
            is_due: AtomicBool::new(false),
            pulses: Mutex::new(pulses),
            emitter: Mutex::new(emitter),
        }
    }

    /// Commits pulses, or leaves that to who has locked them. Returns whether it has.
    pub fn refill(&self) -> bool {
        let (Some(mut emitter), Some(mut pulses)) =
            (self.emitter.try_lock(), self.pulses.try_lock())
        else {
            self.is_due.store(true, Ordering::Relaxed);
            return false;
        };
        pulses.service();
        emitter.refill(&mut *pulses);
        true
    }

    /// Whether the outputs were cut off by hardware. Not while the control tick has the pulses: then it looks itself.
    pub fn has_failed(&self) -> bool {
        (self.pulses.try_lock()).is_some_and(|pulses| pulses.fault().is_some())
    }

    /// For the control tick alone: nothing else holds a lock while that runs, so it never waits.
    fn with<T, R>(&self, shared: &Mutex<T>, f: impl FnOnce(&mut T) -> R) -> R {
        let result = f(&mut lock(shared));
        if self.is_due.load(Ordering::Relaxed) {
            self.make_up();
        }
        result
    }

    /// Does what refills have left. As long as the other one is locked it stays due.
    #[cold]
    #[inline(never)]
    fn make_up(&self) {
        while self.is_due.swap(false, Ordering::Relaxed) && self.refill() {}
    }
}

/// Out of line, as it is called in many places.
#[inline(never)]
fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock()
}

/// The emitter for the control tick.
pub struct SharedEmitter(pub &'static Stepping);

impl EmitterLock for SharedEmitter {
    fn look<R>(&self, f: impl FnOnce(&Emitter) -> R) -> R {
        self.0.with(&self.0.emitter, |emitter| f(emitter))
    }

    fn lock<R>(&mut self, f: impl FnOnce(&mut Emitter) -> R) -> R {
        self.0.with(&self.0.emitter, |emitter| f(emitter))
    }
}

/// The pulses for the control tick.
pub struct SharedPulses(pub &'static Stepping);

impl SharedPulses {
    fn with<R>(&self, f: impl FnOnce(&mut BoardPulses) -> R) -> R {
        self.0.with(&self.0.pulses, f)
    }
}

impl PulseSink for SharedPulses {
    fn push(&mut self, record: Record) -> Result<(), Record> {
        self.with(|pulses| pulses.push(record))
    }

    fn push_all(&mut self, records: &[Record]) -> usize {
        self.with(|pulses| pulses.push_all(records))
    }

    fn pending(&self) -> Ticks {
        self.with(|pulses| pulses.pending())
    }

    fn free(&self) -> usize {
        self.with(|pulses| pulses.free())
    }
}

impl Pulses for SharedPulses {
    fn service(&mut self) {
        self.with(Pulses::service);
    }

    fn position(&mut self) -> i64 {
        self.with(Pulses::position)
    }

    fn position_at(&self, count: u32) -> i32 {
        self.with(|pulses| pulses.position_at(count))
    }

    fn drop_all(&mut self) {
        self.with(Pulses::drop_all);
    }

    fn fault(&self) -> Option<u16> {
        self.with(|pulses| pulses.fault())
    }

    fn mend(&mut self) {
        self.with(Pulses::mend);
    }
}

impl ServoPort for SharedPulses {
    fn motor(&self) -> RatedMotor {
        self.with(|pulses| pulses.motor())
    }

    fn order(&mut self, order: &ServoOrder) {
        self.with(|pulses| pulses.order(order));
    }

    fn report(&self) -> ServoReport {
        self.with(|pulses| pulses.report())
    }

    fn forget(&mut self) {
        self.with(Pulses::forget);
    }
}
