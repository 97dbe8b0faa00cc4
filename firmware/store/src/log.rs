//! Records in two banks of NOR flash.
//!
//! A bank is written from its front, record behind record, and is erased as a whole. A record is a header, its payload, and in
//! the last byte of its last word a mark that is no longer erased when the record was written to its end. The header carries
//! a checksum over itself and its address, and one over the payload: what lies anywhere else, or was changed by one bit,
//! is no record. So whatever somebody has written into a bank, the records before and behind it are found.

use core::ops::Range;

use canopen::cia301::parameters::CHUNK;
use crc::{CRC_32_ISCSI, Crc, NoTable};
use embedded_storage::nor_flash::NorFlash;

use crate::{Error, MAX_WRITE_SIZE};

/// The checksum of records and of sets.
pub const CHECKSUM: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISCSI);

/// Key, length, checksum of the payload, checksum of all this and the address.
const HEADER: usize = 10;

/// The mark at the end of a record.
const MARK: u8 = 0;

const ERASED: u8 = 0xFF;

/// Bytes of the longest record, in whole words of any flash.
pub const BUFFER: usize = (HEADER + CHUNK + 1).next_multiple_of(MAX_WRITE_SIZE);

const _: () = assert!(CHUNK < ERASED as usize, "an erased length is none");

/// One half of the sectors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bank {
    /// The first sectors.
    First,
    /// The sectors behind them.
    Second,
}

impl Bank {
    /// Both.
    pub const ALL: [Self; 2] = [Self::First, Self::Second];

    /// The other one.
    pub const fn other(self) -> Self {
        match self {
            Self::First => Self::Second,
            Self::Second => Self::First,
        }
    }
}

/// A record whose header is whole.
#[derive(Clone, Copy, Debug)]
pub struct Record {
    /// What it is.
    pub key: u8,
    /// Where it begins.
    pub from: u32,
    /// Where the next one begins.
    pub end: u32,
    length: u8,
    checksum: u32,
}

/// The flash and its banks.
#[derive(Debug)]
pub struct Log<F> {
    pub flash: F,
    start: u32,
    /// Bytes of a bank.
    bank: u32,
}

impl<F: NorFlash> Log<F> {
    /// The unit in which records are placed.
    const WORD: usize = if F::READ_SIZE > F::WRITE_SIZE {
        F::READ_SIZE
    } else {
        F::WRITE_SIZE
    };

    /// Banks in the sectors of `range`; `None` unless they are two or more whole sectors of a flash that this log can drive. Of an odd
    /// number of sectors the last one is left alone.
    pub fn new(flash: F, range: &Range<u32>) -> Option<Self> {
        let sector = u32::try_from(F::ERASE_SIZE).ok()?;
        let word = u32::try_from(Self::WORD).ok()?;
        let units_fit = Self::WORD <= MAX_WRITE_SIZE && sector.checked_rem(word)? == 0;
        let inside = usize::try_from(range.end).is_ok_and(|end| end <= flash.capacity());
        let bytes = range.end.checked_sub(range.start)?;
        let whole = range.start.checked_rem(sector)? == 0 && bytes.checked_rem(sector)? == 0;
        let bank = (bytes.checked_div(sector)? / 2).checked_mul(sector)?;
        (units_fit && inside && whole && bank > 0).then_some(Self {
            flash,
            start: range.start,
            bank,
        })
    }

    /// Where a bank begins and ends.
    #[inline(never)]
    pub fn limits(&self, bank: Bank) -> Range<u32> {
        let middle = self.start.saturating_add(self.bank);
        match bank {
            Bank::First => self.start..middle,
            Bank::Second => middle..middle.saturating_add(self.bank),
        }
    }

    /// Bytes of flash that a payload of this length takes.
    pub fn size(length: usize) -> u32 {
        let bytes = (HEADER + 1).saturating_add(length);
        u32::try_from(bytes.next_multiple_of(Self::WORD)).unwrap_or(u32::MAX)
    }

    /// The first record in `place`, and what it passes by to find it is none.
    pub fn next(&mut self, place: Range<u32>) -> Result<Option<Record>, Error<F::Error>> {
        let mut at = place.start;
        while at < place.end {
            if let Some(record) = self.record(at..place.end)? {
                return Ok(Some(record));
            }
            at = at.saturating_add(self.step(at..place.end)?);
        }
        Ok(None)
    }

    /// How far the place of the next record may be where there is none.
    fn step(&mut self, place: Range<u32>) -> Result<u32, Error<F::Error>> {
        let block = u32::try_from(BUFFER).unwrap_or(0);
        let word = u32::try_from(Self::WORD).unwrap_or(1);
        let end = place.start.saturating_add(block).min(place.end);
        // An erased length is none, so at most the last word of an erased block begins a record.
        Ok(if self.is_erased(place.start..end)? {
            (end - place.start).saturating_sub(word).max(word)
        } else {
            word
        })
    }

    /// The record that begins where `place` does.
    // Out of line, as all that has a buffer: who calls it would have that on the stack as long as it runs.
    #[inline(never)]
    pub fn record(&mut self, place: Range<u32>) -> Result<Option<Record>, Error<F::Error>> {
        let mut buffer = [0; BUFFER];
        let size = Self::size(0);
        if place.end.saturating_sub(place.start) < size {
            return Ok(None);
        }
        let header = self.read(place.start, HEADER, &mut buffer)?;
        let Some((&fields, &sum)) = header
            .split_first_chunk::<6>()
            .and_then(|(fields, rest)| Some((fields, rest.first_chunk::<4>()?)))
        else {
            return Ok(None);
        };
        let [key, length, c0, c1, c2, c3] = fields;
        let end = place.start.saturating_add(Self::size(usize::from(length)));
        let is_one = usize::from(length) <= CHUNK
            && end <= place.end
            && header_checksum(place.start, fields) == u32::from_le_bytes(sum);
        Ok(is_one.then_some(Record {
            key,
            from: place.start,
            end,
            length,
            checksum: u32::from_le_bytes([c0, c1, c2, c3]),
        }))
    }

    /// The payload of a record; `None` if it is not what was written.
    pub fn payload<'b>(
        &mut self,
        record: &Record,
        buffer: &'b mut [u8; BUFFER],
    ) -> Result<Option<&'b [u8]>, Error<F::Error>> {
        let length = HEADER.saturating_add(usize::from(record.length));
        let payload = self.read(record.from, length, buffer)?.get(HEADER..);
        Ok(payload.filter(|payload| CHECKSUM.checksum(payload) == record.checksum))
    }

    /// Whether a record was begun and not ended: the power was cut.
    #[inline(never)]
    pub fn is_cut(&mut self, record: &Record) -> Result<bool, Error<F::Error>> {
        let word = u32::try_from(Self::WORD).unwrap_or(1);
        let mut buffer = [0; BUFFER];
        let last = self.read(record.end.saturating_sub(word), Self::WORD, &mut buffer)?;
        Ok(last.last() == Some(&ERASED))
    }

    /// Writes a record where `place`, which is erased, begins, and reads it back. Returns where it ends; `None` without writing if it
    /// does not fit.
    pub fn append(
        &mut self,
        place: Range<u32>,
        key: u8,
        payload: &[u8],
    ) -> Result<Option<u32>, Error<F::Error>> {
        let at = place.start;
        let end = at.saturating_add(Self::size(payload.len()));
        let length = u8::try_from(payload.len()).map_err(|_| Error::Content)?;
        if end > place.end {
            return Ok(None);
        }
        let [c0, c1, c2, c3] = CHECKSUM.checksum(payload).to_le_bytes();
        let fields = [key, length, c0, c1, c2, c3];
        let sum = header_checksum(at, fields).to_le_bytes();
        let size = usize::try_from(end.saturating_sub(at)).map_err(|_| Error::Content)?;
        let mut buffer = [ERASED; BUFFER];
        let bytes = buffer.get_mut(..size).ok_or(Error::Content)?;
        let content = fields.iter().chain(&sum).chain(payload);
        for (byte, &content) in bytes.iter_mut().zip(content) {
            *byte = content;
        }
        if let Some(last) = bytes.last_mut() {
            *last = MARK;
        }
        self.flash.write(at, bytes).map_err(Error::Flash)?;
        let mut buffer = [0; BUFFER];
        if self.read(at, size, &mut buffer)? == bytes {
            Ok(Some(end))
        } else {
            Err(Error::Verify)
        }
    }

    /// Whether nothing was ever written here since it was erased.
    #[inline(never)]
    pub fn is_erased(&mut self, place: Range<u32>) -> Result<bool, Error<F::Error>> {
        let mut at = place.start;
        let mut buffer = [0; BUFFER];
        while at < place.end {
            let rest = usize::try_from(place.end - at).unwrap_or(BUFFER);
            let bytes = self.read(at, rest.min(BUFFER), &mut buffer)?;
            if bytes.iter().any(|byte| *byte != ERASED) {
                return Ok(false);
            }
            at = at.saturating_add(u32::try_from(bytes.len()).unwrap_or(u32::MAX));
        }
        Ok(true)
    }

    /// Whether what lies from `place` on, where no record begins, may be a header that a power cut has left, or nothing: the log goes no
    /// further.
    pub fn is_end(&mut self, place: Range<u32>) -> Result<bool, Error<F::Error>> {
        let behind = place.start.saturating_add(Self::size(0)).min(place.end);
        Ok(self.is_erased(behind..place.end)? || self.is_erased(place.start..behind)?)
    }

    /// Erases a bank if it is not.
    pub fn erase(&mut self, bank: Bank) -> Result<(), Error<F::Error>> {
        let place = self.limits(bank);
        if self.is_erased(place.clone())? {
            return Ok(());
        }
        self.flash
            .erase(place.start, place.end)
            .map_err(Error::Flash)?;
        if self.is_erased(place)? {
            Ok(())
        } else {
            Err(Error::Verify)
        }
    }

    /// Bytes from `at` on, read in whole words.
    fn read<'b>(
        &mut self,
        at: u32,
        length: usize,
        buffer: &'b mut [u8; BUFFER],
    ) -> Result<&'b [u8], Error<F::Error>> {
        let words = length.next_multiple_of(F::READ_SIZE);
        let bytes = buffer.get_mut(..words).ok_or(Error::Content)?;
        self.flash.read(at, bytes).map_err(Error::Flash)?;
        bytes.get(..length).ok_or(Error::Content)
    }
}

fn header_checksum(address: u32, fields: [u8; 6]) -> u32 {
    let mut checksum = CHECKSUM.digest();
    checksum.update(&address.to_le_bytes());
    checksum.update(&fields);
    checksum.finalize()
}
