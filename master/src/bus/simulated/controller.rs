//! What goes wrong in the controller of one station: errors that a test gives it, and frames that it loses.

use canopen::time::NEVER;
use canopen::{ControllerState, Duration, Instant};

use super::{Bus, Handle};
use crate::bus::Station;
use crate::bus::timing::bit_time;

/// Recessive bits after which a controller that was bus-off is back (ISO 11898-1).
const RECOVERY_BITS: u32 = 128 * 11;

/// A controller of the bus.
pub(super) struct Controller {
    state: ControllerState,
    /// When it is back on the bus.
    pub(super) back_at: Instant,
    /// Frames that it will lose.
    to_lose: u32,
}

impl Controller {
    pub(super) const fn new() -> Self {
        Self {
            state: ControllerState::ErrorActive,
            back_at: NEVER,
            to_lose: 0,
        }
    }

    /// Whether it has left the bus.
    pub(super) fn is_off(&self) -> bool {
        self.state == ControllerState::BusOff
    }

    /// Whether the frame that arrives finds no room.
    pub(super) fn loses_a_frame(&mut self) -> bool {
        let loses = self.to_lose > 0;
        self.to_lose = self.to_lose.saturating_sub(1);
        loses
    }
}

impl Bus {
    /// Brings the controller of a station into a state, as many errors do, or as few. From bus-off it returns when the station
    /// has started it again, 128 times 11 bits later; what its mailboxes hold waits.
    pub fn set_controller<S: Station>(&mut self, handle: Handle<S>, state: ControllerState) {
        let now = self.now;
        let slot = &mut self.slots[handle.number()];
        slot.controller.state = state;
        slot.controller.back_at = NEVER;
        slot.wake = now;
        if let Some(station) = &mut slot.station {
            station.controller_changed(state, now);
        }
        if state == ControllerState::BusOff {
            self.flight = self
                .flight
                .take()
                .and_then(|flight| flight.without(handle.number()));
        }
    }

    /// The next `count` frames for a station get lost in its controller.
    pub fn lose_frames<S: Station>(&mut self, handle: Handle<S>, count: u32) {
        self.slots[handle.number()].controller.to_lose += count;
    }

    /// Controllers that were started again come back.
    pub(super) fn serve_controllers(&mut self) {
        let recovery: Duration = bit_time(RECOVERY_BITS, self.bit_rate);
        for slot in &mut self.slots {
            let Some(station) = &mut slot.station else {
                continue;
            };
            let controller = &mut slot.controller;
            if station.restarts_controller() && controller.is_off() && controller.back_at == NEVER {
                controller.back_at = self.now + recovery;
            }
            if controller.back_at <= self.now {
                controller.back_at = NEVER;
                controller.state = ControllerState::ErrorActive;
                slot.wake = self.now;
                station.controller_changed(ControllerState::ErrorActive, self.now);
            }
        }
    }
}
