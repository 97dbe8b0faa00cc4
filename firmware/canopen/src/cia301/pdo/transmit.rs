//! Transmit PDOs (objects 1800h to 1BFFh): from the dictionary to the bus.
//!
//! | transmission type | sent |
//! |---|---|
//! | 0 | at the next SYNC after Operational is entered, or a mapped value has changed |
//! | 1 to 240 | at every n-th SYNC, counted from when Operational is entered or the PDO is changed |
//! | 252 | on request, with the values of the last SYNC |
//! | 253 | on request, with the present values |
//! | 254, 255 | when Operational is entered, when a mapped value has changed, and when the event timer runs out |
//!
//! Change is found by comparing: an application only has to put its values into the dictionary. The inhibit time
//! (multiples of 100 µs) spaces the transmissions of types 254 and 255, from when one has left, and wins over the event timer (milliseconds), which
//! starts anew with each transmission.
//!
//! A request is a remote frame with the COB-ID. The other types answer one too, if bit 30 of the COB-ID is 0: types 0 to 240
//! with what was last sampled, types 254 and 255 as after any other event.
//!
//! With a SYNC start value (sub-index 6) a PDO of type 1 to 240 is first sent at the SYNC with this counter, then at every n-th;
//! without counters in the SYNC it counts from the first one.
//!
//! A multiplexed PDO in source address mode sends every object of the scanner lists, one after the other, when Operational is
//! entered and when the event timer runs out; the application announces others in between ([`Transmit::announce`]). In
//! destination address mode the application alone makes its frames ([`Transmit::send_to`]).
//!
//! The contract:
//! - Each PDO has one place for what is to be sent. Newer data replaces older data that has not been taken yet, so a slow
//!   bus gets fewer PDOs, never old ones. Lower identifiers are taken first.
//! - When the SYNC window (1007h) has passed, synchronous PDOs that have not been taken are dropped; an event of type 0 is
//!   kept for the next SYNC.
//! - Writing the parameter that is there changes nothing: no PDO is sent for it, no time starts anew, no event is lost.
//! - With another parameter a PDO starts anew. An inhibit time that runs goes on, as the bus load it limits does not begin
//!   anew; a new one counts from the last transmission on.

use core::marker::PhantomData;
use core::ops::Range;

use super::mapping::{Direction, Mapped, around};
use super::multiplexed::{self, Addressing, Message};
use super::parameters::{self, Parameters};
use super::transmit_pdo::{TransmitPdo, Watch};
use crate::agenda::{Agenda, Object, Word};
use crate::cia301::sdo::AbortCode;
use crate::od::{Dictionary, Entry, Slots};
use crate::time::{Instant, NEVER, earlier};
use crate::wire::Frame;

/// Why a multiplexed PDO is not sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum NotSent {
    /// No transmit PDO of this kind is valid, or the device is not Operational.
    NoPdo,
    /// The object is not in the scanner lists (1FA0h to 1FCFh), cannot be sent, or there is no such node.
    NotListed,
    /// The message before has not left yet, or the inhibit time runs: try again.
    Busy,
}

/// The transmit PDOs of a device; as many as there are places in `S`, the objects 1800h and up and their
/// mappings. `M` are the places for the objects of one mapping.
#[derive(Debug)]
pub struct Transmit<S, M> {
    pdos: S,
    is_operational: bool,
    /// How many are looked at when values may have changed or time has passed, and how many wait for SYNC: none outside of Operational.
    watching: u16,
    synchronous: u16,
    /// That of the device.
    node_id: u8,
    objects: PhantomData<M>,
}

impl<S: Slots<TransmitPdo<M>>, M: Slots<Mapped>> Transmit<S, M> {
    /// No PDO is in use until [`Transmit::configure_all`].
    pub const fn new() -> Self {
        Self {
            pdos: S::UNUSED,
            is_operational: false,
            watching: 0,
            synchronous: 0,
            node_id: 0,
            objects: PhantomData,
        }
    }

    /// Takes all parameters from the dictionary, after power-on values were loaded; the device has this node-ID. Operational is
    /// left.
    pub fn configure_all<D: Dictionary>(
        &mut self,
        dictionary: &D,
        node_id: u8,
        agenda: &mut Agenda<impl Slots<Word>>,
    ) {
        self.is_operational = false;
        self.node_id = node_id;
        for (number, pdo) in (0..).zip(self.pdos.as_mut()) {
            pdo.reset(Object::pdo(number.into()), agenda);
            pdo.configure(
                dictionary,
                Parameters::new(Direction::Transmit, number),
                agenda,
            );
        }
        self.count();
    }

    /// Counts who looks at what.
    #[inline(never)]
    fn count(&mut self) {
        (self.watching, self.synchronous) = (0, 0);
        if !self.is_operational {
            return;
        }
        for pdo in self.pdos.as_ref() {
            let is_watched = pdo.watch() != Watch::No;
            self.watching = self.watching.saturating_add(is_watched.into());
            let is_synchronous = pdo.is_synchronous();
            self.synchronous = self.synchronous.saturating_add(is_synchronous.into());
        }
    }

    /// The places in RAM that event-driven PDOs look at for changes, as one range.
    pub fn watched(&self) -> Range<u16> {
        let pdos = self.pdos.as_ref().iter();
        let (start, end) = pdos.fold((0, 0), |range, pdo| around(range, pdo.watched()));
        start..end
    }

    /// Operational is entered: counters and timers start, and each PDO of type 254 or 255 is sent once. Nothing happens when
    /// it is Operational already.
    pub fn enter_operational<D: Dictionary>(
        &mut self,
        dictionary: &D,
        now: Instant,
        agenda: &mut Agenda<impl Slots<Word>>,
    ) {
        if self.is_operational {
            return;
        }
        self.is_operational = true;
        self.count();
        for pdo in self.pdos.as_mut() {
            pdo.start(dictionary, now, agenda);
        }
    }

    /// Operational is left. What waits to be sent is dropped.
    pub fn leave_operational(&mut self, agenda: &mut Agenda<impl Slots<Word>>) {
        self.is_operational = false;
        self.count();
        for pdo in self.pdos.as_mut() {
            pdo.stop(agenda);
        }
    }

    /// Whether an entry of 1800h to 1BFFh may get this value. Called when the value has passed the dictionary's own checks
    /// (access, length, limits); nothing changes.
    ///
    /// # Errors
    /// CiA 301's rules for PDO parameters: 06090030h for a COB-ID, transmission type or time, 06010000h for a mapping
    /// that is in use, 06020000h, 06090011h, 06040041h, 06040042h for what cannot be mapped.
    pub fn validate<D: Dictionary>(
        &mut self,
        dictionary: &D,
        entry: &Entry,
        value: &[u8],
    ) -> Result<(), AbortCode> {
        let number = parameters::number_of(entry);
        let pdo = self.pdos.as_mut().get_mut(number);
        let places = pdo.map(TransmitPdo::places);
        Parameters::validate(Direction::Transmit, dictionary, entry, value, places)
    }

    /// An entry of 1800h to 1BFFh was written. A new event timer starts now; with another change the PDO starts anew, as if
    /// Operational was entered (if it is). The value that was there already changes nothing.
    pub fn written<D: Dictionary>(
        &mut self,
        dictionary: &D,
        entry: &Entry,
        now: Instant,
        agenda: &mut Agenda<impl Slots<Word>>,
    ) {
        let number = parameters::number_of(entry);
        let Some(pdo) = self.pdos.as_mut().get_mut(number) else {
            return;
        };
        let parameters = Parameters::new(Direction::Transmit, number as u16);
        if parameters.is_event_timer(entry) {
            pdo.set_event_timer::<D>(parameters.event_timer(dictionary), now);
            self.count();
            return;
        }
        if !pdo.configure(dictionary, parameters, agenda) {
            return;
        }
        if self.is_operational {
            pdo.start(dictionary, now, agenda);
        }
        self.count();
    }

    /// A SYNC arrived, with this counter if it has one: the synchronous PDOs that are due take the present values. Called before
    /// [`super::Receive::on_sync`].
    pub fn on_sync<D: Dictionary>(
        &mut self,
        counter: Option<u8>,
        dictionary: &D,
        agenda: &mut Agenda<impl Slots<Word>>,
    ) {
        let mut left = self.synchronous;
        if left == 0 {
            return;
        }
        for pdo in self.pdos.as_mut() {
            if !pdo.is_synchronous() {
                continue;
            }
            pdo.on_sync(counter, dictionary, agenda);
            left = left.saturating_sub(1);
            if left == 0 {
                break;
            }
        }
    }

    /// The SYNC window (1007h) has passed: synchronous PDOs that have not been taken are dropped.
    pub fn window_passed(&mut self, agenda: &mut Agenda<impl Slots<Word>>) {
        for pdo in self.pdos.as_mut() {
            pdo.window_passed(agenda);
        }
    }

    /// A remote frame with an 11-bit identifier arrived; `now` is when.
    #[cold]
    #[inline(never)]
    pub fn on_request<D: Dictionary>(
        &mut self,
        cob_id: u16,
        dictionary: &D,
        now: Instant,
        agenda: &mut Agenda<impl Slots<Word>>,
    ) {
        if !self.is_operational {
            return;
        }
        for pdo in self.pdos.as_mut() {
            if pdo.cob_id() == cob_id {
                pdo.on_request(dictionary, now, agenda);
            }
        }
    }

    /// The identifiers that PDOs are sent with, some perhaps more than once. They change with [`Transmit::configure_all`] and
    /// [`Transmit::written`] only.
    pub fn cob_ids(&self) -> impl Iterator<Item = u16> {
        let in_use = self.pdos.as_ref().iter().map(TransmitPdo::cob_id);
        in_use.filter(|cob_id| *cob_id != 0)
    }

    /// Whether a change of a value, or time, may cause one to be sent.
    #[inline]
    pub const fn is_watching(&self) -> bool {
        self.watching != 0
    }

    /// Looks for changes and timers that have run out. Called whenever values may have changed; returns when it wants to be
    /// called again at the latest.
    pub fn poll<D: Dictionary>(
        &mut self,
        dictionary: &D,
        now: Instant,
        agenda: &mut Agenda<impl Slots<Word>>,
    ) -> Instant {
        let mut left = self.watching;
        let mut deadline = NEVER;
        if left == 0 {
            return deadline;
        }
        for pdo in self.pdos.as_mut() {
            match pdo.watch() {
                Watch::No => continue,
                Watch::Plain => pdo.look(dictionary, now, agenda),
                Watch::Closely => {
                    let next = pdo.look_closely(dictionary, self.node_id, now, agenda);
                    deadline = earlier(deadline, next);
                }
            }
            left = left.saturating_sub(1);
            if left == 0 {
                break;
            }
        }
        deadline
    }

    /// Sends an object of the scanner lists by the PDO in source address mode.
    ///
    /// # Errors
    /// It is not sent, and why.
    pub fn announce<D: Dictionary>(
        &mut self,
        index: u16,
        sub: u8,
        dictionary: &D,
        now: Instant,
        agenda: &mut Agenda<impl Slots<Word>>,
    ) -> Result<(), NotSent> {
        if !D::FEATURES.multiplexed_pdo {
            return Err(NotSent::NoPdo);
        }
        let entry = multiplexed::object::<D>(index, sub, Direction::Transmit)
            .filter(|entry| multiplexed::is_scanned(dictionary, entry.index, entry.sub))
            .ok_or(NotSent::NotListed)?;
        let message = Message {
            addressing: Addressing::Source,
            node_id: self.node_id,
            index,
            sub,
            value: multiplexed::bytes_of(dictionary, entry),
        };
        self.send(&message, now, agenda)
    }

    /// Sends a value to an object of another node (1 to 127), or of all of them (0), by the PDO in destination address mode.
    ///
    /// # Errors
    /// It is not sent, and why.
    pub fn send_to(
        &mut self,
        node_id: u8,
        index: u16,
        sub: u8,
        value: [u8; 4],
        now: Instant,
        agenda: &mut Agenda<impl Slots<Word>>,
    ) -> Result<(), NotSent> {
        if node_id > 127 {
            return Err(NotSent::NotListed);
        }
        let message = Message {
            addressing: Addressing::Destination,
            node_id,
            index,
            sub,
            value,
        };
        self.send(&message, now, agenda)
    }

    /// Sends a message by the first PDO of its kind.
    fn send(
        &mut self,
        message: &Message,
        now: Instant,
        agenda: &mut Agenda<impl Slots<Word>>,
    ) -> Result<(), NotSent> {
        let mut pdos = self.pdos.as_mut().iter_mut();
        let pdo = pdos
            .find(|pdo| pdo.addressing() == Some(message.addressing))
            .filter(|_| self.is_operational)
            .ok_or(NotSent::NoPdo)?;
        if !pdo.send(message, now, agenda) {
            return Err(NotSent::Busy);
        }
        Ok(())
    }

    /// How many there are, in use or not.
    pub(crate) fn len(&self) -> usize {
        self.pdos.as_ref().len()
    }

    /// The frame of a PDO that waits; its place is empty afterwards.
    #[inline]
    pub fn take(&mut self, number: usize, agenda: &mut Agenda<impl Slots<Word>>) -> Option<Frame> {
        let pdo = self.pdos.as_mut().get_mut(number)?;
        Some(pdo.take(agenda))
    }
}

impl<S: Slots<TransmitPdo<M>>, M: Slots<Mapped>> Default for Transmit<S, M> {
    fn default() -> Self {
        Self::new()
    }
}
