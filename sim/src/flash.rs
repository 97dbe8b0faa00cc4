//! The flash sectors of a virtual drive: in memory, or in a file that keeps them.

use std::fmt;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read,
    check_write,
};
use store::Store;

/// A sector of the STM32F405's first four.
const SECTOR: usize = 16 * 1024;

/// Both sectors.
const SIZE: usize = 2 * SECTOR;

/// The parameter store of a virtual drive.
pub type ParameterStore = Store<Flash>;

/// Two sectors of NOR flash. Erased bytes are FFh, and writing clears bits, as in a chip.
#[derive(Debug)]
pub struct Flash {
    bytes: Vec<u8>,
    file: Option<File>,
    broken: bool,
}

impl Flash {
    /// Erased flash that is forgotten at the end.
    pub fn in_memory() -> Self {
        Self {
            bytes: vec![0xFF; SIZE],
            file: None,
            broken: false,
        }
    }

    /// Flash kept in a file, which is made, erased, if it does not exist.
    ///
    /// # Errors
    /// If the file cannot be opened for writing, is none of these files, or another drive uses it.
    pub fn in_file(path: &Path) -> io::Result<Self> {
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)?;
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            return Err(io::Error::new(
                io::ErrorKind::ResourceBusy,
                "another drive uses it",
            ));
        }
        let mut bytes = Vec::new();
        (&mut file).take(SIZE as u64 + 1).read_to_end(&mut bytes)?;
        if bytes.is_empty() {
            bytes.resize(SIZE, 0xFF);
            file.write_all(&bytes)?;
        }
        if bytes.len() != SIZE {
            return Err(io::Error::new(
                io::ErrorKind::InvalidData,
                format!("not a parameter store: it should have {SIZE} bytes"),
            ));
        }
        Ok(Self {
            bytes,
            file: Some(file),
            broken: false,
        })
    }

    /// From now on nothing can be written.
    pub fn break_down(&mut self) {
        self.broken = true;
    }

    /// Clears the first bits that hold `bytes`, as cells that have worn out. Does nothing if they lie nowhere.
    pub fn wear_out(&mut self, bytes: &[u8]) {
        let place = self
            .bytes
            .windows(bytes.len())
            .position(|cells| cells == bytes);
        if let Some(place) = place {
            self.bytes[place..place + bytes.len()].fill(0);
        }
    }

    /// The parameter store on all of this flash.
    ///
    /// # Panics
    /// Never: the sectors suit the store.
    pub fn into_store(self) -> ParameterStore {
        Store::new(self, 0..SIZE as u32).expect("two sectors are enough for the store")
    }

    fn write_through(&mut self, offset: usize, length: usize) -> Result<(), FlashError> {
        let Some(file) = &mut self.file else {
            return Ok(());
        };
        let written = file
            .seek(SeekFrom::Start(offset as u64))
            .and_then(|_| file.write_all(&self.bytes[offset..offset + length]));
        written.map_err(|error| FlashError::File(error.kind()))
    }
}

/// Why flash could not be read or written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlashError {
    /// The call does not fit the sectors.
    Call(NorFlashErrorKind),
    /// The file could not be written.
    File(io::ErrorKind),
    /// The flash is broken.
    Broken,
}

impl fmt::Display for FlashError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Call(kind) => write!(f, "{kind}"),
            Self::File(kind) => write!(f, "{kind}"),
            Self::Broken => f.write_str("the flash is broken"),
        }
    }
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Call(kind) => *kind,
            Self::File(_) | Self::Broken => NorFlashErrorKind::Other,
        }
    }
}

impl ErrorType for Flash {
    type Error = FlashError;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        check_read(self, offset, bytes.len()).map_err(FlashError::Call)?;
        let offset = offset as usize;
        bytes.copy_from_slice(&self.bytes[offset..offset + bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        SIZE
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        check_erase(self, from, to).map_err(FlashError::Call)?;
        if self.broken {
            return Err(FlashError::Broken);
        }
        let (from, to) = (from as usize, to as usize);
        self.bytes[from..to].fill(0xFF);
        self.write_through(from, to - from)
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        check_write(self, offset, bytes.len()).map_err(FlashError::Call)?;
        if self.broken {
            return Err(FlashError::Broken);
        }
        let offset = offset as usize;
        for (cell, byte) in self.bytes[offset..].iter_mut().zip(bytes) {
            *cell &= byte;
        }
        self.write_through(offset, bytes.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canopen::{BitRate, NodeId, Settings};

    const SETTINGS: Settings = Settings {
        node_id: NodeId::new(4).unwrap(),
        bit_rate: BitRate::Kbit500,
    };

    #[test]
    fn a_file_keeps_the_settings() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("drive.bin");
        let mut store = Flash::in_file(&path).unwrap().into_store();
        assert_eq!(store.load(), Ok(None));
        store.save(&SETTINGS).unwrap();
        drop(store);
        assert_eq!(
            Flash::in_file(&path).unwrap().into_store().load(),
            Ok(Some(SETTINGS))
        );
    }

    #[test]
    fn any_other_file_is_refused_and_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("letter.txt");
        std::fs::write(&path, "Dear reader").unwrap();
        assert_eq!(
            Flash::in_file(&path).unwrap_err().kind(),
            io::ErrorKind::InvalidData
        );
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "Dear reader");
    }

    #[test]
    fn broken_flash_says_so() {
        let mut flash = Flash::in_memory();
        flash.break_down();
        assert_eq!(
            flash.into_store().save(&SETTINGS),
            Err(store::Error::Flash(FlashError::Broken))
        );
    }
}
