//! What waits for the firmware around the device.

use heapless::Deque;

use super::Event;
use crate::cia301::emergency::ReceivedEmergency;
use crate::cia301::error_behaviour::CommunicationError;
use crate::cia301::nmt::{NmtState, Reset};
use crate::settings::{BitTiming, Configuration};
use crate::time::Instant;

/// Most changes of state that wait.
const MOST_STATES: usize = 8;

/// Most emergency messages of others that wait.
const MOST_EMERGENCIES: usize = 4;

/// The events. What must be done has a place of its own and is never lost: the newest request of a kind replaces an older
/// one. A reset comes last, as the device stands still until it is served. Only changes of state and messages of others may be left out.
#[derive(Debug)]
pub(super) struct Events {
    states: Deque<NmtState, MOST_STATES>,
    restart: bool,
    emergencies: Deque<ReceivedEmergency, MOST_EMERGENCIES>,
    communication_error: Option<CommunicationError>,
    /// The same for who asks in between.
    network_lost: bool,
    store: Option<Configuration>,
    switch: Option<(BitTiming, Instant)>,
    reset: Option<Reset>,
    overflows: u32,
}

impl Events {
    pub(super) const fn new() -> Self {
        Self {
            states: Deque::new(),
            restart: false,
            emergencies: Deque::new(),
            communication_error: None,
            network_lost: false,
            store: None,
            switch: None,
            reset: None,
            overflows: 0,
        }
    }

    /// The NMT state changed. Of the changes that find no room only the last one is kept.
    pub(super) fn state_changed(&mut self, state: NmtState) {
        if self.states.push_back(state).is_ok() {
            return;
        }
        self.overflows = self.overflows.saturating_add(1);
        if let Some(newest) = self.states.back_mut() {
            *newest = state;
        }
    }

    /// The network was lost; a later loss takes the place of one that has not been told yet.
    pub(super) fn communication_error(&mut self, error: CommunicationError) {
        self.communication_error = Some(error);
        self.network_lost = true;
    }

    /// Whether the network was lost since the last call. The event stays.
    pub(super) fn take_network_loss(&mut self) -> bool {
        core::mem::take(&mut self.network_lost)
    }

    /// Asks for the CAN controller to be started again.
    pub(super) fn request_restart(&mut self) {
        self.restart = true;
    }

    /// Another device tells of an error. Of several the first ones are kept: they are nearest to the cause.
    pub(super) fn emergency_received(&mut self, emergency: ReceivedEmergency) {
        if self.emergencies.push_back(emergency).is_err() {
            self.overflows = self.overflows.saturating_add(1);
        }
    }

    /// Asks for settings to be stored.
    pub(super) fn request_store(&mut self, settings: Configuration) {
        self.store = Some(settings);
    }

    /// Asks for a switch of the bit rate, or to find it.
    pub(super) fn request_switch(&mut self, to: BitTiming, at: Instant) {
        self.switch = Some((to, at));
    }

    /// Asks for a reset; a reset that has not been served yet becomes the wider one of the two.
    pub(super) fn request_reset(&mut self, reset: Reset) {
        if self.reset != Some(Reset::Node) {
            self.reset = Some(reset);
        }
    }

    /// The device boots: a request for it is served.
    pub(super) fn forget_reset(&mut self) {
        self.reset = None;
    }

    /// The reset that is asked for, removed.
    pub(super) fn take_reset(&mut self) -> Option<Reset> {
        self.reset.take()
    }

    /// The next event, removed: changes of state in their order, what the network brings, what LSS asks for, a reset.
    pub(super) fn pop(&mut self) -> Option<Event> {
        if let Some(state) = self.states.pop_front() {
            return Some(Event::StateChanged(state));
        }
        if core::mem::take(&mut self.restart) {
            return Some(Event::RestartController);
        }
        if let Some(emergency) = self.emergencies.pop_front() {
            return Some(Event::EmergencyReceived(emergency));
        }
        if let Some(error) = self.communication_error.take() {
            return Some(Event::CommunicationError(error));
        }
        if let Some(settings) = self.store.take() {
            return Some(Event::StoreSettings(settings));
        }
        if let Some((to, at)) = self.switch.take() {
            return Some(match to {
                BitTiming::Fixed(bit_rate) => Event::SwitchBitRate { bit_rate, at },
                BitTiming::Automatic => Event::FindBitRate { at },
            });
        }
        self.take_reset().map(Event::ResetRequested)
    }

    /// Changes of state, and emergency messages of others, that found no room.
    pub(super) fn overflows(&self) -> u32 {
        self.overflows
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reset_comes_last_and_is_never_lost() {
        let mut events = Events::new();
        for _ in 0..20 {
            events.state_changed(NmtState::Operational);
        }
        events.state_changed(NmtState::Stopped);
        events.request_reset(Reset::Node);
        events.request_reset(Reset::Communication);
        let mut last = None;
        let mut before = None;
        while let Some(event) = events.pop() {
            before = last;
            last = Some(event);
        }
        assert_eq!(last, Some(Event::ResetRequested(Reset::Node)));
        assert_eq!(before, Some(Event::StateChanged(NmtState::Stopped)));
        assert_eq!(events.overflows(), 13);
    }
}
