//! What the lights of CiA 303-3 are to say of this device.

use super::Node;
use crate::can_controller::ControllerState;
use crate::cia301::emergency::code;
use crate::cia301::parameters::{PARAMETERS_LOST, PARAMETERS_REFUSED};
use crate::cia301::sync;
use crate::cia303::{CommunicationState, Signal};
use crate::od::Dictionary;

impl<D: Dictionary> Node<D> {
    /// What the lights are to say now; ask again every [`crate::cia303::Pattern::STEP`]. While the firmware looks for the bit rate
    /// it sets [`Signal::configuring`] itself.
    pub fn signal(&self) -> Signal {
        Signal {
            state: self.state,
            configuring: self.lss.is_being_configured(),
            communication: self.communication_state(),
        }
    }

    /// The gravest error of the communication that stands.
    fn communication_state(&self) -> CommunicationState {
        let of_controller = match self.controller.state {
            ControllerState::ErrorActive => CommunicationState::NoError,
            ControllerState::Warning | ControllerState::ErrorPassive => {
                CommunicationState::WarningLimit
            }
            ControllerState::BusOff => CommunicationState::BusOff,
        };
        let standing = self.services.emergency.standing().map(of_error);
        standing.fold(of_controller, Ord::max)
    }
}

/// What an error means to the red light: its code, and the first two bytes of the manufacturer.
const fn of_error(history_word: u32) -> CommunicationState {
    let [low, high, info @ ..] = history_word.to_le_bytes();
    match u16::from_le_bytes([low, high]) {
        code::ERROR_CONTROL => CommunicationState::ErrorControl,
        // This code has other causes as well; the object that was not kept to tells them apart.
        code::COMMUNICATION if u16::from_le_bytes(info) == sync::PERIOD => CommunicationState::Sync,
        code::RPDO_TIMEOUT => CommunicationState::EventTimer,
        PARAMETERS_LOST | PARAMETERS_REFUSED => CommunicationState::InvalidConfiguration,
        _ => CommunicationState::NoError,
    }
}
