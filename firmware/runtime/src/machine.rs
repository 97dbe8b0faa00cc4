//! The streamed objects of the drive: 2020h "User memory" and 20D3h "Scope data".
//!
//! The user memory belongs to the maker of the machine: a DOMAIN that the drive does not look at. It is empty after power-on, outlives
//! every reset by NMT, and changes only as a whole: a transfer that ends early leaves the old bytes.
//!
//! A data sheet may leave out either of them. The dictionary then has no entry that leads here, so nobody asks, and the host
//! gives no room for it.

use core::ops::Deref;

use canopen::cia301::sdo::{AbortCode, Completion};
use canopen::od::{Dictionary, Entry, Table};
use canopen::{Application, Domain, Sink, Source};
use cia402::recorder::{Memory, Recording};

/// Index of the user memory.
pub const USER_MEMORY: u16 = 0x2020;

/// Index of the scope data.
pub const SCOPE_DATA: u16 = 0x20D3;

/// Whether the data sheet lists an object: what it leaves out needs no memory.
pub const fn is_listed(table: &Table, index: u16) -> bool {
    let mut entries = table.entries;
    while let [first, rest @ ..] = entries {
        if first.index == index {
            return true;
        }
        entries = rest;
    }
    false
}

/// The application of the drive: no rules of its own, the user memory in rooms `B`, and what the scope has recorded in the memory `M`.
#[derive(Debug)]
pub struct Machine<B, M> {
    user_memory: Domain<B>,
    scope_data: Recording<M>,
}

impl<B: AsRef<[u8]> + AsMut<[u8]>, M: Deref<Target = Memory>> Machine<B, M> {
    /// With an empty user memory that has two rooms of the same size, and with the memory of the scope.
    pub const fn new(value: B, spare: B, scope: M) -> Self {
        Self {
            user_memory: Domain::new(value, spare),
            scope_data: Recording::new(scope),
        }
    }

    /// The user memory: what a client has written last.
    pub fn user_memory(&self) -> &[u8] {
        self.user_memory.value()
    }
}

impl<D, B, M> Application<D> for Machine<B, M>
where
    D: Dictionary,
    B: AsRef<[u8]> + AsMut<[u8]>,
    M: Deref<Target = Memory>,
{
    fn size(&mut self, dictionary: &D, entry: &Entry) -> Result<Option<u32>, AbortCode> {
        match entry.index {
            USER_MEMORY => self.user_memory.size(dictionary),
            SCOPE_DATA => self.scope_data.size(dictionary),
            _ => Err(AbortCode::UnsupportedAccess),
        }
    }

    fn read_at(
        &mut self,
        dictionary: &D,
        entry: &Entry,
        position: u32,
        into: &mut [u8],
    ) -> Result<usize, AbortCode> {
        match entry.index {
            USER_MEMORY => self.user_memory.read_at(dictionary, position, into),
            SCOPE_DATA => self.scope_data.read_at(dictionary, position, into),
            _ => Err(AbortCode::UnsupportedAccess),
        }
    }

    fn begin_write(
        &mut self,
        dictionary: &D,
        entry: &Entry,
        size: Option<u32>,
    ) -> Result<(), AbortCode> {
        match entry.index {
            USER_MEMORY => self.user_memory.begin(dictionary, size),
            _ => Err(AbortCode::UnsupportedAccess),
        }
    }

    fn write_at(
        &mut self,
        dictionary: &D,
        entry: &Entry,
        position: u32,
        data: &[u8],
    ) -> Result<(), AbortCode> {
        match entry.index {
            USER_MEMORY => self.user_memory.write_at(dictionary, position, data),
            _ => Err(AbortCode::UnsupportedAccess),
        }
    }

    fn end_write(
        &mut self,
        dictionary: &mut D,
        entry: &Entry,
        length: u32,
    ) -> Result<Completion, AbortCode> {
        match entry.index {
            USER_MEMORY => self.user_memory.end(dictionary, length),
            _ => Err(AbortCode::UnsupportedAccess),
        }
    }
}
