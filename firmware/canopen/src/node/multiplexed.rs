//! Multiplexed PDOs that the firmware sends (CiA 301, 7.2.2.4 to 7.2.2.7).

use super::Node;
use crate::cia301::pdo::NotSent;
use crate::od::Dictionary;
use crate::time::Instant;

impl<D: Dictionary> Node<D> {
    /// Sends an object of this device, one of the scanner lists (1FA0h to 1FCFh), by the transmit PDO in source address mode.
    /// Its event timer sends them all, one after the other; this is for one that has changed in between.
    ///
    /// # Errors
    /// It is not sent, and why.
    pub fn announce(&mut self, index: u16, sub: u8, now: Instant) -> Result<(), NotSent> {
        let services = &mut self.services;
        services
            .tpdos
            .announce(index, sub, &self.dictionary, now, &mut services.agenda)
    }

    /// Sends a value to an object of another node (1 to 127), or of all nodes (0), by the transmit PDO in destination address
    /// mode. `value` is little-endian; what the object does not have of it is 0.
    ///
    /// # Errors
    /// It is not sent, and why.
    pub fn send_to(
        &mut self,
        node_id: u8,
        index: u16,
        sub: u8,
        value: [u8; 4],
        now: Instant,
    ) -> Result<(), NotSent> {
        let services = &mut self.services;
        services
            .tpdos
            .send_to(node_id, index, sub, value, now, &mut services.agenda)
    }
}
