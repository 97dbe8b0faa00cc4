//! What travels on the bus: the CAN frame, and one file for each CANopen format that needs a view of its own.
//!
//! A frame has an identifier of 11 bits (29 are possible, CANopen's own frames never have them) and up to eight bytes. The
//! identifier is priority and meaning in one: of two frames that start together the lower one wins the bus, and in the
//! pre-defined connection set (CiA 301, 7.3.5) it is a function code plus a node-ID ([`cob_id`]). Numbers travel lowest byte
//! first.
//!
//! The contract: every view reads any bytes without a panic and says what they are, or that they are nothing it knows; what
//! it writes it reads back as it was. Nothing here knows the state of a device.

pub mod cob_id;
mod frame;
pub mod sdo;

pub use frame::Frame;
