//! Service data objects (CiA 301, 7.2.4): a client reads and writes the object dictionary, confirmed.
//!
//! The client starts every exchange. It asks to *upload* (read) or *download* (write) one sub-index. Up to four bytes
//! travel in the initiate frames themselves (expedited); longer values follow in segments of seven bytes, each
//! confirmed, a toggle bit telling a repeated frame from the next one. Either side can end a transfer with an abort and
//! its code; abort messages are never answered.
//!
//! The contract of the server:
//! - One answer to each request, never more; that to a write whose owner is not done with it comes when it is. Requests that are no SDO (not eight bytes) and aborts get none.
//! - Every refusal has its abort code ([`AbortCode`]), and leaves the object as it was.
//! - A value is staged whole: a download changes the object after its last segment and in one step, an upload is a
//!   snapshot of the moment it was initiated. Objects of eight bytes never tear.
//! - A new initiate request drops a transfer that is open, without an abort.
//! - If the client is silent for [`TIME_OUT`] in a transfer, the server aborts it. The stamp of a segment counts: one that
//!   comes too late gets this abort as its answer, also when the server has not been called meanwhile.
//! - An abort ends the open transfer even when too many answers wait for the bus to take another request.
//! - Block transfer is refused as an unknown command.

mod abort;
mod download;
mod server;
mod upload;

pub use abort::AbortCode;
pub use server::{Completion, Objects, Server};

use crate::time::Duration;

/// Most bytes of one value in a segmented transfer. The longest object of a dictionary must fit.
pub const SDO_BUFFER: usize = 128;

/// How long the server waits for the next frame of a transfer, in each step.
pub const TIME_OUT: Duration = Duration::from_ticks(1_000_000);

#[cfg(test)]
mod tests;
