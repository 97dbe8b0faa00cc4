//! What the devices of a maker do in their own way where a standard says otherwise or leaves it open.
//!
//! A habit is a constant of the dictionary, beside [`Features`](super::Features): [`Habits::STANDARD`], unless the binding of a data
//! sheet says otherwise. The rule that it changes asks for it, and costs nothing where it is the standard's.

use crate::settings::{Configuration, Settings};
use crate::wire::sdo::AbortCode;

/// How a maker tells masters of an error that the firmware has a code of its own for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ErrorMapping {
    /// The code in the firmware.
    pub cause: u16,
    /// The code in the message, in 1003h and in 603Fh.
    pub code: u16,
    /// Its bits of the error register, beside the generic one.
    pub register: u8,
    /// Bytes 3 to 7 of the message.
    pub info: [u8; 5],
    /// The high word of its entry in 1003h.
    pub history: u16,
    /// The byte of the message with the number of the PDO, 3 to 7, of an error that is one of a PDO.
    pub number_byte: Option<u8>,
}

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
    /// How masters are told of errors; of one that is not listed as CiA 301 and CiA 402 say.
    pub errors: &'static [ErrorMapping],
    /// A transmit PDO of type 0 is sent at each SYNC, as one of type 1; else with the first one behind an event.
    pub acyclic_is_each_sync: bool,
    /// An expedited SDO download may indicate fewer bytes than the object has: its four bytes are all there.
    pub short_sizes: bool,
    /// A mapping entry whose length is 0 has that of its object.
    pub mapped_length_of_0: bool,
    /// Objects of the maker are node-ID or bit rate, and store them; of a device that may be without LSS.
    pub settings_are_objects: bool,
    /// LSS takes 100 kbit/s, index 5 of its table 0, which CiA 305 has reserved since.
    pub lss_100_kbit: bool,
    /// A frame of a receive PDO of type N, 2 to 240, counts at the Nth SYNC from then on; else at the next one, as CiA 301 has it.
    pub receives_at_nth_sync: bool,
    /// A stored identifier stays as it is under another node-ID, until defaults are restored; else it follows the node-ID where it
    /// is the data sheet's.
    pub stored_identifiers_stay: bool,
    /// The event timer of a transmit PDO counts in 100 µs, as its inhibit time does; else in milliseconds, as CiA 301 has it.
    pub event_timer_in_100_us: bool,
    /// Without a heartbeat, an NMT command that changes the state is answered with the new one, as a heartbeat has it.
    pub tells_its_state: bool,
    /// The message of an error is followed by one with code 0 and the error register: what is wrong in all.
    pub tells_of_the_rest: bool,
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
        errors: &[],
        acyclic_is_each_sync: false,
        short_sizes: false,
        mapped_length_of_0: false,
        settings_are_objects: false,
        lss_100_kbit: false,
        receives_at_nth_sync: false,
        stored_identifiers_stay: false,
        event_timer_in_100_us: false,
        tells_its_state: false,
        tells_of_the_rest: false,
    };

    /// How masters are told of an error with this code; `None` if they are told as it is.
    #[inline]
    pub fn error_mapping(&self, cause: u16) -> Option<&'static ErrorMapping> {
        self.errors.iter().find(|mapping| mapping.cause == cause)
    }

    /// The code that masters see of an error.
    #[inline]
    pub fn code(&self, cause: u16) -> u16 {
        self.error_mapping(cause)
            .map_or(cause, |mapping| mapping.code)
    }
}
