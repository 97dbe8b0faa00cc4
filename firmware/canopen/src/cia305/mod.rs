//! CiA 305: layer setting services (LSS), which give a device its node-ID and bit rate.
//!
//! One master speaks on 7E5h, all slaves hear it; a slave answers on 7E4h. Every message has eight bytes: a command
//! specifier, data, zeros. A device is known by its LSS address, the four words of its identity object 1018h. The master
//! puts one slave (by address, or all of them at once) into the configuration state, configures and stores, and puts it
//! back into the waiting state. Devices without a node-ID are found by fastscan: the master asks bit by bit whether
//! anyone's address goes on like this.
//!
//! The contract:
//! - A service that does not belong to the present state, is malformed or unknown gets no answer and changes nothing but
//!   a sequence it interrupts.
//! - A new node-ID counts from the next reset communication on; for a device that had none, at once when the master
//!   switches it back to the waiting state.
//! - The messages of a service that has several follow each other; any other request between them ends the service.
//! - One store runs at a time. A request to store while one runs is answered after the settings that it has seen are
//!   stored; of several such requests the newest counts, with one answer.
//! - NMT reset node and reset communication put the slave into the waiting state and end scans and services of several
//!   messages. Pending settings, a store and a switch of the bit rate outlive them.
//! - Switching the bit rate takes no waiting: the device is silent for the delay, the rate changes, and it is silent for the
//!   delay again.

mod detection;
mod fastscan;
mod identity;
mod slave;

#[cfg(test)]
mod tests;

pub use detection::{DETECTABLE, Detection, PATIENCE};
pub use identity::Identity;
pub use slave::{LONGEST_SILENCE, LssEvent, Refused, Slave};

/// The identifier of requests from the LSS master.
pub const REQUEST_COB_ID: u16 = 0x7E5;

/// The identifier of answers from the LSS slaves.
pub const RESPONSE_COB_ID: u16 = 0x7E4;
