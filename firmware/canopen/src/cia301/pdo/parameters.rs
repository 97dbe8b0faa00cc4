//! The two records of a PDO: what a master may write into them, and when.
//!
//! | write | refused with |
//! |---|---|
//! | COB-ID: 29-bit identifier, a restricted identifier, another identifier while valid; of a transmit PDO, that of another service of the device | 06090030h |
//! | transmission type: 241 to 251 (reserved); 252 and 253 (on request) of a receive PDO | 06090030h |
//! | another inhibit time, or a SYNC start value, of a transmit PDO while valid; a start value above 240 | 06090030h |
//! | mapping, anything while the PDO is valid; an entry while sub-index 0 is not 0 | 06010000h |
//! | mapping entry: no such object | 06020000h, 06090011h |
//! | mapping entry: not mappable, wrong direction, not its own length, a dummy to transmit or that the data sheet does not list | 06040041h |
//! | COB-ID valid, or the type while it is, of a multiplexed PDO that is not event-driven | 06090030h |
//! | mapping sub-index 0: 65 to 253, more than the record has, or more than 64 bits together | 06040042h |
//! | mapping sub-index 0: counts an empty entry | 06040041h |
//!
//! A device may have habits of its maker ([`Habits`](crate::od::Habits)) here: it maps while a PDO is valid, keeps bit 30, has other codes.

use super::mapping::{Direction, Layout, MOST_BITS, Mapped, MappingEntry};
use super::multiplexed::Addressing;
use crate::cia301::cob_ids;
use crate::cia301::sdo::AbortCode;
use crate::od::{Dictionary, Entry, number_at};
use crate::wire::cob_id::CobId;

/// Bit 30 of the COB-ID of a transmit PDO: no remote frame may ask for it.
const NO_RTR: u32 = 1 << 30;

/// The highest SYNC counter (object 1019h), and with it the highest SYNC start value.
const MOST_START: u8 = 240;

/// A transmission type (CiA 301, 7.5.2.35 and 7.5.2.37): 1 to 240 for every n-th SYNC, and those that have names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TransmissionType(pub(super) u8);

impl TransmissionType {
    /// 0: synchronous, after an event; in a receive PDO at the next SYNC, as for 1 to 240 unless the device has another habit.
    pub(super) const ACYCLIC: Self = Self(0);
    /// 252: on request, with the values of the last SYNC.
    pub(super) const SAMPLED_REQUEST: Self = Self(252);
    /// 253: on request, with the present values.
    pub(super) const REQUEST: Self = Self(253);
    /// 254 and 255: event-driven. Those of multiplexed PDOs are.
    pub(super) const EVENT: Self = Self(254);

    /// From its number; `None` for 241 to 251, and for 252 and 253 of a receive PDO.
    const fn new(number: u8, direction: Direction) -> Option<Self> {
        match (number, direction) {
            (254 | 255, _) => Some(Self::EVENT),
            (0..=240, Direction::Receive) => Some(Self::ACYCLIC),
            (0..=240 | 252 | 253, Direction::Transmit) => Some(Self(number)),
            _ => None,
        }
    }

    /// Of types 1 to 240 the number, of others 0.
    #[inline]
    pub(super) const fn every(self) -> u8 {
        if self.0 <= 240 { self.0 } else { 0 }
    }

    /// Whether SYNC makes the moment.
    #[inline]
    pub(super) const fn is_synchronous(self) -> bool {
        self.0 <= Self::SAMPLED_REQUEST.0
    }
}

/// What a communication parameter says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Communication {
    /// An 11-bit identifier; 0 for a PDO that is not in use.
    pub(super) cob_id: u16,
    /// The inhibit time in multiples of 100 µs; 0 for none.
    pub(super) inhibit_time: u16,
    /// The event timer in milliseconds, of a receive PDO its deadline; 0 for none. Of a transmit PDO the device may have a habit here.
    pub(super) event_timer: u16,
    pub(super) transmission_type: TransmissionType,
    /// Whether a remote frame may ask for the PDO (bit 30 of the COB-ID is 0).
    pub(super) allows_request: bool,
    /// The SYNC counter that a cyclic PDO starts with; 0 for any.
    pub(super) sync_start: u8,
}

impl Communication {
    /// A PDO that is not in use.
    pub(super) const NONE: Self = Self {
        cob_id: 0,
        inhibit_time: 0,
        event_timer: 0,
        transmission_type: TransmissionType::ACYCLIC,
        allows_request: false,
        sync_start: 0,
    };
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

    /// Whether an entry is the event timer, of a receive PDO the deadline.
    pub(super) const fn is_event_timer(self, entry: &Entry) -> bool {
        entry.index < self.mapping() && entry.sub == 5
    }

    const fn communication(self) -> u16 {
        let first = match self.direction {
            Direction::Receive => 0x1400_u16,
            Direction::Transmit => 0x1800,
        };
        first.saturating_add(self.number)
    }

    const fn mapping(self) -> u16 {
        self.communication().saturating_add(Self::MOST)
    }

    fn cob_id<D: Dictionary>(self, dictionary: &D) -> CobId {
        CobId(number(dictionary, self.communication(), 1).unwrap_or(CobId::INVALID))
    }

    /// The transmission type; `None` when it is not supported or missing.
    fn transmission_type<D: Dictionary>(self, dictionary: &D) -> Option<TransmissionType> {
        let number = u8::try_from(number(dictionary, self.communication(), 2)?).ok()?;
        let is_sent = self.direction == Direction::Transmit;
        if D::HABITS.acyclic_is_each_sync && is_sent && number == 0 {
            return TransmissionType::new(1, self.direction);
        }
        if D::HABITS.receives_at_nth_sync && !is_sent && number <= 240 {
            return Some(TransmissionType(number));
        }
        TransmissionType::new(number, self.direction)
    }

    /// What the communication parameter says; `None` for a PDO that is not valid, that cannot have an 11-bit identifier, or whose
    /// transmission type is not supported or missing.
    fn communicate<D: Dictionary>(self, dictionary: &D) -> Option<Communication> {
        let cob_id = self.cob_id(dictionary);
        if !cob_id.is_valid() || !cob_id.is_base_frame() {
            return None;
        }
        let number = |sub| number(dictionary, self.communication(), sub).unwrap_or(0);
        let is_sent = self.direction == Direction::Transmit;
        Some(Communication {
            cob_id: cob_id.identifier(),
            inhibit_time: if is_sent { number(3) as u16 } else { 0 },
            event_timer: number(5) as u16,
            transmission_type: self.transmission_type(dictionary)?,
            allows_request: is_sent && cob_id.0 & NO_RTR == 0,
            sync_start: if is_sent { number(6) as u8 } else { 0 },
        })
    }

    /// The event timer as it is written, of a receive PDO its deadline; 0 for none.
    pub(super) fn event_timer<D: Dictionary>(self, dictionary: &D) -> u16 {
        number(dictionary, self.communication(), 5).unwrap_or(0) as u16
    }

    /// What the dictionary holds. A PDO that is not valid, maps nothing, or whose records do not fit each other is not in use.
    #[inline(never)]
    pub(super) fn read<D: Dictionary>(
        self,
        dictionary: &D,
        objects: &mut [Mapped],
    ) -> (Communication, Layout) {
        let layout = self.resolve(dictionary, self.count(dictionary), objects);
        let (Some(communication), Ok(layout)) = (self.communicate(dictionary), layout) else {
            return (Communication::NONE, Layout::NOTHING);
        };
        if layout.is_empty() || !fits(&layout, Some(communication.transmission_type)) {
            return (Communication::NONE, Layout::NOTHING);
        }
        (communication, layout)
    }

    /// The first `count` mapping entries of the dictionary, which `objects` are made of.
    ///
    /// # Errors
    /// As for a write of sub-index 0.
    #[inline(never)]
    fn resolve<D: Dictionary>(
        self,
        dictionary: &D,
        count: u8,
        objects: &mut [Mapped],
    ) -> Result<Layout, AbortCode> {
        let mut layout = Layout::NOTHING;
        if D::FEATURES.multiplexed_pdo
            && let Some(addressing) = Addressing::new(count)
        {
            return Ok(Layout::addressed(addressing));
        }
        // An object has one bit at least.
        if count > MOST_BITS {
            return Err(AbortCode::PdoLengthExceeded);
        }
        // That there are as many goes before what is wrong with one of them.
        if count > 0 && number(dictionary, self.mapping(), count).is_none() {
            return Err(AbortCode::PdoLengthExceeded);
        }
        for sub in 1..=count {
            let entry = number(dictionary, self.mapping(), sub)
                .map(|number| MappingEntry(number).whole::<D>())
                .ok_or(AbortCode::PdoLengthExceeded)?;
            if entry == MappingEntry::EMPTY {
                return Err(AbortCode::NotMappable);
            }
            let object = entry.resolve(D::TABLE, D::FEATURES.dummies, self.direction)?;
            layout.push(objects, D::TABLE, object, entry.bits())?;
        }
        Ok(layout)
    }

    /// Sub-index 0 of the mapping.
    fn count<D: Dictionary>(self, dictionary: &D) -> u8 {
        let count = number(dictionary, self.mapping(), 0).unwrap_or(0);
        u8::try_from(count).unwrap_or(u8::MAX)
    }

    /// Whether an entry of the records may get this value; there are so many PDOs. A mapping is made to find
    /// out, in the `objects` of the PDO, which is not in use then.
    ///
    /// # Errors
    /// Those of the table above.
    #[inline(never)]
    pub(super) fn validate<D: Dictionary>(
        direction: Direction,
        dictionary: &D,
        entry: &Entry,
        value: &[u8],
        objects: Option<&mut [Mapped]>,
    ) -> Result<(), AbortCode> {
        let objects = objects.ok_or(AbortCode::NoObject)?;
        let parameters = Self::new(direction, number_of(entry) as u16);
        if entry.index < parameters.mapping() {
            parameters.validate_communication(dictionary, entry, value, objects)
        } else {
            parameters.validate_mapping(dictionary, entry.sub, value, objects)
        }
    }

    fn validate_communication<D: Dictionary>(
        self,
        dictionary: &D,
        entry: &Entry,
        value: &[u8],
        objects: &mut [Mapped],
    ) -> Result<(), AbortCode> {
        let sub = entry.sub;
        let present = self.cob_id(dictionary);
        match (sub, self.direction) {
            (1, _) => {
                let new = CobId(u32::from_le_bytes(bytes(value)?));
                if D::HABITS.no_remote_requests
                    && self.direction == Direction::Transmit
                    && new.0 & NO_RTR == 0
                {
                    return Err(AbortCode::InvalidValue);
                }
                cob_ids::validate(dictionary, entry, value, true)?;
                if new.is_valid() && !present.is_valid() {
                    // A mapping that came from elsewhere than a checked write must not be found out by its first frame.
                    let layout = self.resolve(dictionary, self.count(dictionary), objects)?;
                    if !fits(&layout, self.transmission_type(dictionary)) {
                        return Err(AbortCode::InvalidValue);
                    }
                }
                Ok(())
            }
            (2, _) => {
                let [number] = bytes(value)?;
                let new = TransmissionType::new(number, self.direction);
                let is_addressed = D::FEATURES.multiplexed_pdo
                    && Addressing::new(self.count(dictionary)).is_some();
                let must_be_event = present.is_valid() && is_addressed;
                match new {
                    Some(new) if !must_be_event || new == TransmissionType::EVENT => Ok(()),
                    _ => Err(AbortCode::InvalidValue),
                }
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

    fn validate_mapping<D: Dictionary>(
        self,
        dictionary: &D,
        sub: u8,
        value: &[u8],
        objects: &mut [Mapped],
    ) -> Result<(), AbortCode> {
        if !D::HABITS.maps_while_valid && self.cob_id(dictionary).is_valid() {
            return Err(AbortCode::UnsupportedAccess);
        }
        if sub == 0 {
            let [count] = bytes(value)?;
            let found = self.resolve(dictionary, count, objects);
            if D::HABITS.maps_while_valid && found.is_err() {
                // The PDO is in use and stays as it was.
                let _ = self.resolve(dictionary, self.count(dictionary), objects);
            }
            return found.map(|_| ()).map_err(|code| match code {
                AbortCode::PdoLengthExceeded => D::HABITS.mapping_too_long,
                other => other,
            });
        }
        if number(dictionary, self.mapping(), 0) != Some(0) {
            return Err(AbortCode::UnsupportedAccess);
        }
        match MappingEntry(u32::from_le_bytes(bytes(value)?)).whole::<D>() {
            MappingEntry::EMPTY => Ok(()),
            entry => {
                let target = entry.resolve(D::TABLE, D::FEATURES.dummies, self.direction);
                target
                    .map(|_| ())
                    .map_err(|code| D::HABITS.missing_mapped_object.unwrap_or(code))
            }
        }
    }
}

/// The PDO that an entry of 1400h to 1BFFh belongs to, 0 for the first of its direction.
pub(super) const fn number_of(entry: &Entry) -> usize {
    (entry.index & (Parameters::MOST - 1)) as usize
}

/// Whether a mapping can be used with this transmission type.
fn fits(layout: &Layout, transmission_type: Option<TransmissionType>) -> bool {
    !layout.is_addressed() || transmission_type == Some(TransmissionType::EVENT)
}

/// The bytes of a number with `N` bytes.
fn bytes<const N: usize>(value: &[u8]) -> Result<[u8; N], AbortCode> {
    value.try_into().map_err(|_| AbortCode::LengthMismatch)
}

/// An unsigned number of the dictionary, of whatever size.
fn number<D: Dictionary>(dictionary: &D, index: u16, sub: u8) -> Option<u32> {
    number_at(dictionary, index, sub, 1 | 2 | 4)
}
