//! Values that are not in memory: what serves one streamed object (DOMAIN, long strings).
//!
//! A generated dictionary asks its application for a [`Source`] for each such object that can be read and for a [`Sink`] for
//! each one that can be written. Positions are in bytes from the beginning of the value. The calls are short and never wait;
//! they keep the contract of [`Application`](crate::Application), which passes them on.

mod domain;

pub use domain::Domain;

use crate::application::Completion;
use crate::od::Dictionary;
use crate::wire::sdo::AbortCode;

/// A value that is read piece by piece. While a client reads it no other one ends a write of it: that is refused with 08000022h.
pub trait Source<D: Dictionary> {
    /// A client begins to read: the present size in bytes, or `None` if that is not known before the end.
    ///
    /// # Errors
    /// The value cannot be read now.
    fn size(&mut self, dictionary: &D) -> Result<Option<u32>, AbortCode>;

    /// Puts the bytes from `position` on into `into`, and returns how many those are: fewer than there is room for only where
    /// the value ends. A position may be asked for more than once.
    ///
    /// Before another client begins while one reads, no bytes are asked for: an error says that what is being read is gone, and refuses
    /// the new transfer.
    ///
    /// # Errors
    /// The value cannot be read further; the transfer ends with this code.
    fn read_at(
        &mut self,
        dictionary: &D,
        position: u32,
        into: &mut [u8],
    ) -> Result<usize, AbortCode>;
}

/// A value that is written piece by piece.
pub trait Sink<D: Dictionary> {
    /// A client begins to write, so many bytes if it has told.
    ///
    /// # Errors
    /// The value cannot be written now, or not with this size.
    fn begin(&mut self, dictionary: &D, size: Option<u32>) -> Result<(), AbortCode>;

    /// The next bytes. Each position comes once, in order.
    ///
    /// # Errors
    /// The transfer ends with this code; [`Sink::abandon`] is not called.
    fn write_at(&mut self, dictionary: &D, position: u32, data: &[u8]) -> Result<(), AbortCode>;

    /// All `length` bytes have been written, and what the protocol can check is right. With [`Completion::Later`] the answer
    /// waits for [`Node::complete_write`](crate::Node::complete_write).
    ///
    /// # Errors
    /// The value is refused.
    fn end(&mut self, dictionary: &mut D, length: u32) -> Result<Completion, AbortCode>;

    /// The client has given up, or has fallen silent: what has begun will not be ended.
    fn abandon(&mut self, dictionary: &D) {
        let _ = dictionary;
    }
}
