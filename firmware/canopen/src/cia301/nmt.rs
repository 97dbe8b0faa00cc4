//! Network management (CiA 301, 7.2.8): the state of a node, and how a master changes it.
//!
//! The master sends two bytes on identifier 000h: the command specifier, and the node-ID that it is for (0 for all).
//! There is no answer; a reset ends in the boot-up message. A command with another number of bytes is ignored, and one for
//! the state that the node is in already changes nothing: no PDO is sent again, no heartbeat comes early.
//!
//! ```text
//!  power on ──► Initialisation ──► Pre-operational ◄──► Operational
//!                    ▲                    ▲                  ▲
//!                    │ reset node,        └───► Stopped ◄────┘
//!                    │ reset communication (from every state)
//! ```

use crate::settings::NodeId;

/// The NMT state of a CANopen device, with its number in heartbeats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum NmtState {
    /// Booting: silent, no service (00h, the boot-up message). A device without a node-ID stays here and hears LSS only.
    Initialisation = 0x00,
    /// Only NMT, error control and LSS (04h).
    Stopped = 0x04,
    /// Everything (05h).
    Operational = 0x05,
    /// Everything but PDOs (7Fh).
    PreOperational = 0x7F,
}

impl NmtState {
    /// The state with this number in heartbeats; `None` for a number that no state has.
    pub const fn from_number(number: u8) -> Option<Self> {
        match number {
            0x00 => Some(Self::Initialisation),
            0x04 => Some(Self::Stopped),
            0x05 => Some(Self::Operational),
            0x7F => Some(Self::PreOperational),
            _ => None,
        }
    }

    /// Whether SDO and EMCY exist in this state (CiA 301, table 38).
    pub const fn has_sdo_and_emergency(self) -> bool {
        matches!(self, Self::PreOperational | Self::Operational)
    }

    /// Whether SYNC and TIME exist in this state (CiA 301, table 38).
    pub const fn has_sync_and_time(self) -> bool {
        matches!(self, Self::PreOperational | Self::Operational)
    }
}

/// Which part of the device starts anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reset {
    /// Reset node: every object gets its power-on value.
    Node,
    /// Reset communication: objects 1000h to 1FFFh get their power-on values; a new node-ID takes effect.
    Communication,
}

/// What a master commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Go to this state (01h start, 02h stop, 80h enter Pre-operational).
    Enter(NmtState),
    /// 81h reset node, 82h reset communication.
    Reset(Reset),
}

impl Command {
    /// Reads an NMT message; `None` if it is not for this node, is unknown, or has not exactly two bytes.
    pub fn parse(payload: &[u8], node_id: NodeId) -> Option<Self> {
        let [specifier, addressed] = *payload else {
            return None;
        };
        if addressed != 0 && addressed != node_id.get() {
            return None;
        }
        match specifier {
            0x01 => Some(Self::Enter(NmtState::Operational)),
            0x02 => Some(Self::Enter(NmtState::Stopped)),
            0x80 => Some(Self::Enter(NmtState::PreOperational)),
            0x81 => Some(Self::Reset(Reset::Node)),
            0x82 => Some(Self::Reset(Reset::Communication)),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(payload: &[u8]) -> Option<Command> {
        Command::parse(payload, NodeId::new(4).unwrap())
    }

    #[test]
    fn n04_the_broadcast_is_for_everybody() {
        assert_eq!(parse(&[1, 0]), Some(Command::Enter(NmtState::Operational)));
        assert_eq!(parse(&[1, 4]), parse(&[1, 0]));
    }

    #[test]
    fn n06_a_command_has_exactly_two_bytes() {
        for payload in [&[][..], &[1], &[1, 4, 0], &[1, 4, 0, 0, 0, 0, 0, 0]] {
            assert_eq!(parse(payload), None);
        }
    }

    #[test]
    fn n07_unknown_commands_and_nodes() {
        for payload in [[0x77, 4], [0, 4], [1, 0x84], [1, 255], [0x83, 0]] {
            assert_eq!(parse(&payload), None);
        }
    }
}
