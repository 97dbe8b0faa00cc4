//! Receive PDOs (objects 1400h to 17FFh): from the bus into the dictionary.
//!
//! Transmission types 254 and 255 apply a frame when it arrives, 0 to 240 keep the newest one for the next SYNC. A frame
//! shorter than the mapping changes nothing (emergency 8210h), a longer one is applied with its first bytes (8220h). With a
//! deadline (sub-index 5, milliseconds) the next frame must come in time after the first one, or emergency 8250h tells of it.
//! Each PDO has its own errors, whose emergency names it; its own good frame, or a change of its parameters, ends them.
//!
//! The contract:
//! - A value that breaks the limits of its object, or that [`Application::validate`] refuses, leaves this object as it
//!   is; the other objects of the frame are applied. Nobody is told: a PDO has no answer.
//! - Every object is asked for before the first one changes, and [`Application::written`] is called after all of them
//!   have changed, in the order of the mapping.
//! - Two PDOs with the same COB-ID both get the frame, the lower number first.
//! - After the SYNC window (1007h) has passed, frames of synchronous PDOs are discarded until the next SYNC.
//! - Writing the parameter that is there changes nothing: a frame that waits for its SYNC goes on waiting.

use core::marker::PhantomData;
use core::ops::Range;

use super::mapping::{Direction, Mapped};
use super::parameters::{self, Parameters};
use super::receive_pdo::{Circumstances, ReceivePdo, Received};
use crate::application::Application;
use crate::cia301::error_report::ErrorReport;
use crate::cia301::sdo::AbortCode;
use crate::od::{Dictionary, Entry, Slots};
use crate::time::{Instant, NEVER, earlier};
use crate::wire::Frame;

/// The receive PDOs of a device; as many as there are places in `S`, the objects 1400h and up and their mappings. `M` are the
/// places for the objects of one mapping.
#[derive(Debug)]
pub struct Receive<S, M> {
    pdos: S,
    is_operational: bool,
    circumstances: Circumstances,
    /// Whether two PDOs have the same COB-ID.
    has_twins: bool,
    /// Whether a frame is for one PDO, if any: the device is Operational, and there are no twins.
    is_for_one: bool,
    /// Behind the last PDO that waits for SYNC.
    synchronous_end: u16,
    objects: PhantomData<M>,
}

impl<S: Slots<ReceivePdo<M>>, M: Slots<Mapped>> Receive<S, M> {
    /// No PDO is in use until [`Receive::configure_all`].
    pub const fn new() -> Self {
        Self {
            pdos: S::UNUSED,
            is_operational: false,
            circumstances: Circumstances {
                is_window_over: false,
                node_id: 0,
            },
            has_twins: false,
            is_for_one: false,
            synchronous_end: 0,
            objects: PhantomData,
        }
    }

    /// Takes all parameters from the dictionary, after power-on values were loaded; the device has this node-ID. Operational is
    /// left, and errors end: ask [`Receive::report`] afterwards.
    pub fn configure_all<D: Dictionary>(&mut self, dictionary: &D, node_id: u8) {
        self.circumstances.node_id = node_id;
        self.set_operational(false);
        for (number, pdo) in (0..).zip(self.pdos.as_mut()) {
            pdo.reset();
            pdo.configure(dictionary, Parameters::new(Direction::Receive, number));
        }
    }

    /// Operational is entered: PDOs are received from now on.
    pub fn enter_operational(&mut self) {
        self.set_operational(true);
    }

    fn set_operational(&mut self, is_operational: bool) {
        self.is_operational = is_operational;
        self.is_for_one = is_operational && !self.has_twins;
        self.circumstances.is_window_over = false;
    }

    /// Operational is left. Frames that wait for a SYNC are dropped, and no deadline runs.
    pub fn leave_operational(&mut self) {
        self.set_operational(false);
        for pdo in self.pdos.as_mut() {
            pdo.stop();
        }
    }

    /// Whether an entry of 1400h to 17FFh may get this value. Called when the value has passed the dictionary's own checks
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
        let places = pdo.map(ReceivePdo::places);
        Parameters::validate(Direction::Receive, dictionary, entry, value, places)
    }

    /// An entry of 1400h to 17FFh was written: the PDO follows from the next frame on. Ask [`Receive::report`] afterwards.
    pub fn written<D: Dictionary>(&mut self, dictionary: &D, entry: &Entry) {
        let number = parameters::number_of(entry);
        let Some(pdo) = self.pdos.as_mut().get_mut(number) else {
            return;
        };
        let parameters = Parameters::new(Direction::Receive, number as u16);
        if parameters.is_event_timer(entry) {
            pdo.set_deadline(parameters.event_timer(dictionary));
        } else {
            pdo.configure(dictionary, parameters);
        }
    }

    /// The identifiers that PDOs are received with, some perhaps more than once. They change with [`Receive::configure_all`]
    /// and [`Receive::written`] only.
    pub fn cob_ids(&self) -> impl Iterator<Item = u16> {
        let in_use = self.pdos.as_ref().iter().map(ReceivePdo::cob_id);
        in_use.filter(|cob_id| *cob_id != 0)
    }

    /// These places in RAM are looked at by event-driven transmit PDOs ([`super::Transmit::watched`]). To be called after
    /// [`Receive::configure_all`], [`Receive::written`] and their like of the transmit PDOs.
    pub fn watch(&mut self, places: &Range<u16>) {
        self.synchronous_end = 0;
        for (end, pdo) in (1..).zip(self.pdos.as_mut()) {
            pdo.watch(places);
            if pdo.is_synchronous() {
                self.synchronous_end = end;
            }
        }
        let mut rest = self.pdos.as_ref();
        self.has_twins = false;
        while let [pdo, others @ ..] = rest {
            let is_twin = |other: &ReceivePdo<M>| other.cob_id() == pdo.cob_id();
            self.has_twins |= pdo.cob_id() != 0 && others.iter().any(is_twin);
            rest = others;
        }
        self.is_for_one = self.is_operational && !self.has_twins;
    }

    /// A data frame with an 11-bit identifier arrived; `now` is when, and `is_late` tells whether the SYNC window is over then.
    /// Outside of Operational nothing is done.
    #[inline]
    pub fn receive<D: Dictionary, A: Application<D>>(
        &mut self,
        cob_id: u16,
        frame: &Frame,
        now: Instant,
        is_late: impl FnOnce() -> bool,
        dictionary: &mut D,
        application: &mut A,
    ) -> Received {
        if !self.is_for_one {
            self.circumstances.is_window_over |= is_late();
            return self.receive_by_twins(cob_id, frame, now, dictionary, application);
        }
        let mut pdos = self.pdos.as_mut().iter_mut();
        let Some(pdo) = pdos.find(|pdo| pdo.cob_id() == cob_id) else {
            return Received::NOTHING;
        };
        match pdo.receive_plain(frame, dictionary, application) {
            Some(received) => received,
            None => {
                self.circumstances.is_window_over |= is_late();
                pdo.receive(frame, now, &self.circumstances, dictionary, application)
            }
        }
    }

    /// Several PDOs may want the frame, or none.
    #[cold]
    #[inline(never)]
    fn receive_by_twins<D: Dictionary, A: Application<D>>(
        &mut self,
        cob_id: u16,
        frame: &Frame,
        now: Instant,
        dictionary: &mut D,
        application: &mut A,
    ) -> Received {
        let mut received = Received::NOTHING;
        if !self.is_operational {
            return received;
        }
        for pdo in self.pdos.as_mut() {
            if pdo.cob_id() == cob_id {
                let circumstances = &self.circumstances;
                received =
                    received.and(pdo.receive(frame, now, circumstances, dictionary, application));
            }
        }
        received
    }

    /// A SYNC arrived: what waited for it is applied. Returns whether transmit PDOs have to look for changes. Called after
    /// [`super::Transmit::on_sync`].
    #[inline]
    pub fn on_sync<D: Dictionary, A: Application<D>>(
        &mut self,
        dictionary: &mut D,
        application: &mut A,
    ) -> bool {
        self.circumstances.is_window_over = false;
        self.synchronous_end != 0 && self.apply_waiting(dictionary, application)
    }

    #[inline(never)]
    fn apply_waiting<D: Dictionary, A: Application<D>>(
        &mut self,
        dictionary: &mut D,
        application: &mut A,
    ) -> bool {
        // Outside of Operational nothing waits.
        let mut received = Received::NOTHING;
        let end = usize::from(self.synchronous_end);
        for pdo in self.pdos.as_mut().iter_mut().take(end) {
            received = received.and(pdo.on_sync(dictionary, application));
        }
        received.is_applied()
    }

    /// The SYNC window (1007h) has passed: frames of synchronous PDOs are discarded until the next SYNC.
    pub fn window_passed(&mut self) {
        self.circumstances.is_window_over = true;
    }

    /// Looks at the deadlines; returns the next one. Ask [`Receive::report`] afterwards. To be called again when a frame has
    /// brought news ([`Received::has_news`]), as a deadline may have begun.
    pub fn poll(&mut self, now: Instant) -> Instant {
        let mut next = NEVER;
        for pdo in self.pdos.as_mut() {
            pdo.poll(now);
            next = earlier(next, pdo.expires_at());
        }
        next
    }

    /// What the emergency producer has to hear, one at a time until `None`: the end of an error, then the error that has
    /// taken its place. The number of the PDO, from 1, is the info.
    pub fn report(&mut self) -> Option<ErrorReport> {
        let mut pdos = (1..).zip(self.pdos.as_mut());
        pdos.find_map(|(number, pdo)| pdo.report(number))
    }
}

impl<S: Slots<ReceivePdo<M>>, M: Slots<Mapped>> Default for Receive<S, M> {
    fn default() -> Self {
        Self::new()
    }
}
