//! The flash sectors of a virtual drive: in memory, or in a file that keeps them.

mod power;

use std::fmt;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::Path;

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read,
    check_write,
};
use store::Store;

pub use power::Power;

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
    power: Power,
}

impl Flash {
    /// Erased flash that is forgotten at the end.
    pub fn in_memory() -> Self {
        Self {
            bytes: vec![0xFF; SIZE],
            file: None,
            broken: false,
            power: Power::new(),
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
            power: Power::new(),
        })
    }

    /// Feeds it from this power, which can be cut in the middle of a write.
    pub fn powered_by(self, power: &Power) -> Self {
        Self {
            power: power.clone(),
            ..self
        }
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

    /// Programs or erases cells: `to` makes the new byte from the cell's number in the range and its old byte. What was done
    /// before a failure stays.
    fn write_cells(
        &mut self,
        range: Range<usize>,
        to: impl Fn(usize, u8) -> u8,
    ) -> Result<(), FlashError> {
        if self.broken {
            return Err(FlashError::Broken);
        }
        if !self.power.is_on() {
            return Err(FlashError::NoPower);
        }
        let done = (range.clone().enumerate())
            .try_for_each(|(number, place)| self.change(place, to(number, self.bytes[place])));
        self.write_through(range.start, range.len()).and(done)
    }

    /// Programs or erases one byte; if the power goes now, every other bit of it.
    fn change(&mut self, place: usize, to: u8) -> Result<(), FlashError> {
        let cell = &mut self.bytes[place];
        if self.power.spend() {
            *cell = to;
            return Ok(());
        }
        *cell = (*cell & 0xAA) | (to & 0x55);
        Err(FlashError::NoPower)
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
    /// The flash has no power.
    NoPower,
}

impl fmt::Display for FlashError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Call(kind) => write!(f, "{kind}"),
            Self::File(kind) => write!(f, "{kind}"),
            Self::Broken => f.write_str("the flash is broken"),
            Self::NoPower => f.write_str("the flash has no power"),
        }
    }
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Call(kind) => *kind,
            Self::File(_) | Self::Broken | Self::NoPower => NorFlashErrorKind::Other,
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
        if !self.power.is_on() {
            return Err(FlashError::NoPower);
        }
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
        self.write_cells(from as usize..to as usize, |_, _| 0xFF)
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        check_write(self, offset, bytes.len()).map_err(FlashError::Call)?;
        let from = offset as usize;
        self.write_cells(from..from + bytes.len(), |number, cell| {
            cell & bytes[number]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canopen::{BitRate, BitTiming, Configuration, NodeId};

    const SETTINGS: Configuration = Configuration {
        node_id: NodeId::new(4).unwrap(),
        bit_timing: BitTiming::Fixed(BitRate::Kbit500),
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

    #[test]
    fn a_cut_leaves_one_byte_half_done() {
        let power = Power::new();
        let mut flash = Flash::in_memory().powered_by(&power);
        power.cut_at_byte(3);
        assert_eq!(flash.write(4, &[0; 8]), Err(FlashError::NoPower));
        assert_eq!(flash.read(0, &mut [0]), Err(FlashError::NoPower));
        assert_eq!(flash.erase(0, SIZE as u32), Err(FlashError::NoPower));
        power.restore();
        let mut cells = [0; 6];
        flash.read(3, &mut cells).unwrap();
        assert_eq!(cells, [0xFF, 0, 0, 0xAA, 0xFF, 0xFF]);
        flash.erase(0, SIZE as u32).unwrap();
        flash.read(3, &mut cells).unwrap();
        assert_eq!(cells, [0xFF; 6]);
    }
}
