//! One receive PDO: what it does with a frame.

use super::NOT_IN_USE;
use super::errors::Errors;
use super::mapping::{Direction, Layout};
use super::multiplexed::{self, Addressing, Message};
use super::parameters::{Parameters, TransmissionType};
use super::unpack::{Destination, Unpacking};
use crate::application::Application;
use crate::cia301::length_error::LengthReport;
use crate::od::{Dictionary, Slots, Unused, check, put};
use crate::time::{Duration, Instant, NEVER, has_come};
use crate::wire::Frame;

/// What a frame does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// It is applied when it comes.
    Event,
    /// It waits for SYNC.
    Synchronous,
    /// It says which object it is for, which is written when it comes.
    Multiplexed(Addressing),
}

impl Kind {
    const fn new(transmission_type: TransmissionType) -> Self {
        match transmission_type {
            TransmissionType::Multiplexed(addressing) => Self::Multiplexed(addressing),
            other if other.is_synchronous() => Self::Synchronous,
            _ => Self::Event,
        }
    }
}

/// One receive PDO; `M` is its place for mapped objects.
#[derive(Debug)]
pub struct ReceivePdo<M> {
    /// Its identifier, or [`NOT_IN_USE`].
    cob_id: u16,
    kind: Kind,
    /// Whether `waiting` is a frame for the next SYNC.
    is_waiting: bool,
    errors: Errors,
    /// As the emergency producer knows them.
    reported: Errors,
    /// That of the device.
    node_id: u8,
    mapping: Unpacking<M>,
    /// The newest frame.
    waiting: [u8; 8],
    /// Longest time between two frames; zero for any.
    deadline: Duration,
    /// When the next frame must have come; [`NEVER`] until the first one.
    expires_at: Instant,
}

impl<M: Slots<Destination>> Unused for ReceivePdo<M> {
    const UNUSED: Self = Self {
        cob_id: NOT_IN_USE,
        kind: Kind::Event,
        is_waiting: false,
        errors: Errors::NONE,
        reported: Errors::NONE,
        node_id: 0,
        mapping: Unpacking::NOTHING,
        waiting: [0; 8],
        deadline: Duration::from_ticks(0),
        expires_at: NEVER,
    };
}

impl<M: Slots<Destination>> ReceivePdo<M> {
    /// Takes its parameters from the dictionary. What waits, the errors and the deadline end if they are others than before.
    pub(super) fn configure<D: Dictionary>(
        &mut self,
        dictionary: &D,
        parameters: Parameters,
        node_id: u8,
    ) {
        let mut next = Self::UNUSED;
        next.node_id = node_id;
        next.take_parameters(dictionary, parameters);
        let is_same = next.cob_id == self.cob_id
            && next.kind == self.kind
            && next.deadline == self.deadline
            && next.mapping == self.mapping;
        if !is_same {
            next.reported = self.reported;
            *self = next;
        }
    }

    /// For a PDO that has just been made.
    fn take_parameters<D: Dictionary>(&mut self, dictionary: &D, parameters: Parameters) {
        let (Some(cob_id), Some(transmission_type), Ok(mapping)) = (
            parameters.identifier(dictionary),
            parameters.transmission_type(dictionary),
            parameters.resolve::<D, Unpacking<M>>(dictionary),
        ) else {
            return;
        };
        if mapping.length() > 0
            && let Some(transmission_type) = transmission_type.with(mapping.addressing())
        {
            self.cob_id = cob_id;
            self.kind = Kind::new(transmission_type);
            self.mapping = mapping;
            self.deadline = milliseconds(parameters.event_timer(dictionary));
        }
    }

    /// Forgets everything, but what the emergency producer has heard.
    pub(super) fn reset(&mut self) {
        *self = Self {
            reported: self.reported,
            ..Self::UNUSED
        };
    }

    /// A new deadline in milliseconds, 0 for none; it counts from the next frame on, as at the beginning (CiA 301, 7.5.2.35).
    pub(super) fn set_deadline(&mut self, time: u32) {
        let deadline = milliseconds(time);
        if deadline != self.deadline {
            self.deadline = deadline;
            self.expires_at = NEVER;
            self.errors = self.errors.without(Errors::LATE);
        }
    }

    /// Operational is left: what waits is dropped, and nothing is expected.
    pub(super) fn stop(&mut self) {
        self.is_waiting = false;
        self.expires_at = NEVER;
    }

    /// Its identifier; above 7FFh when it is not in use.
    #[inline]
    pub(super) const fn cob_id(&self) -> u16 {
        self.cob_id
    }

    /// Whether the emergency producer has to hear of a change.
    #[inline]
    pub(super) const fn has_report(&self) -> bool {
        self.errors.without(self.reported).first().is_some()
            || self.reported.without(self.errors).first().is_some()
    }

    /// When its deadline ends.
    pub(super) const fn expires_at(&self) -> Instant {
        self.expires_at
    }

    /// Takes a frame; after the SYNC window a synchronous PDO only notes that it came. Returns whether there is news: an error came or went, or a deadline has begun that was not running. One
    /// function for all PDOs: few of many frames get here.
    #[inline(never)]
    pub(super) fn receive<D: Dictionary, A: Application<D>>(
        &mut self,
        frame: &Frame,
        now: Instant,
        is_window_over: bool,
        dictionary: &mut D,
        application: &mut A,
    ) -> bool {
        let mut has_news = false;
        if frame.length() != self.mapping.length() {
            has_news = self.receive_other_length(frame.length());
            if self.errors.has(Errors::SHORT) {
                return has_news;
            }
        } else if self.errors != Errors::NONE {
            self.errors = Errors::NONE;
            has_news = true;
        }
        if self.deadline.ticks() != 0 {
            has_news |= self.restart_deadline(now);
        }
        match self.kind {
            Kind::Event => self.apply(frame.bytes(), dictionary, application),
            Kind::Synchronous if is_window_over => {}
            Kind::Synchronous => {
                self.waiting = *frame.bytes();
                self.is_waiting = true;
            }
            Kind::Multiplexed(addressing) => {
                has_news |= self.dispatch(addressing, frame.bytes(), dictionary, application);
            }
        }
        has_news
    }

    /// Looks at a frame that is not as long as the mapping. Returns whether an error came or went.
    #[cold]
    #[inline(never)]
    fn receive_other_length(&mut self, length: u8) -> bool {
        let before = self.errors;
        self.errors = if length < self.mapping.length() {
            // It is not processed: a deadline that is missed stays so.
            before.without(Errors::LONG).with(Errors::SHORT)
        } else {
            Errors::LONG
        };
        self.errors != before
    }

    /// Returns whether it was not running.
    fn restart_deadline(&mut self, now: Instant) -> bool {
        let was_running = self.expires_at.ticks() != NEVER.ticks();
        self.expires_at = Instant::from_ticks(now.ticks().saturating_add(self.deadline.ticks()));
        !was_running
    }

    /// Looks at the deadline; returns whether it has been missed just now.
    pub(super) fn poll(&mut self, now: Instant) -> bool {
        let is_late = has_come(self.expires_at, now);
        if is_late {
            self.expires_at = NEVER;
            self.errors = self.errors.with(Errors::LATE);
        }
        is_late
    }

    /// A SYNC: the frame that waits is applied. Returns whether there was one.
    #[inline]
    pub(super) fn on_sync<D: Dictionary, A: Application<D>>(
        &mut self,
        dictionary: &mut D,
        application: &mut A,
    ) -> bool {
        let is_waiting = self.is_waiting;
        if is_waiting {
            self.is_waiting = false;
            self.apply(&self.waiting, dictionary, application);
        }
        is_waiting
    }

    /// Writes the object that a frame names. Returns whether there is none, and the sender has to hear of it.
    #[cold]
    #[inline(never)]
    fn dispatch<D: Dictionary, A: Application<D>>(
        &mut self,
        addressing: Addressing,
        frame: &[u8; 8],
        dictionary: &mut D,
        application: &mut A,
    ) -> bool {
        let message = Message::parse(frame);
        if message.addressing != addressing {
            return false;
        }
        let is_for_us = message.node_id == 0 || message.node_id == self.node_id;
        let entry = match addressing {
            Addressing::Destination if !is_for_us => return false,
            Addressing::Destination => {
                multiplexed::object::<D>(message.index, message.sub, Direction::Receive)
            }
            Addressing::Source => multiplexed::dispatch(dictionary, &message),
        };
        if let Some(entry) = entry {
            let length = usize::from(entry.size);
            let value = message.value.get(..length).unwrap_or(&message.value);
            if check(D::TABLE, entry, value).is_ok()
                && application.validate(dictionary, entry, value).is_ok()
            {
                put(dictionary, entry, value);
                application.written(dictionary, entry);
            }
            return false;
        }
        if addressing == Addressing::Destination {
            self.errors = self.errors.with(Errors::NO_OBJECT);
        }
        addressing == Addressing::Destination
    }

    /// Copies the bytes of a frame into the mapped objects.
    fn apply<D: Dictionary, A: Application<D>>(
        &self,
        frame: &[u8; 8],
        dictionary: &mut D,
        application: &mut A,
    ) {
        let refused = self.refused(frame, dictionary, application);
        if refused != 0 {
            self.apply_accepted(refused, frame, dictionary, application);
            return;
        }
        self.mapping.unpack(frame, dictionary);
        for object in self.mapping.objects() {
            if let Some(entry) = object.entry(D::TABLE) {
                application.written(dictionary, entry);
            }
        }
    }

    /// Which objects do not take their value: a bit for each, the first in bit 0.
    fn refused<D: Dictionary, A: Application<D>>(
        &self,
        frame: &[u8; 8],
        dictionary: &D,
        application: &mut A,
    ) -> u64 {
        let mut refused = 0;
        let mut bit = 1_u64;
        for object in self.mapping.objects() {
            let is_accepted = object.entry(D::TABLE).is_some_and(|entry| {
                object.is_within_limits(D::TABLE, entry, frame)
                    && application
                        .validate(dictionary, entry, object.value(entry, frame).bytes())
                        .is_ok()
            });
            if !is_accepted {
                refused |= bit;
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
    ) {
        let accepted = |number: u32| refused.wrapping_shr(number) & 1 == 0;
        for (number, object) in (0..).zip(self.mapping.objects()) {
            if accepted(number) {
                object.put(frame, dictionary);
            }
        }
        for (number, object) in (0..).zip(self.mapping.objects()) {
            if accepted(number)
                && let Some(entry) = object.entry(D::TABLE)
            {
                application.written(dictionary, entry);
            }
        }
    }

    /// What the emergency producer has to hear, one at a time: what is gone first. `number` is that of the PDO, from 1.
    pub(super) fn report(&mut self, number: u16) -> Option<LengthReport> {
        if let Some(error) = self.reported.without(self.errors).first() {
            self.reported = self.reported.without(error);
            return Some(LengthReport::Gone(error.emergency(number)));
        }
        let error = self.errors.without(self.reported).first()?;
        self.reported = self.reported.with(error);
        Some(LengthReport::Appeared(error.emergency(number)))
    }
}

fn milliseconds(time: u32) -> Duration {
    Duration::from_ticks(u64::from(time).saturating_mul(1000))
}
