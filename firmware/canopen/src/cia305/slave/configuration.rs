//! Services of the configuration state: node-ID, bit rate, store, and what the slave tells of itself.

use super::{LONGEST_SILENCE, LssEvent, Slave, Switch, after, bit, message};
use crate::cia305::identity::Identity;
use crate::settings::{BitRate, BitTiming, NodeId};
use crate::time::{Duration, Instant, NEVER};

/// The answer to 11h and 13h for what the build of this firmware has fixed: an error of the manufacturer (FFh), whose number (01h) follows.
const FIXED_BY_BUILD: u16 = 0x01FF;

/// The answer to 11h and 13h for what the device does not have.
const OUT_OF_RANGE: u16 = 0x0001;

/// Error code and specific error of an answer.
fn error_code(result: Result<(), u16>) -> u32 {
    result.err().unwrap_or_default().into()
}

impl Slave {
    /// Services of the configuration state.
    pub(super) fn configure(
        &mut self,
        specifier: u8,
        [first, second]: [u8; 2],
        identity: &Identity,
        now: Instant,
    ) -> Option<[u8; 8]> {
        match specifier {
            0x11 => {
                let node_id = NodeId::new(first).ok_or(OUT_OF_RANGE);
                let result = node_id.and_then(|node_id| self.configure_node_id(node_id));
                Some(message(specifier, error_code(result)))
            }
            0x13 => {
                // Tables above 0 belong to makers; this device has none.
                let in_table = (first == 0)
                    .then(|| BitTiming::from_table_index(second))
                    .flatten()
                    .ok_or(OUT_OF_RANGE);
                let result = in_table.and_then(|timing| self.configure_bit_timing(timing));
                Some(message(specifier, error_code(result)))
            }
            0x15 => {
                let delay = u16::from_le_bytes([first, second]);
                let delay = Duration::from_ticks(u64::from(delay) * 1000);
                let at = after(now, delay);
                self.switch_bit_rate(at, delay);
                None
            }
            0x17 => {
                self.owes_answer = true;
                self.store();
                None
            }
            0x5A..=0x5D => {
                let word = identity
                    .words()
                    .get(usize::from(specifier - 0x5A))
                    .copied()?;
                Some(message(specifier, word))
            }
            0x5E => Some(message(specifier, self.active.node_id.get().into())),
            _ => None,
        }
    }

    /// Service 13h with index 5 of table 0, of a device that takes 100 kbit/s.
    pub fn configure_100_kbit(&mut self, now: Instant) -> Option<[u8; 8]> {
        if self.is_silent(now) || !self.is_being_configured() {
            return None;
        }
        self.expected = 0;
        let result = self.configure_bit_timing(BitTiming::Fixed(BitRate::Kbit100));
        Some(message(0x13, error_code(result)))
    }

    /// A new node-ID, for the next reset communication and to be stored; refused with the error of service 11h.
    fn configure_node_id(&mut self, node_id: NodeId) -> Result<(), u16> {
        if !self.takes_node_id() {
            return Err(FIXED_BY_BUILD);
        }
        self.wish.node_id = None;
        self.pending.node_id = node_id;
        self.kept.node_id = node_id;
        Ok(())
    }

    /// A new bit rate, for service 15h and to be stored; refused with the error of service 13h.
    fn configure_bit_timing(&mut self, timing: BitTiming) -> Result<(), u16> {
        if !self.has_free_bit_timing() {
            return Err(FIXED_BY_BUILD);
        }
        if self.supported & bit(timing) == 0 {
            return Err(OUT_OF_RANGE);
        }
        self.wish.bit_timing = None;
        self.pending.bit_timing = timing;
        self.kept.bit_timing = timing;
        Ok(())
    }

    /// Activate bit timing: the pending bit rate comes into force at `at`, between two silences of `delay`.
    fn switch_bit_rate(&mut self, at: Instant, delay: Duration) {
        let to = self.pending().bit_timing;
        let is_long = delay > LONGEST_SILENCE || to == BitTiming::Automatic;
        if self.stays_reachable && is_long {
            return;
        }
        let (end, event) = match to {
            BitTiming::Fixed(bit_rate) => {
                (after(at, delay), LssEvent::SwitchBitRate { bit_rate, at })
            }
            // Until the bit rate is found.
            BitTiming::Automatic => (NEVER, LssEvent::FindBitRate { at }),
        };
        self.switch = Switch { to, at, end };
        self.event = Some(event);
    }
}
