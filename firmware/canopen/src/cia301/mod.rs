//! CiA 301: the communication profile, one file or folder for each of its services.
//!
//! Everything about a device is an object, and services reach it: a master reads and writes single objects by service data
//! ([`sdo`]), process data carry mapped objects without a question ([`pdo`]), all devices at the same moment if a [`sync`]
//! object says so, and [`time_stamp`] tells them what time it is. Network management ([`nmt`]) decides which services there are; a
//! [`heartbeat`] or the answers of [`guarding`] show that the device is alive, an [`emergency`] message that it has an error. What a device
//! does when it loses the network is its [`error_behaviour`]; [`parameters`] outlive power-off.
//!
//! ```text
//!                    NMT  error control  SDO  EMCY  SYNC, TIME  PDO
//!  Pre-operational    x         x         x     x        x
//!  Operational        x         x         x     x        x       x
//!  Stopped            x         x
//! ```
//!
//! The contract every service keeps:
//! - It holds what it needs of its parameter objects. A write is asked for first (`validate`: the standard's abort code, and
//!   nothing changes), then told (`written`), and counts from there on.
//! - Time comes in as an argument; a service that waits says when it wants to be called again.
//! - A frame that is malformed, too short, remote or not for this device is ignored or answered as the standard says; it
//!   changes nothing else.

pub(crate) mod cob_ids;
pub mod emergency;
pub mod error_behaviour;
pub mod error_report;
pub mod guarding;
pub mod heartbeat;
pub mod nmt;
pub mod parameters;
pub mod pdo;
pub mod sdo;
pub mod serial_number;
pub mod sync;
pub mod time_stamp;
