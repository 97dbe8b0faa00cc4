//! The serial number that production has given to the device. It is written once and outlives everything else: a factory
//! reset, and damage as long as one directory is left.

use embedded_storage::nor_flash::NorFlash;

use crate::{Error, Store};

impl<F: NorFlash> Store<F> {
    /// The serial number that was stored; `None` if there never was one.
    ///
    /// # Errors
    /// [`Error::Flash`], or [`Error::Damaged`] where one may have been lost. A device then has the serial number of its chip.
    pub fn serial_number(&mut self) -> Result<Option<u32>, Error<F::Error>> {
        let found = self.found()?;
        match found.directory.serial_number {
            None if found.is_damaged => Err(Error::Damaged),
            number => Ok(number),
        }
    }

    /// Stores the serial number, once, and reads it back. The same number again is no error.
    ///
    /// # Errors
    /// [`Error::Content`]: there is another one already. Otherwise as [`Store::save`].
    #[inline(never)]
    pub fn save_serial_number(&mut self, number: u32) -> Result<(), Error<F::Error>> {
        let mut directory = self.found()?.directory;
        match directory.serial_number {
            Some(stored) if stored == number => return Ok(()),
            Some(_) => return Err(Error::Content),
            None => directory.serial_number = Some(number),
        }
        self.put(directory)
    }
}
