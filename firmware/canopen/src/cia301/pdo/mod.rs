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
mod pack;
mod parameters;
mod receive;
mod receive_pdo;
mod transmit;
mod transmit_pdo;
mod unpack;

#[cfg(test)]
pub(crate) mod tests;

pub use pack::Source;
pub use receive::Receive;
pub use receive_pdo::ReceivePdo;
pub use transmit::Transmit;
pub use transmit_pdo::TransmitPdo;
pub use unpack::Destination;

/// The COB-ID of a PDO that is not in use: no 11-bit identifier is equal to it.
const NOT_IN_USE: u16 = u16::MAX;
