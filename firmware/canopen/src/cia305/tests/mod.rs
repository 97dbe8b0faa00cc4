//! The cases of layer setting services, each under its number.

mod configuring;
mod finding;
mod properties;
mod selecting;

use super::{Identity, Slave};
use crate::settings::{BitRate, NodeId, Settings};
use crate::time::Instant;

const IDENTITY: Identity = Identity {
    vendor_id: 0x1122_3344,
    product_code: 0x5566_7788,
    revision_number: 0x99AA_BBCC,
    serial_number: 0xDDEE_FF01,
};

const START: Instant = Instant::from_ticks(5_000_000);

/// A slave on node-ID `number` (255: none), in the waiting state.
fn slave(number: u8) -> Slave {
    Slave::new(Settings {
        node_id: NodeId::new(number).unwrap(),
        bit_rate: BitRate::Kbit1000,
    })
}

/// A message: these bytes and zeros.
fn message(bytes: &[u8]) -> [u8; 8] {
    let mut message = [0; 8];
    message[..bytes.len()].copy_from_slice(bytes);
    message
}

/// A message with one word.
fn word(specifier: u8, word: u32) -> [u8; 8] {
    let [a, b, c, d] = word.to_le_bytes();
    message(&[specifier, a, b, c, d])
}

/// A fastscan message.
fn fastscan(id_number: u32, bit_check: u8, sub: u8, next: u8) -> [u8; 8] {
    let [a, b, c, d] = id_number.to_le_bytes();
    [0x51, a, b, c, d, bit_check, sub, next]
}

impl Slave {
    /// Asks, at [`START`].
    fn ask(&mut self, bytes: &[u8]) -> Option<[u8; 8]> {
        self.receive(&message(bytes), &IDENTITY, START)
    }

    /// Whether it is in the configuration state: only there it tells its node-ID.
    fn is_in_configuration(&mut self) -> bool {
        self.ask(&[0x5E]).is_some()
    }
}
