//! 1010h, 1011h and 1020h: what a master may write, and what is under way.

use super::{ParameterSet, ParameterSets, RESTORE, Refused, STORE, VERIFY_CONFIGURATION, Walk};
use crate::cia301::emergency::{Emergency, ErrorRegister};
use crate::cia301::nmt::Reset;
use crate::cia301::sdo::AbortCode;
use crate::od::{self, Dictionary, Entry};
use crate::settings::StoreError;

/// Emergency error code "loss of parameters" (63xxh is "data set" of CiA 301): a stored set cannot be read. Its
/// parameters have the values of the data sheet.
pub const PARAMETERS_LOST: u16 = 0x6310;

/// Emergency error code "parameter error": some of what is stored does not fit this device. Those parameters have the values
/// of the data sheet. The manufacturer's bytes are index and sub-index of the first, and how many records there are.
pub const PARAMETERS_REFUSED: u16 = 0x6320;

/// "save" as it travels, lowest byte first.
const SAVE: [u8; 4] = *b"save";
/// "load" as it travels.
const LOAD: [u8; 4] = *b"load";

/// What is to be done with the store.
#[derive(Clone, Copy, Debug)]
#[repr(u8)] // Nothing is zero.
pub(crate) enum Job {
    Nothing,
    /// Load what is stored, at a reset.
    Load(Reset),
    /// Begin new sets.
    BeginSave(ParameterSets),
    /// Write the next chunk of the walk.
    Save(ParameterSets, Walk),
    /// Put what was written in force.
    Commit(ParameterSets),
    /// Forget these sets.
    Forget(ParameterSets),
}

/// Store and restore parameters.
#[derive(Debug)]
pub(crate) struct Parameters {
    /// The firmware has a store.
    has_store: bool,
    job: Job,
    /// The sub-index of 1010h or 1011h that the job was ordered with.
    order: (u16, u8),
    /// 1020h is not 0.
    is_dated: bool,
    /// A stored parameter that a reset of the communication leaves alone has another value than the store: the date that it
    /// loads is not that of the configuration.
    is_stale: bool,
    /// What was refused at the last reset of those parameters.
    refused: Refused,
}

impl Parameters {
    pub(crate) const fn new() -> Self {
        Self {
            has_store: false,
            job: Job::Nothing,
            order: (0, 0),
            is_dated: false,
            is_stale: false,
            refused: Refused::NOTHING,
        }
    }

    /// The firmware has a store.
    pub(crate) const fn support(&mut self) {
        self.has_store = true;
    }

    /// Whether the firmware has a store.
    pub(crate) const fn has_store(&self) -> bool {
        self.has_store
    }

    /// A reset: what was under way is void, and what is stored is to be loaded. Returns whether it is.
    pub(crate) fn reset(&mut self, reset: Reset) -> bool {
        self.is_dated = false;
        if self.has_store {
            self.job = Job::Load(reset);
        }
        self.has_store
    }

    /// Power-on values are in the dictionary, or what was stored.
    pub(crate) fn configure<D: Dictionary>(&mut self, dictionary: &mut D) {
        let capability = u32::from(self.has_store);
        for index in [STORE, RESTORE] {
            for entry in D::TABLE.range(index..=index) {
                if entry.sub > 0 {
                    let known = ParameterSets::of_sub_index(entry.sub).is_some();
                    let value = if known { capability } else { 0 };
                    od::write_u32(dictionary, index, entry.sub, value);
                }
            }
        }
        self.read_date(dictionary);
    }

    /// What is under way.
    pub(crate) const fn job(&self) -> Job {
        self.job
    }

    /// What is next.
    pub(crate) const fn set_job(&mut self, job: Job) {
        self.job = job;
    }

    /// Whether 1010h or 1011h may get this value.
    ///
    /// # Errors
    /// - [`AbortCode::NotTransferable`]: a wrong signature (CiA 301, 7.5.2.13; [`Habits::wrong_signature`](od::Habits)), a
    ///   sub-index that stands for nothing, or the device has no store.
    /// - [`AbortCode::DeviceState`]: the store is still busy with the last order.
    pub(crate) fn validate<D: Dictionary>(
        &self,
        entry: &Entry,
        value: &[u8],
    ) -> Result<(), AbortCode> {
        let signature = if entry.index == STORE { SAVE } else { LOAD };
        let is_known = ParameterSets::of_sub_index(entry.sub).is_some();
        if !self.has_store || !is_known {
            Err(AbortCode::NotTransferable)
        } else if value != signature {
            Err(D::HABITS.wrong_signature)
        } else if !matches!(self.job, Job::Nothing) {
            Err(AbortCode::DeviceState)
        } else {
            Ok(())
        }
    }

    /// Whether a write of this entry is an order that takes a while.
    #[inline]
    pub(crate) const fn is_order(&self, entry: &Entry) -> bool {
        matches!(entry.index, STORE | RESTORE)
    }

    /// Index and sub-index of what was ordered last.
    pub(crate) const fn order(&self) -> (u16, u8) {
        self.order
    }

    /// An order that has passed [`Parameters::validate`] is taken.
    pub(crate) fn begin(&mut self, entry: &Entry) {
        self.order = (entry.index, entry.sub);
        self.job = match (ParameterSets::of_sub_index(entry.sub), entry.index) {
            (None, _) => Job::Nothing,
            (Some(sets), STORE) => Job::BeginSave(sets),
            (Some(sets), _) => Job::Forget(sets),
        };
    }

    /// Whether a change of this entry is a change of the configuration that 1020h dates, in the dictionary or in the store.
    #[inline]
    pub(crate) fn is_dated(&self, entry: &Entry) -> bool {
        // Without a store nothing differs from it.
        (self.is_dated || self.has_store && !self.is_stale)
            && entry.storage_group().is_some()
            && entry.index != VERIFY_CONFIGURATION
    }

    /// Such an entry has changed.
    #[cold]
    #[inline(never)]
    pub(crate) fn changed<D: Dictionary>(&mut self, dictionary: &mut D, entry: &Entry) {
        self.is_stale |= entry.index >> 12 != 1;
        if self.is_dated {
            self.forget_date(dictionary);
        }
    }

    /// Whether the stored date is not that of the configuration, whatever 1020h is.
    pub(crate) const fn is_stale(&self) -> bool {
        self.is_stale
    }

    /// Stored parameters are loaded. `is_stale`: others than those may differ from the store. Returns all that is refused:
    /// what this reset has found, and what the last reset of the other parameters has.
    pub(crate) fn loaded(
        &mut self,
        reset: Reset,
        is_stale: bool,
        (communication, others): (Refused, Refused),
    ) -> Refused {
        // The loading itself has changed parameters.
        self.is_stale = is_stale;
        if matches!(reset, Reset::Node) {
            self.refused = others;
        }
        communication.and(self.refused)
    }

    /// The store has what the dictionary has, and the date with it; `is_all` if every set was saved.
    pub(crate) const fn saved(&mut self, is_all: bool) {
        self.is_stale = false;
        if is_all {
            self.refused = Refused::NOTHING;
        }
    }

    /// The configuration is no longer that of 1020h.
    #[cold]
    #[inline(never)]
    pub(crate) fn forget_date<D: Dictionary>(&mut self, dictionary: &mut D) {
        self.is_dated = false;
        for sub in 1..=2 {
            od::write_u32(dictionary, VERIFY_CONFIGURATION, sub, 0);
        }
    }

    /// 1020h was written.
    pub(crate) fn read_date<D: Dictionary>(&mut self, dictionary: &D) {
        self.is_dated = (1..=2)
            .any(|sub| od::read_u32(dictionary, VERIFY_CONFIGURATION, sub).unwrap_or(0) != 0);
    }
}

impl Job {
    /// The set that is written after `set`, or the commit.
    pub(crate) fn after(sets: ParameterSets, set: Option<ParameterSet>) -> Self {
        let all = ParameterSet::ALL.into_iter();
        let mut later = all.skip_while(|other| set.is_some_and(|set| set != *other));
        if set.is_some() {
            later.next();
        }
        match later.find(|set| sets.has(*set)) {
            Some(set) => Self::Save(sets, Walk::new(set)),
            None => Self::Commit(sets),
        }
    }
}

impl From<StoreError> for AbortCode {
    fn from(error: StoreError) -> Self {
        match error {
            StoreError::NotSupported => Self::NotTransferable,
            StoreError::Medium => Self::HardwareError,
        }
    }
}

/// The emergency of parameters that do not fit.
pub(crate) fn refusal(refused: &Refused) -> Emergency {
    let [index_low, index_high] = refused.index.to_le_bytes();
    let [low, high] = refused.count.to_le_bytes();
    Emergency {
        code: PARAMETERS_REFUSED,
        register: ErrorRegister::GENERIC,
        info: [index_low, index_high, refused.sub, low, high],
    }
}

/// The emergency of a set that cannot be read; the manufacturer's first byte is the sub-index of 1010h it belongs to.
pub(crate) fn loss(set: ParameterSet) -> Emergency {
    let sub = match set {
        ParameterSet::ConfigurationDate => 1,
        ParameterSet::Communication => 2,
        ParameterSet::Application => 3,
        ParameterSet::Manufacturer => 4,
    };
    Emergency {
        code: PARAMETERS_LOST,
        register: ErrorRegister::GENERIC,
        info: [sub, 0, 0, 0, 0],
    }
}
