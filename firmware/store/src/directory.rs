//! The directory: what is stored, as one record. It has the settings, the serial number, and for each set of parameters which
//! chunks it has and a checksum over them. The newest directory counts, so all that is stored changes at once.

use canopen::cia301::parameters::{ParameterSet, ParameterSets};
use canopen::{BitTiming, Configuration, NodeId};

use crate::Error;
use crate::log::CHECKSUM;

/// Key of the directory. A key that was ever used keeps its meaning.
pub const DIRECTORY: u8 = 0x20;

/// Most chunks of a set: what is left of a key, of which two bits name the set and one the half; number 0 is for other records.
pub const MOST_CHUNKS: u8 = 31;

/// Layout 1: layout, number of the directory (4 bytes), settings (3), serial number (5), then each set (7). Zeros at the end
/// are not written. All layouts have the first two in these places, and the serial number in its.
const LAYOUT: u8 = 1;

/// Bytes of a set in the directory.
const PART: usize = 7;

/// Bytes of what is before the sets.
const FIXED: usize = 13;

/// Most bytes of the directory.
pub const BYTES: usize = FIXED + PART * ParameterSet::COUNT;

/// The bit of the half.
const HALF: u8 = 1 << 7;

/// The bit of what was lost.
const LOST: u8 = 1 << 6;

/// The chunks of one set. Each set has two places for them, its halves: new chunks are written to the one that is not in
/// force.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Part {
    /// Which half.
    pub half: bool,
    /// It was damaged, and has not been stored since.
    pub is_lost: bool,
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

    /// No chunks, and that is not as it should be.
    pub fn lost(self) -> Self {
        Self {
            half: self.half,
            is_lost: true,
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
            chunks: self.chunks.checked_add(1)?,
            length: self.length.checked_add(length)?,
            checksum: checksum.finalize(),
            ..self
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
        let lost = if self.is_lost { LOST } else { 0 };
        let [l0, l1] = self.length.to_le_bytes();
        let [c0, c1, c2, c3] = self.checksum.to_le_bytes();
        [half | lost | self.chunks, l0, l1, c0, c1, c2, c3]
    }

    fn from_bytes([first, l0, l1, c0, c1, c2, c3]: [u8; PART]) -> Self {
        Self {
            half: first & HALF != 0,
            is_lost: first & LOST != 0,
            chunks: (first & !(HALF | LOST)).min(MOST_CHUNKS),
            length: u16::from_le_bytes([l0, l1]),
            checksum: u32::from_le_bytes([c0, c1, c2, c3]),
        }
    }
}

/// Node-ID and bit rate, as the layer setting services store them (CiA 305, service 17h). The bit rate is an index of table 0 of
/// CiA 305, 9 for one that is to be found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Settings {
    /// Never stored.
    #[default]
    None,
    /// Node-ID and index of the bit rate.
    Stored(u8, u8),
    /// They were damaged, and have not been stored since.
    Lost,
}

impl Settings {
    /// How these are kept.
    pub fn of(settings: &Configuration) -> Self {
        Self::Stored(settings.node_id.get(), settings.bit_timing.table_index())
    }

    /// What they mean.
    pub fn configuration<E>(self) -> Result<Option<Configuration>, Error<E>> {
        let (node_id, bit_timing) = match self {
            Self::None => return Ok(None),
            Self::Lost => return Err(Error::Damaged),
            Self::Stored(node_id, bit_timing) => (
                NodeId::new(node_id),
                BitTiming::from_stored_index(bit_timing),
            ),
        };
        match (node_id, bit_timing) {
            (Some(node_id), Some(bit_timing)) => Ok(Some(Configuration {
                node_id,
                bit_timing,
            })),
            _ => Err(Error::Content),
        }
    }

    const fn to_bytes(self) -> [u8; 3] {
        match self {
            Self::None => [0; 3],
            Self::Stored(node_id, bit_timing) => [1, node_id, bit_timing],
            Self::Lost => [2, 0, 0],
        }
    }

    const fn from_bytes(bytes: [u8; 3]) -> Self {
        match bytes {
            [0, ..] => Self::None,
            [1, node_id, bit_timing] => Self::Stored(node_id, bit_timing),
            _ => Self::Lost,
        }
    }
}

/// What is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Directory {
    /// The layout it was read in.
    pub layout: u8,
    /// How many there were before it; it wraps.
    pub number: u32,
    /// Node-ID and bit rate.
    pub settings: Settings,
    /// The serial number that production has given.
    pub serial_number: Option<u32>,
    parts: [Part; ParameterSet::COUNT],
}

impl Default for Directory {
    /// Nothing was ever stored.
    fn default() -> Self {
        Self {
            layout: LAYOUT,
            number: 0,
            settings: Settings::None,
            serial_number: None,
            parts: [Part::default(); ParameterSet::COUNT],
        }
    }
}

impl Directory {
    /// Whether it is newer than the other one.
    pub const fn is_newer_than(&self, other: &Self) -> bool {
        self.number.wrapping_sub(other.number).cast_signed() > 0
    }

    /// Everything was lost but the serial number, which never changes.
    pub fn lost(mut self) -> Self {
        self.settings = Settings::Lost;
        self.parts = self.parts.map(Part::lost);
        self
    }

    /// Whether anything was lost and has not been stored since.
    pub fn has_losses(&self) -> bool {
        self.settings == Settings::Lost || self.parts.iter().any(|part| part.is_lost)
    }

    /// Whether the layout is one of a later firmware, of which this one understands but the serial number.
    pub const fn is_later(&self) -> bool {
        self.layout != LAYOUT
    }

    /// The chunks of a set.
    #[inline(never)]
    pub fn part(&self, set: ParameterSet) -> Part {
        let [date, communication, application, manufacturer] = self.parts;
        match set {
            ParameterSet::ConfigurationDate => date,
            ParameterSet::Communication => communication,
            ParameterSet::Application => application,
            ParameterSet::Manufacturer => manufacturer,
        }
    }

    /// Changes the chunks of a set.
    pub fn set_part(&mut self, set: ParameterSet, part: Part) {
        let [date, communication, application, manufacturer] = &mut self.parts;
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

    /// The record, written into `bytes`.
    pub fn write<'b>(&self, bytes: &'b mut [u8; BYTES]) -> &'b [u8] {
        let [n0, n1, n2, n3] = self.number.to_le_bytes();
        let [s0, s1, s2] = self.settings.to_bytes();
        let [i0, i1, i2, i3] = self.serial_number.unwrap_or(0).to_le_bytes();
        let has_number = u8::from(self.serial_number.is_some());
        let fixed: [u8; FIXED] = [
            LAYOUT, n0, n1, n2, n3, s0, s1, s2, has_number, i0, i1, i2, i3,
        ];
        let parts = self.parts.iter().flat_map(|part| part.to_bytes());
        let mut length = 0;
        for (at, (byte, content)) in bytes
            .iter_mut()
            .zip(fixed.into_iter().chain(parts))
            .enumerate()
        {
            *byte = content;
            if content != 0 {
                length = at.saturating_add(1);
            }
        }
        bytes.get(..length).unwrap_or_default()
    }

    /// The directory in a record.
    pub fn read(record: &[u8]) -> Self {
        let mut bytes = [0; BYTES];
        for (byte, &content) in bytes.iter_mut().zip(record) {
            *byte = content;
        }
        let [
            layout,
            n0,
            n1,
            n2,
            n3,
            s0,
            s1,
            s2,
            has_number,
            i0,
            i1,
            i2,
            i3,
            rest @ ..,
        ] = bytes;
        let (parts, _) = rest.as_chunks::<PART>();
        let mut directory = Self {
            layout,
            number: u32::from_le_bytes([n0, n1, n2, n3]),
            settings: Settings::from_bytes([s0, s1, s2]),
            serial_number: (has_number != 0).then_some(u32::from_le_bytes([i0, i1, i2, i3])),
            ..Self::default()
        };
        for (part, bytes) in directory.parts.iter_mut().zip(parts) {
            *part = Part::from_bytes(*bytes);
        }
        if directory.is_later() {
            directory = directory.lost();
        }
        directory
    }
}
