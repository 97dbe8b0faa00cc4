//! Receive PDOs (objects 1400h to 17FFh): from the bus into the dictionary.
//!
//! Transmission types 254 and 255 apply a frame when it arrives, 0 to 240 keep the newest one for the next SYNC. A frame
//! shorter than the mapping changes nothing (emergency 8210h), a longer one is applied with its first bytes (8220h). Each
//! PDO has its own error, whose emergency names it; its own good frame, or a change of its parameters, ends it.
//!
//! The contract:
//! - A value that breaks the limits of its object, or that [`Application::validate`] refuses, leaves this object as it
//!   is; the other objects of the frame are applied. Nobody is told: a PDO has no answer.
//! - Every object is asked for before the first one changes, and [`Application::written`] is called after all of them
//!   have changed, in the order of the mapping.
//! - Two PDOs with the same COB-ID both get the frame, the lower number first.

use super::NOT_IN_USE;
use super::copy_plan::CopyPlan;
use super::mapping::{Direction, Mapping};
use super::parameters::{Parameters, TransmissionType};
use crate::application::Application;
use crate::cia301::emergency::{Emergency, ErrorRegister};
use crate::cia301::length_error::LengthReport;
use crate::cia301::sdo::AbortCode;
use crate::od::{Dictionary, Entry, Slots, Unused, check, put};
use crate::wire::Frame;

/// The receive PDOs of a device; as many as there are places in `S`, the objects 1400h and up and their
/// mappings.
#[derive(Debug)]
pub struct Receive<S> {
    pdos: S,
    is_operational: bool,
    /// Whether a length error is not as the emergency producer knows it.
    lengths_changed: bool,
}

impl<S: Slots<ReceivePdo>> Receive<S> {
    /// No PDO is in use until [`Receive::configure_all`].
    pub fn new() -> Self {
        Self {
            pdos: S::unused(),
            is_operational: false,
            lengths_changed: false,
        }
    }

    /// Takes all parameters from the dictionary, after power-on values were loaded. Operational is left, and length
    /// errors end: ask [`Receive::length_report`] afterwards.
    pub fn configure_all<D: Dictionary>(&mut self, dictionary: &D) {
        self.is_operational = false;
        self.lengths_changed = true;
        for (number, pdo) in (0..).zip(self.pdos.as_mut()) {
            pdo.configure(dictionary, Parameters::new(Direction::Receive, number));
        }
    }

    /// Operational is entered: PDOs are received from now on.
    pub fn enter_operational(&mut self) {
        self.is_operational = true;
    }

    /// Operational is left. Frames that wait for a SYNC are dropped.
    pub fn leave_operational(&mut self) {
        self.is_operational = false;
        for pdo in self.pdos.as_mut() {
            pdo.waiting = None;
        }
    }

    /// Whether an entry of 1400h to 17FFh may get this value. Called when the value has passed the dictionary's own checks
    /// (access, length, limits); nothing changes.
    ///
    /// # Errors
    /// CiA 301's rules for PDO parameters: 06090030h for a COB-ID, transmission type or time, 06010000h for a mapping
    /// that is in use, 06020000h, 06090011h, 06040041h, 06040042h for what cannot be mapped.
    pub fn validate<D: Dictionary>(
        &self,
        dictionary: &D,
        entry: &Entry,
        value: &[u8],
    ) -> Result<(), AbortCode> {
        match Parameters::of(Direction::Receive, entry.index) {
            Some((parameters, record)) if parameters.number() < self.pdos.as_ref().len() => {
                parameters.validate(dictionary, record, entry, value)
            }
            _ => Err(AbortCode::NoObject),
        }
    }

    /// An entry of 1400h to 17FFh was written: the PDO follows from the next frame on. Ask
    /// [`Receive::length_report`] afterwards.
    pub fn written<D: Dictionary>(&mut self, dictionary: &D, entry: &Entry) {
        let Some((parameters, _)) = Parameters::of(Direction::Receive, entry.index) else {
            return;
        };
        if let Some(pdo) = self.pdos.as_mut().get_mut(parameters.number()) {
            self.lengths_changed |= pdo.length_error.is_some();
            pdo.configure(dictionary, parameters);
        }
    }

    /// The identifiers of the PDOs in use.
    pub fn cob_ids(&self) -> impl Iterator<Item = u16> {
        let cob_ids = self.pdos.as_ref().iter().map(|pdo| pdo.cob_id);
        cob_ids.filter(|cob_id| *cob_id != NOT_IN_USE)
    }

    /// A frame with an 11-bit identifier arrived. Returns whether it was for a PDO: values of the dictionary may have
    /// changed, and [`Receive::length_report`] may have something to tell. Remote frames, and every frame outside of
    /// Operational, do nothing.
    #[inline]
    pub fn receive<D: Dictionary, A: Application<D>>(
        &mut self,
        cob_id: u16,
        frame: &Frame,
        dictionary: &mut D,
        application: &mut A,
    ) -> bool {
        let mut is_taken = false;
        if self.is_operational && !frame.is_remote() {
            for pdo in self.pdos.as_mut() {
                if pdo.cob_id == cob_id {
                    self.lengths_changed |= pdo.receive(frame, dictionary, application);
                    is_taken = true;
                }
            }
        }
        is_taken
    }

    /// A SYNC arrived: what waited for it is applied. Returns whether something has waited: values of the dictionary
    /// may have changed. Called after [`super::Transmit::on_sync`].
    pub fn on_sync<D: Dictionary, A: Application<D>>(
        &mut self,
        dictionary: &mut D,
        application: &mut A,
    ) -> bool {
        let mut is_applied = false;
        if self.is_operational {
            for pdo in self.pdos.as_mut() {
                if let Some(bytes) = pdo.waiting.take() {
                    pdo.apply(&bytes, dictionary, application);
                    is_applied = true;
                }
            }
        }
        is_applied
    }

    /// Whether [`Receive::length_report`] may have something to tell.
    pub const fn has_length_report(&self) -> bool {
        self.lengths_changed
    }

    /// What the emergency producer has to hear, one at a time until `None`: the end of an error, then the error that has
    /// taken its place. The number of the PDO, from 1, is the info.
    pub fn length_report(&mut self) -> Option<LengthReport> {
        if !self.lengths_changed {
            return None;
        }
        for (number, pdo) in (1..).zip(self.pdos.as_mut()) {
            if pdo.length_error == pdo.reported_error {
                continue;
            }
            if let Some(error) = pdo.reported_error.take() {
                return Some(LengthReport::Gone(error.emergency(number)));
            }
            if let Some(error) = pdo.length_error {
                pdo.reported_error = Some(error);
                return Some(LengthReport::Appeared(error.emergency(number)));
            }
        }
        self.lengths_changed = false;
        None
    }
}

impl<S: Slots<ReceivePdo>> Default for Receive<S> {
    fn default() -> Self {
        Self::new()
    }
}

/// How the last frame of a PDO did not fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum LengthError {
    Short,
    Long,
}

impl LengthError {
    /// The emergency error code (CiA 301 table 26).
    const fn code(self) -> u16 {
        match self {
            // PDO not processed due to length error.
            Self::Short => 0x8210,
            // PDO length exceeded.
            Self::Long => 0x8220,
        }
    }

    fn emergency(self, number: u16) -> Emergency {
        let [low, high] = number.to_le_bytes();
        Emergency {
            code: self.code(),
            register: ErrorRegister::COMMUNICATION,
            info: [low, high, 0, 0, 0],
        }
    }
}

/// One receive PDO.
#[derive(Debug)]
pub struct ReceivePdo {
    /// Its identifier, or [`NOT_IN_USE`].
    cob_id: u16,
    is_synchronous: bool,
    mapping: Mapping,
    plan: CopyPlan,
    /// The newest frame that waits for a SYNC.
    waiting: Option<[u8; 8]>,
    length_error: Option<LengthError>,
    /// As the emergency producer knows it.
    reported_error: Option<LengthError>,
}

impl Unused for ReceivePdo {
    const UNUSED: Self = Self::new();
}

impl ReceivePdo {
    const fn new() -> Self {
        Self {
            cob_id: NOT_IN_USE,
            is_synchronous: false,
            mapping: Mapping::new(),
            plan: CopyPlan::new(),
            waiting: None,
            length_error: None,
            reported_error: None,
        }
    }

    fn configure<D: Dictionary>(&mut self, dictionary: &D, parameters: Parameters) {
        *self = Self {
            reported_error: self.reported_error,
            ..Self::new()
        };
        let (Some(cob_id), Some(transmission_type), Ok(mapping)) = (
            parameters.identifier(dictionary),
            parameters.transmission_type(dictionary),
            parameters.resolve(dictionary),
        ) else {
            return;
        };
        if mapping.length > 0 {
            self.cob_id = cob_id;
            self.is_synchronous = transmission_type != TransmissionType::Event;
            self.plan = CopyPlan::of(&mapping);
            self.mapping = mapping;
        }
    }

    /// Takes a frame; returns whether the length error changed. One function for all PDOs: few of many frames get here.
    #[inline(never)]
    fn receive<D: Dictionary, A: Application<D>>(
        &mut self,
        frame: &Frame,
        dictionary: &mut D,
        application: &mut A,
    ) -> bool {
        let length_error = match frame.length() {
            length if length == self.mapping.length => None,
            length if length < self.mapping.length => Some(LengthError::Short),
            _ => Some(LengthError::Long),
        };
        if length_error != Some(LengthError::Short) {
            if self.is_synchronous {
                self.waiting = Some(*frame.bytes());
            } else {
                self.apply(frame.bytes(), dictionary, application);
            }
        }
        let changed = self.length_error != length_error;
        self.length_error = length_error;
        changed
    }

    /// Copies the bytes of a frame into the mapped objects.
    fn apply<D: Dictionary, A: Application<D>>(
        &self,
        frame: &[u8; 8],
        dictionary: &mut D,
        application: &mut A,
    ) {
        let refused = self.refused(frame, dictionary, application);
        if refused == 0 {
            self.plan.unpack(frame, dictionary.ram_mut());
        } else {
            self.put_accepted(refused, frame, dictionary);
        }
        let mut refused = refused;
        for object in &self.mapping.objects {
            if refused & 1 == 0 {
                application.written(dictionary, object.entry);
            }
            refused >>= 1;
        }
    }

    /// Which objects do not take their value: a bit for each, the first in bit 0.
    fn refused<D: Dictionary, A: Application<D>>(
        &self,
        frame: &[u8; 8],
        dictionary: &D,
        application: &mut A,
    ) -> u8 {
        let mut refused = 0;
        let mut bit = 1_u8;
        for object in &self.mapping.objects {
            let value = object.value(frame);
            let is_accepted = (!object.is_limited || check(D::TABLE, object.entry, value).is_ok())
                && application
                    .validate(dictionary, object.entry, value)
                    .is_ok();
            if !is_accepted {
                refused |= bit;
            }
            bit = bit.wrapping_shl(1);
        }
        refused
    }

    /// Copies object by object, those that are refused left out.
    #[cold]
    fn put_accepted<D: Dictionary>(&self, refused: u8, frame: &[u8; 8], dictionary: &mut D) {
        let mut refused = refused;
        for object in &self.mapping.objects {
            if refused & 1 == 0 {
                put(dictionary, object.entry, object.value(frame));
            }
            refused >>= 1;
        }
    }
}
