//! SYNC and TIME: what the whole network does at the same moment, and what time it is.

use super::Node;
use crate::agenda::Object;
use crate::application::Application;
use crate::cia301::nmt::NmtState;
use crate::cia301::sync::Due;
use crate::cia301::time_stamp::TimeOfDay;
use crate::od::Dictionary;
use crate::time::Instant;

impl<D: Dictionary> Node<D> {
    /// A SYNC is due, or missed, or its window is over.
    #[inline(never)]
    pub(super) fn serve_sync<A: Application<D>>(&mut self, now: Instant, application: &mut A) {
        while let Some(due) = self.services.sync.poll(now) {
            match due {
                Due::Produce(beat) => {
                    self.queue.sync = beat.counter;
                    self.services.agenda.set(Object::SYNC, true);
                    if self.state == NmtState::Operational {
                        self.services
                            .synchronise(beat, &mut self.dictionary, application);
                    }
                }
                Due::WindowOver => self.services.window_over(),
                Due::Missed => self.services.report_errors(&mut self.dictionary, now),
            }
        }
    }

    /// The device produces no SYNC any more, or has none in this state: one that waits is void.
    pub(super) fn drop_sync(&mut self) {
        self.services.agenda.set(Object::SYNC, false);
    }

    /// Whether a SYNC was followed since the last call, received or produced: synchronous PDOs have been sampled and applied. There is none
    /// outside of Operational.
    pub fn take_sync(&mut self) -> bool {
        core::mem::take(&mut self.services.synced)
    }

    /// A frame with the identifier of TIME; `false` if this device does not take it.
    pub(super) fn receive_time(&mut self, cob_id: u16, payload: &[u8], now: Instant) -> bool {
        let is_taken = self.services.time.is_consumer() && cob_id == self.services.time.cob_id();
        if is_taken && self.state.has_sync_and_time() {
            self.services.time.receive(payload, now);
        }
        is_taken
    }

    /// The time of day, as TIME or [`Node::set_time_of_day`] have told it; `None` before the first of them.
    pub fn time_of_day(&self, now: Instant) -> Option<TimeOfDay> {
        self.services.time.get(now)
    }

    /// It is this time of day at `now`: the firmware has a clock.
    pub fn set_time_of_day(&mut self, time: TimeOfDay, now: Instant) {
        self.services.time.set(time, now);
    }

    /// Sends the time of day to the network. Returns whether it will be sent: bit 30 of 1012h makes the device a producer, the NMT
    /// state has TIME, and the time of day is known.
    pub fn send_time_of_day(&mut self, now: Instant) -> bool {
        if !self.services.time.is_producer() || !self.state.has_sync_and_time() {
            return false;
        }
        let time = self.services.time.get(now);
        if let Some(time) = time {
            self.queue.time = time.to_bytes();
            self.services.agenda.set(Object::TIME, true);
        }
        time.is_some()
    }
}
