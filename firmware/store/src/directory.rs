//! The directory: which chunks each set of parameters has, and a checksum over them. It is one record of the log, so all sets
//! change at once.

use canopen::cia301::parameters::{ParameterSet, ParameterSets};
use crc::{CRC_32_ISCSI, Crc, NoTable};
use sequential_storage::map::{SerializationError, Value};

/// Key of the directory. A key that was ever used keeps its meaning.
pub const DIRECTORY: u8 = 0x20;

/// Most chunks of a set: what is left of a key, of which two bits name the set and one the half; number 0 is for other records.
pub const MOST_CHUNKS: u8 = 31;

/// Layout 1: layout, then for each set half and number of chunks, length (2 bytes), checksum (4 bytes).
const LAYOUT: u8 = 1;

/// Bytes of a set in the directory.
const PART: usize = 7;

/// Bytes of the directory.
pub const BYTES: usize = 1 + PART * ParameterSet::COUNT;

/// The bit of the half.
const HALF: u8 = 1 << 7;

const CHECKSUM: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISCSI);

/// The chunks of one set. Each set has two places for them, its halves: new chunks are written to the one that is not in
/// force.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Part {
    /// Which half.
    pub half: bool,
    /// How many chunks.
    pub chunks: u8,
    /// Their bytes together.
    pub length: u16,
    /// The checksum over the chunks, each chained to that of those before it.
    pub checksum: u32,
}

impl Part {
    /// No chunks, in the other half.
    pub fn renewed(self) -> Self {
        Self {
            half: !self.half,
            ..Self::default()
        }
    }

    /// With one chunk more; `None` if it has no place.
    pub fn with(self, chunk: &[u8]) -> Option<Self> {
        if self.chunks == MOST_CHUNKS {
            return None;
        }
        let length = u16::try_from(chunk.len()).ok()?;
        let mut checksum = CHECKSUM.digest();
        checksum.update(&self.checksum.to_le_bytes());
        checksum.update(chunk);
        Some(Self {
            half: self.half,
            chunks: self.chunks.checked_add(1)?,
            length: self.length.checked_add(length)?,
            checksum: checksum.finalize(),
        })
    }

    /// The key of chunk `number`, counted from 0; `None` beyond the last that may be.
    pub fn key(self, set: ParameterSet, number: u8) -> Option<u8> {
        let half = u8::from(self.half) << 5;
        let number = number.checked_add(1)?;
        (number <= MOST_CHUNKS).then_some((set as u8) << 6 | half | number)
    }

    fn to_bytes(self) -> [u8; PART] {
        let half = if self.half { HALF } else { 0 };
        let [l0, l1] = self.length.to_le_bytes();
        let [c0, c1, c2, c3] = self.checksum.to_le_bytes();
        [half | self.chunks, l0, l1, c0, c1, c2, c3]
    }

    fn from_bytes([first, l0, l1, c0, c1, c2, c3]: [u8; PART]) -> Self {
        Self {
            half: first & HALF != 0,
            chunks: (first & !HALF).min(MOST_CHUNKS),
            length: u16::from_le_bytes([l0, l1]),
            checksum: u32::from_le_bytes([c0, c1, c2, c3]),
        }
    }
}

/// The chunks of all sets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Directory([Part; ParameterSet::COUNT]);

impl Directory {
    /// The chunks of a set.
    pub fn part(&self, set: ParameterSet) -> Part {
        let [date, communication, application, manufacturer] = self.0;
        match set {
            ParameterSet::ConfigurationDate => date,
            ParameterSet::Communication => communication,
            ParameterSet::Application => application,
            ParameterSet::Manufacturer => manufacturer,
        }
    }

    /// Changes the chunks of a set.
    pub fn set_part(&mut self, set: ParameterSet, part: Part) {
        let [date, communication, application, manufacturer] = &mut self.0;
        *match set {
            ParameterSet::ConfigurationDate => date,
            ParameterSet::Communication => communication,
            ParameterSet::Application => application,
            ParameterSet::Manufacturer => manufacturer,
        } = part;
    }

    /// These sets begin anew.
    pub fn renewed(mut self, sets: ParameterSets) -> Self {
        for set in ParameterSet::ALL {
            if sets.has(set) {
                self.set_part(set, self.part(set).renewed());
            }
        }
        self
    }
}

impl Value<'_> for Directory {
    fn serialize_into(&self, buffer: &mut [u8]) -> Result<usize, SerializationError> {
        let bytes: &mut [u8; BYTES] = buffer
            .first_chunk_mut()
            .ok_or(SerializationError::BufferTooSmall)?;
        let [layout, parts @ ..] = bytes;
        *layout = LAYOUT;
        let (parts, _) = parts.as_chunks_mut::<PART>();
        for (bytes, part) in parts.iter_mut().zip(self.0) {
            *bytes = part.to_bytes();
        }
        Ok(BYTES)
    }

    fn deserialize_from(buffer: &[u8]) -> Result<(Self, usize), SerializationError> {
        let bytes: &[u8; BYTES] = buffer
            .first_chunk()
            .ok_or(SerializationError::InvalidFormat)?;
        let [layout, parts @ ..] = bytes;
        if *layout != LAYOUT || buffer.len() != BYTES {
            return Err(SerializationError::InvalidFormat);
        }
        let mut directory = Self::default();
        let (parts, _) = parts.as_chunks::<PART>();
        for (part, bytes) in directory.0.iter_mut().zip(parts) {
            *part = Part::from_bytes(*bytes);
        }
        Ok((directory, BYTES))
    }
}
