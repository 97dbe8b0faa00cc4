//! One receive PDO: what it does with a frame.

use core::ops::Range;

use super::errors::Errors;
use super::mapping::{Direction, Mapped};
use super::multiplexed::{self, Addressing, Message};
use super::parameters::{Communication, Parameters};
use super::record::Record;
use crate::application::Application;
use crate::cia301::error_report::ErrorReport;
use crate::od::{Dictionary, Slots, Unused, check, put};
use crate::time::{Duration, Instant, NEVER, has_come};
use crate::wire::Frame;

/// What has become of a frame: a bit for each thing that has to be done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Received(u8);

impl Received {
    /// It is for nobody here.
    pub const NOTHING: Self = Self(0);
    /// It was for a PDO, and no event-driven transmit PDO has to look for changes.
    pub const KEPT: Self = Self(1 << 0);
    /// It was for a PDO, and transmit PDOs have to look for changes.
    pub const APPLIED: Self = Self(1 << 0 | 1 << 1);
    /// An error came or went, or a deadline has begun.
    const NEWS: Self = Self(1 << 2);

    /// Of two PDOs.
    pub(super) const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// The same, with news.
    const fn with_news(self, has_news: bool) -> Self {
        if has_news { self.and(Self::NEWS) } else { self }
    }

    /// Whether transmit PDOs have to look for changes.
    #[inline]
    pub const fn is_applied(self) -> bool {
        self.0 & 1 << 1 != 0
    }

    /// Whether [`super::Receive::report`] may have something to tell, or a deadline has begun.
    #[inline]
    pub const fn has_news(self) -> bool {
        self.0 & Self::NEWS.0 != 0
    }
}

/// What all receive PDOs share.
#[derive(Debug)]
pub(super) struct Circumstances {
    /// Whether it is too late for what belongs to the last SYNC.
    pub(super) is_window_over: bool,
    /// That of the device.
    pub(super) node_id: u8,
}

/// No frame has this length, the complement of [`ReceivePdo::plain_length`]. All of a PDO that is not in use is zero.
const NEVER_PLAIN: u8 = 0;

/// A deadline that has not begun.
const NOT_RUNNING: Instant = Instant::from_ticks(0);

/// One receive PDO; `M` is its place for mapped objects.
#[derive(Debug)]
pub struct ReceivePdo<M> {
    record: Record<M>,
    /// The complement of the length of a frame that is applied without a second thought: the PDO is event-driven, nobody waits for it, no object
    /// has limits, and no error stands. [`NEVER_PLAIN`] otherwise.
    plain_length: u8,
    /// Whether an object of it is in an event-driven transmit PDO.
    is_watched: bool,
    /// At which SYNC from now on `waiting` counts; 0 if nothing waits.
    syncs_left: u8,
    errors: Errors,
    /// As the emergency producer knows them.
    reported: Errors,
    /// The newest frame.
    waiting: [u8; 8],
    /// When the next frame must have come; 0 until the first one.
    expires_at: Instant,
}

impl<M: Slots<Mapped>> Unused for ReceivePdo<M> {
    const UNUSED: Self = Self {
        record: Record::NONE,
        plain_length: NEVER_PLAIN,
        is_watched: false,
        syncs_left: 0,
        errors: Errors::NONE,
        reported: Errors::NONE,
        waiting: [0; 8],
        expires_at: NOT_RUNNING,
    };
}

impl<M: Slots<Mapped>> ReceivePdo<M> {
    /// Takes its parameters from the dictionary. What waits, the errors and the deadline end if they are others than before.
    pub(super) fn configure<D: Dictionary>(&mut self, dictionary: &D, parameters: Parameters) {
        if self.record.configure(dictionary, parameters) {
            self.stop();
            self.errors = Errors::NONE;
            self.find_plain_length();
        }
    }

    /// The places for its objects.
    pub(super) fn places(&mut self) -> &mut [Mapped] {
        self.record.mapping.objects.as_mut()
    }

    fn find_plain_length(&mut self) {
        let is_plain = !self.record.is_synchronous()
            && self.addressing().is_none()
            && self.record.communication.event_timer == 0
            && self.errors == Errors::NONE
            && !self.record.mapping.is_limited();
        self.plain_length = if is_plain {
            !self.record.mapping.length()
        } else {
            NEVER_PLAIN
        };
    }

    /// These places in RAM are looked at by event-driven transmit PDOs.
    pub(super) fn watch(&mut self, places: &Range<u16>) {
        self.is_watched = self.record.mapping.writes(places);
    }

    /// Whether its frames wait for SYNC.
    pub(super) const fn is_synchronous(&self) -> bool {
        self.record.is_synchronous()
    }

    const fn addressing(&self) -> Option<Addressing> {
        self.record.mapping.addressing()
    }

    /// Forgets everything, but what the emergency producer has heard.
    pub(super) fn reset(&mut self) {
        self.record.communication = Communication::NONE;
        self.stop();
        self.errors = Errors::NONE;
        self.plain_length = NEVER_PLAIN;
    }

    /// A new deadline in milliseconds, 0 for none; it counts from the next frame on, as at the beginning (CiA 301, 7.5.2.35).
    pub(super) fn set_deadline(&mut self, time: u16) {
        if self.record.is_in_use() && time != self.record.communication.event_timer {
            self.record.communication.event_timer = time;
            self.expires_at = NOT_RUNNING;
            self.errors = self.errors.without(Errors::LATE);
            self.find_plain_length();
        }
    }

    /// Operational is left: what waits is dropped, and nothing is expected.
    pub(super) fn stop(&mut self) {
        self.syncs_left = 0;
        self.expires_at = NOT_RUNNING;
    }

    /// Its identifier; 0 when it is not in use.
    #[inline]
    pub(super) const fn cob_id(&self) -> u16 {
        self.record.cob_id()
    }

    /// When its deadline ends.
    pub(super) const fn expires_at(&self) -> Instant {
        if self.expires_at.ticks() == 0 {
            NEVER
        } else {
            self.expires_at
        }
    }

    /// Takes a frame that is applied without a second thought; `None` if this one is not.
    #[inline]
    pub(super) fn receive_plain<D: Dictionary, A: Application<D>>(
        &mut self,
        frame: &Frame,
        dictionary: &mut D,
        application: &mut A,
    ) -> Option<Received> {
        if !frame.length() != self.plain_length {
            return None;
        }
        let frame = frame.bytes();
        let refused = self.refused(0, frame, dictionary, application);
        Some(if refused == 0 {
            self.apply_all(frame, dictionary, application)
        } else {
            self.apply_accepted(refused, frame, dictionary, application)
        })
    }

    /// Takes a frame; after the SYNC window a synchronous PDO only notes that it came. One function for all PDOs: few of many frames
    /// get here.
    #[inline(never)]
    pub(super) fn receive<D: Dictionary, A: Application<D>>(
        &mut self,
        frame: &Frame,
        now: Instant,
        circumstances: &Circumstances,
        dictionary: &mut D,
        application: &mut A,
    ) -> Received {
        let before = self.errors;
        if frame.length() != self.record.mapping.length() {
            self.receive_other_length(frame.length());
            if self.errors.has(Errors::SHORT) {
                return Received::KEPT.with_news(self.errors != before);
            }
        } else if self.errors != Errors::NONE {
            self.end_errors();
        }
        let begins = self.record.communication.event_timer != 0 && self.restart_deadline(now);
        let received = if D::FEATURES.multiplexed_pdo
            && let Some(addressing) = self.addressing()
        {
            let node_id = circumstances.node_id;
            self.dispatch(addressing, node_id, frame.bytes(), dictionary, application);
            Received::APPLIED
        } else if !self.is_synchronous() {
            self.apply(frame.bytes(), dictionary, application)
        } else {
            if !circumstances.is_window_over {
                self.waiting = *frame.bytes();
                if !D::HABITS.receives_at_nth_sync {
                    self.syncs_left = 1;
                } else if self.syncs_left == 0 {
                    self.syncs_left = self.record.communication.transmission_type.every().max(1);
                }
            }
            Received::KEPT
        };
        received.with_news(begins || self.errors != before)
    }

    /// A good frame has come.
    #[cold]
    fn end_errors(&mut self) {
        // Whether its object is there shows when it is dispatched, and only if it is for this device.
        self.errors = if self.errors.has(Errors::NO_OBJECT) {
            Errors::NO_OBJECT
        } else {
            Errors::NONE
        };
        self.find_plain_length();
    }

    /// Looks at a frame that is not as long as the mapping.
    #[cold]
    #[inline(never)]
    fn receive_other_length(&mut self, length: u8) {
        self.errors = if length < self.record.mapping.length() {
            // It is not processed: a deadline that is missed stays so.
            self.errors.without(Errors::LONG).with(Errors::SHORT)
        } else {
            Errors::LONG
        };
        self.find_plain_length();
    }

    /// Returns whether it was not running.
    fn restart_deadline(&mut self, now: Instant) -> bool {
        let was_running = self.expires_at != NOT_RUNNING;
        let deadline = u32::from(self.record.communication.event_timer) * 1000;
        self.expires_at = now + Duration::from_ticks(deadline.into());
        !was_running
    }

    /// Looks at the deadline.
    pub(super) fn poll(&mut self, now: Instant) {
        if has_come(self.expires_at(), now) {
            self.expires_at = NOT_RUNNING;
            self.errors = self.errors.with(Errors::LATE);
            self.find_plain_length();
        }
    }

    /// A SYNC: the frame that waits is applied.
    #[inline]
    pub(super) fn on_sync<D: Dictionary, A: Application<D>>(
        &mut self,
        dictionary: &mut D,
        application: &mut A,
    ) -> Received {
        if self.syncs_left == 0 {
            return Received::NOTHING;
        }
        self.syncs_left = self.syncs_left.wrapping_sub(1);
        if D::HABITS.receives_at_nth_sync && self.syncs_left != 0 {
            return Received::NOTHING;
        }
        self.apply(&self.waiting, dictionary, application)
    }

    /// Writes the object that a frame names. If there is no such object the sender has to hear of it.
    #[cold]
    #[inline(never)]
    fn dispatch<D: Dictionary, A: Application<D>>(
        &mut self,
        addressing: Addressing,
        node_id: u8,
        frame: &[u8; 8],
        dictionary: &mut D,
        application: &mut A,
    ) {
        let message = Message::parse(frame);
        if message.addressing != addressing {
            return;
        }
        let is_for_us = message.node_id == 0 || message.node_id == node_id;
        let entry = match addressing {
            Addressing::Destination if !is_for_us => return,
            Addressing::Destination => {
                multiplexed::object::<D>(message.index, message.sub, Direction::Receive)
            }
            Addressing::Source => multiplexed::dispatch(dictionary, &message),
        };
        if let Some(entry) = entry {
            let length = usize::from(entry.size());
            let value = message.value.get(..length).unwrap_or(&message.value);
            if check(D::TABLE, entry, value).is_ok()
                && application.validate(dictionary, entry, value).is_ok()
            {
                put(dictionary, entry, value);
                application.written(dictionary, entry);
            }
        }
        let is_missing = entry.is_none() && addressing == Addressing::Destination;
        self.errors = if is_missing {
            self.errors.with(Errors::NO_OBJECT)
        } else {
            self.errors.without(Errors::NO_OBJECT)
        };
    }

    /// Copies the bytes of a frame into the mapped objects that take them.
    #[inline(never)]
    fn apply<D: Dictionary, A: Application<D>>(
        &self,
        frame: &[u8; 8],
        dictionary: &mut D,
        application: &mut A,
    ) -> Received {
        let refused = if self.record.mapping.is_limited() {
            let beyond = self.beyond_limits(frame, dictionary);
            self.refused(beyond, frame, dictionary, application)
        } else {
            self.refused(0, frame, dictionary, application)
        };
        if refused == 0 {
            self.apply_all(frame, dictionary, application)
        } else {
            self.apply_accepted(refused, frame, dictionary, application)
        }
    }

    /// Copies the bytes of a frame into all mapped objects.
    #[inline(always)]
    fn apply_all<D: Dictionary, A: Application<D>>(
        &self,
        frame: &[u8; 8],
        dictionary: &mut D,
        application: &mut A,
    ) -> Received {
        self.record.mapping.unpack(frame, dictionary);
        for object in self.record.mapping.objects() {
            if let Some(entry) = object.entry(D::TABLE) {
                application.written(dictionary, entry);
            }
        }
        if A::WRITES_BACK || self.is_watched {
            Received::APPLIED
        } else {
            Received::KEPT
        }
    }

    /// Which objects have limits that their values break: a bit for each, the first in bit 0.
    #[inline(never)]
    fn beyond_limits<D: Dictionary>(&self, frame: &[u8; 8], _: &D) -> u64 {
        let mut beyond = 0;
        let mut bit = 1_u64;
        for object in self.record.mapping.objects() {
            if let Some(entry) = object.entry(D::TABLE) {
                let mut room = [0; 8];
                let value = object.value(entry, frame, &mut room);
                if !object.is_within_limits(D::TABLE, entry, value) {
                    beyond |= bit;
                }
            }
            bit = bit.wrapping_add(bit);
        }
        beyond
    }

    /// Which objects do not take their value, those that break their limits and those that the application refuses. It is not
    /// asked about the former.
    #[inline]
    fn refused<D: Dictionary, A: Application<D>>(
        &self,
        beyond: u64,
        frame: &[u8; 8],
        dictionary: &D,
        application: &mut A,
    ) -> u64 {
        let mut refused = beyond;
        let mut bit = 1_u64;
        for object in self.record.mapping.objects() {
            if let Some(entry) = object.entry(D::TABLE)
                && beyond & bit == 0
            {
                let mut room = [0; 8];
                let value = object.value(entry, frame, &mut room);
                if application.validate(dictionary, entry, value).is_err() {
                    refused |= bit;
                }
            }
            bit = bit.wrapping_add(bit);
        }
        refused
    }

    /// Copies object by object, those that are refused left out.
    #[cold]
    #[inline(never)]
    fn apply_accepted<D: Dictionary, A: Application<D>>(
        &self,
        refused: u64,
        frame: &[u8; 8],
        dictionary: &mut D,
        application: &mut A,
    ) -> Received {
        let accepted = |number: u32| refused.wrapping_shr(number) & 1 == 0;
        for (number, object) in (0..).zip(self.record.mapping.objects()) {
            if accepted(number) {
                object.unpack(frame, dictionary);
            }
        }
        for (number, object) in (0..).zip(self.record.mapping.objects()) {
            if accepted(number)
                && let Some(entry) = object.entry(D::TABLE)
            {
                application.written(dictionary, entry);
            }
        }
        Received::APPLIED
    }

    /// What the emergency producer has to hear, one at a time: what is gone first. `number` is that of the PDO, from 1.
    pub(super) fn report(&mut self, number: u16) -> Option<ErrorReport> {
        if let Some(error) = self.reported.without(self.errors).first() {
            self.reported = self.reported.without(error);
            return Some(ErrorReport::Gone(error.emergency(number)));
        }
        let error = self.errors.without(self.reported).first()?;
        self.reported = self.reported.with(error);
        Some(ErrorReport::Appeared(error.emergency(number)))
    }
}
