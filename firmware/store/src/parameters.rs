//! The sets of parameters: chunks, and the directory that says which of them count.

use canopen::cia301::parameters::{CHUNK, ParameterSet, ParameterSets, ParameterStore};
use canopen::node::StoreError;
use embedded_storage::nor_flash::NorFlash;

use crate::directory::{BYTES, Directory, Part};
use crate::log::{BUFFER, Bank, Log};
use crate::{Error, Store, taken};

/// Sets that are being written.
#[derive(Clone, Copy, Debug)]
pub struct Begun {
    sets: ParameterSets,
    /// The sets to be.
    directory: Directory,
}

impl Begun {
    /// What there is of a set to be.
    pub fn part(&self, set: ParameterSet) -> Option<Part> {
        self.sets.has(set).then(|| self.directory.part(set))
    }
}

/// The set that is being read.
#[derive(Debug)]
pub struct Opened {
    set: ParameterSet,
    part: Part,
}

impl<F: NorFlash> Store<F> {
    /// Copies chunk `number` of a set out of a bank: of several the last. `None` if there is none that is whole.
    fn chunk<'b>(
        &mut self,
        bank: Bank,
        (set, part, number): (ParameterSet, Part, u8),
        buffer: &'b mut [u8; BUFFER],
    ) -> Result<Option<&'b [u8]>, Error<F::Error>> {
        let Some(key) = part.key(set, number) else {
            return Ok(None);
        };
        let mut place = self.log.limits(bank);
        let mut last = None;
        while let Some(record) = self.log.next(place.clone())? {
            place.start = record.end;
            if record.key == key {
                last = Some(record);
            }
        }
        match last {
            Some(record) => self.log.payload(&record, buffer),
            None => Ok(None),
        }
    }

    /// Whether the chunks of a set are what was stored.
    pub(crate) fn is_whole(
        &mut self,
        bank: Bank,
        set: ParameterSet,
        wanted: Part,
    ) -> Result<bool, Error<F::Error>> {
        let mut part = Part {
            half: wanted.half,
            ..Part::default()
        };
        while part.chunks < wanted.chunks {
            let mut buffer = [0; BUFFER];
            let chunk = self.chunk(bank, (set, part, part.chunks), &mut buffer)?;
            match chunk.and_then(|chunk| part.with(chunk)) {
                Some(longer) => part = longer,
                None => return Ok(false),
            }
        }
        Ok(part == wanted)
    }

    /// Copies the chunks of a set to `to` in the other bank. Returns where they end.
    pub(crate) fn copy(
        &mut self,
        bank: Bank,
        (set, part): (ParameterSet, Part),
        mut to: core::ops::Range<u32>,
    ) -> Result<u32, Error<F::Error>> {
        for number in 0..part.chunks {
            let mut buffer = [0; BUFFER];
            let chunk = self.chunk(bank, (set, part, number), &mut buffer)?;
            let chunk = chunk.ok_or(Error::Verify)?;
            let key = part.key(set, number).ok_or(Error::Full)?;
            to.start = self
                .log
                .append(to.clone(), key, chunk)?
                .ok_or(Error::Full)?;
        }
        Ok(to.start)
    }

    /// Writes a chunk so that a directory fits behind it.
    fn put_chunk(&mut self, key: u8, chunk: &[u8]) -> Result<bool, Error<F::Error>> {
        let found = self.found()?;
        let Some(mut place) = self.free(&found)? else {
            return Ok(false);
        };
        place.end = place.end.saturating_sub(Log::<F>::size(BYTES));
        taken(self.log.append(place, key, chunk))
    }

    fn append_chunk(
        &mut self,
        mut begun: Begun,
        set: ParameterSet,
        chunk: &[u8],
    ) -> Result<Begun, Error<F::Error>> {
        if !begun.sets.has(set) || chunk.is_empty() || chunk.len() > CHUNK {
            return Err(Error::Content);
        }
        let part = begun.directory.part(set);
        let longer = part.with(chunk).ok_or(Error::Full)?;
        let key = part.key(set, part.chunks).ok_or(Error::Full)?;
        if !self.put_chunk(key, chunk)? {
            let found = self.found()?;
            self.move_on(found.directory)?;
            if !self.put_chunk(key, chunk)? {
                return Err(Error::Full);
            }
        }
        begun.directory.set_part(set, longer);
        Ok(begun)
    }

    fn commit_sets(&mut self, begun: &Begun) -> Result<(), Error<F::Error>> {
        let found = self.found()?;
        let mut directory = found.directory;
        for set in ParameterSet::ALL {
            if let Some(part) = begun.part(set) {
                if !self.is_whole(found.bank, set, part)? {
                    return Err(Error::Verify);
                }
                directory.set_part(set, part);
            }
        }
        self.put(directory)
    }

    fn open_set(&mut self, set: ParameterSet) -> Result<Opened, Error<F::Error>> {
        let found = self.found()?;
        let part = found.directory.part(set);
        if !part.is_lost && self.is_whole(found.bank, set, part)? {
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
        let number = u8::try_from(number)
            .ok()
            .filter(|number| *number < part.chunks)
            .ok_or(Error::Content)?;
        let bank = self.found()?.bank;
        let mut buffer = [0; BUFFER];
        let stored = self
            .chunk(bank, (set, part, number), &mut buffer)?
            .ok_or(Error::Damaged)?;
        let room = chunk.get_mut(..stored.len()).ok_or(Error::Content)?;
        room.copy_from_slice(stored);
        Ok(stored.len())
    }
}

/// To the device every failure of the store is one of its medium; [`Error`] is for the firmware.
impl<F: NorFlash> ParameterStore for Store<F> {
    fn begin(&mut self, sets: ParameterSets) -> Result<(), StoreError> {
        self.begun = None;
        let directory = self.found().map_err(medium)?.directory.renewed(sets);
        self.begun = Some(Begun { sets, directory });
        Ok(())
    }

    fn append(&mut self, set: ParameterSet, chunk: &[u8]) -> Result<(), StoreError> {
        let begun = self.begun.ok_or(StoreError::Medium)?;
        match self.append_chunk(begun, set, chunk) {
            Ok(longer) => {
                self.begun = Some(longer);
                Ok(())
            }
            Err(error) => {
                self.begun = None;
                Err(medium(error))
            }
        }
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
