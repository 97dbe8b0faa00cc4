//! The holding brake: it is opened after the motor has current, and closed before the current is switched off.
//!
//! A brake opens and closes slowly. Transition 4 does not wait for it: the drive shows operation enabled at once, and its modes hold the
//! motor until the brake is open. The order to open comes 2040h:3 after the current, and the brake counts as open 2040h:1 after the
//! order. Where operation ends on a ramp, the motor keeps its current until the brake has closed (2040h:2 after the order); then follows
//! the transition that switches the current off. Where the current must go at once, brake and current are switched off together.

use canopen::{Duration, Instant};

use crate::configuration::BrakeTimes;

/// The brake.
#[derive(Debug)]
pub(crate) struct Brake {
    is_released: bool,
    /// When it was told so.
    since: Instant,
}

impl Brake {
    /// A brake that is closed.
    pub(crate) const fn new() -> Self {
        Self {
            is_released: false,
            since: Instant::from_ticks(0),
        }
    }

    /// It opens, or closes.
    pub(crate) fn set(&mut self, release: bool, now: Instant) {
        if self.is_released != release {
            self.is_released = release;
            self.since = now;
        }
    }

    /// Whether it is told to open.
    pub(crate) const fn is_released(&self) -> bool {
        self.is_released
    }

    /// Whether the motor may move.
    pub(crate) fn is_open(&self, times: BrakeTimes, now: Instant) -> bool {
        self.is_released && self.has_had(times.release, now)
    }

    /// Whether it holds the motor.
    pub(crate) fn is_closed(&self, times: BrakeTimes, now: Instant) -> bool {
        !self.is_released && self.has_had(times.engage, now)
    }

    fn has_had(&self, milliseconds: u16, now: Instant) -> bool {
        let time = Duration::from_ticks(u64::from(milliseconds) * 1000);
        now.checked_duration_since(self.since)
            .is_some_and(|passed| passed >= time)
    }
}

/// What keeps the motor from moving at power-on: the brake, and a rotor that is still drawn to its field.
#[derive(Debug)]
pub(crate) struct Brakes {
    /// The brake as the state machine wants it.
    pub(crate) wanted: Brake,
    /// The brake itself: 60FEh may want it otherwise.
    pub(crate) actual: Brake,
    /// From when on the rotor counts as aligned with the field, so that the motor may move.
    pub(crate) aligned_at: Instant,
    /// From when on the brake may open: so long the current needs to rise (2040h:3).
    pub(crate) may_open_at: Instant,
}

impl Brakes {
    /// Brakes that are closed.
    pub(crate) const fn new() -> Self {
        Self {
            wanted: Brake::new(),
            actual: Brake::new(),
            aligned_at: Instant::from_ticks(0),
            may_open_at: Instant::from_ticks(0),
        }
    }

    /// Whether the rotor is aligned with the field.
    pub(crate) fn is_rotor_aligned(&self, now: Instant) -> bool {
        now >= self.aligned_at
    }
}
