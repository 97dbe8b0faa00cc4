//! The two records of a PDO: what a master may write into them, and when.
//!
//! | write | refused with |
//! |---|---|
//! | COB-ID: 29-bit identifier, a restricted identifier, another identifier while valid | 06090030h |
//! | transmission type: 241 to 251 (reserved), 252 and 253 (only on request) | 06090030h |
//! | inhibit time of a transmit PDO while valid | 06090030h |
//! | deadline of a receive PDO, SYNC start value: anything but 0 | 06090030h |
//! | mapping, anything while the PDO is valid; an entry while sub-index 0 is not 0 | 06010000h |
//! | mapping entry: no such object | 06020000h, 06090011h |
//! | mapping entry: not mappable, wrong direction, not its own length, a dummy to transmit | 06040041h |
//! | mapping sub-index 0: above 8, or more than 64 bits together | 06040042h |
//! | mapping sub-index 0: counts an empty entry | 06040041h |

use super::mapping::{Direction, MOST_OBJECTS, Mapping, MappingEntry};
use crate::cia301::sdo::AbortCode;
use crate::od::{Dictionary, Entry, find, value};
use crate::wire::cob_id::{CobId, is_restricted};

/// Whether a PDO with the COB-ID `present` may get `new` (CiA 301, 7.5.2.35 and 7.5.2.37). Bit 30 of a transmit PDO (no RTR)
/// is kept as written and has no effect: RTR is never answered.
fn check_cob_id(present: CobId, new: CobId) -> Result<(), AbortCode> {
    let moved = present.is_valid() && new.is_valid() && present.identifier() != new.identifier();
    let taken = new.is_valid() && is_restricted(new.identifier());
    if !new.is_base_frame() || moved || taken {
        Err(AbortCode::InvalidValue)
    } else {
        Ok(())
    }
}

/// Transmission types (CiA 301, 7.5.2.36).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TransmissionType {
    /// 0: synchronous, after an event.
    Acyclic,
    /// 1 to 240: synchronous, every n-th SYNC.
    Cyclic(u8),
    /// 254 and 255: event-driven.
    Event,
}

impl TransmissionType {
    /// From its number; `None` for 241 to 253.
    pub(super) const fn new(number: u8) -> Option<Self> {
        match number {
            0 => Some(Self::Acyclic),
            1..=240 => Some(Self::Cyclic(number)),
            254 | 255 => Some(Self::Event),
            241..=253 => None,
        }
    }
}

/// Which of the two records.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Record {
    /// 1400h, 1800h and on.
    Communication,
    /// 1600h, 1A00h and on.
    Mapping,
}

/// The records of one PDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Parameters {
    direction: Direction,
    /// 0 for the first PDO.
    number: u16,
}

impl Parameters {
    /// Most PDOs in one direction (CiA 301).
    const MOST: u16 = 512;

    pub(super) const fn new(direction: Direction, number: u16) -> Self {
        Self { direction, number }
    }

    /// The PDO that an object of this direction belongs to.
    pub(super) fn of(direction: Direction, index: u16) -> Option<(Self, Record)> {
        let offset = index.checked_sub(Self::new(direction, 0).communication())?;
        let (record, number) = match offset {
            0..Self::MOST => (Record::Communication, offset),
            _ => (Record::Mapping, offset.checked_sub(Self::MOST)?),
        };
        (number < Self::MOST).then_some((Self::new(direction, number), record))
    }

    /// 0 for the first PDO.
    pub(super) fn number(self) -> usize {
        usize::from(self.number)
    }

    fn communication(self) -> u16 {
        let first = match self.direction {
            Direction::Receive => 0x1400_u16,
            Direction::Transmit => 0x1800,
        };
        first.saturating_add(self.number)
    }

    fn mapping(self) -> u16 {
        self.communication().saturating_add(Self::MOST)
    }

    fn cob_id<D: Dictionary>(self, dictionary: &D) -> CobId {
        CobId(number(dictionary, self.communication(), 1).unwrap_or(CobId::INVALID))
    }

    /// The identifier of a PDO in use; `None` while it is not valid, or cannot be an 11-bit identifier.
    pub(super) fn identifier<D: Dictionary>(self, dictionary: &D) -> Option<u16> {
        let cob_id = self.cob_id(dictionary);
        (cob_id.is_valid() && cob_id.is_base_frame()).then(|| cob_id.identifier())
    }

    /// The transmission type; `None` when it is not supported or missing.
    pub(super) fn transmission_type<D: Dictionary>(
        self,
        dictionary: &D,
    ) -> Option<TransmissionType> {
        TransmissionType::new(u8::try_from(number(dictionary, self.communication(), 2)?).ok()?)
    }

    /// The inhibit time in multiples of 100 µs; 0 for none.
    pub(super) fn inhibit_time<D: Dictionary>(self, dictionary: &D) -> u32 {
        number(dictionary, self.communication(), 3).unwrap_or(0)
    }

    /// The event timer in milliseconds; 0 for none.
    pub(super) fn event_timer<D: Dictionary>(self, dictionary: &D) -> u32 {
        number(dictionary, self.communication(), 5).unwrap_or(0)
    }

    /// The mapping that the dictionary holds, resolved.
    ///
    /// # Errors
    /// As for a write of sub-index 0.
    pub(super) fn resolve<D: Dictionary>(self, dictionary: &D) -> Result<Mapping, AbortCode> {
        let count = number(dictionary, self.mapping(), 0).unwrap_or(0);
        self.resolve_first(dictionary, u8::try_from(count).unwrap_or(u8::MAX))
    }

    /// The first `count` mapping entries, resolved.
    fn resolve_first<D: Dictionary>(self, dictionary: &D, count: u8) -> Result<Mapping, AbortCode> {
        if usize::from(count) > MOST_OBJECTS {
            return Err(AbortCode::PdoLengthExceeded);
        }
        let mut mapping = Mapping::new();
        for sub in 1..=count {
            let entry = MappingEntry(number(dictionary, self.mapping(), sub).unwrap_or(0));
            if entry == MappingEntry::EMPTY {
                return Err(AbortCode::NotMappable);
            }
            mapping.push(entry.resolve(D::TABLE, self.direction)?)?;
        }
        Ok(mapping)
    }

    /// Whether a sub-index of one of the records may get this value. Nothing changes.
    ///
    /// # Errors
    /// Those of the table above.
    pub(super) fn validate<D: Dictionary>(
        self,
        dictionary: &D,
        record: Record,
        entry: &Entry,
        value: &[u8],
    ) -> Result<(), AbortCode> {
        match record {
            Record::Communication => self.validate_communication(dictionary, entry.sub, value),
            Record::Mapping => self.validate_mapping(dictionary, entry.sub, value),
        }
    }

    fn validate_communication<D: Dictionary>(
        self,
        dictionary: &D,
        sub: u8,
        value: &[u8],
    ) -> Result<(), AbortCode> {
        let present = self.cob_id(dictionary);
        match (sub, self.direction) {
            (1, _) => {
                let new = CobId(u32::from_le_bytes(bytes(value)?));
                check_cob_id(present, new)?;
                if new.is_valid() && !present.is_valid() {
                    // A mapping that came from elsewhere than a checked write must not be found out by its first frame.
                    self.resolve(dictionary)?;
                }
                Ok(())
            }
            (2, _) => {
                let [number] = bytes(value)?;
                TransmissionType::new(number)
                    .map(|_| ())
                    .ok_or(AbortCode::InvalidValue)
            }
            (3, Direction::Transmit) if present.is_valid() => Err(AbortCode::InvalidValue),
            // A receive PDO makes no use of its inhibit time.
            (3, _) | (5, Direction::Transmit) => Ok(()),
            (5 | 6, _) if value.iter().any(|byte| *byte != 0) => Err(AbortCode::InvalidValue),
            (5 | 6, _) => Ok(()),
            _ => Err(AbortCode::NoSubIndex),
        }
    }

    fn validate_mapping<D: Dictionary>(
        self,
        dictionary: &D,
        sub: u8,
        value: &[u8],
    ) -> Result<(), AbortCode> {
        if self.cob_id(dictionary).is_valid() {
            return Err(AbortCode::UnsupportedAccess);
        }
        if sub == 0 {
            let [count] = bytes(value)?;
            return self.resolve_first(dictionary, count).map(|_| ());
        }
        if number(dictionary, self.mapping(), 0) != Some(0) {
            return Err(AbortCode::UnsupportedAccess);
        }
        match MappingEntry(u32::from_le_bytes(bytes(value)?)) {
            MappingEntry::EMPTY => Ok(()),
            entry => entry.resolve(D::TABLE, self.direction).map(|_| ()),
        }
    }
}

/// The bytes of a number with `N` bytes.
fn bytes<const N: usize>(value: &[u8]) -> Result<[u8; N], AbortCode> {
    value.try_into().map_err(|_| AbortCode::LengthMismatch)
}

/// An unsigned number of the dictionary, of whatever size. One function for all of them is small, and none of them is read
/// while frames move.
#[inline(never)]
fn number<D: Dictionary>(dictionary: &D, index: u16, sub: u8) -> Option<u32> {
    let bytes = value(dictionary, find::<D>(index, sub).ok()?);
    Some(
        bytes
            .iter()
            .rev()
            .fold(0, |number, byte| number << 8 | u32::from(*byte)),
    )
}
