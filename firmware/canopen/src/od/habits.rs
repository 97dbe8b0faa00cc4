//! What the devices of a maker do in their own way where a standard says otherwise or leaves it open.
//!
//! A habit is a constant of the dictionary, beside [`Features`](super::Features): [`Habits::STANDARD`], unless the binding of a data
//! sheet says otherwise. The rule that it changes asks for it, and costs nothing where it is the standard's.

use crate::settings::{Configuration, Settings};
use crate::wire::sdo::AbortCode;

/// The ways of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Habits {
    /// Node-ID and bit rate that it leaves the factory with.
    pub factory: Configuration,
    /// A node-ID that LSS has configured is in force at the end of the configuration state; else, of a device that has one, at
    /// the next reset communication (CiA 305).
    pub node_id_at_once: bool,
    /// An SDO request need not have eight bytes; those that are missing are 0. CiA 301 has such a frame ignored.
    pub short_sdo_requests: bool,
    /// A mapping is written while its PDO is valid. CiA 301 (7.5.2.36) has the PDO destroyed first.
    pub maps_while_valid: bool,
    /// Remote frames never ask for a PDO: bit 30 of the COB-ID of a transmit PDO cannot be 0.
    pub no_remote_requests: bool,
    /// The answer to a wrong signature in 1010h and 1011h.
    pub wrong_signature: AbortCode,
    /// The answer to a number of errors in 1003h that is not 0.
    pub wrong_history_count: AbortCode,
    /// The answer to a mapping entry whose object does not exist: `None` tells what is missing.
    pub missing_mapped_object: Option<AbortCode>,
    /// The answer to a mapping that is longer than a PDO.
    pub mapping_too_long: AbortCode,
}

impl Habits {
    /// As the standards say.
    pub const STANDARD: Self = Self {
        factory: Settings::FACTORY.configuration(),
        node_id_at_once: false,
        short_sdo_requests: false,
        maps_while_valid: false,
        no_remote_requests: false,
        wrong_signature: AbortCode::NotTransferable,
        wrong_history_count: AbortCode::InvalidValue,
        missing_mapped_object: None,
        mapping_too_long: AbortCode::PdoLengthExceeded,
    };
}
