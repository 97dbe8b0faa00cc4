//! Multiplexed PDOs (CiA 301, 7.2.2.4 to 7.2.2.7): the frame itself says which object its four bytes are.
//!
//! | bytes | |
//! |---|---|
//! | 0 | bit 7: destination address mode; bits 0 to 6: a node-ID |
//! | 1 to 3 | index and sub-index |
//! | 4 to 7 | the value, its low bytes first |
//!
//! Sub-index 0 of the mapping is 255 for *destination address mode*: node-ID, index and sub-index are those of the receiver, and
//! node-ID 0 is everybody. With 254 for *source address mode* they are those of the sender. Its *scanner list* (1FA0h to 1FCFh)
//! names the objects that are sent; the *dispatcher list* (1FD0h to 1FFFh) of the receiver says which object of its own stands
//! for which of whom. An entry of a list stands for as many sub-indices in a row as its block size says; with 0 for none.
//!
//! The contract:
//! - The frame has eight bytes, and both transmission types are event-driven: 254 or 255.
//! - A value goes where a receive PDO may go: the data sheet allows it, limits and the application agree. Bytes that the object
//!   does not have are left out.
//! - The list entries of a device name objects that can be mapped, four bytes long at most; others are not accepted.

use core::ops::RangeInclusive;

use super::mapping::{Direction, is_mappable};
use crate::cia301::sdo::AbortCode;
use crate::od::{Dictionary, Entry, find, value};

/// The scanner lists: what a sender sends in source address mode.
const SCANNER: RangeInclusive<u16> = 0x1FA0..=0x1FCF;

/// The dispatcher lists: what a receiver takes in source address mode.
const DISPATCHER: RangeInclusive<u16> = 0x1FD0..=0x1FFF;

/// Most bytes of a value.
const MOST_BYTES: u16 = 4;

/// Whose object the frame names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Addressing {
    /// The sender's.
    Source = 1,
    /// The receiver's.
    Destination = 2,
}

impl Addressing {
    /// From sub-index 0 of the mapping; `None` for a count of objects.
    pub(super) const fn new(count: u8) -> Option<Self> {
        match count {
            254 => Some(Self::Source),
            255 => Some(Self::Destination),
            _ => None,
        }
    }
}

/// A frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Message {
    pub(super) addressing: Addressing,
    /// 0 to 127.
    pub(super) node_id: u8,
    pub(super) index: u16,
    pub(super) sub: u8,
    pub(super) value: [u8; 4],
}

impl Message {
    /// Bit 7 of the first byte.
    const DESTINATION: u8 = 1 << 7;

    pub(super) const fn parse(frame: &[u8; 8]) -> Self {
        let [first, low, high, sub, a, b, c, d] = *frame;
        Self {
            addressing: if first & Self::DESTINATION == 0 {
                Addressing::Source
            } else {
                Addressing::Destination
            },
            node_id: first & !Self::DESTINATION,
            index: u16::from_le_bytes([low, high]),
            sub,
            value: [a, b, c, d],
        }
    }

    pub(super) const fn bytes(&self) -> [u8; 8] {
        let flag = match self.addressing {
            Addressing::Source => 0,
            Addressing::Destination => Self::DESTINATION,
        };
        let [low, high] = self.index.to_le_bytes();
        let [a, b, c, d] = self.value;
        [self.node_id | flag, low, high, self.sub, a, b, c, d]
    }
}

/// The object at an index, if its value may go this way in a frame.
pub(super) fn object<D: Dictionary>(
    index: u16,
    sub: u8,
    direction: Direction,
) -> Option<&'static Entry> {
    find::<D>(index, sub)
        .ok()
        .filter(|entry| is_mappable(entry, direction) && entry.size() <= MOST_BYTES)
}

/// The value of an object, the bytes that it does not have 0.
pub(super) fn bytes_of<D: Dictionary>(dictionary: &D, entry: &Entry) -> [u8; 4] {
    let mut bytes = [0; 4];
    for (to, from) in bytes.iter_mut().zip(value(dictionary, entry)) {
        *to = *from;
    }
    bytes
}

/// An entry of a scanner list, UNSIGNED32.
#[derive(Clone, Copy, Debug)]
struct Scanned {
    index: u16,
    sub: u8,
    /// So many sub-indices in a row.
    block: u8,
}

impl Scanned {
    fn new(number: u32) -> Self {
        let [sub, low, high, block] = number.to_le_bytes();
        Self {
            index: u16::from_le_bytes([low, high]),
            sub,
            block,
        }
    }

    fn has(self, index: u16, sub: u8) -> bool {
        let offset = sub.checked_sub(self.sub);
        self.index == index && offset.is_some_and(|offset| offset < self.block)
    }
}

/// An entry of a dispatcher list, UNSIGNED64.
#[derive(Clone, Copy, Debug)]
struct Dispatched {
    /// Whose object it is at the sender.
    node_id: u8,
    theirs: Scanned,
    index: u16,
    sub: u8,
}

impl Dispatched {
    fn new(number: u64) -> Self {
        let [node_id, their_sub, low, high, sub, own_low, own_high, block] = number.to_le_bytes();
        Self {
            node_id,
            theirs: Scanned {
                index: u16::from_le_bytes([low, high]),
                sub: their_sub,
                block,
            },
            index: u16::from_le_bytes([own_low, own_high]),
            sub,
        }
    }

    /// The sub-index of the own object that stands for this one.
    fn own_sub(self, message: &Message) -> Option<u8> {
        let offset = message.sub.checked_sub(self.theirs.sub)?;
        let is_there =
            self.node_id == message.node_id && self.theirs.has(message.index, message.sub);
        is_there.then(|| self.sub.checked_add(offset))?
    }
}

/// The numbers of the lists in a range of indices, with their entries.
fn numbers<D: Dictionary>(dictionary: &D, lists: RangeInclusive<u16>) -> impl Iterator<Item = u64> {
    let entries = D::TABLE.range(lists).iter();
    entries.filter(|entry| entry.sub != 0).map(|entry| {
        let bytes = value(dictionary, entry).iter().rev();
        bytes.fold(0, |number, byte| number << 8 | u64::from(*byte))
    })
}

/// Whether the scanner lists name this object.
pub(super) fn is_scanned<D: Dictionary>(dictionary: &D, index: u16, sub: u8) -> bool {
    numbers(dictionary, SCANNER).any(|number| Scanned::new(number as u32).has(index, sub))
}

/// The own object that a message in source address mode is for.
pub(super) fn dispatch<D: Dictionary>(dictionary: &D, message: &Message) -> Option<&'static Entry> {
    numbers(dictionary, DISPATCHER).find_map(|number| {
        let entry = Dispatched::new(number);
        object::<D>(entry.index, entry.own_sub(message)?, Direction::Receive)
    })
}

/// A walk along the scanner lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Scan {
    /// Numbers that it has left behind.
    position: u16,
    /// Sub-indices of the present one that it has left behind.
    offset: u8,
}

impl Scan {
    /// In front of the first object.
    pub(super) const START: Self = Self {
        position: 0,
        offset: 0,
    };

    /// The next object; `None` at the end of the lists.
    pub(super) fn next<D: Dictionary>(&mut self, dictionary: &D) -> Option<&'static Entry> {
        for number in numbers(dictionary, SCANNER).skip(self.position.into()) {
            let scanned = Scanned::new(number as u32);
            // A block may have holes: only its first and its last object were there when it was written.
            while self.offset < scanned.block {
                let sub = scanned.sub.checked_add(self.offset);
                self.offset = self.offset.saturating_add(1);
                let object =
                    sub.and_then(|sub| object::<D>(scanned.index, sub, Direction::Transmit));
                if object.is_some() {
                    return object;
                }
            }
            self.position = self.position.saturating_add(1);
            self.offset = 0;
        }
        None
    }
}

/// Whether an entry of a list may get this value.
///
/// # Errors
/// - [`AbortCode::NotMappable`]: the first or the last object of the block cannot be sent, or received.
/// - [`AbortCode::InvalidValue`]: a node-ID above 127.
pub(super) fn validate<D: Dictionary>(entry: &Entry, value: &[u8]) -> Result<(), AbortCode> {
    if entry.sub == 0 {
        return Ok(());
    }
    let bytes = value.iter().rev();
    let number = bytes.fold(0_u64, |number, byte| number << 8 | u64::from(*byte));
    let (index, sub, block, direction) = if SCANNER.contains(&entry.index) {
        let scanned = Scanned::new(number as u32);
        (
            scanned.index,
            scanned.sub,
            scanned.block,
            Direction::Transmit,
        )
    } else {
        let dispatched = Dispatched::new(number);
        if dispatched.node_id > 127 {
            return Err(AbortCode::InvalidValue);
        }
        let block = dispatched.theirs.block;
        (dispatched.index, dispatched.sub, block, Direction::Receive)
    };
    let Some(last) = block.checked_sub(1) else {
        return Ok(());
    };
    let last = sub.checked_add(last);
    let is_there = |sub| object::<D>(index, sub, direction).is_some();
    if is_there(sub) && last.is_some_and(is_there) {
        Ok(())
    } else {
        Err(AbortCode::NotMappable)
    }
}
