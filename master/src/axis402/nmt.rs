//! `axis402 nmt`: start, stop and reset nodes.

use canopen::Duration;

use super::Problem;
use crate::{Line, Master, NmtCommand};

/// Sends an NMT command; node 0 is every node.
///
/// # Errors
/// [`Problem::Failed`] if the bus cannot be used.
pub fn nmt<L: Line>(master: &mut Master<L>, command: NmtCommand, node: u8) -> Result<(), Problem> {
    master.nmt(command, node);
    // Nobody answers; the frame is to be on the bus before this program ends.
    Ok(master.wait(Duration::from_ticks(50_000))?)
}
