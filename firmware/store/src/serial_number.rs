//! The serial number that production has given to the device. It is written once and outlives everything else: a factory
//! reset, and a log that is begun anew.

use embedded_storage::nor_flash::NorFlash;
use sequential_storage::map::{SerializationError, Value};

use crate::{BUFFER, Error, Store};

/// Key of the serial number. A key that was ever used keeps its meaning.
const SERIAL_NUMBER: u8 = 0x40;

/// Bytes of the record.
pub const BYTES: usize = 5;

/// Layout 1: layout, serial number (4 bytes, lowest first).
const LAYOUT: u8 = 1;

/// The record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SerialNumber(u32);

impl<F: NorFlash> Store<F> {
    /// The serial number that was stored; `None` if there never was one.
    ///
    /// # Errors
    /// Any but [`Error::Range`] and [`Error::Verify`]. A device then has the serial number of its chip.
    pub fn serial_number(&mut self) -> Result<Option<u32>, Error<F::Error>> {
        let record: Option<SerialNumber> = self.fetch(SERIAL_NUMBER, &mut [0; BUFFER])?;
        Ok(record.map(|SerialNumber(number)| number))
    }

    /// Stores the serial number, once, and reads it back. The same number again is no error.
    ///
    /// # Errors
    /// [`Error::Content`]: there is another one already. Otherwise as [`Store::save`].
    pub fn save_serial_number(&mut self, number: u32) -> Result<(), Error<F::Error>> {
        match self.serial_number() {
            Ok(Some(stored)) if stored == number => return Ok(()),
            Ok(Some(_)) => return Err(Error::Content),
            Ok(None) => {}
            Err(error @ Error::Flash(_)) => return Err(error),
            Err(_) => self.begin_anew()?,
        }
        self.put(SERIAL_NUMBER, &SerialNumber(number))?;
        if self.serial_number()? == Some(number) {
            Ok(())
        } else {
            Err(Error::Verify)
        }
    }

    /// Puts the serial number back into a log that was begun anew.
    pub(crate) fn restore_serial_number(&mut self, number: u32) -> Result<(), Error<F::Error>> {
        self.put(SERIAL_NUMBER, &SerialNumber(number))
    }
}

impl Value<'_> for SerialNumber {
    fn serialize_into(&self, buffer: &mut [u8]) -> Result<usize, SerializationError> {
        let bytes: &mut [u8; BYTES] = buffer
            .first_chunk_mut()
            .ok_or(SerializationError::BufferTooSmall)?;
        let [a, b, c, d] = self.0.to_le_bytes();
        *bytes = [LAYOUT, a, b, c, d];
        Ok(BYTES)
    }

    fn deserialize_from(buffer: &[u8]) -> Result<(Self, usize), SerializationError> {
        match *buffer {
            [LAYOUT, a, b, c, d] => Ok((Self(u32::from_le_bytes([a, b, c, d])), BYTES)),
            _ => Err(SerializationError::InvalidFormat),
        }
    }
}
