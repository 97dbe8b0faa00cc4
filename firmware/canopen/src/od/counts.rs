//! How many of each service a device has: its receive PDOs, its transmit PDOs and so on.
//!
//! The data sheet decides, and `od-gen` writes the answer into the dictionary as [`Count`]. A service keeps its places in
//! [`Slots`], an array whose length it does not know by name, so that a device is written as `Node<Dictionary>`.

use core::fmt::Debug;

use crate::cia301::heartbeat::Consumer;
use crate::cia301::pdo::{ReceivePdo, TransmitPdo};
use crate::cia301::sdo::Server;

/// The places of a service, one for each of what it serves: `[T; N]`.
pub trait Slots<T>: AsRef<[T]> + AsMut<[T]> + Debug {
    /// Places with nothing in use.
    fn unused() -> Self;
}

/// What a place is before anything uses it.
pub trait Unused {
    /// Not in use.
    const UNUSED: Self;
}

impl<T: Unused + Debug, const N: usize> Slots<T> for [T; N] {
    fn unused() -> Self {
        [const { T::UNUSED }; N]
    }
}

/// The places of all services that are counted. [`Count`] implements it.
pub trait Counts: Debug {
    /// Receive PDOs, 1400h and up.
    type Rpdos: Slots<ReceivePdo>;
    /// Transmit PDOs, 1800h and up.
    type Tpdos: Slots<TransmitPdo>;
    /// SDO servers, 1200h and up; at least one.
    type SdoServers: Slots<Server>;
    /// Heartbeat consumers, the entries of 1016h.
    type HeartbeatConsumers: Slots<Consumer>;
}

/// A device with so many receive PDOs, transmit PDOs, SDO servers, and heartbeat consumers (entries of 1016h).
#[derive(Debug)]
pub struct Count<
    const RPDOS: usize,
    const TPDOS: usize,
    const SDO_SERVERS: usize,
    const HEARTBEAT_CONSUMERS: usize,
>;

impl<
    const RPDOS: usize,
    const TPDOS: usize,
    const SDO_SERVERS: usize,
    const HEARTBEAT_CONSUMERS: usize,
> Counts for Count<RPDOS, TPDOS, SDO_SERVERS, HEARTBEAT_CONSUMERS>
{
    type Rpdos = [ReceivePdo; RPDOS];
    type Tpdos = [TransmitPdo; TPDOS];
    type SdoServers = [Server; SDO_SERVERS];
    type HeartbeatConsumers = [Consumer; HEARTBEAT_CONSUMERS];
}
