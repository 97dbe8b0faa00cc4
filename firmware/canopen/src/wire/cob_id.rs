//! Communication object identifiers: the 11-bit numbers of the frames, and the 32-bit form that objects keep them in.
//!
//! The identifier of a frame is its priority, the lowest wins. The predefined connection set (CiA 301, 7.3.5) derives
//! the identifiers of a device from its node-ID. Those that a network needs for itself are restricted (CiA 301,
//! table 40): no configurable service may take one.

use crate::settings::NodeId;

/// NMT commands, from the master to everybody.
pub const NMT: u16 = 0x000;

/// EMCY of a device, by default.
pub const fn emergency(node_id: NodeId) -> u16 {
    0x080 + node_id.get() as u16
}

/// Answers of the SDO server to the client.
pub const fn sdo_response(node_id: NodeId) -> u16 {
    0x580 + node_id.get() as u16
}

/// Requests of the client to the SDO server.
pub const fn sdo_request(node_id: NodeId) -> u16 {
    0x600 + node_id.get() as u16
}

/// Boot-up message and heartbeat (error control).
pub const fn error_control(node_id: NodeId) -> u16 {
    0x700 + node_id.get() as u16
}

/// The node whose error control messages have this identifier.
pub const fn error_control_node(cob_id: u16) -> Option<NodeId> {
    match cob_id {
        0x701..=0x77F => NodeId::new(cob_id.to_le_bytes()[0]),
        _ => None,
    }
}

/// Whether no configurable service may use this 11-bit identifier (CiA 301, table 40): NMT and what is reserved, TIME's
/// neighbours, the default SDO, and error control with the LSS above it.
pub const fn is_restricted(cob_id: u16) -> bool {
    matches!(cob_id, 0x000..=0x07F | 0x101..=0x180 | 0x581..=0x5FF | 0x601..=0x67F | 0x6E0..=0x6FF | 0x701..)
}

/// A COB-ID as an object of the dictionary keeps it (1005h, 1014h, 1400h:1, 1800h:1 ...): the identifier in the low bits,
/// options in the three highest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CobId(pub u32);

impl CobId {
    /// Bit 31 of most objects: the service does not exist or is switched off.
    pub const INVALID: u32 = 1 << 31;
    /// Bits 0 to 10: an 11-bit identifier.
    pub const IDENTIFIER: u32 = 0x7FF;

    /// Whether the service is switched on (bit 31 is 0).
    pub const fn is_valid(self) -> bool {
        self.0 & Self::INVALID == 0
    }

    /// Bits 0 to 10, the identifier of a base frame.
    pub const fn identifier(self) -> u16 {
        (self.0 & Self::IDENTIFIER) as u16
    }

    /// Whether bits 11 to 29 are 0, so that this is a base frame and nothing that only an extended one has.
    pub const fn is_base_frame(self) -> bool {
        self.0 & 0x3FFF_F800 == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn s41_the_restricted_identifiers_are_those_of_the_table() {
        let free = [
            0x080, 0x081, 0x100, 0x181, 0x57F, 0x580, 0x600, 0x680, 0x6DF, 0x700,
        ];
        let restricted = [
            0x000, 0x001, 0x07F, 0x101, 0x180, 0x581, 0x5FF, 0x601, 0x67F, 0x6E0, 0x6FF, 0x701,
            0x780, 0x7FF,
        ];
        for cob_id in free {
            assert!(!is_restricted(cob_id), "{cob_id:03X}h is free");
        }
        for cob_id in restricted {
            assert!(is_restricted(cob_id), "{cob_id:03X}h is restricted");
        }
    }

    #[test]
    fn the_parts_of_a_cob_id() {
        assert!(CobId(0x184).is_valid());
        assert!(!CobId(0x8000_0184).is_valid());
        assert_eq!(CobId(0xC000_0184).identifier(), 0x184);
        assert!(CobId(0xC000_0184).is_base_frame());
        assert!(!CobId(0x2000_0184).is_base_frame());
        assert!(!CobId(0x0000_0984).is_base_frame());
    }
}
