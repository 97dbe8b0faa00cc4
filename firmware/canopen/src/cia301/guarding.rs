//! Node guarding and life guarding (CiA 301, 7.2.8.3.2.1; objects 100Ch and 100Dh), the older way of error control.
//!
//! The master asks each node with a remote frame on 700h + node-ID. The answer is one byte: the NMT state, and in bit 7 a toggle
//! that begins with 0 and changes with every answer. A node whose life time (guard time 100Ch in ms times life time factor 100Dh) passes
//! without a question has lost its master.
//!
//! The contract:
//! - A device that produces heartbeats is not guarded: it answers no question, and a life time ends.
//! - The life time counts from the first question on; the next question after a loss ends the error.
//! - The toggle starts anew with communication (reset communication), and not with 1017h.

use crate::od::{self, Dictionary};
use crate::time::{Duration, Instant, NEVER, has_come};

/// Index of the guard time, in ms.
pub const GUARD_TIME: u16 = 0x100C;
/// Index of the life time factor.
pub const LIFE_TIME_FACTOR: u16 = 0x100D;

/// What is known of the master.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Life {
    /// It has not asked yet.
    Unknown,
    /// It asks in time.
    Guarded,
    /// It has ceased to ask.
    Lost,
}

/// The guarded side of guarding.
#[derive(Debug)]
pub struct Guarding {
    /// In ms; 0: life guarding is switched off.
    life_time: u32,
    /// When the master is lost, while it guards.
    deadline: Instant,
    life: Life,
    toggle: u8,
}

impl Guarding {
    const TOGGLE: u8 = 0x80;

    /// Not guarded, without a life time until [`Guarding::configure`].
    pub const fn new() -> Self {
        Self {
            life_time: 0,
            deadline: Instant::from_ticks(0),
            life: Life::Unknown,
            toggle: 0,
        }
    }

    /// Takes its parameters after power-on values were loaded. An error that stands is for the caller to clear.
    pub fn configure<D: Dictionary>(&mut self, dictionary: &D) {
        *self = Self {
            life_time: life_time(dictionary),
            ..Self::new()
        };
    }

    /// 100Ch or 100Dh was written: a life time that runs starts anew. Returns whether an error ends because life guarding was
    /// switched off.
    pub fn written<D: Dictionary>(&mut self, dictionary: &D, now: Instant) -> bool {
        self.life_time = life_time(dictionary);
        if self.life_time == 0 {
            return self.stop();
        }
        if self.life == Life::Guarded {
            self.restart(now);
        }
        false
    }

    /// Heartbeats take over, or there is no life time any more. Returns whether an error ends with it.
    pub fn stop(&mut self) -> bool {
        let is_lost = self.life == Life::Lost;
        self.life = Life::Unknown;
        is_lost
    }

    /// The master asks. Returns whether this ends an error.
    pub fn ask(&mut self, now: Instant) -> bool {
        if self.life_time == 0 {
            return false;
        }
        let is_lost = self.life == Life::Lost;
        self.life = Life::Guarded;
        self.restart(now);
        is_lost
    }

    fn restart(&mut self, now: Instant) {
        self.deadline = now + Duration::from_ticks(u64::from(self.life_time) * 1000);
    }

    /// The toggle bit of the answer that leaves now.
    pub fn next_toggle(&mut self) -> u8 {
        let toggle = self.toggle;
        self.toggle ^= Self::TOGGLE;
        toggle
    }

    /// Lets time pass; returns whether the master has just been lost.
    pub fn poll(&mut self, now: Instant) -> bool {
        let is_over = has_come(self.deadline(), now);
        if is_over {
            self.life = Life::Lost;
        }
        is_over
    }

    /// [`Guarding::poll`] has nothing to do before this moment.
    pub const fn deadline(&self) -> Instant {
        match self.life {
            Life::Guarded => self.deadline,
            Life::Unknown | Life::Lost => NEVER,
        }
    }
}

impl Default for Guarding {
    fn default() -> Self {
        Self::new()
    }
}

fn life_time<D: Dictionary>(dictionary: &D) -> u32 {
    let guard_time = od::fixed::<D, GUARD_TIME, 0>(dictionary).unwrap_or(0);
    let factor = od::fixed::<D, LIFE_TIME_FACTOR, 0>(dictionary).unwrap_or(0);
    guard_time.saturating_mul(factor)
}
