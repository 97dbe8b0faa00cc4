//! From beats to slots: evenly spaced moments, each with the beat that has brought its set-point, or with none.
//!
//! Where 60C2h is a multiple of the SYNC period, only one SYNC in so many brings a set-point. If set-points come more often than
//! 60C2h says, they count as they come.

use heapless::Vec;

use super::lock::{Heard, Lock};
use super::{Beat, Fine, POINT, SyncStatus, fine};

/// The most slots in one control tick.
const MOST: usize = 4;

/// The slots of a control tick, in their order.
pub(crate) type Slots = Vec<Slot, MOST>;

/// A moment for a set-point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Slot {
    /// When its beat should have come.
    pub(crate) at: Fine,
    /// The time between set-points.
    pub(crate) period: Fine,
    /// What has come; `None` if nothing new has.
    pub(crate) beat: Option<Beat>,
}

/// The clock of the network.
#[derive(Debug)]
pub(crate) struct NetworkClock {
    lock: Lock,
    is_synced: bool,
    /// SYNCs for one set-point.
    share: u32,
    /// SYNCs since the last slot.
    since: u32,
}

impl NetworkClock {
    pub(crate) const fn new() -> Self {
        Self {
            lock: Lock::new(),
            is_synced: false,
            share: 1,
            since: 0,
        }
    }

    pub(crate) const fn lock(&self) -> &Lock {
        &self.lock
    }

    /// The time between set-points.
    pub(crate) fn period(&self) -> Fine {
        self.lock.period().saturating_mul(self.share.into())
    }

    /// A beat came. `is_new` says whether it brings a set-point, `interpolation` is 60C2h and `cycle` 1006h, both 0 if not known.
    pub(crate) fn hear(
        &mut self,
        beat: Beat,
        is_new: bool,
        (interpolation, cycle): (Fine, Fine),
        slots: &mut Slots,
    ) {
        if beat.is_sync != self.is_synced {
            self.is_synced = beat.is_sync;
            let (missed, rejected) = (self.lock.missed(), self.lock.rejected());
            self.lock = Lock::new();
            self.lock.carry_on(missed, rejected);
        }
        let heard = self.lock.hear(fine(beat.at), [interpolation, cycle]);
        if heard == Heard::OutOfTurn {
            return;
        }
        self.find_share(interpolation);
        self.since = self.since.saturating_add(1);
        if is_new {
            self.share = self.share.min(self.since).max(1);
            self.slot(Some(beat), slots);
        } else if self.since >= self.share {
            self.slot(None, slots);
        }
    }

    /// Lets time pass.
    pub(crate) fn pass(&mut self, now: Fine, slots: &mut Slots) {
        while !slots.is_full() && self.lock.misses(now) {
            self.since = self.since.saturating_add(1);
            if self.since >= self.share {
                self.slot(None, slots);
            }
        }
    }

    fn slot(&mut self, beat: Option<Beat>, slots: &mut Slots) {
        self.since = 0;
        let slot = Slot {
            at: self.lock.at(),
            period: self.period(),
            beat,
        };
        // More than these cannot be carried out in one tick.
        let _ = slots.push(slot);
    }

    /// How many SYNCs make one set-point, as long as the period is not settled.
    fn find_share(&mut self, interpolation: Fine) {
        if self.lock.is_locked() && self.share > 1 {
            return;
        }
        let period = self.lock.period();
        let micros = |time: Fine| u32::try_from(time >> POINT).unwrap_or(u32::MAX);
        let half = micros(period) / 2;
        let share = micros(interpolation)
            .saturating_add(half)
            .checked_div(micros(period))
            .unwrap_or(1);
        let whole = period.saturating_mul(share.into());
        let is_near = whole.abs_diff(interpolation) <= period / 8;
        if !self.lock.is_locked() {
            self.share = if is_near { share.max(1) } else { 1 };
        }
    }

    /// Whether the beat comes with another period than one that is set up, where that is known.
    pub(crate) fn differs(&self, interpolation: Fine, cycle: Fine) -> bool {
        let is_far = |period: Fine, from: Fine| from.abs_diff(period) > period / 16;
        self.is_synced
            && self.lock.is_locked()
            && (is_far(self.period(), interpolation)
                || cycle != 0 && is_far(self.lock.period(), cycle))
    }

    /// What 2050h shows of the beat.
    pub(crate) fn status(&self) -> SyncStatus {
        let nanoseconds = |time: Fine| {
            let whole = time.saturating_mul(1_000) >> POINT;
            u32::try_from(whole).unwrap_or(u32::MAX)
        };
        let is_there = self.lock.state() != 0;
        let shown = |time| if is_there { nanoseconds(time) } else { 0 };
        SyncStatus {
            state: if self.is_synced { self.lock.state() } else { 0 },
            period: shown(self.lock.period()),
            jitter: shown(self.lock.jitter()),
            missed: self.lock.missed(),
            rejected: self.lock.rejected(),
            ..SyncStatus::default()
        }
    }
}
