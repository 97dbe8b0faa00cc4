//! What the loops and the tasks of a board copy from one to the other.
//!
//! The interrupt of the loops stands above all of these tasks and waits for nobody: where it finds a part locked, it goes on by what it has copied before. Each part has one task
//! beside that interrupt, which never finds it locked.

use core::sync::atomic::{AtomicBool, AtomicU16, Ordering};

use cia402::{ServoOrder, ServoReport};
use spin::Mutex;

use super::raw_report::RawReport;
use super::{Found, LoopReport, Request, ServoData, ServoSettings};

/// From the control tick.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Orders {
    /// What is to be done, and the count of the clock when that was said.
    pub(super) order: Option<(ServoOrder, u32)>,
    /// Current in the motor.
    pub(super) is_on: bool,
    /// The stage, in 0.1 °C.
    pub(super) temperature: i16,
    /// The stage gives no current, whatever is asked of it.
    pub(super) is_blocked: bool,
}

/// From the task of the dictionary.
#[derive(Debug, Default)]
struct SetUp {
    settings: ServoSettings,
    /// Taken once.
    request: Option<Request>,
    /// The loops have not seen it yet.
    is_new: bool,
}

/// From the loops to the control tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LoopStatus {
    /// What has become of the orders.
    pub report: ServoReport,
    /// Why there is no current, as an error code of CiA 402.
    pub fault: Option<u16>,
    /// The bus.
    pub millivolts: u32,
    /// The rotor stands against a limit of the torque.
    pub is_stalled: bool,
    /// The heat has come near its bound.
    pub is_hot: bool,
    /// How far the rotor may be from where it is held at rest, in counts.
    pub position_tolerance: u32,
}

/// See the module.
#[derive(Debug, Default)]
pub struct Link {
    orders: Mutex<Orders>,
    set_up: Mutex<SetUp>,
    status: Mutex<LoopStatus>,
    found: Mutex<Found>,
    lead: AtomicU16,
    /// Published once somebody has asked for it.
    raw_report: Mutex<RawReport>,
    is_asked: AtomicBool,
}

impl Link {
    /// Nothing is ordered or reported.
    pub const fn new() -> Self {
        Self {
            orders: Mutex::new(Orders {
                order: None,
                is_on: false,
                temperature: 250,
                is_blocked: false,
            }),
            set_up: Mutex::new(SetUp {
                settings: ServoSettings::NONE,
                request: None,
                is_new: false,
            }),
            status: Mutex::new(LoopStatus {
                report: ServoReport::NONE,
                fault: None,
                millivolts: 0,
                is_stalled: false,
                is_hot: false,
                position_tolerance: i32::MAX.unsigned_abs(),
            }),
            found: Mutex::new(Found::NONE),
            lead: AtomicU16::new(0),
            raw_report: Mutex::new(RawReport::NONE),
            is_asked: AtomicBool::new(false),
        }
    }

    /// Current in the motor, or none. For the control tick, as the next two.
    pub fn energise(&self, on: bool) {
        self.orders.lock().is_on = on;
    }

    /// What the board measures: the temperature of the stage in 0.1 °C, and whether it can give no current; that takes it at once.
    pub fn set_stage(&self, temperature: i16, is_blocked: bool) {
        let mut orders = self.orders.lock();
        (orders.temperature, orders.is_blocked) = (temperature, is_blocked);
    }

    /// What the loops have published last.
    pub fn status(&self) -> LoopStatus {
        *self.status.lock()
    }

    pub(super) fn order(&self, order: &ServoOrder, at: u32) {
        self.orders.lock().order = Some((*order, at));
    }

    /// What masters have set and ask for. For the task of the dictionary, as the next one.
    pub fn set_up(&self, settings: ServoSettings, request: Option<Request>) {
        let mut set_up = self.set_up.lock();
        set_up.is_new |= request.is_some() || set_up.settings != settings;
        set_up.settings = settings;
        if request.is_some() {
            set_up.request = request;
        }
    }

    /// What a measurement has found.
    pub fn found(&self) -> Found {
        *self.found.lock()
    }

    /// The lead of a stepper's field in hundredths of a full step.
    pub fn lead(&self) -> u16 {
        self.lead.load(Ordering::Relaxed)
    }

    /// The last report of the loops of this axis, beside the actual values; they publish one from the first call on.
    pub fn loop_report(&self, data: &ServoData) -> LoopReport {
        self.is_asked.store(true, Ordering::Relaxed);
        let raw = *self.raw_report.lock();
        raw.report(data, self.found())
    }

    /// While the tasks have locked all of it.
    #[cfg(test)]
    pub(super) fn while_locked(&self, f: impl FnOnce()) {
        let _locked = (
            self.orders.lock(),
            self.set_up.lock(),
            self.status.lock(),
            self.found.lock(),
            self.raw_report.lock(),
        );
        f();
    }

    /// For the loops, as all that follows. Nothing is copied that is not asked for: that takes a part of its time.
    #[inline]
    pub(super) fn take_orders(&self, take: impl FnOnce(&Orders)) {
        if let Some(orders) = self.orders.try_lock() {
            take(&orders);
        }
    }

    /// What is set up, if that is new, or `again`.
    #[inline]
    pub(super) fn take_set_up(
        &self,
        again: bool,
        take: impl FnOnce(&ServoSettings, Option<Request>),
    ) {
        if let Some(mut set_up) = self.set_up.try_lock()
            && (again || set_up.is_new)
        {
            set_up.is_new = false;
            let request = set_up.request.take();
            take(&set_up.settings, request);
        }
    }

    #[inline]
    pub(super) fn publish(&self, lead: u16, status: impl FnOnce() -> LoopStatus) {
        if let Some(mut place) = self.status.try_lock() {
            *place = status();
        }
        self.lead.store(lead, Ordering::Relaxed);
    }

    /// Returns whether it is published: nobody else had it locked.
    #[inline]
    pub(super) fn publish_found(&self, found: &Found) -> bool {
        let place = self.found.try_lock();
        place.map(|mut place| *place = *found).is_some()
    }

    #[inline]
    pub(super) fn publish_raw_report(&self, report: impl FnOnce() -> RawReport) {
        if self.is_asked.load(Ordering::Relaxed)
            && let Some(mut place) = self.raw_report.try_lock()
        {
            *place = report();
        }
    }
}
