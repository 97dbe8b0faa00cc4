//! What a server reads and writes: the object dictionary, and the application behind streamed objects.

use super::{AbortCode, Completion};
use crate::od::Entry;
use crate::wire::sdo::Multiplexer;

/// Values that are no bytes in memory, but are given and taken piece by piece ([`crate::Application`] serves them).
pub trait Streams {
    /// Whether there are any; if not, the code for them is left out.
    const ARE_THERE: bool = true;

    /// Whether these and all other objects can be reached by block transfer; if not, the code for it is left out.
    const HAVE_BLOCK_TRANSFER: bool = true;

    /// The bytes from `position` on; how many, less than there is room for only at the end of the value.
    ///
    /// # Errors
    /// They cannot be read.
    fn read_at(
        &mut self,
        entry: &'static Entry,
        position: u32,
        into: &mut [u8],
    ) -> Result<usize, AbortCode>;

    /// The next bytes.
    ///
    /// # Errors
    /// They cannot be written; nothing more is to come.
    fn write_at(
        &mut self,
        entry: &'static Entry,
        position: u32,
        data: &[u8],
    ) -> Result<(), AbortCode>;

    /// What [`Objects::begin_write`] has begun will not be ended.
    fn abandon_write(&mut self, entry: &'static Entry);
}

/// The object dictionary with every rule that stands before it.
pub trait Objects: Streams {
    /// The descriptor of an object that may be read.
    ///
    /// # Errors
    /// It does not exist or cannot be read.
    fn readable(&mut self, object: Multiplexer) -> Result<&'static Entry, AbortCode>;

    /// The present value if it is a number of one, two or four bytes that lies in memory.
    fn number(&self, entry: &Entry) -> Option<u32>;

    /// The value of an object that is to be read.
    ///
    /// # Errors
    /// It has none now.
    fn open(&mut self, entry: &'static Entry) -> Result<Value<'_>, AbortCode>;

    /// The descriptor of an object that may be written.
    ///
    /// # Errors
    /// It does not exist or cannot be written.
    fn writable(&mut self, object: Multiplexer) -> Result<&'static Entry, AbortCode>;

    /// Writes a value, after checking its length, its range and the state of the device.
    ///
    /// # Errors
    /// It is refused; nothing has changed.
    fn write(&mut self, entry: &'static Entry, value: &[u8]) -> Result<Completion, AbortCode>;

    /// A streamed object will be written, with so many bytes if that is known.
    ///
    /// # Errors
    /// Not now, or not with this size.
    fn begin_write(&mut self, entry: &'static Entry, size: Option<u32>) -> Result<(), AbortCode>;

    /// All of a streamed object is written.
    ///
    /// # Errors
    /// The value is refused.
    fn end_write(&mut self, entry: &'static Entry, length: u32) -> Result<Completion, AbortCode>;
}

/// Where the value of an object is.
#[derive(Clone, Copy, Debug)]
pub enum Value<'a> {
    /// In RAM: what is read later may be another value, so a transfer takes a snapshot.
    Variable(&'a [u8]),
    /// In flash, for ever.
    Constant(&'static [u8]),
    /// With the application, which knows the size, or will know it at the end.
    Streamed(&'static Entry, Option<u32>),
}
