//! What leaves: the frames of whatever waits, lowest identifier first.
//!
//! Each communication object has its own place. Process data is replaced by newer data (in the transmit PDOs); emergency
//! messages and LSS answers keep their order, as do the answers of each SDO server, which wait there; of heartbeats there is one. Who goes
//! first is in the [agenda](crate::agenda).

use heapless::Deque;

use super::Node;
use super::objects::Streams;
use crate::agenda::{Kind, Object};
use crate::application::Application;
use crate::cia301::nmt::NmtState;
use crate::cia305;
use crate::od::Dictionary;
use crate::outbox::{Pending, Sender};
use crate::time::Instant;
use crate::wire::{Frame, cob_id};

/// Most LSS answers that wait. A master has one request in flight.
const MOST_LSS_ANSWERS: usize = 4;

/// What waits, beside emergency messages, PDOs and SDO answers, which wait with their producers.
#[derive(Debug)]
pub(super) struct TransmitQueue {
    lss: Deque<[u8; 8], MOST_LSS_ANSWERS>,
    /// The counter of the SYNC that waits.
    pub(super) sync: Option<u8>,
    /// The TIME that waits.
    pub(super) time: [u8; 6],
    overflows: u32,
}

impl TransmitQueue {
    pub(super) const fn new() -> Self {
        Self {
            lss: Deque::new(),
            sync: None,
            time: [0; 6],
            overflows: 0,
        }
    }

    /// An SDO request is lost, as its answer has no room.
    pub(super) fn count_lost_request(&mut self) {
        self.overflows = self.overflows.saturating_add(1);
    }

    /// SDO requests and LSS answers that were lost because too many answers waited.
    pub(super) fn overflows(&self) -> u32 {
        self.overflows
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
        let first = self.services.agenda.first()?;
        self.take_first(first, application)
    }

    /// The frame of what [`Node::pending`] has just given.
    pub fn take<A: Application<D>>(
        &mut self,
        next: &Pending,
        application: &mut A,
    ) -> Option<Frame> {
        self.take_first(Object::of(next), application)
    }

    #[inline]
    fn take_first<A: Application<D>>(
        &mut self,
        first: Object,
        application: &mut A,
    ) -> Option<Frame> {
        match first.kind(self.services.tpdos.len()) {
            Kind::Pdo(number) => self.services.tpdos.take(number, &mut self.services.agenda),
            Kind::Answer(number) => self.take_answer(number, application),
            Kind::Service if first == Object::EMERGENCY => self.take_emergency(),
            Kind::Service => self.take_seldom(first),
        }
    }

    /// Drops synchronous PDOs whose SYNC window (1007h) is over at `now`, so that none leaves late: to be called before
    /// [`Node::transmit`] where [`Node::poll`] was not called for this moment, as frames that arrived before it still wait to be given.
    /// An event of transmission type 0 is kept for the next SYNC.
    #[inline]
    pub fn drop_late(&mut self, now: Instant) {
        if D::FEATURES.sync && self.services.sync.is_window_over(now) {
            let services = &mut self.services;
            services.tpdos.window_passed(&mut services.agenda);
        }
    }

    /// What leaves next. A controller that has no room for it is better not asked to take it, as process data is replaced by newer data
    /// here; [`Node::take`] gives its frame. [`Outbox`](crate::Outbox) sees to that.
    pub fn pending(&self) -> Option<Pending> {
        self.services.agenda.pending()
    }

    /// The emergency message that may leave.
    #[inline(never)]
    fn take_emergency(&mut self) -> Option<Frame> {
        let message = self.services.emergency.take();
        self.services.emergencies_changed();
        message
    }

    /// The frame of what has one place, or a queue of its own.
    #[inline(never)]
    fn take_seldom(&mut self, first: Object) -> Option<Frame> {
        let (services, queue) = (&mut self.services, &mut self.queue);
        let error_control = cob_id::error_control(self.node_id);
        let mut is_last = true;
        let frame = match first {
            Object::SYNC => match queue.sync {
                Some(counter) => Frame::data_frame(services.sync.cob_id(), &[counter]),
                None => Frame::data_frame(services.sync.cob_id(), &[]),
            },
            Object::TIME => Frame::data_frame(services.time.cob_id(), &queue.time),
            Object::LSS => {
                let answer = queue.lss.pop_front();
                is_last = queue.lss.is_empty();
                Frame::full(cia305::RESPONSE_COB_ID, answer.unwrap_or_default())
            }
            Object::GUARDING => {
                let state = self.state as u8 | services.guarding.next_toggle();
                Frame::data_frame(error_control, &[state])
            }
            Object::BOOT_UP => Frame::data_frame(error_control, &[NmtState::Initialisation as u8]),
            _ => Frame::data_frame(error_control, &[self.state as u8]),
        };
        if is_last {
            services.agenda.set(first, false);
        }
        Some(frame)
    }

    /// What an SDO server has to send. Out of line, so that process data leaves by a short way.
    #[inline(never)]
    fn take_answer<A: Application<D>>(
        &mut self,
        number: usize,
        application: &mut A,
    ) -> Option<Frame> {
        match self.sdo.answer(number, &mut self.services.agenda) {
            None if D::FEATURES.block_transfer => self.take_segment(number, application),
            answer => answer,
        }
    }

    /// The next segment of a block upload.
    #[inline(never)]
    fn take_segment<A: Application<D>>(
        &mut self,
        number: usize,
        application: &mut A,
    ) -> Option<Frame> {
        let mut streams = Streams {
            dictionary: &self.dictionary,
            application,
        };
        self.sdo
            .segment(number, &mut streams, &mut self.services.agenda)
    }

    /// Adds an LSS answer; one that finds no room is lost, and counts.
    pub(super) fn push_lss(&mut self, answer: [u8; 8]) {
        if self.queue.lss.push_back(answer).is_err() {
            self.queue.count_lost_request();
        }
        self.services.agenda.set(Object::LSS, true);
    }
}

/// A node with its application.
impl<D: Dictionary, A: Application<D>> Sender for (&mut Node<D>, &mut A) {
    fn pending(&self) -> Option<Pending> {
        self.0.pending()
    }

    fn take(&mut self, next: &Pending) -> Option<Frame> {
        self.0.take(next, self.1)
    }
}
