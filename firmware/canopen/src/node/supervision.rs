//! Watching the network, and what happens when it is lost: the emergency, the error behaviour 1029h, the word to the application.

use super::Node;
use crate::agenda::Object;
use crate::cia301::emergency::{Emergency, ErrorRegister, code, consumer};
use crate::cia301::error_behaviour::{self, CommunicationError};
use crate::cia301::heartbeat::{Heard, HeartbeatError};
use crate::cia305;
use crate::od::Dictionary;
use crate::settings::NodeId;
use crate::time::Instant;
use crate::wire::{Frame, cob_id};

impl<D: Dictionary> Node<D> {
    /// A data frame that belongs to none of the services that are used all the time.
    #[cold]
    #[inline(never)]
    pub(super) fn receive_other(&mut self, cob_id: u16, frame: &Frame, now: Instant) {
        if D::FEATURES.lss && cob_id == cia305::REQUEST_COB_ID {
            if let Some(request) = frame.full_payload() {
                self.receive_lss(request, now);
            }
            return;
        }
        if self.receive_error_control(cob_id, frame.payload(), now)
            || D::FEATURES.time && self.receive_time(cob_id, frame.payload(), now)
            || D::FEATURES.emergency_consumer && self.receive_emergency(cob_id, frame)
        {
            return;
        }
        if self.services.is_sent(cob_id) || self.is_sent(cob_id) {
            self.report_collision(cob_id, now);
        }
    }

    /// Whether the device sends this identifier, whatever its parameters are.
    fn is_sent(&self, cob_id: u16) -> bool {
        let mut servers = self.sdo.identifiers(&self.dictionary, self.node_id);
        cob_id == cob_id::error_control(self.node_id)
            || servers.any(|server| server.response == cob_id)
    }

    /// A remote frame: a question of the guarding master, or for a transmit PDO.
    #[cold]
    #[inline(never)]
    pub(super) fn receive_remote(&mut self, cob_id: u16, now: Instant) {
        let is_asked = D::FEATURES.guarding && cob_id == cob_id::error_control(self.node_id);
        if is_asked && !self.services.heartbeat.is_on() {
            if self.services.guarding.ask(now) {
                self.clear_error(&CommunicationError::LifeGuarding.emergency(), now);
            }
            self.services.agenda.wake();
            self.services.agenda.set(Object::GUARDING, true);
        } else {
            let services = &mut self.services;
            services
                .tpdos
                .on_request(cob_id, &self.dictionary, now, &mut services.agenda);
            // The times of an event-driven one may have changed.
            self.services.agenda.look();
        }
    }

    /// A message of a watched node; `false` if it is none.
    fn receive_error_control(&mut self, cob_id: u16, payload: &[u8], now: Instant) -> bool {
        let Some(node_id) = cob_id::error_control_node(cob_id) else {
            return false;
        };
        if !self.services.consumers.watches(node_id) {
            return false;
        }
        if let &[state] = payload {
            match self.services.consumers.receive(node_id, state, now) {
                Some(Heard::Returned(error)) => self.clear_error(&error.emergency(), now),
                Some(Heard::Restarted(node_id)) => {
                    let error = HeartbeatError::Restarted(node_id);
                    self.communication_error(CommunicationError::Heartbeat(error), now);
                }
                None => {}
            }
            self.services.agenda.wake();
        }
        true
    }

    /// An emergency message of another device; `false` if it is none that 1028h listens to.
    fn receive_emergency(&mut self, cob_id: u16, frame: &Frame) -> bool {
        let Some(emergency) = consumer::receive(&self.dictionary, cob_id, frame) else {
            return false;
        };
        if self.state.has_sdo_and_emergency() {
            self.events.emergency_received(emergency);
        }
        true
    }

    /// Another device sends what only this one may send. It stands until communication starts anew.
    fn report_collision(&mut self, cob_id: u16, now: Instant) {
        let [low, high] = cob_id.to_le_bytes();
        let emergency = Emergency {
            code: code::COLLISION,
            register: ErrorRegister::COMMUNICATION,
            info: [low, high, 0, 0, 0],
        };
        self.report(emergency, now);
    }

    /// Looks who has fallen silent.
    #[cold]
    #[inline(never)]
    pub(super) fn supervise(&mut self, now: Instant) {
        let mut is_lost = false;
        while let Some(node_id) = self.services.consumers.poll(now) {
            let error = HeartbeatError::Lost(node_id);
            self.tell_communication_error(CommunicationError::Heartbeat(error), now);
            is_lost = true;
        }
        if D::FEATURES.guarding && self.services.guarding.poll(now) {
            self.tell_communication_error(CommunicationError::LifeGuarding, now);
            is_lost = true;
        }
        if is_lost {
            self.follow_error_behaviour(now);
        }
    }

    /// The network is lost: told, and followed by the NMT state of 1029h. An emergency message that may leave does so even when
    /// the device stops itself: it says why.
    pub(super) fn communication_error(&mut self, error: CommunicationError, now: Instant) {
        self.tell_communication_error(error, now);
        self.follow_error_behaviour(now);
    }

    #[inline(never)]
    fn tell_communication_error(&mut self, error: CommunicationError, now: Instant) {
        self.report(error.emergency(), now);
        self.events.communication_error(error);
    }

    fn follow_error_behaviour(&mut self, now: Instant) {
        if let Some(state) = error_behaviour::next_state(&self.dictionary, self.state) {
            self.enter(state, now);
        }
    }

    #[inline(never)]
    pub(super) fn clear_error(&mut self, emergency: &Emergency, now: Instant) {
        self.services
            .clear_one(&mut self.dictionary, emergency, now);
    }

    /// The NMT state of another node, as its last heartbeat told it; `None` for one that 1016h does not watch, or that is not
    /// heard.
    pub fn remote_state(&self, node_id: NodeId) -> Option<crate::cia301::nmt::NmtState> {
        self.services.consumers.state(node_id)
    }

    /// Whether the network was lost since the last call, ahead of the events that wait: for who has to stop something at once.
    /// [`super::Event::CommunicationError`] tells of it all the same.
    pub fn take_network_loss(&mut self) -> bool {
        self.events.take_network_loss()
    }
}
