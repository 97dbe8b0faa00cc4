//! Objects whose index the code knows: where they lie is found when the device is compiled. There
//! is no search, and no code at all for what the data sheet does not list.

use core::marker::PhantomData;

use super::{Attributes, Dictionary, Entry, Location, Table, key, raw};

/// One object of the dictionary `D`.
struct Fixed<D, const INDEX: u16, const SUB: u8>(PhantomData<D>);

impl<D: Dictionary, const INDEX: u16, const SUB: u8> Fixed<D, INDEX, SUB> {
    const ENTRY: Option<&'static Entry> = D::TABLE.entry(INDEX, SUB);
}

/// The value of a number of one, two or four bytes; `None` if the dictionary does not have it.
#[inline]
pub(crate) fn fixed<D: Dictionary, const INDEX: u16, const SUB: u8>(dictionary: &D) -> Option<u32> {
    raw(dictionary, Fixed::<D, INDEX, SUB>::ENTRY?)
}

/// Where a number of so many bytes lies in RAM; beyond all RAM if it does not.
pub(crate) const fn place(table: &Table, index: u16, sub: u8, size: u16) -> usize {
    match table.entry(index, sub) {
        Some(entry) if entry.size() == size => match entry.location() {
            Location::Ram(offset) => offset as usize,
            Location::Rom(_) | Location::Application => usize::MAX,
        },
        _ => usize::MAX,
    }
}

impl Table {
    /// Whether an object with an index from `first` to `last` can be written: for the compiler, as
    /// well.
    pub(crate) const fn is_written(&self, first: u16, last: u16) -> bool {
        let mut entries = self.entries;
        while let [entry, rest @ ..] = entries {
            if entry.index > last {
                return false;
            }
            if entry.index >= first && entry.attributes.has(Attributes::WRITE) {
                return true;
            }
            entries = rest;
        }
        false
    }

    /// An entry, one after the other looked at: for the compiler.
    const fn entry(&self, index: u16, sub: u8) -> Option<&'static Entry> {
        let mut entries = self.entries;
        while let [entry, rest @ ..] = entries {
            // In order: most objects of a large dictionary are behind those that are asked for.
            if entry.key() >= key(index, sub) {
                return if entry.key() == key(index, sub) {
                    Some(entry)
                } else {
                    None
                };
            }
            entries = rest;
        }
        None
    }
}
