//! Who gets a received frame: dispatch by identifier.
//!
//! Most frames on a bus are for others: a bit for each identifier tells ([`super::identifiers`]). What is for this device is served out of
//! line, the services that are used all the time first.

use super::Node;
use super::objects::{Objects, Streams};
use super::services::Services;
use crate::agenda::Object;
use crate::application::Application;
use crate::cia301::nmt::{Command, NmtState, Reset};
use crate::cia301::pdo::Received;
use crate::cia301::sync::Beat;
use crate::cia305::Identity;
use crate::od::{self, Dictionary};
use crate::time::Instant;
use crate::wire::sdo::Request;
use crate::wire::{Frame, cob_id};

impl<D: Dictionary> Node<D> {
    /// Takes a frame from the bus; `stamp` is when it arrived. Frames that are for others, and extended frames, do
    /// nothing.
    #[inline]
    pub fn receive<A: Application<D>>(
        &mut self,
        frame: &Frame,
        stamp: Instant,
        application: &mut A,
    ) {
        let Some(cob_id) = frame.standard_id() else {
            return;
        };
        if !self.identifiers.has(cob_id) {
            return;
        }
        if frame.is_remote() {
            self.receive_remote(cob_id, stamp);
        } else if let Some(server) = self.sdo.find(cob_id) {
            // Most frames of a long transfer are segments, and those have a way of their own.
            if let Some(request) = sdo_request::<D>(frame)
                && let request = &with_size::<D>(*request)
                && !(self.sdo.is_in_segments(server)
                    && self.receive_segment(server, request, stamp, application))
            {
                self.receive_request(server, request, stamp, application);
            }
        } else if cob_id == cob_id::NMT {
            self.receive_nmt(frame.payload(), stamp);
        } else if D::FEATURES.sync && cob_id == self.services.sync.cob_id() {
            self.receive_sync(frame, stamp, application);
        } else {
            self.receive_pdo(frame, stamp, application);
        }
    }

    /// Returns whether the frame is the next segment of a transfer, and served.
    #[inline(never)]
    fn receive_segment<A: Application<D>>(
        &mut self,
        server: usize,
        request: &[u8; 8],
        now: Instant,
        application: &mut A,
    ) -> bool {
        let mut streams = Streams {
            dictionary: &self.dictionary,
            application,
        };
        if self.services.agenda.is_mute {
            return false;
        }
        let agenda = &mut self.services.agenda;
        let deadline = self.sdo.pass(server, request, now, &mut streams, agenda);
        if let Some(deadline) = deadline {
            agenda.wake_at(deadline);
        }
        deadline.is_some()
    }

    #[inline(never)]
    fn receive_request<A: Application<D>>(
        &mut self,
        server: usize,
        request: &[u8; 8],
        now: Instant,
        application: &mut A,
    ) {
        // In the silence of a bit rate switch no answer could tell of what was done. An abort needs
        // none, and nothing of its transfer may be sent afterwards.
        if self.services.agenda.is_mute && self.is_switching(now) && !Request::is_abort(request) {
            return;
        }
        let Some((sdo, others)) = self.sdo.split(server) else {
            return;
        };
        let has_room = sdo.has_room();
        let mut objects = Objects {
            dictionary: &mut self.dictionary,
            application,
            services: &mut self.services,
            others,
            now,
            number: [0; 8],
        };
        if has_room {
            sdo.receive(request, now, &mut objects);
        } else if !sdo.receive_abort(request, &mut objects) {
            self.queue.count_lost_request();
            return;
        }
        if self.services.identifiers_changed {
            self.listen();
        }
        self.sdo.settle(server, &mut self.services.agenda);
    }

    #[cold]
    #[inline(never)]
    pub(super) fn receive_lss(&mut self, request: &[u8; 8], now: Instant) {
        let identity = Identity::of(&self.dictionary);
        let answer = if D::HABITS.lss_100_kbit && matches!(request, [0x13, 0, 5, ..]) {
            self.lss.configure_100_kbit(now)
        } else {
            self.lss.receive(request, &identity, now)
        };
        if let Some(answer) = answer {
            self.push_lss(answer);
        }
        let is_left = matches!(request, [0x04, 0x00, ..]);
        if D::HABITS.node_id_at_once && is_left && self.lss.has_new_node_id() {
            self.request_reset(Reset::Communication);
        }
        self.serve_lss_events();
        self.services.agenda.wake();
        self.services.agenda.is_mute = self.must_be_mute(now);
    }

    #[cold]
    #[inline(never)]
    fn receive_nmt(&mut self, payload: &[u8], now: Instant) {
        match Command::parse(payload, self.node_id) {
            Some(Command::Enter(state)) => {
                let is_told = D::HABITS.tells_its_state
                    && state != self.state
                    && !self.services.heartbeat.is_on();
                self.enter(state, now);
                if is_told {
                    self.services.agenda.set(Object::HEARTBEAT, true);
                }
                if state == NmtState::Stopped {
                    self.services.emergency.hold_back();
                    self.services.emergencies_changed();
                }
            }
            Some(Command::Reset(reset)) => self.request_reset(reset),
            None => {}
        }
    }

    #[inline(never)]
    fn receive_sync<A: Application<D>>(
        &mut self,
        frame: &Frame,
        now: Instant,
        application: &mut A,
    ) {
        if !self.services.sync.is_plain() || frame.length() != 0 {
            self.receive_timed_sync(frame, now, application);
        } else if self.state == NmtState::Operational {
            self.services
                .synchronise(Beat::PLAIN, &mut self.dictionary, application);
        }
    }

    /// A SYNC with a counter, a period or a window, one of another length, or one that another device must not send.
    #[inline(never)]
    fn receive_timed_sync<A: Application<D>>(
        &mut self,
        frame: &Frame,
        now: Instant,
        application: &mut A,
    ) {
        if self.services.sync.is_producer() {
            self.receive_other(self.services.sync.cob_id(), frame, now);
            return;
        }
        let [first, ..] = *frame.bytes();
        if let Some(beat) = self.services.sync.receive(frame.length(), first, now) {
            if self.state == NmtState::Operational {
                self.services
                    .synchronise(beat, &mut self.dictionary, application);
            }
            self.services.agenda.wake_at(self.services.sync.deadline());
        }
        if self.services.sync.has_report() {
            self.services.report_errors(&mut self.dictionary, now);
        }
    }

    /// A frame for a receive PDO, or for one of the services that are not used all the time.
    #[inline(never)]
    fn receive_pdo<A: Application<D>>(&mut self, frame: &Frame, now: Instant, application: &mut A) {
        let cob_id = frame.low_id();
        let Services { rpdos, sync, .. } = &mut self.services;
        // A frame may be given before time passes: its stamp counts.
        let is_late = || D::FEATURES.sync && sync.is_window_over(now);
        let dictionary = &mut self.dictionary;
        let received = rpdos.receive(cob_id, frame, now, is_late, dictionary, application);
        if received == Received::NOTHING {
            return self.receive_other(cob_id, frame, now);
        }
        if received.is_applied() {
            self.services.agenda.look();
        }
        if received.has_news() {
            // A deadline may have begun.
            self.services.agenda.wake();
            self.services.report_errors(&mut self.dictionary, now);
        }
    }
}

/// The request, with the size of its object where it indicates a smaller one and may.
#[inline(always)]
fn with_size<D: Dictionary>(request: [u8; 8]) -> [u8; 8] {
    /// An expedited download that indicates its size, and one that does not; where the size is.
    const SIZED: u8 = 0x23;
    const UNSIZED: u8 = 0x22;
    const UNUSED: u8 = 0x0C;
    let [command, low, high, sub, ref value @ ..] = request;
    if !D::HABITS.short_sizes || command & !UNUSED != SIZED {
        return request;
    }
    let indicated = 4 - u16::from(command >> 2 & 3);
    let entry = od::find::<D>(u16::from_le_bytes([low, high]), sub);
    match entry {
        Ok(entry) if indicated < entry.size() && entry.size() <= 4 => {
            let [a, b, c, d] = *value;
            [UNSIZED, low, high, sub, a, b, c, d]
        }
        _ => request,
    }
}

/// The eight bytes of an SDO request.
#[inline]
fn sdo_request<D: Dictionary>(frame: &Frame) -> Option<&[u8; 8]> {
    if D::HABITS.short_sdo_requests {
        Some(frame.bytes())
    } else {
        frame.full_payload()
    }
}
