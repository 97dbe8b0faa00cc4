//! The sets of parameters: chunks, and the directory that says which of them count.

use canopen::cia301::parameters::{CHUNK, ParameterSet, ParameterSets, ParameterStore};
use canopen::node::StoreError;
use embedded_storage::nor_flash::NorFlash;
use sequential_storage::map::MapStorage;

use crate::blocking::Blocking;
use crate::directory::{self, DIRECTORY, Directory, Part};
use crate::record::RECORD;
use crate::serial_number;
use crate::{BUFFER, Error, KEY, NoCache, Store};

/// Sets that are being written.
#[derive(Debug)]
pub struct Begun {
    sets: ParameterSets,
    /// The directory to be.
    directory: Directory,
    /// Bytes of flash that the new chunks may still take.
    room: usize,
}

/// The set that is being read.
#[derive(Debug)]
pub struct Opened {
    set: ParameterSet,
    part: Part,
}

impl<F: NorFlash> Store<F> {
    /// Bytes of flash that a value of this length takes.
    fn item(length: usize) -> usize {
        let overhead = MapStorage::<u8, Blocking<F>, NoCache>::item_overhead_size();
        let word = F::READ_SIZE.max(F::WRITE_SIZE);
        (KEY + length)
            .next_multiple_of(word)
            .saturating_add(usize::try_from(overhead).unwrap_or(usize::MAX))
    }

    /// Most bytes of flash that the chunks of a set take.
    fn items(part: Part) -> usize {
        // Of each chunk the last word may be all but empty.
        let word = F::READ_SIZE.max(F::WRITE_SIZE);
        let each = Self::item(0).saturating_add(word);
        usize::from(part.chunks)
            .saturating_mul(each)
            .saturating_add(usize::from(part.length))
    }

    /// The directory. If there is none, or none that this firmware knows, an empty one is written first: that shows whether the
    /// log takes anything. If not, it is damaged beyond repair, which no power cut does, and is begun anew.
    fn directory(&mut self) -> Result<Directory, Error<F::Error>> {
        match self.fetch(DIRECTORY, &mut [0; BUFFER]) {
            Ok(Some(directory)) => return Ok(directory),
            Ok(None) | Err(Error::Damaged | Error::Content) => {}
            Err(error) => return Err(error),
        }
        let empty = Directory::default();
        match self.put(DIRECTORY, &empty) {
            Err(Error::Damaged | Error::Full | Error::Content) => {
                self.begin_anew()?;
                self.put(DIRECTORY, &empty)?;
            }
            other => other?,
        }
        Ok(empty)
    }

    /// Empties the chunks of the half that is not in force, which an earlier save has left behind, so that the log forgets them.
    /// Returns how many there are or were.
    fn sweep(&mut self, set: ParameterSet, part: Part) -> Result<usize, Error<F::Error>> {
        let stale = part.renewed();
        let mut count = 0;
        while let Some(key) = stale.key(set, count) {
            let mut buffer = [0; BUFFER];
            let chunk: Option<&[u8]> = self.fetch(key, &mut buffer)?;
            match chunk {
                None => break,
                Some([]) => {}
                Some(_) => self.put::<&[u8]>(key, &&[][..])?,
            }
            count = count.saturating_add(1);
        }
        Ok(usize::from(count))
    }

    /// Bytes of flash for new chunks: what one sector less than all holds, but for what is kept and a reserve for new
    /// settings and a new directory.
    fn room(&mut self, directory: &Directory) -> Result<usize, Error<F::Error>> {
        let range = self.log.flash_range();
        let bytes = usize::try_from(range.end.saturating_sub(range.start)).unwrap_or(usize::MAX);
        let word = F::READ_SIZE.max(F::WRITE_SIZE);
        let sectors = bytes.checked_div(F::ERASE_SIZE).unwrap_or(0);
        // The log marks both ends of a sector.
        let sector = F::ERASE_SIZE.saturating_sub(2 * word);
        let mut taken = 2 * (Self::item(RECORD) + Self::item(directory::BYTES))
            + Self::item(serial_number::BYTES);
        for set in ParameterSet::ALL {
            let part = directory.part(set);
            let swept = self.sweep(set, part)?;
            taken = taken
                .saturating_add(Self::items(part))
                .saturating_add(swept.saturating_mul(Self::item(0)));
        }
        // A value that no longer fits the end of a sector leaves that end empty.
        let holds = sector.saturating_mul(sectors.saturating_sub(1));
        let waste = Self::item(CHUNK).saturating_mul(sectors.saturating_sub(2));
        Ok(holds.saturating_sub(taken).saturating_sub(waste))
    }

    /// Every set is as if it was never stored.
    pub(crate) fn forget_parameters(&mut self) -> Result<(), Error<F::Error>> {
        self.begun = None;
        self.opened = None;
        let directory = self.directory()?;
        let is_stored = |set: &ParameterSet| directory.part(*set).chunks > 0;
        if !ParameterSet::ALL.iter().any(is_stored) {
            return Ok(());
        }
        let begun = self.begin_sets(ParameterSets::ALL)?;
        self.commit_sets(&begun)
    }

    /// Reads the chunks of a set and returns what they are in truth.
    fn verified(&mut self, set: ParameterSet, wanted: Part) -> Result<Part, Error<F::Error>> {
        let mut part = Part {
            half: wanted.half,
            ..Part::default()
        };
        while part.chunks < wanted.chunks {
            let mut buffer = [0; BUFFER];
            let key = part.key(set, part.chunks).ok_or(Error::Damaged)?;
            let chunk: Option<&[u8]> = self.fetch(key, &mut buffer)?;
            part = chunk
                .and_then(|chunk| part.with(chunk))
                .ok_or(Error::Damaged)?;
        }
        Ok(part)
    }

    fn begin_sets(&mut self, sets: ParameterSets) -> Result<Begun, Error<F::Error>> {
        let directory = self.directory()?;
        Ok(Begun {
            sets,
            room: self.room(&directory)?,
            directory: directory.renewed(sets),
        })
    }

    fn append_chunk(
        &mut self,
        begun: &mut Begun,
        set: ParameterSet,
        chunk: &[u8],
    ) -> Result<(), Error<F::Error>> {
        if !begun.sets.has(set) || chunk.is_empty() || chunk.len() > CHUNK {
            return Err(Error::Content);
        }
        let part = begun.directory.part(set);
        let longer = part.with(chunk).ok_or(Error::Full)?;
        let key = part.key(set, part.chunks).ok_or(Error::Full)?;
        begun.room = begun
            .room
            .checked_sub(Self::item(chunk.len()))
            .ok_or(Error::Full)?;
        self.put(key, &chunk)?;
        begun.directory.set_part(set, longer);
        Ok(())
    }

    fn commit_sets(&mut self, begun: &Begun) -> Result<(), Error<F::Error>> {
        for set in ParameterSet::ALL {
            let part = begun.directory.part(set);
            if begun.sets.has(set) && self.verified(set, part)? != part {
                return Err(Error::Verify);
            }
        }
        self.put(DIRECTORY, &begun.directory)?;
        let stored: Option<Directory> = self.fetch(DIRECTORY, &mut [0; BUFFER])?;
        if stored == Some(begun.directory) {
            Ok(())
        } else {
            Err(Error::Verify)
        }
    }

    fn open_set(&mut self, set: ParameterSet) -> Result<Opened, Error<F::Error>> {
        let directory: Option<Directory> = self.fetch(DIRECTORY, &mut [0; BUFFER])?;
        let part = directory.unwrap_or_default().part(set);
        if self.verified(set, part)? == part {
            Ok(Opened { set, part })
        } else {
            Err(Error::Damaged)
        }
    }

    fn read_chunk(
        &mut self,
        set: ParameterSet,
        number: u16,
        chunk: &mut [u8; CHUNK],
    ) -> Result<usize, Error<F::Error>> {
        let opened = self.opened.as_ref().filter(|opened| opened.set == set);
        let part = opened.ok_or(Error::Content)?.part;
        let number = u8::try_from(number).map_err(|_| Error::Content)?;
        let key = (number < part.chunks)
            .then(|| part.key(set, number))
            .flatten()
            .ok_or(Error::Content)?;
        let mut buffer = [0; BUFFER];
        let stored: Option<&[u8]> = self.fetch(key, &mut buffer)?;
        let stored = stored.ok_or(Error::Damaged)?;
        let room = chunk.get_mut(..stored.len()).ok_or(Error::Content)?;
        room.copy_from_slice(stored);
        Ok(stored.len())
    }
}

/// To the device every failure of the store is one of its medium; [`Error`] is for the firmware.
impl<F: NorFlash> ParameterStore for Store<F> {
    fn begin(&mut self, sets: ParameterSets) -> Result<(), StoreError> {
        self.begun = None;
        self.begun = Some(self.begin_sets(sets).map_err(medium)?);
        Ok(())
    }

    fn append(&mut self, set: ParameterSet, chunk: &[u8]) -> Result<(), StoreError> {
        let mut begun = self.begun.take().ok_or(StoreError::Medium)?;
        self.append_chunk(&mut begun, set, chunk).map_err(medium)?;
        self.begun = Some(begun);
        Ok(())
    }

    fn commit(&mut self) -> Result<(), StoreError> {
        let begun = self.begun.take().ok_or(StoreError::Medium)?;
        self.commit_sets(&begun).map_err(medium)
    }

    fn open(&mut self, set: ParameterSet) -> Result<u16, StoreError> {
        self.opened = None;
        let opened = self.open_set(set).map_err(medium)?;
        let chunks = u16::from(opened.part.chunks);
        self.opened = Some(opened);
        Ok(chunks)
    }

    fn read(
        &mut self,
        set: ParameterSet,
        number: u16,
        chunk: &mut [u8; CHUNK],
    ) -> Result<usize, StoreError> {
        self.read_chunk(set, number, chunk).map_err(medium)
    }

    fn keep_serial_number(&mut self, number: u32) -> Result<(), StoreError> {
        self.save_serial_number(number).map_err(medium)
    }
}

fn medium<E>(_: Error<E>) -> StoreError {
    StoreError::Medium
}
