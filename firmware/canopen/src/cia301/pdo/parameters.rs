//! The two records of a PDO: what a master may write into them, and when.
//!
//! | write | refused with |
//! |---|---|
//! | COB-ID: 29-bit identifier, a restricted identifier, another identifier while valid | 06090030h |
//! | transmission type: 241 to 251 (reserved); 252 and 253 (on request) of a receive PDO | 06090030h |
//! | another inhibit time, or a SYNC start value, of a transmit PDO while valid; a start value above 240 | 06090030h |
//! | mapping, anything while the PDO is valid; an entry while sub-index 0 is not 0 | 06010000h |
//! | mapping entry: no such object | 06020000h, 06090011h |
//! | mapping entry: not mappable, wrong direction, not its own length, a dummy to transmit or that the data sheet does not list | 06040041h |
//! | COB-ID valid, or the type while it is, of a multiplexed PDO that is not event-driven | 06090030h |
//! | mapping sub-index 0: 65 to 253, more than the record has, or more than 64 bits together | 06040042h |
//! | mapping sub-index 0: counts an empty entry | 06040041h |

use super::mapping::{Direction, Layout, MOST_BITS, MappingEntry, Target, with_target};
use super::multiplexed::Addressing;
use crate::cia301::sdo::AbortCode;
use crate::od::{Dictionary, Entry, find, value};
use crate::wire::cob_id::{CobId, is_restricted};

/// Bit 30 of the COB-ID of a transmit PDO: no remote frame may ask for it.
const NO_RTR: u32 = 1 << 30;

/// The highest SYNC counter (object 1019h), and with it the highest SYNC start value.
const MOST_START: u8 = 240;

/// Whether a PDO with the COB-ID `present` may get `new` (CiA 301, 7.5.2.35 and 7.5.2.37). Bit 30 of a transmit PDO (no RTR)
/// may change at any time.
fn check_cob_id(present: CobId, new: CobId) -> Result<(), AbortCode> {
    let moved = present.is_valid() && new.is_valid() && present.identifier() != new.identifier();
    let taken = new.is_valid() && is_restricted(new.identifier());
    if !new.is_base_frame() || moved || taken {
        Err(AbortCode::InvalidValue)
    } else {
        Ok(())
    }
}

/// Transmission types (CiA 301, 7.5.2.35 and 7.5.2.37).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TransmissionType {
    /// 0: synchronous, after an event.
    Acyclic,
    /// 1 to 240: synchronous, every n-th SYNC.
    Cyclic(u8),
    /// 252: on request, with the values of the last SYNC.
    SampledRequest,
    /// 253: on request, with the present values.
    Request,
    /// 254 and 255: event-driven.
    Event,
    /// 254 and 255, and the frame names its object.
    Multiplexed(Addressing),
}

impl TransmissionType {
    /// From its number; `None` for 241 to 251, and for 252 and 253 of a receive PDO.
    const fn new(number: u8, direction: Direction) -> Option<Self> {
        match (number, direction) {
            (0, _) => Some(Self::Acyclic),
            (1..=240, _) => Some(Self::Cyclic(number)),
            (252, Direction::Transmit) => Some(Self::SampledRequest),
            (253, Direction::Transmit) => Some(Self::Request),
            (254 | 255, _) => Some(Self::Event),
            (241..=253, _) => None,
        }
    }

    /// That of a mapping; `None` if they do not fit.
    pub(super) const fn with(self, addressing: Option<Addressing>) -> Option<Self> {
        match (self, addressing) {
            (_, None) => Some(self),
            (Self::Event, Some(addressing)) => Some(Self::Multiplexed(addressing)),
            (_, Some(_)) => None,
        }
    }

    /// Whether SYNC makes the moment.
    pub(super) const fn is_synchronous(self) -> bool {
        matches!(self, Self::Acyclic | Self::Cyclic(_) | Self::SampledRequest)
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

/// What a communication parameter says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Communication {
    /// An 11-bit identifier.
    pub(super) cob_id: u16,
    /// Whether a remote frame may ask for the PDO (bit 30 of the COB-ID is 0).
    pub(super) allows_request: bool,
    pub(super) transmission_type: TransmissionType,
    /// The SYNC counter that a cyclic PDO starts with; 0 for any.
    pub(super) sync_start: u8,
    /// The inhibit time in multiples of 100 µs; 0 for none.
    pub(super) inhibit_time: u32,
    /// The event timer in milliseconds, of a receive PDO its deadline; 0 for none.
    pub(super) event_timer: u32,
}

/// The records of one PDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Parameters {
    direction: Direction,
    /// 0 for the first PDO.
    pub(super) number: u16,
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

    /// The transmission type; `None` when it is not supported or missing.
    fn transmission_type<D: Dictionary>(self, dictionary: &D) -> Option<TransmissionType> {
        let number = u8::try_from(number(dictionary, self.communication(), 2)?).ok()?;
        TransmissionType::new(number, self.direction)
    }

    /// What the communication parameter says; `None` for a PDO that is not valid, that cannot have an 11-bit identifier, or whose
    /// transmission type is not supported or missing.
    #[inline(never)]
    pub(super) fn communicate<D: Dictionary>(self, dictionary: &D) -> Option<Communication> {
        let cob_id = self.cob_id(dictionary);
        if !cob_id.is_valid() || !cob_id.is_base_frame() {
            return None;
        }
        let number = |sub| number(dictionary, self.communication(), sub).unwrap_or(0);
        Some(Communication {
            cob_id: cob_id.identifier(),
            allows_request: cob_id.0 & NO_RTR == 0,
            transmission_type: self.transmission_type(dictionary)?,
            sync_start: u8::try_from(number(6)).unwrap_or(0),
            inhibit_time: number(3),
            event_timer: number(5),
        })
    }

    /// The event timer in milliseconds, of a receive PDO its deadline; 0 for none.
    pub(super) fn event_timer<D: Dictionary>(self, dictionary: &D) -> u32 {
        number(dictionary, self.communication(), 5).unwrap_or(0)
    }

    /// The mapping that the dictionary holds, resolved.
    ///
    /// # Errors
    /// As for a write of sub-index 0.
    pub(super) fn resolve<D: Dictionary, L: Layout>(self, dictionary: &D) -> Result<L, AbortCode> {
        let count = self.count(dictionary);
        if let Some(addressing) = self.check_count(dictionary, count)? {
            return Ok(L::addressed(addressing));
        }
        let mut mapping = L::NOTHING;
        for sub in 1..=count {
            mapping.push(self.target(dictionary, sub)?)?;
        }
        Ok(mapping)
    }

    /// Sub-index 0 of the mapping.
    fn count<D: Dictionary>(self, dictionary: &D) -> u8 {
        let count = number(dictionary, self.mapping(), 0).unwrap_or(0);
        u8::try_from(count).unwrap_or(u8::MAX)
    }

    /// Whose object the frame names with this sub-index 0, if it does; otherwise it counts mapping entries.
    ///
    /// # Errors
    /// [`AbortCode::PdoLengthExceeded`]: it counts more than there are.
    fn check_count<D: Dictionary>(
        self,
        dictionary: &D,
        count: u8,
    ) -> Result<Option<Addressing>, AbortCode> {
        if D::FEATURES.multiplexed_pdo
            && let Some(addressing) = Addressing::new(count)
        {
            return Ok(Some(addressing));
        }
        // An object has one bit at least.
        let has_room = count == 0 || number(dictionary, self.mapping(), count).is_some();
        if count > MOST_BITS || !has_room {
            return Err(AbortCode::PdoLengthExceeded);
        }
        Ok(None)
    }

    /// What a mapping entry of the dictionary stands for.
    #[inline(never)]
    fn target<D: Dictionary>(self, dictionary: &D, sub: u8) -> Result<Target, AbortCode> {
        let entry = number(dictionary, self.mapping(), sub)
            .map(MappingEntry)
            .ok_or(AbortCode::PdoLengthExceeded)?;
        if entry == MappingEntry::EMPTY {
            return Err(AbortCode::NotMappable);
        }
        entry.resolve(D::TABLE, D::FEATURES.dummies, self.direction)
    }

    /// Whether a PDO with room for so many objects can be made of the first `count` mapping entries, and whose object its frame
    /// names, if it does. The same for all PDOs: it makes no [`Layout`].
    #[inline(never)]
    fn check_first<D: Dictionary>(
        self,
        dictionary: &D,
        count: u8,
        room: usize,
    ) -> Result<Option<Addressing>, AbortCode> {
        let addressing = self.check_count(dictionary, count)?;
        if addressing.is_some() {
            return Ok(addressing);
        }
        let (mut bits, mut room) = (0, room);
        for sub in 1..=count {
            let target = self.target(dictionary, sub)?;
            bits = with_target(bits, &target)?;
            if let Target::Object { .. } = target {
                room = room.checked_sub(1).ok_or(AbortCode::PdoLengthExceeded)?;
            }
        }
        Ok(None)
    }

    /// Whether an entry of the records may get this value; there are so many PDOs, each with room for so many objects. Nothing changes.
    ///
    /// # Errors
    /// Those of the table above.
    #[inline(never)]
    pub(super) fn validate<D: Dictionary>(
        direction: Direction,
        dictionary: &D,
        entry: &Entry,
        value: &[u8],
        (pdos, room): (usize, usize),
    ) -> Result<(), AbortCode> {
        let (parameters, record) = Self::of(direction, entry.index)
            .filter(|(parameters, _)| parameters.number() < pdos)
            .ok_or(AbortCode::NoObject)?;
        match record {
            Record::Communication => {
                parameters.validate_communication(dictionary, entry.sub, value, room)
            }
            Record::Mapping => parameters.validate_mapping(dictionary, entry.sub, value, room),
        }
    }

    fn validate_communication<D: Dictionary>(
        self,
        dictionary: &D,
        sub: u8,
        value: &[u8],
        room: usize,
    ) -> Result<(), AbortCode> {
        let present = self.cob_id(dictionary);
        match (sub, self.direction) {
            (1, _) => {
                let new = CobId(u32::from_le_bytes(bytes(value)?));
                check_cob_id(present, new)?;
                if new.is_valid() && !present.is_valid() {
                    // A mapping that came from elsewhere than a checked write must not be found out by its first frame.
                    self.check_type(dictionary, self.transmission_type(dictionary), room)?;
                }
                Ok(())
            }
            (2, _) => {
                let [number] = bytes(value)?;
                let new = TransmissionType::new(number, self.direction);
                if present.is_valid() {
                    self.check_type(dictionary, new, room)?;
                }
                new.map(|_| ()).ok_or(AbortCode::InvalidValue)
            }
            (3 | 6, Direction::Transmit) if present.is_valid() => {
                let is_same = sub == 3
                    && number(dictionary, self.communication(), 3)
                        == Some(u16::from_le_bytes(bytes(value)?).into());
                is_same.then_some(()).ok_or(AbortCode::InvalidValue)
            }
            (6, Direction::Transmit) if value.first().is_some_and(|start| *start > MOST_START) => {
                Err(AbortCode::InvalidValue)
            }
            // A receive PDO makes no use of its inhibit time.
            (3 | 5, _) | (6, Direction::Transmit) => Ok(()),
            _ => Err(AbortCode::NoSubIndex),
        }
    }

    /// Whether the mapping that is there can be used with this transmission type.
    fn check_type<D: Dictionary>(
        self,
        dictionary: &D,
        transmission_type: Option<TransmissionType>,
        room: usize,
    ) -> Result<(), AbortCode> {
        let addressing = self.check_first(dictionary, self.count(dictionary), room)?;
        if addressing.is_some() && transmission_type != Some(TransmissionType::Event) {
            Err(AbortCode::InvalidValue)
        } else {
            Ok(())
        }
    }

    fn validate_mapping<D: Dictionary>(
        self,
        dictionary: &D,
        sub: u8,
        value: &[u8],
        room: usize,
    ) -> Result<(), AbortCode> {
        if self.cob_id(dictionary).is_valid() {
            return Err(AbortCode::UnsupportedAccess);
        }
        if sub == 0 {
            let [count] = bytes(value)?;
            return self.check_first(dictionary, count, room).map(|_| ());
        }
        if number(dictionary, self.mapping(), 0) != Some(0) {
            return Err(AbortCode::UnsupportedAccess);
        }
        match MappingEntry(u32::from_le_bytes(bytes(value)?)) {
            MappingEntry::EMPTY => Ok(()),
            entry => {
                let target = entry.resolve(D::TABLE, D::FEATURES.dummies, self.direction);
                target.map(|_| ())
            }
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
