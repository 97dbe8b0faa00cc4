//! The flash sectors of a virtual drive: in memory, or in a file that keeps them.

mod power;

use std::fmt;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::Path;

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read,
    check_write,
};
use store::Store;

pub use power::Power;
pub use store::Contents;

/// A sector of the STM32F405's first four.
const SECTOR: usize = 16 * 1024;

/// The unit in which it is written.
const WORD: usize = 4;

/// Both sectors.
const SIZE: usize = 2 * SECTOR;

/// The parameter store of a virtual drive.
pub type ParameterStore = Store<Flash>;

/// Two sectors of NOR flash. Erased bytes are FFh, and writing clears bits, as in a chip.
#[derive(Debug)]
pub struct Flash {
    bytes: Vec<u8>,
    file: Option<File>,
    /// Nothing can be written.
    broken: bool,
    /// The file holds something else, which stays there.
    is_foreign: bool,
    power: Power,
}

impl Flash {
    /// Erased flash that is forgotten at the end.
    pub fn in_memory() -> Self {
        Self {
            bytes: vec![0xFF; SIZE],
            file: None,
            broken: false,
            is_foreign: false,
            power: Power::new(),
        }
    }

    /// Flash kept in a file, which is made, erased, if it does not exist. In a file of this size that holds something else nothing is
    /// ever written ([`Flash::contents`]).
    ///
    /// # Errors
    /// If the file cannot be opened for writing, is none of these files, or another drive uses it.
    pub fn in_file(path: &Path) -> io::Result<Self> {
        if fs::metadata(path).is_ok_and(|found| !found.is_file()) {
            return Err(not_a_store("it is no file"));
        }
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
            // Half a file would be none of ours at the next start.
            file.write_all(&bytes)
                .inspect_err(|_| file.set_len(0).unwrap_or_default())?;
        }
        if bytes.len() != SIZE {
            return Err(not_a_store(&format!("it should have {SIZE} bytes")));
        }
        let mut flash = Self {
            bytes,
            ..Self::in_memory()
        };
        flash.is_foreign = flash.contents() == Contents::Foreign;
        if flash.is_foreign {
            flash.broken = true;
            flash.bytes.fill(0xFF);
        }
        flash.file = Some(file);
        Ok(flash)
    }

    /// What it holds.
    ///
    /// # Panics
    /// Never: flash with power can be read.
    pub fn contents(&self) -> Contents {
        if self.is_foreign {
            return Contents::Foreign;
        }
        let bytes = self.bytes.clone();
        let mut store = Self {
            bytes,
            ..Self::in_memory()
        }
        .into_store();
        store.contents().expect("it has power")
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
        let place = SeekFrom::Start(offset as u64);
        let cells = &mut self.bytes[offset..offset + length];
        let written = file.seek(place).and_then(|_| file.write_all(cells));
        written.map_err(|error| {
            // What is not in the file is not in the flash.
            let read = file.seek(place).and_then(|_| file.read_exact(cells));
            self.broken |= read.is_err();
            FlashError::File(error.kind())
        })
    }
}

fn not_a_store(why: &str) -> io::Error {
    let why = format!("not a parameter store: {why}");
    io::Error::new(io::ErrorKind::InvalidData, why)
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
    const WRITE_SIZE: usize = WORD;
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
        fs::write(&path, "Dear reader").unwrap();
        assert_eq!(
            Flash::in_file(&path).unwrap_err().kind(),
            io::ErrorKind::InvalidData
        );
        assert_eq!(fs::read_to_string(&path).unwrap(), "Dear reader");
    }

    /// What a store with these bytes in its file is taken for.
    fn taken_for(bytes: &[u8]) -> Contents {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("drive.bin");
        fs::write(&path, bytes).unwrap();
        Flash::in_file(&path).unwrap().contents()
    }

    /// A flash in which a number of settings were stored, and where the last record ends.
    fn with_settings() -> (Vec<u8>, usize) {
        let mut store = Flash::in_memory().into_store();
        for node_id in 1..=20 {
            let node_id = NodeId::new(node_id).unwrap();
            let bit_timing = SETTINGS.bit_timing;
            store
                .save(&Configuration {
                    node_id,
                    bit_timing,
                })
                .unwrap();
        }
        let bytes = store.release().bytes;
        let end = bytes.iter().rposition(|byte| *byte != 0xFF).unwrap() + 1;
        (bytes, end)
    }

    #[test]
    fn what_somebody_else_has_written_is_told() {
        assert_eq!(taken_for(&[0xFF; SIZE]), Contents::Whole);
        for byte in [0x00, 0x41, 0xAA] {
            assert_eq!(taken_for(&[byte; SIZE]), Contents::Foreign, "{byte:02X}");
        }
        let noise = |seed: u32| {
            let next = |number: &mut u32| {
                *number = number.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                Some((*number >> 24) as u8)
            };
            let noise = std::iter::repeat(()).scan(seed, move |number, ()| next(number));
            noise.take(SIZE).collect::<Vec<_>>()
        };
        for seed in 0..50 {
            assert_eq!(taken_for(&noise(seed)), Contents::Foreign, "{seed}");
        }
        let (bytes, end) = with_settings();
        assert_eq!(taken_for(&bytes), Contents::Whole);
        for length in [4, 8, 16, 64] {
            for byte in [0x00, 0x55] {
                let mut bytes = bytes.clone();
                bytes[end - length..end].fill(byte);
                assert_eq!(
                    taken_for(&bytes),
                    Contents::Damaged,
                    "{length} x {byte:02X}"
                );
            }
        }
    }

    /// At every byte of two records, and here and there in all of a save that erases a sector.
    #[test]
    fn a_power_cut_is_no_damage() {
        use canopen::cia301::parameters::{ParameterSet, ParameterSets, ParameterStore as _};
        let save = |store: &mut ParameterStore, seed: u8| {
            store.begin(ParameterSets::ALL)?;
            for number in 0..12 {
                store.append(ParameterSet::Application, &[seed ^ number; 97])?;
            }
            store.commit()
        };
        let mut before = Flash::in_memory().into_store();
        for seed in 0..12 {
            save(&mut before, seed).unwrap();
        }
        let before = before.release().bytes;
        let flash = |bytes: &[u8]| Flash {
            bytes: bytes.to_vec(),
            ..Flash::in_memory()
        };
        let (mut is_cut, mut cut) = (true, 1);
        while is_cut {
            let power = Power::new();
            let mut store = flash(&before).powered_by(&power).into_store();
            power.cut_at_byte(cut);
            is_cut = save(&mut store, 9).is_err();
            let left = store.release();
            assert_eq!(left.contents(), Contents::Whole, "cut at byte {cut}");
            cut += if cut < 250 { 1 } else { 997 };
        }
        assert!(cut > SECTOR as u64, "no sector is erased: {cut}");
    }

    #[test]
    fn in_a_foreign_file_nothing_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.raw");
        fs::write(&path, [0x41; SIZE]).unwrap();
        let mut store = Flash::in_file(&path).unwrap().into_store();
        assert!(store.save(&SETTINGS).is_err());
        // Nothing of ours is there to be forgotten.
        store.forget().unwrap();
        drop(store);
        assert_eq!(fs::read(&path).unwrap(), [0x41; SIZE]);
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
