//! Store and restore parameters (CiA 301, 7.5.2.13 and 7.5.2.14: objects 1010h and 1011h), and verify configuration (7.5.2.22:
//! 1020h).
//!
//! A master writes "save" to a sub-index of 1010h, and from the next reset on the parameters start with the values they have
//! now; "load" to one of 1011h makes the next reset start with those of the data sheet again. Sub-index 1 is for all
//! parameters, 2 for those of the communication, 3 for those of the device profile, 4 to 127 for the manufacturer's. The answer
//! comes when the data is safe, and not before. 1020h is for a configuration tool: it puts in when it configured the device, saves,
//! and sees after each start whether that still holds.
//!
//! The contract:
//! - Nothing here waits for flash. The firmware does the work in steps ([`Node::store_parameters`]), when it suits the
//!   device, on a [`ParameterStore`]; one piece of at most [`CHUNK`] bytes at a time.
//! - What is stored is what a master would write, record by record with index and sub-index, in the order in which a master
//!   must write it (a PDO is switched off, mapped, switched on). Loading writes it just so: every rule of every object holds,
//!   and a firmware with another dictionary takes what still fits. What does not fit is told by one emergency message.
//! - A PDO is loaded whole or not at all.
//! - A value that is the data sheet's with the node-ID in it (`$NODEID`) is stored as such, and follows a new node-ID, unless the
//!   device has another habit ([`Habits`](crate::od::Habits)); any other is stored as it is.
//! - Several sets that are stored together count together or not at all: that is for the [`ParameterStore`] to keep.
//! - A parameter that a master changes sets 1020h to 0, and so does a restore. Process data change no configuration.
//!
//! [`Node::store_parameters`]: crate::Node::store_parameters

mod replay;
mod service;
mod walk;

pub(crate) use replay::{Refused, Replay, Writer};
pub(crate) use service::{Job, Parameters, loss, refusal};
pub use service::{PARAMETERS_LOST, PARAMETERS_REFUSED};
pub(crate) use walk::Walk;

use crate::settings::StoreError;

/// Most bytes that a [`ParameterStore`] is given or asked for at a time.
pub const CHUNK: usize = 240;

/// Index of store parameters.
pub const STORE: u16 = 0x1010;
/// Index of restore default parameters.
pub const RESTORE: u16 = 0x1011;
/// Index of verify configuration.
pub const VERIFY_CONFIGURATION: u16 = 0x1020;

/// What is stored as a whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum ParameterSet {
    /// When the device was configured, 1020h. It is stored and forgotten with each of the others.
    ConfigurationDate = 0,
    /// Communication parameters, sub-index 2.
    Communication = 1,
    /// Application parameters of the device profile, sub-index 3.
    Application = 2,
    /// Parameters of the manufacturer, sub-index 4.
    Manufacturer = 3,
}

impl ParameterSet {
    /// How many there are.
    pub const COUNT: usize = 4;

    /// All of them, in the order in which they are loaded.
    pub const ALL: [Self; Self::COUNT] = [
        Self::Communication,
        Self::Application,
        Self::Manufacturer,
        Self::ConfigurationDate,
    ];
}

/// Some of the sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParameterSets(u8);

impl ParameterSets {
    /// Every set: sub-index 1.
    pub const ALL: Self = Self(0b1111);

    /// This set, and the date of the configuration.
    pub const fn with_date(set: ParameterSet) -> Self {
        Self(1 << set as u8 | 1 << ParameterSet::ConfigurationDate as u8)
    }

    /// What a sub-index of 1010h or 1011h stands for; `None` for 0 and those that are reserved. A manufacturer may have divided his
    /// parameters into groups, 4 to 127: here they are one.
    pub const fn of_sub_index(sub: u8) -> Option<Self> {
        match sub {
            1 => Some(Self::ALL),
            2 => Some(Self::with_date(ParameterSet::Communication)),
            3 => Some(Self::with_date(ParameterSet::Application)),
            4..=0x7F => Some(Self::with_date(ParameterSet::Manufacturer)),
            _ => None,
        }
    }

    /// Whether this set is one of them.
    pub const fn has(self, set: ParameterSet) -> bool {
        self.0 & 1 << set as u8 != 0
    }
}

/// Where parameters are kept while the device has no power: sets of chunks of bytes that mean nothing to the store.
///
/// New sets are begun, filled and committed. Until then those in force stay, and the commit changes all of them at once,
/// whenever the power fails.
pub trait ParameterStore {
    /// Begins new, empty sets. Sets that were begun and not committed are dropped.
    ///
    /// # Errors
    /// The medium failed.
    fn begin(&mut self, sets: ParameterSets) -> Result<(), StoreError>;

    /// Adds a chunk of 1 to [`CHUNK`] bytes to a set that was begun.
    ///
    /// # Errors
    /// The medium failed or is full, or the set was not begun. The sets begun cannot be committed any more.
    fn append(&mut self, set: ParameterSet, chunk: &[u8]) -> Result<(), StoreError>;

    /// The sets begun take the place of those in force; an empty set is as if none was ever stored.
    ///
    /// # Errors
    /// The medium failed, or nothing was begun. The sets in force still are, or the new ones are.
    fn commit(&mut self) -> Result<(), StoreError>;

    /// How many chunks the set in force has, after a check that it is whole. 0 if there is none.
    ///
    /// # Errors
    /// The medium failed, or the set is damaged.
    fn open(&mut self, set: ParameterSet) -> Result<u16, StoreError>;

    /// Copies chunk `number`, from 0, of the set in force, and returns its length.
    ///
    /// # Errors
    /// The medium failed, or there is no such chunk.
    fn read(
        &mut self,
        set: ParameterSet,
        number: u16,
        chunk: &mut [u8; CHUNK],
    ) -> Result<usize, StoreError>;

    /// Keeps the serial number that production gives to the device, for ever.
    ///
    /// # Errors
    /// [`StoreError::NotSupported`]: this store keeps none. Otherwise the medium failed, or another number is kept already.
    fn keep_serial_number(&mut self, number: u32) -> Result<(), StoreError> {
        let _ = number;
        Err(StoreError::NotSupported)
    }
}
