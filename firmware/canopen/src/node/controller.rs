//! The CAN controller and the node: what its errors set off, and when it is started again.

use super::Node;
use crate::can_controller::{ControllerState, Counters, Due};
use crate::cia301::emergency::{Emergency, ErrorRegister, code};
use crate::cia301::error_behaviour::CommunicationError;
use crate::od::Dictionary;
use crate::time::{Duration, Instant, earlier};

/// Received frames were lost. The application may know of it too: who reports 8110h by itself does not call [`Node::frames_lost`].
const OVERRUN: Emergency = communication(code::OVERRUN);
const ERROR_PASSIVE: Emergency = communication(code::ERROR_PASSIVE);

const fn communication(code: u16) -> Emergency {
    Emergency {
        code,
        register: ErrorRegister::COMMUNICATION,
        info: [0; 5],
    }
}

impl<D: Dictionary> Node<D> {
    /// The state of the CAN controller, told when it changes or again and again. Bus-off stops everything that is sent, and
    /// [`super::Event::RestartController`] follows after the delay; tell the new state when the controller is back.
    pub fn controller_changed(&mut self, state: ControllerState, now: Instant) {
        let Some(before) = self.controller.enter(state, now) else {
            return;
        };
        self.services.agenda.is_mute = self.must_be_mute(now);
        if before == ControllerState::BusOff {
            self.clear_error(&CommunicationError::BusOff.emergency(), now);
        }
        match state {
            ControllerState::ErrorActive | ControllerState::Warning => {
                self.clear_error(&ERROR_PASSIVE, now);
            }
            ControllerState::ErrorPassive => self.report(ERROR_PASSIVE, now),
            ControllerState::BusOff => self.communication_error(CommunicationError::BusOff, now),
        }
        self.services.agenda.wake();
    }

    /// `count` received frames were lost before the device saw them: emergency 8110h, until none is lost for a second.
    pub fn frames_lost(&mut self, count: u32, now: Instant) {
        self.controller.lose(count, now);
        self.report(OVERRUN, now);
        self.services.agenda.wake();
    }

    /// How long the controller stays off the bus after bus-off (100 ms unless this is called); `None` until the next power-on.
    pub fn set_restart_delay(&mut self, delay: Option<Duration>) {
        self.controller.set_delay(delay);
    }

    /// What has gone wrong on the bus since power-on.
    pub fn counters(&self) -> Counters {
        Counters {
            overflows: self.overflows(),
            ..self.controller.counters
        }
    }

    /// The errors of the controller outlive a reset, which has made the emergency producer forget them.
    pub(super) fn report_controller_again(&mut self, now: Instant) {
        match self.controller.state {
            ControllerState::ErrorActive | ControllerState::Warning => {}
            ControllerState::ErrorPassive => self.report(ERROR_PASSIVE, now),
            ControllerState::BusOff => self.report(CommunicationError::BusOff.emergency(), now),
        }
    }

    /// Lets the delays of the controller pass; returns the next one.
    #[inline]
    pub(super) fn serve_controller(&mut self, now: Instant, deadline: Instant) -> Instant {
        while let Some(due) = self.controller.poll(now) {
            match due {
                Due::Restart => self.events.request_restart(),
                Due::OverrunOver => self.clear_error(&OVERRUN, now),
            }
        }
        earlier(deadline, self.controller.deadline())
    }
}
