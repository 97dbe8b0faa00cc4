//! Which identifiers concern this device.
//!
//! Most frames on a bus are for others. One bit for each of the 2048 identifiers tells them apart before anything else is looked
//! at, however many services there are. The map holds what the device listens to, and what it alone may send: a frame of
//! that from somebody else is the sign of a second device with its identifier.

use super::Node;
use crate::agenda::{Object, SendPolicy};
use crate::cia305;
use crate::od::Dictionary;
use crate::wire::cob_id;

/// A set of 11-bit identifiers.
#[derive(Debug)]
pub(super) struct Identifiers([u32; Self::WORDS]);

impl Identifiers {
    const WORDS: usize = 0x800 / 32;

    pub(super) const fn none() -> Self {
        Self([0; Self::WORDS])
    }

    /// Whether an identifier is in the set.
    #[inline]
    pub(super) fn has(&self, cob_id: u16) -> bool {
        let word = usize::from(cob_id >> 5) % Self::WORDS;
        self.0
            .get(word)
            .is_some_and(|bits| bits >> (cob_id % 32) & 1 != 0)
    }

    /// Adds one; "no identifier" (above 7FFh) is not added.
    #[inline(never)]
    fn add(&mut self, cob_id: u16) {
        if let Some(bits) = self.0.get_mut(usize::from(cob_id >> 5)) {
            *bits |= 1 << (cob_id % 32);
        }
    }
}

impl<D: Dictionary> Node<D> {
    /// Builds the set anew: after a boot, and when a COB-ID has changed. A device that starts anew hears nothing, one without
    /// a node-ID only LSS.
    #[cold]
    #[inline(never)]
    pub(super) fn listen(&mut self) {
        self.services.identifiers_changed = false;
        self.identifiers = Identifiers::none();
        if !self.services.sync.is_producer() {
            self.drop_sync();
        }
        if !self.services.time.is_producer() {
            self.services.agenda.set(Object::TIME, false);
        }
        if self.is_resetting {
            return;
        }
        let set = &mut self.identifiers;
        if D::FEATURES.lss {
            set.add(cia305::REQUEST_COB_ID);
        }
        if self.node_id.is_configured() {
            set.add(cob_id::NMT);
            set.add(cob_id::error_control(self.node_id));
            for server in self.sdo.identifiers(&self.dictionary, self.node_id) {
                set.add(server.request);
                set.add(server.response);
            }
            self.services
                .identifiers(&self.dictionary, |cob_id| set.add(cob_id));
        }
        if self.state.has_sdo_and_emergency() {
            self.configure_sdo();
            self.services.agenda.wake();
        }
        let services = &mut self.services;
        let error_control = cob_id::error_control(self.node_id);
        let sync = match services.sync.is_producer() {
            true => services.sync.cob_id(),
            false => 0,
        };
        for (object, cob_id, policy) in [
            (
                Object::EMERGENCY,
                services.emergency.cob_id(),
                SendPolicy::Every,
            ),
            (Object::SYNC, sync, SendPolicy::Newest),
            (Object::TIME, services.time.cob_id(), SendPolicy::Newest),
            (Object::HEARTBEAT, error_control, SendPolicy::Every),
            (Object::GUARDING, error_control, SendPolicy::Every),
            (Object::LSS, cia305::RESPONSE_COB_ID, SendPolicy::Every),
        ] {
            services.agenda.name(object, cob_id, policy);
        }
    }

    /// The SDO servers take their identifiers.
    pub(super) fn configure_sdo(&mut self) {
        let (agenda, pdos) = (&mut self.services.agenda, self.services.tpdos.len());
        self.sdo
            .configure(&self.dictionary, self.node_id, pdos, agenda);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_identifier_is_in_the_set_that_was_added() {
        let mut set = Identifiers::none();
        for cob_id in [0, 0x1F, 0x20, 0x604, 0x7FF] {
            assert!(!set.has(cob_id));
            set.add(cob_id);
            assert!(set.has(cob_id));
        }
        assert_eq!((0..0x800).filter(|cob_id| set.has(*cob_id)).count(), 5);
    }

    #[test]
    fn no_identifier_is_never_in_the_set() {
        let mut set = Identifiers::none();
        set.add(0x800);
        set.add(u16::MAX);
        assert!((0..0x800).all(|cob_id| !set.has(cob_id)));
    }
}
