//! The transmit queue: what waits for the bus, lowest identifier first.
//!
//! Each communication object has its own place. Process data is replaced by newer data (in the transmit PDOs); emergency
//! messages and LSS answers keep their order, as do the answers of each SDO server, which wait there; of heartbeats there is one. The boot-up message goes
//! before everything, because it must be the first frame of all.

use heapless::Deque;

use super::objects::Streams;
use super::{NO_COB_ID, Node};
use crate::application::Application;
use crate::cia301::nmt::NmtState;
use crate::cia305;
use crate::od::Dictionary;
use crate::outbox::Pending;
use crate::settings::NodeId;
use crate::time::Instant;
use crate::wire::{Frame, cob_id};

/// Most LSS answers that wait. A master has one request in flight.
const MOST_LSS_ANSWERS: usize = 4;

/// What waits, beside emergency messages and PDOs, which wait with their producers.
#[derive(Debug)]
pub(super) struct TransmitQueue {
    /// The bits of [`waiting`].
    waiting: u8,
    lss: Deque<[u8; 8], MOST_LSS_ANSWERS>,
    /// The counter of the SYNC that waits.
    sync: Option<u8>,
    /// The TIME that waits.
    time: [u8; 6],
    overflows: u32,
}

/// What may wait, the lowest identifier in the lowest bit.
mod waiting {
    pub const BOOT_UP: u8 = 1 << 0;
    pub const ANSWER: u8 = 1 << 1;
    pub const HEARTBEAT: u8 = 1 << 2;
    pub const GUARDING: u8 = 1 << 3;
    pub const LSS: u8 = 1 << 4;
    pub const SYNC: u8 = 1 << 5;
    pub const TIME: u8 = 1 << 6;
    /// Both have identifiers that a master chooses.
    pub const TIMING: u8 = SYNC | TIME;
    /// Both have the identifier of error control.
    pub const ERROR_CONTROL: u8 = HEARTBEAT | GUARDING;
}

impl TransmitQueue {
    pub(super) const fn new() -> Self {
        Self {
            waiting: 0,
            lss: Deque::new(),
            sync: None,
            time: [0; 6],
            overflows: 0,
        }
    }

    /// Drops all but LSS answers, which belong to no NMT state.
    pub(super) fn clear(&mut self) {
        self.waiting &= waiting::LSS;
    }

    /// Whether an SDO server has something to send; it waits there.
    #[inline]
    pub(super) fn set_answers(&mut self, are_waiting: bool) {
        if are_waiting {
            self.waiting |= waiting::ANSWER;
        } else {
            self.waiting &= !waiting::ANSWER;
        }
    }

    pub(super) fn push_boot_up(&mut self) {
        self.waiting |= waiting::BOOT_UP;
    }

    pub(super) fn push_heartbeat(&mut self) {
        self.waiting |= waiting::HEARTBEAT;
    }

    /// A SYNC; one that still waits is left out.
    pub(super) fn push_sync(&mut self, counter: Option<u8>) {
        self.waiting |= waiting::SYNC;
        self.sync = counter;
    }

    /// A TIME; one that still waits is replaced.
    pub(super) fn push_time(&mut self, time: [u8; 6]) {
        self.waiting |= waiting::TIME;
        self.time = time;
    }

    /// The device produces no SYNC any more.
    pub(super) fn drop_sync(&mut self) {
        self.waiting &= !waiting::SYNC;
    }

    /// The device produces no TIME any more.
    pub(super) fn drop_time(&mut self) {
        self.waiting &= !waiting::TIME;
    }

    /// An answer to the guarding master, one for all questions that wait.
    pub(super) fn push_guarding(&mut self) {
        self.waiting |= waiting::GUARDING;
    }

    /// Heartbeats have taken over.
    pub(super) fn drop_guarding(&mut self) {
        self.waiting &= !waiting::GUARDING;
    }

    /// An SDO request is lost, as its answer has no room.
    pub(super) fn count_lost_request(&mut self) {
        self.overflows = self.overflows.saturating_add(1);
    }

    /// Adds an LSS answer; one that finds no room is lost, and counts.
    pub(super) fn push_lss(&mut self, answer: [u8; 8]) {
        self.waiting |= waiting::LSS;
        if self.lss.push_back(answer).is_err() {
            self.overflows = self.overflows.saturating_add(1);
        }
    }

    /// SDO requests and LSS answers that were lost because too many answers waited.
    pub(super) fn overflows(&self) -> u32 {
        self.overflows
    }

    fn has(&self, what: u8) -> bool {
        self.waiting & what != 0
    }

    /// The lowest identifier that waits, SDO and the boot-up message left out.
    fn pending(&self, node_id: NodeId) -> Option<u16> {
        if self.has(waiting::ERROR_CONTROL) {
            Some(cob_id::error_control(node_id))
        } else if self.has(waiting::LSS) {
            Some(cia305::RESPONSE_COB_ID)
        } else {
            None
        }
    }

    /// The oldest LSS answer, removed. Out of the way of what is sent often.
    #[cold]
    #[inline(never)]
    fn take_lss(&mut self) -> Option<Frame> {
        let answer = self.lss.pop_front();
        if self.lss.is_empty() {
            self.waiting &= !waiting::LSS;
        }
        answer.map(|answer| Frame::full(cia305::RESPONSE_COB_ID, answer))
    }
}

impl<D: Dictionary> Node<D> {
    /// The next frame to send, lowest identifier first; `None` when there is nothing.
    ///
    /// The segments of a block upload come from here one by one, so the application is asked for the next piece of an object
    /// that it streams. Call it when the CAN controller can take a frame, and [`Node::poll`] after it: the time for the answer to a
    /// sub-block begins there. A frame that the controller gives back (it was not sent, and
    /// one of higher priority shall go first) cannot be put back here.
    #[inline]
    pub fn transmit<A: Application<D>>(&mut self, application: &mut A) -> Option<Frame> {
        let may_wait = self.queue.waiting != 0
            || self.services.tpdos.is_pending()
            || self.services.emergency.is_pending();
        if may_wait && !self.is_mute {
            self.transmit_next(application)
        } else {
            None
        }
    }

    /// Drops synchronous PDOs whose SYNC window (1007h) is over at `now`, so that none leaves late: to be called before
    /// [`Node::transmit`] where [`Node::poll`] was not called for this moment, as frames that arrived before it still wait to be given.
    /// An event of transmission type 0 is kept for the next SYNC.
    #[inline]
    pub fn drop_late(&mut self, now: Instant) {
        if self.services.sync.is_window_over(now) {
            self.services.tpdos.window_passed();
        }
    }

    /// What [`Node::transmit`] would give now: a controller that has no room for it is better not asked to take it, as process data
    /// is replaced by newer data here. [`Outbox`](crate::Outbox) sees to that.
    pub fn pending(&self) -> Option<Pending> {
        if self.is_mute {
            return None;
        }
        if self.queue.has(waiting::BOOT_UP) {
            return Some(Pending {
                cob_id: cob_id::error_control(self.node_id),
                is_process_data: false,
            });
        }
        let emergency = self.services.emergency.pending().unwrap_or(NO_COB_ID);
        let pdo = self.services.tpdos.pending().unwrap_or(NO_COB_ID);
        let fixed = self.pending_fixed().unwrap_or(NO_COB_ID);
        let (cob_id, is_process_data) = if emergency <= pdo && emergency <= fixed {
            (emergency, false)
        } else if pdo <= fixed {
            (pdo, self.services.tpdos.is_pending_replaced())
        } else {
            let (timing, _) = self.pending_timing();
            (fixed, fixed == timing)
        };
        (cob_id != NO_COB_ID).then_some(Pending {
            cob_id,
            is_process_data,
        })
    }

    /// The SYNC of this device that [`Node::pending`] answers: what its controller holds must not be overtaken.
    pub fn follows(&self) -> Option<u16> {
        let sync = &self.services.sync;
        let tpdos = &self.services.tpdos;
        let is_pdo = || self.pending().map(|next| next.cob_id) == tpdos.pending();
        let follows = sync.is_producer() && tpdos.is_pending_synchronous() && is_pdo();
        follows.then_some(sync.cob_id())
    }

    #[inline(never)]
    fn transmit_next<A: Application<D>>(&mut self, application: &mut A) -> Option<Frame> {
        if self.queue.has(waiting::BOOT_UP) {
            self.queue.waiting &= !waiting::BOOT_UP;
            return Some(self.error_control(NmtState::Initialisation));
        }
        let is_pdo = self.services.tpdos.is_pending();
        let is_emergency = self.services.emergency.is_pending();
        // Mostly one thing waits.
        match (is_emergency, is_pdo, self.queue.waiting) {
            (false, false, waiting::ANSWER) => self.take_answer(application),
            (false, true, 0) => self.take_pdo(),
            (false, false, _) => self.take_fixed(application),
            (true, false, 0) => self.take_emergency(),
            _ => self.take_lowest(application),
        }
    }

    /// The PDO to send first; its inhibit time begins with the next [`Node::poll`].
    #[inline]
    fn take_pdo(&mut self) -> Option<Frame> {
        let frame = self.services.tpdos.take();
        self.services.values_changed |= self.services.tpdos.needs_time();
        frame
    }

    /// The emergency message that may leave first; [`Node::poll`] finds out when the next one may.
    #[inline]
    fn take_emergency(&mut self) -> Option<Frame> {
        self.services.timers_changed |= self.services.emergency.needs_time();
        self.services.emergency.take()
    }

    /// The frame with the lowest identifier, whatever it is. Of equals an emergency message goes first, then a PDO.
    #[inline(never)]
    fn take_lowest<A: Application<D>>(&mut self, application: &mut A) -> Option<Frame> {
        let or_none = |cob_id: Option<u16>| cob_id.unwrap_or(NO_COB_ID);
        let emergency = or_none(self.services.emergency.pending());
        let pdo = or_none(self.services.tpdos.pending());
        let fixed = or_none(self.pending_fixed());
        if emergency <= pdo && emergency <= fixed {
            self.take_emergency()
        } else if pdo <= fixed {
            self.take_pdo()
        } else {
            self.take_fixed(application)
        }
    }

    /// The lowest identifier of what waits beside emergency messages and PDOs.
    fn pending_fixed(&self) -> Option<u16> {
        let sdo = self.sdo.pending();
        let fixed = sdo.or_else(|| self.queue.pending(self.node_id));
        if self.queue.has(waiting::TIMING) {
            let (timing, _) = self.pending_timing();
            Some(fixed.map_or(timing, |fixed| timing.min(fixed)))
        } else {
            fixed
        }
    }

    /// The lower identifier of SYNC and TIME, of those that wait, and which it is.
    fn pending_timing(&self) -> (u16, u8) {
        let cob_id = |what, cob_id| {
            if self.queue.has(what) {
                cob_id
            } else {
                NO_COB_ID
            }
        };
        let sync = cob_id(waiting::SYNC, self.services.sync.cob_id());
        let time = cob_id(waiting::TIME, self.services.time.cob_id());
        if sync <= time {
            (sync, waiting::SYNC)
        } else {
            (time, waiting::TIME)
        }
    }

    /// SYNC or TIME waits, and something else perhaps. Seldom, compared to the others.
    #[cold]
    #[inline(never)]
    fn take_with_timing<A: Application<D>>(&mut self, application: &mut A) -> Option<Frame> {
        let (cob_id, which) = self.pending_timing();
        if Some(cob_id) > self.pending_fixed() {
            return self.take_answer_or_error_control(application);
        }
        self.queue.waiting &= !which;
        if which == waiting::SYNC {
            self.services.tpdos.follow_sync(false);
        }
        Some(match (which, self.queue.sync) {
            (waiting::TIME, _) => Frame::data_frame(cob_id, &self.queue.time),
            (_, Some(counter)) => Frame::data_frame(cob_id, &[counter]),
            (_, None) => Frame::data_frame(cob_id, &[]),
        })
    }

    /// What has identifiers other than emergency messages and PDOs.
    #[inline]
    fn take_fixed<A: Application<D>>(&mut self, application: &mut A) -> Option<Frame> {
        if (D::FEATURES.sync || D::FEATURES.time) && self.queue.has(waiting::TIMING) {
            self.take_with_timing(application)
        } else {
            self.take_answer_or_error_control(application)
        }
    }

    /// What an SDO server has to send. Out of line, so that process data leaves by a short way.
    #[inline(never)]
    fn take_answer<A: Application<D>>(&mut self, application: &mut A) -> Option<Frame> {
        let mut streams = Streams {
            dictionary: &self.dictionary,
            application,
        };
        let frame = self.sdo.transmit(&mut streams);
        if self.sdo.pending().is_none() {
            self.queue.set_answers(false);
        }
        if self.sdo.needs_time() {
            self.services.timers_changed = true;
        }
        frame
    }

    /// SDO, heartbeats and LSS answers, in the order of their identifiers: those above 700h are restricted to error control
    /// and LSS.
    fn take_answer_or_error_control<A: Application<D>>(
        &mut self,
        application: &mut A,
    ) -> Option<Frame> {
        if self.queue.has(waiting::ANSWER) {
            self.take_answer(application)
        } else if self.queue.has(waiting::HEARTBEAT) {
            self.queue.waiting &= !waiting::HEARTBEAT;
            Some(self.error_control(self.state))
        } else if self.queue.has(waiting::GUARDING) {
            self.queue.drop_guarding();
            let state = self.state as u8 | self.services.guarding.next_toggle();
            let cob_id = cob_id::error_control(self.node_id);
            Some(Frame::data_frame(cob_id, &[state]))
        } else {
            self.queue.take_lss()
        }
    }

    /// Boot-up message or heartbeat.
    fn error_control(&self, state: NmtState) -> Frame {
        Frame::data_frame(cob_id::error_control(self.node_id), &[state as u8])
    }
}
