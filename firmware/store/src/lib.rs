//! The parameter store: what a drive keeps while it has no power, on two or more sectors of NOR flash.
//!
//! The store is a log. A new value is appended behind the old ones and the last complete one counts; when a sector is
//! full, what still counts moves to the next sector and the full one is erased, all sectors in turn. Each record carries
//! a checksum over its length and one over its bytes, and names its layout. So a power cut at any byte leaves the old
//! value or the new one, never a mixture, and the next start repairs what the cut left behind.
//!
//! Two kinds of things are kept. The settings of the layer setting services are one record ([`Store::load`],
//! [`Store::save`]). The parameters of objects 1010h and 1011h (CiA 301) are sets of chunks, and a directory says which chunks
//! count ([`ParameterStore`]): new chunks are written beside the old ones, and the directory, one record, changes all sets that
//! were stored together at once. The log itself is the crate `sequential-storage`; this crate adds the records and waits for
//! the flash where that crate would return a future.
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

mod blocking;
mod directory;
mod parameters;
mod record;
mod serial_number;
#[cfg(test)]
mod tests;

use core::fmt;
use core::ops::Range;

use blocking::Blocking;
use canopen::Configuration;
use canopen::cia301::parameters::CHUNK;
use embassy_futures::block_on;
use embedded_storage::nor_flash::NorFlash;
use parameters::{Begun, Opened};
use record::{RECORD, Record};
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage, Value};

/// The largest unit in which the flash may be read or written, in bytes. Larger units do not fit [`Store::new`].
pub const MAX_WRITE_SIZE: usize = 32;

/// Bytes of a key.
const KEY: usize = 1;

/// Key of the settings. A key that was ever used keeps its meaning.
const SETTINGS: u8 = 0x00;

/// Bytes of the buffer through which records pass: the longest of them with its key, in whole words of the flash. Whatever is
/// stored, the log may move all of them.
const BUFFER: usize = (KEY + CHUNK).next_multiple_of(MAX_WRITE_SIZE);

const _: () = assert!(RECORD <= CHUNK && BUFFER <= 256);

/// Why a value cannot be loaded or stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error<E> {
    /// The range is not made of two or more whole sectors of the flash, or the flash reads or writes in units of more
    /// than [`MAX_WRITE_SIZE`] bytes.
    Range,
    /// The flash driver failed.
    Flash(E),
    /// The log is damaged beyond repair. The next [`Store::save`] erases it and begins anew.
    Damaged,
    /// The sectors are too small for what is kept in them.
    Full,
    /// The record is whole, but of another layout (its first byte): it was written by a firmware this one does not know.
    Layout(u8),
    /// The record is whole and of a known layout, but its bytes mean nothing, such as node-ID 200.
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

type NoCache = Cache<Uncached, Uncached, Uncached, u8>;

/// The parameter store over a flash driver.
///
/// It caches nothing: every call reads the flash, so a call never depends on what an interrupted one left in RAM. Only sets that
/// are being written or read are known to it.
pub struct Store<F: NorFlash> {
    log: MapStorage<u8, Blocking<F>, NoCache>,
    begun: Option<Begun>,
    opened: Option<Opened>,
}

impl<F: NorFlash> fmt::Debug for Store<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Store")
            .field("range", &self.log.flash_range())
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
        let units_fit = F::READ_SIZE.max(F::WRITE_SIZE) <= MAX_WRITE_SIZE;
        let inside = range.start < range.end
            && usize::try_from(range.end).is_ok_and(|end| end <= flash.capacity());
        if !units_fit || !inside {
            return Err(Error::Range);
        }
        let config = MapConfig::try_new(range).map_err(|_| Error::Range)?;
        Ok(Self {
            log: MapStorage::new(Blocking(flash), config, Cache::new_uncached()),
            begun: None,
            opened: None,
        })
    }

    /// The settings that were stored last; `None` if there never were any. Repairs what a power cut has left behind, so it
    /// may write and erase: call it where the time of a sector erase does no harm.
    ///
    /// # Errors
    /// Any but [`Error::Range`] and [`Error::Verify`]. A device then starts with the settings of the factory.
    pub fn load(&mut self) -> Result<Option<Configuration>, Error<F::Error>> {
        match self.settings()? {
            Some(record) => record.settings().map(Some),
            None => Ok(None),
        }
    }

    /// Stores the settings and reads them back. Settings that are there already are not written again, to spare the flash.
    /// Erases a sector now and then.
    ///
    /// A log that takes no record is damaged beyond repair, for its sectors hold all groups many times over. It is erased and
    /// begun anew.
    ///
    /// # Errors
    /// [`Error::Flash`], [`Error::Verify`], or [`Error::Full`] if even erased sectors are too small. The old settings then still
    /// stand, or the new ones do.
    pub fn save(&mut self, settings: &Configuration) -> Result<(), Error<F::Error>> {
        let record = Record::of_settings(settings);
        if matches!(self.settings(), Ok(Some(stored)) if stored == record) {
            return Ok(());
        }
        match self.put(SETTINGS, &record) {
            Err(Error::Damaged | Error::Full | Error::Content) => {
                self.begin_anew()?;
                self.put(SETTINGS, &record)?;
            }
            other => other?,
        }
        if self.settings()? == Some(record) {
            Ok(())
        } else {
            Err(Error::Verify)
        }
    }

    /// Gives the flash driver back.
    pub fn release(self) -> F {
        self.log.destroy().0.0
    }

    /// Factory reset: settings and parameters are as if none were ever stored. Each change is whole when the power fails, and
    /// the order given again does what was left. What is forgotten already costs no flash. Settings are forgotten even if the
    /// parameters cannot be: they are what brings a lost device back.
    ///
    /// # Errors
    /// As [`Store::save`]: something is not forgotten.
    pub fn forget(&mut self) -> Result<(), Error<F::Error>> {
        let parameters = self.forget_parameters();
        if !matches!(self.settings(), Ok(None)) {
            self.save(&Configuration::default())?;
        }
        parameters
    }

    /// Begins the log anew, with what can still be read of settings and serial number.
    fn begin_anew(&mut self) -> Result<(), Error<F::Error>> {
        let settings = self.settings().ok().flatten();
        let serial_number = self.serial_number().ok().flatten();
        block_on(self.log.erase_all()).map_err(error)?;
        if let Some(number) = serial_number {
            self.restore_serial_number(number)?;
        }
        match settings {
            Some(settings) => self.put(SETTINGS, &settings),
            None => Ok(()),
        }
    }

    fn settings(&mut self) -> Result<Option<Record>, Error<F::Error>> {
        self.fetch(SETTINGS, &mut [0; BUFFER])
    }

    /// The newest value of a key.
    fn fetch<'b, V: Value<'b>>(
        &mut self,
        key: u8,
        buffer: &'b mut [u8; BUFFER],
    ) -> Result<Option<V>, Error<F::Error>> {
        block_on(self.log.fetch_item(buffer, &key)).map_err(error)
    }

    /// A new value of a key; the old one counts until this one is whole.
    fn put<'v, V: Value<'v>>(&mut self, key: u8, value: &V) -> Result<(), Error<F::Error>> {
        block_on(self.log.store_item(&mut [0; BUFFER], &key, value)).map_err(error)
    }
}

/// The log's errors in this crate's words.
fn error<E>(error: sequential_storage::Error<E>) -> Error<E> {
    use sequential_storage::Error as Log;
    match error {
        Log::Storage { value, .. } => Error::Flash(value),
        Log::FullStorage | Log::ItemTooBig => Error::Full,
        // A whole record that is too short or too long for any this firmware knows.
        Log::SerializationError(_) | Log::BufferTooSmall(_) | Log::BufferTooBig => Error::Content,
        _ => Error::Damaged,
    }
}
