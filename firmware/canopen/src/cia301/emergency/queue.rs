//! Emergency messages that wait: for a state that has them, for the inhibit time, then for the bus.
//!
//! ```text
//!   report ──► [ held back | released ] ──► transmit
//!                  ▲             │
//!                  └ inhibit ────┘   starts when the released message has left
//! ```

use super::Message;
use crate::time::{Duration, Instant, NEVER, has_come, with_length};
use crate::wire::Frame;
use crate::wire::cob_id::CobId;

/// Most messages that wait.
const MOST_MESSAGES: u8 = 16;

const _: () = assert!(
    MOST_MESSAGES.is_power_of_two(),
    "the numbers of messages wrap around at 256"
);

/// What the NMT state has of emergency messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Service {
    /// Communication has not begun, or the device has no node-ID: there are no messages, and none is kept.
    Absent,
    /// Messages wait for another state.
    Stopped,
    Running,
}

/// The queue of one emergency producer.
#[derive(Debug)]
pub(super) struct EmergencyQueue {
    /// A ring.
    messages: [Message; MOST_MESSAGES as usize],
    /// The number of the first one, counted on and on.
    first: u8,
    /// This many wait.
    waiting: u8,
    /// This many messages at the front may be sent.
    released: u8,
    service: Service,
    /// A message has left, and its inhibit time has not begun yet.
    has_left: bool,
    /// 0: switched off.
    cob_id: u16,
    /// 1015h in µs; 0 for none.
    inhibit_time: u32,
    /// Before this moment no message is released.
    inhibited_until: Instant,
    /// Messages that lost their room to newer ones.
    overflows: u32,
}

impl EmergencyQueue {
    pub(super) const fn new() -> Self {
        Self {
            messages: [Message::NO_ERROR; MOST_MESSAGES as usize],
            first: 0,
            waiting: 0,
            released: 0,
            service: Service::Absent,
            has_left: false,
            cob_id: 0,
            inhibit_time: 0,
            inhibited_until: Instant::from_ticks(0),
            overflows: 0,
        }
    }

    /// From 1014h. Messages that wait go out with the new identifier, or are dropped with an invalid one.
    pub(super) fn set_cob_id(&mut self, cob_id: CobId) {
        self.cob_id = match cob_id.is_valid() {
            true => cob_id.identifier(),
            false => 0,
        };
        if self.cob_id == 0 {
            self.clear();
        }
    }

    /// The identifier of the messages; 0 while the producer is switched off.
    pub(super) const fn cob_id(&self) -> u16 {
        self.cob_id
    }

    /// From 1015h, in µs; 0 for none. The new time counts from when the last message has left.
    pub(super) fn set_inhibit_time(&mut self, inhibit_time: u32) {
        let (old, new) = (span(self.inhibit_time), span(inhibit_time));
        self.inhibited_until = with_length(self.inhibited_until, old, new);
        self.inhibit_time = inhibit_time;
    }

    /// Whether messages keep a distance.
    #[inline]
    pub(super) const fn has_inhibit_time(&self) -> bool {
        self.inhibit_time != 0
    }

    /// Drops what waits.
    pub(super) fn clear(&mut self) {
        self.waiting = 0;
        self.released = 0;
    }

    /// The NMT state has emergency messages: what waits goes out, in its order.
    pub(super) fn start(&mut self, now: Instant) {
        self.service = Service::Running;
        self.release(now);
    }

    /// The NMT state has no emergency messages: what comes now waits for one that has.
    pub(super) fn stop(&mut self) {
        self.service = Service::Stopped;
    }

    /// Communication starts anew: what waits is dropped, and what comes before [`EmergencyQueue::start`] is not kept.
    pub(super) fn end(&mut self) {
        self.clear();
        self.service = Service::Absent;
    }

    /// What was released has not left, and waits with the others.
    pub(super) fn hold_back(&mut self) {
        self.released = 0;
    }

    /// Adds a message, unless the producer is switched off. The oldest one makes room for it in a full queue: the last
    /// message that the master gets always has the present error register.
    #[inline]
    pub(super) fn push(&mut self, message: Message, now: Instant) {
        if self.cob_id == 0 || self.service == Service::Absent {
            return;
        }
        if self.waiting == MOST_MESSAGES {
            self.drop_first();
            self.overflows = self.overflows.saturating_add(1);
        }
        let next = usize::from(self.first.wrapping_add(self.waiting) % MOST_MESSAGES);
        if let Some(place) = self.messages.get_mut(next) {
            *place = message;
        }
        self.waiting = self.waiting.wrapping_add(1);
        self.release(now);
    }

    fn drop_first(&mut self) {
        self.first = self.first.wrapping_add(1);
        self.waiting = self.waiting.saturating_sub(1);
        self.released = self.released.saturating_sub(1);
    }

    /// Lets the inhibit time pass.
    pub(super) fn poll(&mut self, now: Instant) {
        if core::mem::take(&mut self.has_left) {
            self.inhibited_until = now + span(self.inhibit_time);
        }
        self.release(now);
    }

    /// Releases what state and inhibit time allow.
    #[inline]
    fn release(&mut self, now: Instant) {
        if self.service != Service::Running {
            return;
        }
        if !self.has_inhibit_time() {
            self.released = self.waiting;
        } else if !self.is_released() && !self.has_left && has_come(self.inhibited_until, now) {
            self.released = u8::from(self.waiting != 0);
        }
    }

    /// When there will be more to release.
    pub(super) fn deadline(&self) -> Instant {
        if self.has_left {
            // The inhibit time begins with the next call.
            Instant::from_ticks(0)
        } else if self.service != Service::Running || self.is_released() || self.waiting == 0 {
            NEVER
        } else {
            self.inhibited_until
        }
    }

    /// Whether a message may be sent now. None waits while the producer is switched off.
    #[inline]
    pub(super) const fn is_released(&self) -> bool {
        self.released > 0
    }

    /// The message that may be sent now, removed.
    #[inline(always)]
    pub(super) fn take(&mut self) -> Option<Frame> {
        if !self.is_released() {
            return None;
        }
        self.has_left = self.has_inhibit_time();
        let first = usize::from(self.first % MOST_MESSAGES);
        let message = self.messages.get(first).copied()?;
        self.drop_first();
        Some(Frame::full(self.cob_id, message.0.to_le_bytes()))
    }

    /// Messages that lost their room since power-on.
    pub(super) fn overflows(&self) -> u32 {
        self.overflows
    }
}

fn span(microseconds: u32) -> Duration {
    Duration::from_ticks(microseconds.into())
}
