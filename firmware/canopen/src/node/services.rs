//! The communication objects (1000h to 1FFFh) behind one door: each has its rules beside its own code; this is the only
//! place that knows which code owns which index.

use crate::application::Application;
use crate::cia301::emergency::{self, Emergency};
use crate::cia301::heartbeat;
use crate::cia301::length_error::LengthReport;
use crate::cia301::parameters::{self, Parameters};
use crate::cia301::pdo;
use crate::cia301::sdo::AbortCode;
use crate::cia301::sync::Sync;
use crate::od::{Counts, Dictionary, Entry};
use crate::time::Instant;

/// The services whose behaviour is set by communication objects.
#[derive(Debug)]
pub(super) struct Services<C: Counts> {
    pub(super) heartbeat: heartbeat::Producer,
    pub(super) emergency: emergency::Producer,
    pub(super) sync: Sync,
    pub(super) parameters: Parameters,
    pub(super) rpdos: pdo::Receive<C::Rpdos>,
    pub(super) tpdos: pdo::Transmit<C::Tpdos>,
    /// Whether the NMT state has emergency messages.
    pub(super) may_send_emergency: bool,
    /// Whether a timer may end earlier than the node knows.
    pub(super) timers_changed: bool,
    /// Whether a value of the dictionary may have changed since transmit PDOs were compared with it.
    pub(super) values_changed: bool,
}

impl<C: Counts> Services<C> {
    pub(super) fn new() -> Self {
        Self {
            heartbeat: heartbeat::Producer::new(),
            emergency: emergency::Producer::new(),
            sync: Sync::new(),
            parameters: Parameters::new(),
            rpdos: pdo::Receive::new(),
            tpdos: pdo::Transmit::new(),
            may_send_emergency: false,
            timers_changed: true,
            values_changed: true,
        }
    }

    /// Takes every parameter from the dictionary, after power-on values have been loaded.
    pub(super) fn configure<D: Dictionary>(&mut self, dictionary: &mut D, now: Instant) {
        self.timers_changed = true;
        self.values_changed = true;
        self.heartbeat.configure(dictionary, now);
        self.emergency.configure(dictionary);
        self.sync.configure(dictionary);
        self.parameters.configure(dictionary);
        self.rpdos.configure_all(dictionary);
        self.tpdos.configure_all(dictionary);
        self.report_lengths(dictionary, now);
        self.emergency.show_register(dictionary);
    }

    /// Whether a communication object may get this value, which has passed the dictionary's own checks.
    pub(super) fn validate<D: Dictionary>(
        &self,
        dictionary: &D,
        entry: &Entry,
        value: &[u8],
    ) -> Result<(), AbortCode> {
        match entry.index {
            0x1003 | 0x1014 | 0x1015 => self.emergency.validate(dictionary, entry, value),
            0x1005 => self.sync.validate(value),
            parameters::STORE | parameters::RESTORE => self.parameters.validate(entry, value),
            0x1400..=0x17FF => self.rpdos.validate(dictionary, entry, value),
            0x1800..=0x1BFF => self.tpdos.validate(dictionary, entry, value),
            _ => Ok(()),
        }
    }

    /// A communication object was written.
    pub(super) fn written<D: Dictionary>(
        &mut self,
        dictionary: &mut D,
        entry: &Entry,
        now: Instant,
    ) {
        match entry.index {
            0x1003 | 0x1014 | 0x1015 => {
                self.emergency.written(dictionary, entry);
                self.timers_changed = true;
            }
            0x1005 => {
                self.sync.written(dictionary);
                self.report_lengths(dictionary, now);
            }
            parameters::VERIFY_CONFIGURATION => self.parameters.read_date(dictionary),
            heartbeat::INDEX => {
                self.heartbeat.written(dictionary, now);
                self.timers_changed = true;
            }
            0x1400..=0x17FF => {
                self.rpdos.written(dictionary, entry);
                self.report_lengths(dictionary, now);
            }
            0x1800..=0x1BFF => self.tpdos.written(dictionary, entry, now),
            _ => {}
        }
    }

    /// A SYNC: transmit PDOs sample what the objects are now, then receive PDOs that waited for it are applied.
    pub(super) fn synchronise<D: Dictionary, A: Application<D>>(
        &mut self,
        dictionary: &mut D,
        application: &mut A,
    ) {
        self.tpdos.on_sync(dictionary);
        self.values_changed |= self.rpdos.on_sync(dictionary, application);
    }

    /// An error appeared.
    pub(super) fn report<D: Dictionary>(
        &mut self,
        dictionary: &mut D,
        emergency: &Emergency,
        now: Instant,
    ) {
        self.emergency
            .report(dictionary, emergency, self.may_send_emergency, now);
        self.errors_changed();
    }

    /// An error is gone.
    pub(super) fn clear<D: Dictionary>(&mut self, dictionary: &mut D, code: u16, now: Instant) {
        self.emergency
            .clear(dictionary, code, self.may_send_emergency, now);
        self.errors_changed();
    }

    /// A message may wait, and the error register may be mapped.
    fn errors_changed(&mut self) {
        self.timers_changed |= self.emergency.needs_time();
        self.values_changed = true;
    }

    /// Passes on what SYNC and receive PDOs have found wrong with the length of frames, or right again.
    #[inline]
    pub(super) fn report_lengths<D: Dictionary>(&mut self, dictionary: &mut D, now: Instant) {
        if self.sync.has_length_report() || self.rpdos.has_length_report() {
            self.report_changed_lengths(dictionary, now);
        }
    }

    #[cold]
    #[inline(never)]
    fn report_changed_lengths<D: Dictionary>(&mut self, dictionary: &mut D, now: Instant) {
        while let Some(report) = self
            .sync
            .length_report()
            .or_else(|| self.rpdos.length_report())
        {
            match report {
                LengthReport::Appeared(emergency) => self.report(dictionary, &emergency, now),
                LengthReport::Gone(emergency) => {
                    self.emergency
                        .clear_one(dictionary, &emergency, self.may_send_emergency, now);
                    self.errors_changed();
                }
            }
        }
    }
}
