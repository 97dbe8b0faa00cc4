//! Emergency messages that wait: for a state that has them, for the inhibit time, then for the bus.
//!
//! ```text
//!   report ──► [ held back | released ] ──► transmit
//!                  ▲             │
//!                  └ inhibit ────┘   starts when the last released message has left
//! ```

use heapless::Deque;

use crate::time::{Duration, Instant, NEVER, has_come, with_length};
use crate::wire::Frame;
use crate::wire::cob_id::CobId;

/// Most messages that wait.
const MOST_MESSAGES: usize = 16;

/// The queue of one emergency producer.
#[derive(Debug)]
pub(super) struct EmergencyQueue {
    messages: Deque<[u8; 8], MOST_MESSAGES>,
    /// This many messages at the front may be sent.
    released: u8,
    /// `None`: switched off.
    cob_id: Option<u16>,
    /// The NMT state has no emergency messages: none is released.
    is_stopped: bool,
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
            messages: Deque::new(),
            released: 0,
            cob_id: None,
            is_stopped: true,
            inhibit_time: 0,
            inhibited_until: Instant::from_ticks(0),
            overflows: 0,
        }
    }

    /// From 1014h. Messages that wait go out with the new identifier, or are dropped with an invalid one.
    pub(super) fn set_cob_id(&mut self, cob_id: CobId) {
        self.cob_id = cob_id.is_valid().then_some(cob_id.identifier());
        if self.cob_id.is_none() {
            self.clear();
        }
    }

    /// The identifier of the messages; `None` while the producer is switched off.
    pub(super) const fn cob_id(&self) -> Option<u16> {
        self.cob_id
    }

    /// From 1015h, in µs; 0 for none. The new time counts from when the last message has left.
    pub(super) fn set_inhibit_time(&mut self, inhibit_time: u32) {
        let (old, new) = (span(self.inhibit_time), span(inhibit_time));
        self.inhibited_until = with_length(self.inhibited_until, old, new);
        self.inhibit_time = inhibit_time;
    }

    /// Drops what waits.
    pub(super) fn clear(&mut self) {
        self.messages.clear();
        self.released = 0;
    }

    /// The NMT state has emergency messages: what waits goes out, in its order.
    pub(super) fn start(&mut self, now: Instant) {
        self.is_stopped = false;
        self.release(now);
    }

    /// The NMT state has no emergency messages: what comes now waits for one that has.
    pub(super) fn stop(&mut self) {
        self.is_stopped = true;
    }

    /// What was released has not left, and waits with the others.
    pub(super) fn hold_back(&mut self) {
        self.released = 0;
    }

    /// Adds a message, unless the producer is switched off. The oldest one makes room for it in a full queue: the last
    /// message that the master gets always has the present error register.
    #[inline(never)]
    pub(super) fn push(&mut self, message: [u8; 8], now: Instant) {
        if self.cob_id.is_none() {
            return;
        }
        if self.messages.is_full() {
            self.messages.pop_front();
            self.released = self.released.saturating_sub(1);
            self.overflows = self.overflows.saturating_add(1);
        }
        // There is room.
        let _ = self.messages.push_back(message);
        self.release(now);
    }

    /// Releases what state and inhibit time allow.
    pub(super) fn release(&mut self, now: Instant) {
        if self.is_stopped {
            return;
        }
        if self.inhibit_time == 0 {
            self.released = self.messages.len() as u8;
        } else if self.released == 0
            && !self.messages.is_empty()
            && has_come(self.inhibited_until, now)
        {
            self.released = 1;
        }
        if self.needs_time() {
            // It still waits for the bus: the inhibit time has not begun.
            self.inhibited_until = now + span(self.inhibit_time);
        }
    }

    /// Whether a message waits for the bus, and the inhibit time for it: [`EmergencyQueue::release`] is to be called again and again.
    pub(super) const fn needs_time(&self) -> bool {
        self.released > 0 && self.inhibit_time != 0
    }

    /// When there will be more to release.
    pub(super) fn deadline(&self) -> Instant {
        if self.is_stopped || self.released != 0 || self.messages.is_empty() {
            NEVER
        } else {
            self.inhibited_until
        }
    }

    /// Whether a message may be sent now. None waits while the producer is switched off.
    pub(super) const fn is_pending(&self) -> bool {
        self.released > 0
    }

    /// The message that may be sent now, removed.
    pub(super) fn take(&mut self) -> Option<Frame> {
        let cob_id = self.cob_id.filter(|_| self.released > 0)?;
        self.released = self.released.saturating_sub(1);
        let message = self.messages.pop_front()?;
        Some(Frame::full(cob_id, message))
    }

    /// Messages that lost their room since power-on.
    pub(super) fn overflows(&self) -> u32 {
        self.overflows
    }
}

fn span(microseconds: u32) -> Duration {
    Duration::from_ticks(microseconds.into())
}
