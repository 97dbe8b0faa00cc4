//! The parameter store: what a drive keeps while it has no power, on two or more sectors of NOR flash.
//!
//! The store is a log in two banks. A new value is appended behind the old ones and the newest directory counts, one record that names
//! everything that is stored; when a bank is full, or somebody has written into it, what still counts moves to the other bank
//! and the first is erased. Each record carries a checksum over its header and its place, and one over its bytes. So a power
//! cut at any byte leaves the old values or the new ones, never a mixture, and bytes that were changed anywhere cost at most
//! the values that they belong to: what is lost is told until it is stored again. Only where the end of the newest record was
//! erased nothing can tell it from one that a power cut has left: the old values count, all of them.
//!
//! Two kinds of things are kept. The settings of the layer setting services and the serial number stand in the directory itself
//! ([`Store::load`], [`Store::save`]). The parameters of objects 1010h and 1011h (CiA 301) are sets of chunks
//! ([`ParameterStore`]): new chunks are written beside the old ones, and the directory changes all sets that were stored together
//! at once.
//!
//! [`ParameterStore`]: canopen::cia301::parameters::ParameterStore
#![no_std]
#![forbid(unsafe_code)]
#![deny(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::unreachable
)]

#[cfg(test)]
extern crate std;

mod directory;
mod log;
mod parameters;
mod serial_number;
#[cfg(test)]
mod tests;

use core::fmt;
use core::ops::Range;

use canopen::Configuration;
use canopen::cia301::parameters::{ParameterSet, ParameterSets};
use directory::{BYTES, DIRECTORY, Directory, Settings};
use embedded_storage::nor_flash::NorFlash;
use log::{BUFFER, Bank, Log, Record};
use parameters::{Begun, Opened};

/// The largest unit in which the flash may be read or written, in bytes. Larger units do not fit [`Store::new`].
pub const MAX_WRITE_SIZE: usize = 32;

/// Why a value cannot be loaded or stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error<E> {
    /// The range is not made of two or more whole sectors of the flash, or the flash reads or writes in units of more
    /// than [`MAX_WRITE_SIZE`] bytes.
    Range,
    /// The flash driver failed.
    Flash(E),
    /// It was stored and somebody has written over it. It is told until it is stored again.
    Damaged,
    /// The sectors are too small for what is kept in them.
    Full,
    /// The directory is whole, but of another layout (its first byte): it was written by a firmware this one does not know.
    Layout(u8),
    /// The record is whole and of a known layout, but its bytes mean nothing, such as node-ID 200; or what is to be stored is none
    /// of what this store keeps.
    Content,
    /// What was read back is not what was written: the flash is worn out or write-protected.
    Verify,
}

impl<E: fmt::Debug> fmt::Display for Error<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Range => {
                f.write_str("the parameter range is not two or more whole sectors of this flash")
            }
            Self::Flash(error) => write!(f, "the flash failed: {error:?}"),
            Self::Damaged => f.write_str("the parameter store is damaged"),
            Self::Full => f.write_str("the parameter store is full"),
            Self::Layout(layout) => write!(f, "the parameters have the unknown layout {layout}"),
            Self::Content => f.write_str("the parameters make no sense"),
            Self::Verify => f.write_str("the flash did not keep what was written"),
        }
    }
}

impl<E: fmt::Debug> core::error::Error for Error<E> {}

/// What the sectors hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contents {
    /// Nothing, or a log that a power cut may have ended.
    Whole,
    /// A log of which something was lost.
    Damaged,
    /// No record of this store.
    Foreign,
}

/// The newest directory and where it was found.
struct Found {
    bank: Bank,
    /// Where the log goes on behind it.
    end: u32,
    directory: Directory,
    /// There is one.
    is_there: bool,
    /// A newer one may have been there.
    is_damaged: bool,
}

/// The parameter store over a flash driver.
///
/// It caches nothing: every call reads the flash, so a call never depends on what an interrupted one left in RAM. Only sets that
/// are being written or read are known to it.
pub struct Store<F: NorFlash> {
    log: Log<F>,
    begun: Option<Begun>,
    opened: Option<Opened>,
}

impl<F: NorFlash> fmt::Debug for Store<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Store")
            .field("first", &self.log.limits(Bank::First))
            .field("second", &self.log.limits(Bank::Second))
            .finish_non_exhaustive()
    }
}

impl<F: NorFlash> Store<F> {
    /// A store on the sectors of `range` (byte addresses of `flash`). Nothing outside the range is read, written or erased.
    /// An erased range is an empty store.
    ///
    /// # Errors
    /// [`Error::Range`] unless the range is two or more whole sectors of a flash that this store can drive.
    pub fn new(flash: F, range: Range<u32>) -> Result<Self, Error<F::Error>> {
        Ok(Self {
            log: Log::new(flash, &range).ok_or(Error::Range)?,
            begun: None,
            opened: None,
        })
    }

    /// The settings that were stored last; `None` if there never were any.
    ///
    /// # Errors
    /// Any but [`Error::Range`], [`Error::Full`] and [`Error::Verify`]. A device then starts with the settings of the factory.
    pub fn load(&mut self) -> Result<Option<Configuration>, Error<F::Error>> {
        let directory = self.found()?.directory;
        if directory.is_later() {
            return Err(Error::Layout(directory.layout));
        }
        directory.settings.configuration()
    }

    /// Stores the settings and reads them back. Settings that are there already are not written again, to spare the flash.
    /// Erases a bank now and then.
    ///
    /// # Errors
    /// [`Error::Flash`], [`Error::Verify`], or [`Error::Full`] if even erased sectors are too small. The old settings then still
    /// stand, or the new ones do.
    pub fn save(&mut self, settings: &Configuration) -> Result<(), Error<F::Error>> {
        let mut directory = self.found()?.directory;
        let settings = Settings::of(settings);
        if directory.settings == settings {
            return Ok(());
        }
        directory.settings = settings;
        self.put(directory)
    }

    /// Gives the flash driver back.
    pub fn release(self) -> F {
        self.log.flash
    }

    /// Factory reset: settings and parameters are as if none were ever stored, all at once. What is forgotten already costs no
    /// flash.
    ///
    /// # Errors
    /// As [`Store::save`]: nothing is forgotten, or everything is.
    pub fn forget(&mut self) -> Result<(), Error<F::Error>> {
        self.begun = None;
        self.opened = None;
        let found = self.found()?;
        let mut directory = found.directory;
        if directory.settings != Settings::None {
            directory.settings = Settings::of(&Configuration::default());
        }
        let is_stored = |set: ParameterSet| {
            let part = found.directory.part(set);
            part.chunks > 0 || part.is_lost
        };
        if ParameterSet::ALL.into_iter().any(is_stored) {
            directory = directory.renewed(ParameterSets::ALL);
        } else if directory == found.directory {
            return Ok(());
        }
        self.put(directory)
    }

    /// What the sectors hold.
    ///
    /// # Errors
    /// [`Error::Flash`].
    pub fn contents(&mut self) -> Result<Contents, Error<F::Error>> {
        let found = self.found()?;
        let mut is_whole = !found.directory.has_losses();
        for set in ParameterSet::ALL {
            is_whole &= self.is_whole(found.bank, set, found.directory.part(set))?;
        }
        if is_whole {
            return Ok(Contents::Whole);
        }
        let mut has_records = false;
        for bank in Bank::ALL {
            has_records |= self.log.next(self.log.limits(bank))?.is_some();
        }
        Ok(if has_records {
            Contents::Damaged
        } else {
            Contents::Foreign
        })
    }

    /// The newest directory. Without one nothing was ever stored, or everything is lost.
    fn found(&mut self) -> Result<Found, Error<F::Error>> {
        let mut found = Found {
            bank: Bank::First,
            end: self.log.limits(Bank::First).start,
            directory: Directory::default(),
            is_there: false,
            is_damaged: false,
        };
        for bank in Bank::ALL {
            let mut place = self.log.limits(bank);
            while let Some(record) = self.log.next(place.clone())? {
                place.start = record.end;
                if let Some(directory) = self.directory(&record)?
                    && (!found.is_there || directory.is_newer_than(&found.directory))
                {
                    found = Found {
                        bank,
                        end: record.end,
                        directory,
                        is_there: true,
                        is_damaged: false,
                    };
                }
            }
        }
        found.is_damaged = if found.is_there {
            let end = self.log.limits(found.bank).end;
            self.hides_a_directory(found.end..end)?
        } else {
            let [first, second] = Bank::ALL.map(|bank| self.log.limits(bank));
            self.hides_a_directory(first)? || self.hides_a_directory(second)?
        };
        if found.is_damaged {
            found.directory = found.directory.lost();
        }
        Ok(found)
    }

    /// The directory that this record is.
    fn directory(&mut self, record: &Record) -> Result<Option<Directory>, Error<F::Error>> {
        if record.key != DIRECTORY {
            return Ok(None);
        }
        let mut buffer = [0; BUFFER];
        let payload = self.log.payload(record, &mut buffer)?;
        Ok(payload.map(Directory::read))
    }

    /// Whether a directory may have been in `place` that is no longer one: a damaged header or a damaged directory. What a power cut has
    /// left was none yet.
    fn hides_a_directory(&mut self, mut place: Range<u32>) -> Result<bool, Error<F::Error>> {
        while let Some(record) = self.log.next(place.clone())? {
            let is_cut = self.log.is_cut(&record)?;
            let is_directory = record.key == DIRECTORY;
            if record.from != place.start
                || is_directory && !is_cut && self.directory(&record)?.is_none()
            {
                return Ok(true);
            }
            place.start = record.end;
        }
        Ok(!self.log.is_end(place)?)
    }

    /// Where the log may go on; `None` if somebody has written there, or a cut has left half a header.
    fn free(&mut self, found: &Found) -> Result<Option<Range<u32>>, Error<F::Error>> {
        if found.is_damaged && !found.is_there {
            return Ok(None);
        }
        let mut place = found.end..self.log.limits(found.bank).end;
        while let Some(record) = self.log.record(place.clone())? {
            place.start = record.end;
        }
        Ok(self.log.is_erased(place.clone())?.then_some(place))
    }

    /// Writes a directory behind all others, or into the other bank, and reads it back.
    fn put(&mut self, mut directory: Directory) -> Result<(), Error<F::Error>> {
        let found = self.found()?;
        directory.layout = Directory::default().layout;
        directory.number = found.directory.number.wrapping_add(1);
        let written = match self.free(&found)? {
            Some(place) => taken(self.put_directory(place, &directory))?,
            None => false,
        };
        if !written {
            directory = self.move_on(directory)?;
        }
        let found = self.found()?;
        if found.directory == directory && !found.is_damaged {
            Ok(())
        } else {
            Err(Error::Verify)
        }
    }

    fn put_directory(
        &mut self,
        place: Range<u32>,
        directory: &Directory,
    ) -> Result<Option<u32>, Error<F::Error>> {
        let mut bytes = [0; BYTES];
        self.log
            .append(place, DIRECTORY, directory.write(&mut bytes))
    }

    /// Moves what still counts to the other bank, under this directory, and erases the one where it was. Until the directory is written
    /// the old one counts.
    fn move_on(&mut self, mut directory: Directory) -> Result<Directory, Error<F::Error>> {
        let found = self.found()?;
        // Where there is no directory, the bank that says that there was one says so until the end.
        let first = self.log.limits(Bank::First);
        let from = if found.is_damaged && !found.is_there && !self.hides_a_directory(first)? {
            Bank::Second
        } else {
            found.bank
        };
        self.log.erase(from.other())?;
        let mut place = self.log.limits(from.other());
        let end = place.end;
        place.end = end.saturating_sub(Log::<F>::size(BYTES));
        let begun = self.begun;
        for set in ParameterSet::ALL {
            let part = directory.part(set);
            if self.is_whole(from, set, part)? {
                place.start = self.copy(from, (set, part), place.clone())?;
            } else {
                directory.set_part(set, part.lost());
            }
            if let Some(part) = begun.and_then(|begun| begun.part(set)) {
                place.start = self.copy(from, (set, part), place.clone())?;
            }
        }
        directory.layout = Directory::default().layout;
        directory.number = found.directory.number.wrapping_add(1);
        self.put_directory(place.start..end, &directory)?
            .ok_or(Error::Full)?;
        self.log.erase(from)?;
        Ok(directory)
    }
}

/// Whether a record was written. Cells that did not take it are passed by, as those that are full.
fn taken<E>(written: Result<Option<u32>, Error<E>>) -> Result<bool, Error<E>> {
    match written {
        Ok(end) => Ok(end.is_some()),
        Err(Error::Verify) => Ok(false),
        Err(error) => Err(error),
    }
}
