//! How many of each service a device has: its receive PDOs, its transmit PDOs and so on.
//!
//! The data sheet decides, and `od-gen` writes the answer into the dictionary as [`Count`]. A service keeps its places in
//! [`Slots`], an array whose length it does not know by name, so that a device is written as `Node<Dictionary>`. What lies in a
//! place is the service's own, and not named here.

use core::fmt::Debug;

use crate::agenda::{SERVICES, Word};
use crate::slots::{Slots, Unused};

/// The places of all services that are counted. [`Count`] implements it.
pub trait Counts: Debug {
    /// The objects that a PDO may map, sub-indices of 1600h, 1A00h and up.
    type PdoObjects<T: Unused + Debug>: Slots<T>;
    /// Receive PDOs, 1400h and up.
    type Rpdos<T: Unused + Debug>: Slots<T>;
    /// Transmit PDOs, 1800h and up.
    type Tpdos<T: Unused + Debug>: Slots<T>;
    /// SDO servers, 1200h and up; at least one.
    type SdoServers<T: Unused + Debug>: Slots<T>;
    /// The buffer of an SDO server, where values in RAM are whole while they travel in pieces.
    type SdoBuffer: Slots<u8>;
    /// Heartbeat consumers, the entries of 1016h.
    type HeartbeatConsumers<T: Unused + Debug>: Slots<T>;
    /// A bit for each object that sends.
    type Senders: Slots<Word>;

    /// Does not compile when [`Counts::Senders`] are too few.
    const ARE_ENOUGH_SENDERS: ();
}

/// A device with so many receive PDOs, transmit PDOs, SDO servers, and heartbeat consumers (entries of 1016h). Behind that may
/// be said how many objects a PDO maps (64 at most, each a bit), and how many bytes the longest value in RAM has: an SDO server
/// refuses a longer one with 05040005h, out of memory, and with less than eight bytes every upload of what the application serves. The last
/// number is one word for each 32 transmit PDOs, SDO servers and seven services that send.
#[derive(Debug)]
pub struct Count<
    const RPDOS: usize,
    const TPDOS: usize,
    const SDO_SERVERS: usize,
    const HEARTBEAT_CONSUMERS: usize,
    const MAPPED_OBJECTS: usize = 8,
    const SDO_BUFFER: usize = 128,
    const SENDER_WORDS: usize = 1,
>;

impl<
    const RPDOS: usize,
    const TPDOS: usize,
    const SDO_SERVERS: usize,
    const HEARTBEAT_CONSUMERS: usize,
    const MAPPED_OBJECTS: usize,
    const SDO_BUFFER: usize,
    const SENDER_WORDS: usize,
> Counts
    for Count<
        RPDOS,
        TPDOS,
        SDO_SERVERS,
        HEARTBEAT_CONSUMERS,
        MAPPED_OBJECTS,
        SDO_BUFFER,
        SENDER_WORDS,
    >
{
    type PdoObjects<T: Unused + Debug> = [T; MAPPED_OBJECTS];
    type Rpdos<T: Unused + Debug> = [T; RPDOS];
    type Tpdos<T: Unused + Debug> = [T; TPDOS];
    type SdoServers<T: Unused + Debug> = [T; SDO_SERVERS];
    type SdoBuffer = [u8; SDO_BUFFER];
    type HeartbeatConsumers<T: Unused + Debug> = [T; HEARTBEAT_CONSUMERS];
    type Senders = [Word; SENDER_WORDS];

    const ARE_ENOUGH_SENDERS: () = assert!(
        SENDER_WORDS <= 8 && TPDOS + SDO_SERVERS + SERVICES <= 32 * SENDER_WORDS,
        "a device has a word for each 32 transmit PDOs, SDO servers and seven services, and eight words at most"
    );
}
