//! From sync events to slots: evenly spaced moments, each with the sync event that has brought its set-point, or with none.
//!
//! Where 60C2h is a multiple of the SYNC period, only one SYNC in so many brings a set-point, and has a slot. Once the loop is locked, the
//! slots stay where they are: a set-point that comes a SYNC early or late waits for the next slot. The slots begin anew at a
//! set-point that comes after a long pause. Set-points that go on coming more often than 60C2h says count as they come.

use heapless::Vec;

use motion::low;

use super::pll::{Arrival, Pll};
use super::{MicrosQ16, POINT, SyncEvent, SyncStatus, micros_q16};

/// The most slots in one control tick.
const MAX: usize = 4;

/// So many set-points in a row that are as far apart tell how often they come.
const STEADY: u8 = 8;

/// After so many slots without a set-point the next one begins the slots anew.
const PAUSE: u32 = 8;

/// The slots of a control tick, in their order.
pub(crate) type Slots = Vec<Slot, MAX>;

/// A moment for a set-point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Slot {
    /// When its sync event should have come.
    pub(crate) at: MicrosQ16,
    /// The time between set-points.
    pub(crate) period: MicrosQ16,
    /// From there to the moment at which the motor is at its set-point; worked out when time passes.
    pub(crate) latency: MicrosQ16,
    /// What has come; `None` if nothing new has.
    pub(crate) event: Option<SyncEvent>,
}

impl Slot {
    /// When the motor is to be at its set-point. A cubic has to know the one behind it first.
    pub(crate) const fn due(&self, is_cubic: bool) -> MicrosQ16 {
        let due = self.at.wrapping_add(self.latency);
        if is_cubic {
            due.wrapping_add(self.period)
        } else {
            due
        }
    }
}

/// The clock of the network.
#[derive(Debug)]
pub(crate) struct NetworkClock {
    pll: Pll,
    is_synced: bool,
    /// SYNCs for one set-point.
    syncs_per_set_point: u32,
    /// SYNCs for one set-point as 60C2h says.
    nominal: u32,
    /// 60C2h, as it was when that was found.
    interpolation: MicrosQ16,
    /// SYNCs since the last slot.
    since: u32,
    spacing: Spacing,
    /// A set-point that came before its slot.
    early: Option<SyncEvent>,
    /// A mode uses the slots. Without one they pass empty.
    is_used: bool,
}

/// How far apart set-points are, in SYNCs.
#[derive(Debug)]
struct Spacing {
    /// SYNCs since the last set-point.
    since: u32,
    /// SYNCs between the last two set-points.
    apart: u32,
    /// How often in a row that distance was the same before.
    alike: u8,
}

impl Spacing {
    /// No set-point has come.
    const NONE: Self = Self {
        since: u32::MAX,
        apart: 0,
        alike: 0,
    };

    const fn pass(&mut self) {
        self.since = self.since.saturating_add(1);
    }

    /// Counts a set-point. Returns how many SYNCs after the one before it.
    const fn restart(&mut self) -> u32 {
        let apart = self.since;
        self.alike = if apart == self.apart {
            self.alike.saturating_add(1)
        } else {
            0
        };
        self.apart = apart;
        self.since = 0;
        apart
    }

    /// How far apart they are if that has been the same for long.
    fn steady(&self) -> Option<u32> {
        (self.alike >= STEADY).then_some(self.apart)
    }
}

impl NetworkClock {
    pub(crate) const fn new() -> Self {
        Self {
            pll: Pll::new(),
            is_synced: false,
            syncs_per_set_point: 1,
            nominal: 1,
            interpolation: 0,
            since: 0,
            spacing: Spacing::NONE,
            early: None,
            is_used: true,
        }
    }

    /// Whether there is, or may soon be, a mode that goes by the slots. Without one, only SYNC is a sync event. Returns whether there
    /// are no sync events any more because of that.
    pub(crate) fn set_used(&mut self, is_used: bool) -> bool {
        self.is_used = is_used;
        let is_over = !is_used && !self.is_synced && self.pll.is_running();
        if is_over {
            self.begin_anew();
        }
        is_over
    }

    /// Another loop, with the counts of this one.
    #[inline(never)]
    fn begin_anew(&mut self) {
        let (missed, rejected) = (self.pll.missed(), self.pll.rejected());
        self.pll = Pll::new();
        self.pll.carry_on(missed, rejected);
        self.spacing = Spacing::NONE;
        self.early = None;
    }

    pub(crate) const fn pll(&self) -> &Pll {
        &self.pll
    }

    /// The time between set-points.
    pub(crate) fn period(&self) -> MicrosQ16 {
        let period = self.pll.period();
        match self.syncs_per_set_point {
            1 => period,
            number => period.saturating_mul(number.into()),
        }
    }

    /// A sync event came. `is_new` says whether it brings a set-point, `interpolation` is 60C2h and `cycle` 1006h, both 0 if not known.
    pub(crate) fn on_sync_event(
        &mut self,
        event: SyncEvent,
        is_new: bool,
        (interpolation, cycle): (MicrosQ16, MicrosQ16),
        slots: &mut Slots,
    ) {
        if !event.is_sync && !self.is_used {
            return;
        }
        if event.is_sync != self.is_synced {
            self.is_synced = event.is_sync;
            self.begin_anew();
        }
        let arrival = self
            .pll
            .on_sync_event(micros_q16(event.at), [interpolation, cycle]);
        if arrival == Arrival::OutOfTurn {
            return;
        }
        let is_locked = self.pll.is_locked();
        if !is_locked || self.interpolation != interpolation {
            self.find_syncs_per_set_point(interpolation);
        }
        self.step();
        let is_due = self.since >= self.syncs_per_set_point;
        if is_new && (self.take_set_point(is_locked) || is_due) {
            self.slot(Some(event), slots);
        } else if is_new {
            self.early = Some(event);
        } else if is_due {
            self.early_slot(slots);
        }
    }

    /// Lets time pass. Returns whether a sync event should have come, and has not.
    #[inline]
    pub(crate) fn pass(&mut self, now: MicrosQ16, slots: &mut Slots) -> bool {
        self.pll.may_miss(now) && self.pass_late(now, slots)
    }

    #[inline(never)]
    fn pass_late(&mut self, now: MicrosQ16, slots: &mut Slots) -> bool {
        let mut has_missed = false;
        while !slots.is_full() && self.pll.count_missed(now) {
            has_missed = true;
            self.step();
            if self.since >= self.syncs_per_set_point {
                self.early_slot(slots);
            }
        }
        has_missed
    }

    /// A SYNC was, or should have been.
    fn step(&mut self) {
        self.since = self.since.saturating_add(1);
        self.spacing.pass();
    }

    /// Counts a set-point. Returns whether it gets its slot at once, wherever the slots have been.
    fn take_set_point(&mut self, is_locked: bool) -> bool {
        let apart = self.spacing.restart();
        if !is_locked {
            self.syncs_per_set_point = self.syncs_per_set_point.min(self.since).max(1);
            return true;
        }
        match self.spacing.steady() {
            Some(apart) if apart != self.syncs_per_set_point && apart <= self.nominal => {
                self.syncs_per_set_point = apart.max(1);
                true
            }
            _ => apart >= self.syncs_per_set_point.saturating_mul(PAUSE),
        }
    }

    /// A slot for the set-point that came before it, if one did.
    fn early_slot(&mut self, slots: &mut Slots) {
        let event = self.early;
        self.slot(event, slots);
    }

    fn slot(&mut self, event: Option<SyncEvent>, slots: &mut Slots) {
        self.since = 0;
        self.early = None;
        if !self.is_used {
            return;
        }
        let slot = Slot {
            at: self.pll.at(),
            period: self.period(),
            latency: 0,
            event,
        };
        // More than these cannot be carried out in one tick.
        let _ = slots.push(slot);
    }

    /// How many SYNCs make one set-point, as long as the period is not settled and when 60C2h changes.
    #[inline(never)]
    fn find_syncs_per_set_point(&mut self, interpolation: MicrosQ16) {
        self.interpolation = interpolation;
        let period = self.pll.period();
        let micros = |time: MicrosQ16| u32::try_from(time >> POINT).unwrap_or(u32::MAX);
        let half = micros(period) / 2;
        let syncs = micros(interpolation)
            .saturating_add(half)
            .checked_div(micros(period))
            .unwrap_or(1);
        let whole = period.saturating_mul(syncs.into());
        let is_near = whole.abs_diff(interpolation) <= period / 8;
        self.nominal = if is_near { syncs.max(1) } else { 1 };
        self.syncs_per_set_point = self.nominal;
    }

    /// Whether the sync events of a loop that is locked come with another period than one that is set up, where that is known.
    pub(crate) fn differs(&self, interpolation: MicrosQ16, cycle: MicrosQ16) -> bool {
        let is_far =
            |period: MicrosQ16, from: MicrosQ16| from != 0 && from.abs_diff(period) > period / 16;
        is_far(self.period(), interpolation) || is_far(self.pll.period(), cycle)
    }

    /// What 2050h shows of the sync events.
    pub(crate) fn status(&self) -> SyncStatus {
        // A period is at most two seconds, and so is jitter.
        let nanoseconds = |time: MicrosQ16| low::u32(time.wrapping_mul(1_000) >> POINT);
        let is_there = self.pll.state() != 0;
        let shown = |time| if is_there { nanoseconds(time) } else { 0 };
        SyncStatus {
            state: if self.is_synced { self.pll.state() } else { 0 },
            period: shown(self.pll.period()),
            jitter: shown(self.pll.jitter()),
            missed: self.pll.missed(),
            rejected: self.pll.rejected(),
            ..SyncStatus::default()
        }
    }
}

#[cfg(test)]
mod tests;
