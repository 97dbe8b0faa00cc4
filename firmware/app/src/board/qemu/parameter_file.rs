//! Parameter sectors in a file of the host, `params.bin` in the folder where the emulator was started.
//!
//! Every change goes to the file at once, a byte range for each write, so that an emulator that is stopped at any moment
//! leaves what a board would that loses its power. No file is an erased flash.

use embedded_storage::nor_flash::{check_erase, check_read, check_write};
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};

use super::semihosting::{File, Mode, Refused};

const NAME: &core::ffi::CStr = c"params.bin";
const SECTOR: usize = 16 * 1024;
const SIZE: usize = 2 * SECTOR;

/// The sectors, two of 16 KiB as on the board.
pub struct ParameterFile {
    /// `None` if the host gave no file: then every access fails.
    file: Option<File>,
}

impl ParameterFile {
    /// Opens the file, or makes one that looks like erased flash.
    pub fn open() -> Self {
        let file = File::open(NAME, Mode::Update).or_else(|Refused| Self::create());
        Self { file: file.ok() }
    }

    fn create() -> Result<File, Refused> {
        let mut file = File::open(NAME, Mode::Create)?;
        fill(&mut file, 0, SIZE)?;
        Ok(file)
    }

    fn file(&mut self) -> Result<&mut File, NorFlashErrorKind> {
        self.file.as_mut().ok_or(NorFlashErrorKind::Other)
    }
}

/// Makes a range look erased.
fn fill(file: &mut File, from: usize, to: usize) -> Result<(), Refused> {
    const ERASED: [u8; 1024] = [0xFF; 1024];
    (from..to)
        .step_by(ERASED.len())
        .try_for_each(|position| file.write(position, &ERASED))
}

impl From<Refused> for NorFlashErrorKind {
    fn from(_: Refused) -> Self {
        Self::Other
    }
}

impl ErrorType for ParameterFile {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for ParameterFile {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        check_read(self, offset, bytes.len())?;
        Ok(self.file()?.read(offset as usize, bytes)?)
    }

    fn capacity(&self) -> usize {
        SIZE
    }
}

impl NorFlash for ParameterFile {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        check_erase(self, from, to)?;
        Ok(fill(self.file()?, from as usize, to as usize)?)
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        check_write(self, offset, bytes.len())?;
        // Programming can only clear bits.
        let mut word = [0; 4];
        for (i, new) in bytes.chunks_exact(word.len()).enumerate() {
            let position = offset as usize + i * word.len();
            self.file()?.read(position, &mut word)?;
            for (byte, new) in word.iter_mut().zip(new) {
                *byte &= new;
            }
            self.file()?.write(position, &word)?;
        }
        Ok(())
    }
}
