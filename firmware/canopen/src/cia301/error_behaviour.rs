//! Error behaviour (CiA 301, 7.5.2.32; object 1029h): which NMT state a device goes to when it has lost the network.
//!
//! | 1029h:1 | after a communication error |
//! |---|---|
//! | 0 | Pre-operational, if it is Operational |
//! | 1 | no change |
//! | 2 | Stopped |
//!
//! A device without 1029h behaves as with 0. The other sub-indices belong to the device profile and to the manufacturer, and
//! do nothing here.

use super::emergency::{Emergency, ErrorRegister, code};
use super::heartbeat::HeartbeatError;
use super::nmt::NmtState;
use super::sdo::AbortCode;
use crate::od::{self, Dictionary};

/// Index of the error behaviour.
pub const INDEX: u16 = 0x1029;

/// How the network was lost (CiA 301 calls all of these communication errors).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum CommunicationError {
    /// A watched node is silent, or has started anew.
    Heartbeat(HeartbeatError),
    /// Nobody guards this device any more.
    LifeGuarding,
    /// The CAN controller has left the bus.
    BusOff,
}

impl CommunicationError {
    /// Its emergency. 8130h for the loss of a node and of guarding (node-ID 0 in the first byte of the info), 8140h for bus-off.
    pub const fn emergency(self) -> Emergency {
        let code = match self {
            Self::Heartbeat(error) => return error.emergency(),
            Self::LifeGuarding => code::ERROR_CONTROL,
            Self::BusOff => code::BUS_OFF,
        };
        Emergency {
            code,
            register: ErrorRegister::COMMUNICATION,
            info: [0; 5],
        }
    }
}

/// Whether a sub-index of 1029h may get this value. Called when it has passed the dictionary's own checks.
///
/// # Errors
/// [`AbortCode::InvalidValue`]: a reserved value of sub-index 1, above 2.
pub fn validate(sub: u8, value: &[u8]) -> Result<(), AbortCode> {
    match (sub, value) {
        (1, [3..=u8::MAX]) => Err(AbortCode::InvalidValue),
        _ => Ok(()),
    }
}

/// The state to go to from `present`; `None` to stay.
pub fn next_state<D: Dictionary>(dictionary: &D, present: NmtState) -> Option<NmtState> {
    let next = match od::fixed::<D, INDEX, 1>(dictionary).unwrap_or(0) {
        0 if present == NmtState::Operational => NmtState::PreOperational,
        2 if present != NmtState::Initialisation => NmtState::Stopped,
        _ => return None,
    };
    (next != present).then_some(next)
}
