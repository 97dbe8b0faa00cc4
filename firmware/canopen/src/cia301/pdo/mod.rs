//! Process data objects (CiA 301, 7.2.2): up to eight bytes of mapped objects in one unconfirmed frame.
//!
//! A PDO is two records of the object dictionary. The *communication parameter* (1400h for the first receive PDO, 1800h
//! for the first transmit PDO) holds its COB-ID, its transmission type and its times. The *mapping parameter* (1600h,
//! 1A00h) lists the objects that its bytes are copied to or from. A master changes a mapping in five steps: COB-ID with
//! bit 31 (not valid), sub-index 0 of the mapping to 0, the entries, sub-index 0 to their number, COB-ID valid again.
//!
//! The contract:
//! - A write is checked in full before it changes anything; the abort codes are in `parameters.rs`.
//! - A mapping is resolved once, when it is written, into a copy plan. A frame follows the plan and searches nothing.
//! - A mapping is byte-granular: each mapped object has its own length, a multiple of 8 bits. A BOOLEAN is mapped as the
//!   8 bits that it takes in the dictionary.
//! - A PDO that is valid but maps nothing is inert: nothing is received or sent.
//! - PDOs move in Operational only. A remote request for a PDO (RTR) gets no answer, and transmission types 252 and 253
//!   are refused.
//! - At a SYNC the synchronous transmit PDOs sample their objects first; then the synchronous receive PDOs that came
//!   before it are applied. What is sent is the device as it was at the SYNC.

mod copy_plan;
mod mapping;
mod parameters;
mod receive;
mod transmit;
mod transmit_pdo;

#[cfg(test)]
pub(crate) mod tests;

pub use receive::{Receive, ReceivePdo};
pub use transmit::Transmit;
pub use transmit_pdo::TransmitPdo;

/// The COB-ID of a PDO that is not in use: no 11-bit identifier is equal to it.
const NOT_IN_USE: u16 = u16::MAX;
