//! Process data objects (CiA 301, 7.2.2): up to eight bytes of mapped objects in one unconfirmed frame.
//!
//! A PDO is two records of the object dictionary. The *communication parameter* (1400h for the first receive PDO, 1800h
//! for the first transmit PDO) holds its COB-ID, its transmission type and its times. The *mapping parameter* (1600h,
//! 1A00h) lists the objects that its bytes are copied to or from. A master changes a mapping in five steps: COB-ID with
//! bit 31 (not valid), sub-index 0 of the mapping to 0, the entries, sub-index 0 to their number, COB-ID valid again.
//!
//! The contract:
//! - A write is checked in full before it changes anything; the abort codes are in `parameters.rs`.
//! - A mapping is resolved once, when it is written. A frame searches nothing.
//! - A mapping is bit-granular: objects follow each other without a gap. Whole bytes at whole bytes are copies.
//! - A PDO that is valid but maps nothing is inert: nothing is received or sent.
//! - PDOs move in Operational only.
//! - At a SYNC the synchronous transmit PDOs sample their objects first; then the synchronous receive PDOs that came
//!   before it are applied. What is sent is the device as it was at the SYNC.

mod bits;
mod errors;
mod mapping;
mod multiplexed;
mod parameters;
mod receive;
mod receive_pdo;
mod record;
mod transmit;
mod transmit_pdo;

#[cfg(test)]
pub(crate) mod tests;

use crate::cia301::sdo::AbortCode;
use crate::od::{Dictionary, Entry};

pub use mapping::Mapped;
pub use receive::Receive;
pub use receive_pdo::{ReceivePdo, Received};
pub use transmit::{NotSent, Transmit};
pub use transmit_pdo::TransmitPdo;

/// Whether an entry of a scanner or dispatcher list (1FA0h to 1FFFh) may get this value, which has passed the dictionary's own
/// checks. It counts from there on.
///
/// # Errors
/// 06040041h: an object that cannot be sent or received in four bytes. 06090030h: a node-ID above 127.
pub fn validate_list<D: Dictionary>(entry: &Entry, value: &[u8]) -> Result<(), AbortCode> {
    multiplexed::validate::<D>(entry, value)
}
