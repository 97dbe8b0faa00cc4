//! Service data objects (CiA 301, 7.2.4): a client reads and writes the object dictionary, confirmed.
//!
//! The client starts every exchange. It asks to *upload* (read) or *download* (write) one sub-index. Up to four bytes
//! travel in the initiate frames themselves (expedited); longer values follow in segments of seven bytes, each
//! confirmed, a toggle bit telling a repeated frame from the next one. Either side can end a transfer with an abort and
//! its code; abort messages are never answered.
//!
//! In a *block* transfer up to 127 segments follow each other without a question, and only the last of them is confirmed
//! (see the modules of both directions); a checksum is over all data.
//!
//! The contract of the servers:
//! - One answer to each request, never more; that to a write whose owner is not done with it comes when it is. Requests that are no SDO
//!   (not eight bytes) and aborts get none.
//! - Every refusal has its abort code ([`AbortCode`]), and leaves the object as it was.
//! - A value in RAM is staged whole: a download changes the object after its last segment and in one step, an upload is
//!   a snapshot of the moment it was initiated. Objects of eight bytes never tear. A constant is read where it
//!   lies. What the application serves piece by piece ([`Attributes::STREAMED`](crate::od::Attributes::STREAMED)) may have any length.
//! - A new initiate request drops a transfer that is open, without an abort. Only within a sub-block it cannot: there
//!   every frame is a segment.
//! - If the client is silent for the time-out ([`TIME_OUT`] by default) in a transfer, the server aborts it. The stamp of a segment counts: one
//!   that comes too late gets this abort as its answer, also when the server has not been called meanwhile. While a frame of
//!   the server waits for the bus, the client is not late.
//! - Each server has room for two answers, and an answer is never dropped. A request whose answer has no room is not executed,
//!   and counts as lost; an abort by the client always counts.
//! - Servers are independent. Only a streamed object is written by one of them at a time.

mod answers;
mod block;
mod block_download;
mod block_upload;
mod crc;
mod download;
mod objects;
pub(crate) mod parameters;
mod segments;
mod server;
mod servers;
mod upload;

pub use crate::application::Completion;
pub use crate::wire::sdo::AbortCode;
pub use objects::{Objects, Streams, Value};
pub use server::Server;
pub(crate) use servers::Others;
pub use servers::Servers;

use crate::time::Duration;

/// How long a server waits for the next frame of a transfer, in each step, unless it is told otherwise
/// ([`Node::set_sdo_time_out`](crate::Node::set_sdo_time_out)).
pub const TIME_OUT: Duration = Duration::from_ticks(1_000_000);

/// Stands for "no identifier": no 11-bit identifier is equal to it.
const NO_COB_ID: u16 = u16::MAX;

#[cfg(test)]
mod tests;
