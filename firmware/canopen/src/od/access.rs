//! Finding entries, reading and writing values.
//!
//! Everything here works on the bytes as they travel on the bus. Nothing here looks at access rights
//! ([`super::Access`]): the services do, because each has its own answer. No function can panic: an entry of another
//! dictionary, or bytes of a wrong length, give an error or nothing.

use core::ops::RangeInclusive;

use super::{Attributes, DataType, Dictionary, Entry, Location, Table, buckets};
use crate::copy::copy;
use crate::wire::sdo::AbortCode;

/// Why an entry cannot be had.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)] // As long as a reference, so that a result of both travels in registers.
pub enum AccessError {
    /// No object at this index.
    NoObject,
    /// The object has no such sub-index.
    NoSubIndex,
}

impl From<AccessError> for AbortCode {
    fn from(error: AccessError) -> Self {
        match error {
            AccessError::NoObject => Self::NoObject,
            AccessError::NoSubIndex => Self::NoSubIndex,
        }
    }
}

impl Table {
    /// The position of an entry in [`Table::entries`]; `None` for one of another table.
    pub fn position(&self, entry: &Entry) -> Option<u16> {
        u16::try_from(self.entries.element_offset(entry)?).ok()
    }

    /// The entry at `index`, `sub`. Mostly the object is in its own bucket, and has all sub-indices from 0 on: that is one look.
    ///
    /// # Errors
    /// The object, or only the sub-index, does not exist.
    #[inline(never)]
    pub fn find(&self, index: u16, sub: u8) -> Result<&'static Entry, AccessError> {
        let bucket = buckets::first(index, self.buckets.len());
        let Some(&start) = self.buckets.get(bucket) else {
            return Err(AccessError::NoObject);
        };
        if start == buckets::EMPTY {
            return Err(AccessError::NoObject);
        }
        let position = usize::from(start).wrapping_add(usize::from(sub));
        match self.entries.get(position) {
            Some(entry) if entry.index == index && entry.sub == sub => Ok(entry),
            _ => self.search(index, sub),
        }
    }

    /// The object is in another bucket, has gaps among its sub-indices, or does not exist.
    #[cold]
    #[inline(never)]
    fn search(&self, index: u16, sub: u8) -> Result<&'static Entry, AccessError> {
        let entries = self.object(index).ok_or(AccessError::NoObject)?;
        // In order, so none is further behind than its sub-index.
        let mut entries = entries.iter().take(usize::from(sub).wrapping_add(1));
        let found = entries.find(|entry| entry.index == index && entry.sub == sub);
        found.ok_or(AccessError::NoSubIndex)
    }

    /// The entries from those of an object on; `None` if there is no such object.
    #[inline]
    fn object(&self, index: u16) -> Option<&'static [Entry]> {
        let count = self.buckets.len();
        let mut bucket = buckets::first(index, count);
        // Mostly it ends much earlier, at a bucket that is empty.
        for _ in self.buckets {
            let start = usize::from(*self.buckets.get(bucket)?);
            let entries = self.entries.get(start..)?;
            if entries.first()?.index == index {
                return Some(entries);
            }
            bucket = buckets::next(bucket, count);
        }
        None
    }

    /// The entries of the objects in a range of indices, in ascending order.
    #[inline(never)]
    pub fn range(&self, indices: RangeInclusive<u16>) -> &'static [Entry] {
        let start = self
            .entries
            .partition_point(|entry| entry.index < *indices.start());
        let end = self
            .entries
            .partition_point(|entry| entry.index <= *indices.end());
        self.entries.get(start..end).unwrap_or(&[])
    }
}

/// The entry of a dictionary at `index`, `sub`.
///
/// # Errors
/// The object, or only the sub-index, does not exist.
#[inline]
pub fn find<D: Dictionary + ?Sized>(index: u16, sub: u8) -> Result<&'static Entry, AccessError> {
    D::TABLE.find(index, sub)
}

/// The present value: the bytes of a number, the present length of a string that can be written, all of a constant string;
/// nothing of a value that the application serves.
pub fn value<'a, D: Dictionary + ?Sized>(dictionary: &'a D, entry: &Entry) -> &'a [u8] {
    match entry.location() {
        Location::Ram(_) => present(dictionary.ram(), entry),
        Location::Rom(_) => slot(D::TABLE.rom, entry.offset, entry.size()),
        Location::Application => &[],
    }
}

/// The present value of a number of one, two or four bytes in RAM or in flash, as it travels on the bus; `None` for every other value.
#[inline]
pub(crate) fn raw<D: Dictionary + ?Sized>(dictionary: &D, entry: &Entry) -> Option<u32> {
    let block = match entry.location() {
        Location::Ram(_) => dictionary.ram(),
        Location::Rom(_) => D::TABLE.rom,
        Location::Application => return None,
    };
    let bytes = block.get(usize::from(entry.offset)..)?;
    match entry.width() {
        1 => bytes.first().map(|byte| u32::from(*byte)),
        2 => bytes
            .first_chunk()
            .map(|bytes| u16::from_le_bytes(*bytes).into()),
        4 => bytes.first_chunk().map(|bytes| u32::from_le_bytes(*bytes)),
        _ => None,
    }
}

/// The bytes of an entry in flash, which stay for ever.
pub fn constant(table: &Table, offset: u16, size: u16) -> &'static [u8] {
    slot(table.rom, offset, size)
}

/// Checks a new value: its length and its limits. Nothing changes.
///
/// # Errors
/// - [`AbortCode::LengthTooHigh`], [`AbortCode::LengthTooLow`]: not the length of the type, or more than a string holds.
/// - [`AbortCode::ValueTooHigh`], [`AbortCode::ValueTooLow`]: outside LowLimit and HighLimit, or a BOOLEAN above 1.
#[inline]
pub fn check(table: &Table, entry: &Entry, bytes: &[u8]) -> Result<(), AbortCode> {
    // Most numbers of a device take every value.
    if entry.takes_all() && bytes.len() == usize::from(entry.width()) {
        return Ok(());
    }
    check_closely(table, entry, bytes)
}

#[inline(never)]
fn check_closely(table: &Table, entry: &Entry, bytes: &[u8]) -> Result<(), AbortCode> {
    let size = usize::from(entry.size());
    if bytes.len() > size {
        return Err(AbortCode::LengthTooHigh);
    }
    if entry.is_variable() {
        return Ok(());
    }
    if bytes.len() < size {
        return Err(AbortCode::LengthTooLow);
    }
    if entry.data_type == DataType::Boolean && bytes.first().is_some_and(|byte| *byte > 1) {
        return Err(AbortCode::ValueTooHigh);
    }
    match entry.limits() {
        None => Ok(()),
        Some(at) => check_limits(table, entry.data_type, at, bytes),
    }
}

/// Whether a number lies between the limits at this place, ends included.
fn check_limits(
    table: &Table,
    data_type: DataType,
    at: usize,
    bytes: &[u8],
) -> Result<(), AbortCode> {
    let size = bytes.len();
    let limits = table.limits.get(at..at.saturating_add(2 * size));
    let Some((low, high)) = limits.and_then(|limits| limits.split_at_checked(size)) else {
        return Ok(());
    };
    let rank = |bytes| rank(data_type, bytes);
    if rank(bytes) > rank(high) {
        Err(AbortCode::ValueTooHigh)
    } else if rank(bytes) < rank(low) {
        Err(AbortCode::ValueTooLow)
    } else {
        Ok(())
    }
}

/// A number that is in order with those of other values of the type. REALs are in the order of the
/// numbers, the lower zero before the higher one and NaN beyond the ends.
#[inline(never)]
fn rank(data_type: DataType, bytes: &[u8]) -> u64 {
    const SIGN: u64 = 1 << 63;
    // The highest bit of each type at the top.
    let mut raw = [0; 8];
    let unused = raw.len().saturating_sub(bytes.len());
    copy(raw.get_mut(unused..).unwrap_or(&mut []), bytes);
    let raw = u64::from_le_bytes(raw);
    if data_type.is_real() && raw & SIGN != 0 {
        // Sign and magnitude.
        !raw
    } else if data_type.is_real() || data_type.is_signed() {
        raw ^ SIGN
    } else {
        raw
    }
}

/// Checks a new value as [`check`] does, then writes it.
///
/// # Errors
/// Those of [`check`], and [`AbortCode::ReadOnly`] for an entry that is not in RAM. On an error nothing has changed.
pub fn set<D: Dictionary + ?Sized>(
    dictionary: &mut D,
    entry: &Entry,
    bytes: &[u8],
) -> Result<(), AbortCode> {
    if !matches!(entry.location(), Location::Ram(_)) {
        return Err(AbortCode::ReadOnly);
    }
    check(D::TABLE, entry, bytes)?;
    put(dictionary, entry, bytes);
    Ok(())
}

/// Writes a value that has passed [`check`], without checking it again. An entry that is not in RAM does not change, and no byte
/// outside of the entry's own place is ever written.
#[inline(never)]
pub fn put<D: Dictionary + ?Sized>(dictionary: &mut D, entry: &Entry, bytes: &[u8]) {
    put_here(dictionary, entry, bytes);
}

/// [`put`] without a call, for the one place that every write of the application's objects passes.
#[inline(always)]
pub(crate) fn put_here<D: Dictionary + ?Sized>(dictionary: &mut D, entry: &Entry, bytes: &[u8]) {
    if let Location::Ram(offset) = entry.location() {
        let ram = dictionary.ram_mut();
        match *bytes {
            [a, b, c, d] if entry.width() == 4 => put_number(ram, offset, [a, b, c, d]),
            [a, b] if entry.width() == 2 => put_number(ram, offset, [a, b]),
            [a] if entry.width() == 1 => put_number(ram, offset, [a]),
            _ => put_at(ram, offset, entry, bytes),
        }
    }
}

/// Writes a number, if all of its place is there.
#[inline]
fn put_number<const N: usize>(ram: &mut [u8], offset: u16, bytes: [u8; N]) {
    let place = ram.get_mut(usize::from(offset)..);
    if let Some(place) = place.and_then(<[u8]>::first_chunk_mut) {
        *place = bytes;
    }
}

/// A value as a number, sign-extended. `None` for a string, a REAL, a wrong length, and an UNSIGNED64 above `i64::MAX`.
pub fn number(entry: &Entry, bytes: &[u8]) -> Option<i64> {
    let data_type = entry.data_type;
    let is_integer = !entry.is_variable() && !data_type.is_real();
    if !is_integer || bytes.len() != usize::from(entry.size()) {
        return None;
    }
    let raw = little_endian(bytes);
    if data_type.is_signed() {
        // Up to the top and back down: the shift right of a signed number copies its sign.
        let unused = 64u32.saturating_sub(u32::from(entry.size()).saturating_mul(8));
        Some(raw.wrapping_shl(unused).cast_signed().wrapping_shr(unused))
    } else {
        i64::try_from(raw).ok()
    }
}

/// Sets the objects of a range of indices to their power-on values, the node-ID added where the data sheet says $NODEID. All
/// objects for NMT reset node, 1000h to 1FFFh for reset communication (CiA 301, 7.3.2.2.1).
pub fn load_defaults<D: Dictionary + ?Sized>(
    dictionary: &mut D,
    node_id: u8,
    indices: RangeInclusive<u16>,
) {
    for entry in D::TABLE.range(indices) {
        let Location::Ram(offset) = entry.location() else {
            continue;
        };
        let length = room(entry);
        let to = slot_mut(dictionary.ram_mut(), offset, length);
        if entry.attributes.has(Attributes::NODE_ID) {
            copy(to, &node_id_default::<D>(entry, node_id));
        } else {
            copy(to, slot(D::TABLE.defaults, offset, length));
        }
    }
}

/// The power-on value of a number in RAM, the node-ID added to it; its bytes and zeros behind them.
#[inline(never)]
pub fn node_id_default<D: Dictionary + ?Sized>(entry: &Entry, node_id: u8) -> [u8; 8] {
    let default = slot(D::TABLE.defaults, entry.offset, entry.size().min(8));
    let sum = little_endian(default).wrapping_add(u64::from(node_id));
    sum.to_le_bytes()
}

/// Whether an entry has the power-on value that goes with this node-ID; never one without the node-ID in its default.
pub fn is_node_id_default<D: Dictionary + ?Sized>(
    dictionary: &D,
    entry: &Entry,
    node_id: u8,
) -> bool {
    let present = value(dictionary, entry);
    let default = node_id_default::<D>(entry, node_id);
    entry.attributes.has(Attributes::NODE_ID) && default.get(..present.len()) == Some(present)
}

/// The value of an UNSIGNED8 (or any other 1-byte object); `None` when there is no such object.
pub fn read_u8<D: Dictionary + ?Sized>(dictionary: &D, index: u16, sub: u8) -> Option<u8> {
    number_at(dictionary, index, sub, 1).map(|number| number as u8)
}

/// The value of an UNSIGNED16 (or any other 2-byte object); `None` when there is no such object.
pub fn read_u16<D: Dictionary + ?Sized>(dictionary: &D, index: u16, sub: u8) -> Option<u16> {
    number_at(dictionary, index, sub, 2).map(|number| number as u16)
}

/// The value of an UNSIGNED32 (or any other 4-byte object); `None` when there is no such object.
pub fn read_u32<D: Dictionary + ?Sized>(dictionary: &D, index: u16, sub: u8) -> Option<u32> {
    number_at(dictionary, index, sub, 4)
}

/// Writes a 1-byte object in RAM, with no regard to access and limits: for the objects' own code. Returns whether there
/// is one.
pub fn write_u8<D: Dictionary + ?Sized>(
    dictionary: &mut D,
    index: u16,
    sub: u8,
    value: u8,
) -> bool {
    write(dictionary, index, sub, &value.to_le_bytes())
}

/// Writes a 2-byte object in RAM, with no regard to access and limits: for the objects' own code. Returns whether there
/// is one.
pub fn write_u16<D: Dictionary + ?Sized>(
    dictionary: &mut D,
    index: u16,
    sub: u8,
    value: u16,
) -> bool {
    write(dictionary, index, sub, &value.to_le_bytes())
}

/// Writes a 4-byte object in RAM, with no regard to access and limits: for the objects' own code. Returns whether there
/// is one.
pub fn write_u32<D: Dictionary + ?Sized>(
    dictionary: &mut D,
    index: u16,
    sub: u8,
    value: u32,
) -> bool {
    write(dictionary, index, sub, &value.to_le_bytes())
}

/// The value of a number that has one of these widths in bytes, 1, 2 and 4 or a sum of them. One function for all is small: what frames wait for
/// has found its entries before.
#[inline(never)]
pub(crate) fn number_at<D: Dictionary + ?Sized>(
    dictionary: &D,
    index: u16,
    sub: u8,
    widths: u16,
) -> Option<u32> {
    let entry = find::<D>(index, sub).ok()?;
    if entry.width() & widths == 0 {
        return None;
    }
    raw_of(dictionary, entry)
}

/// [`raw`], of what no frame waits for.
#[inline(never)]
pub(crate) fn raw_of<D: Dictionary + ?Sized>(dictionary: &D, entry: &Entry) -> Option<u32> {
    raw(dictionary, entry)
}

/// Writes a number of exactly these bytes.
fn write<D: Dictionary + ?Sized>(dictionary: &mut D, index: u16, sub: u8, bytes: &[u8]) -> bool {
    let Ok(entry) = find::<D>(index, sub) else {
        return false;
    };
    let fits = !entry.is_variable() && usize::from(entry.size()) == bytes.len();
    let in_ram = matches!(entry.location(), Location::Ram(_));
    if fits && in_ram {
        put(dictionary, entry, bytes);
    }
    fits && in_ram
}

/// Bytes of RAM before the characters of a string that can be written: its present length.
const LENGTH_PREFIX: u16 = 2;

/// Bytes that an entry takes in RAM.
fn room(entry: &Entry) -> u16 {
    if entry.is_variable() {
        entry.size().saturating_add(LENGTH_PREFIX)
    } else {
        entry.size()
    }
}

/// The present bytes of an entry in RAM.
fn present<'a>(ram: &'a [u8], entry: &Entry) -> &'a [u8] {
    if !entry.is_variable() {
        return slot(ram, entry.offset, entry.size());
    }
    match *slot(ram, entry.offset, LENGTH_PREFIX) {
        [low, high] => {
            let length = u16::from_le_bytes([low, high]).min(entry.size());
            slot(ram, entry.offset.saturating_add(LENGTH_PREFIX), length)
        }
        _ => &[],
    }
}

/// Writes the bytes of an entry in RAM, never more than its own.
#[inline(never)]
fn put_at(ram: &mut [u8], offset: u16, entry: &Entry, bytes: &[u8]) {
    if entry.is_variable() {
        let length = u16::try_from(bytes.len())
            .unwrap_or(u16::MAX)
            .min(entry.size());
        if let Some(prefix) = slot_mut(ram, offset, LENGTH_PREFIX).first_chunk_mut() {
            *prefix = length.to_le_bytes();
        }
        copy(
            slot_mut(ram, offset.saturating_add(LENGTH_PREFIX), length),
            bytes,
        );
    } else {
        copy(slot_mut(ram, offset, entry.size()), bytes);
    }
}

/// `length` bytes at `offset`; none when they are not all there.
fn slot(block: &[u8], offset: u16, length: u16) -> &[u8] {
    let (start, length) = (usize::from(offset), usize::from(length));
    block
        .get(start..start.saturating_add(length))
        .unwrap_or(&[])
}

/// `length` bytes at `offset`, to be written; none when they are not all there.
fn slot_mut(block: &mut [u8], offset: u16, length: u16) -> &mut [u8] {
    let (start, length) = (usize::from(offset), usize::from(length));
    block
        .get_mut(start..start.saturating_add(length))
        .unwrap_or(&mut [])
}

/// Up to eight bytes, lowest first, as a number.
fn little_endian(bytes: &[u8]) -> u64 {
    let mut raw = [0; 8];
    copy(&mut raw, bytes);
    u64::from_le_bytes(raw)
}

#[cfg(test)]
mod tests;
