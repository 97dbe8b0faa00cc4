//! The scope: values of the drive, recorded at the rate of the control tick around a trigger, and read as one DOMAIN.
//!
//! A master maps up to eight values to channels as it would map them to a PDO (20D1h), says what the trigger is (20D2h) and how much
//! is to be recorded (20D0h), and arms the recorder. From then on every n-th control tick leaves a sample in a ring; when the
//! trigger comes, as many samples follow as are left, and then 20D3h is there to be read. `docs/scope.md` has every byte.
//!
//! The parts:
//! - `ScopeObjects`, in the node task: the rules of the objects, and what a master has ordered.
//! - [`Recorder`], behind the control tick: takes orders, looks for the trigger, samples.
//! - [`Recording`], in the node task: the source of 20D3h.
//!
//! The contract:
//! - What is sampled is what the tick has published: all values of a sample are of one tick, and equal to what a PDO shows of it.
//! - Orders and the state pass through the [`Exchange`](crate::Exchange) as everything else does. The samples do not: they lie in a
//!   [`Memory`] of single words that both halves may touch, and only one of them does at a time. While the recorder is at work the
//!   memory is its own; when it is full it says so, and until the next recording begins the node may read.
//! - Nobody waits for a lock longer than the copy of a set of actual values, however large the memory is.
//! - A recorder that is idle costs a control tick one look at the exchange.

mod memory;
mod objects;
mod reading;
mod sampling;
mod values;

pub use crate::scope::{CHANNELS, Edge, Orders, Setup, Signal, State, Status, Trigger};
pub use memory::{HEADER, Memory, VERSION};
pub(crate) use objects::ScopeObjects;
pub use reading::Recording;
pub use sampling::Recorder;

#[cfg(test)]
mod tests;
