//! `axis402 save`: the parameters of a node into its memory (1010h).

use canopen::Duration;

use super::{Console, Node, Problem};
use crate::data_sheet::Address;
use crate::{Failure, Line, Master};

/// The signature "save" (CiA 301, 7.5.2.13).
const SIGNATURE: &[u8; 4] = b"save";

/// How long a device may take to save; erasing flash takes its time.
const SAVE_TIME: Duration = Duration::from_ticks(20_000_000);

/// Which parameters (the sub-indices of 1010h).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Group {
    /// All of them
    #[default]
    All,
    /// Communication: 1000h to 1FFFh
    Communication,
    /// Application: 6000h to 9FFFh
    Application,
    /// Of the manufacturer: 2000h to 5FFFh
    Manufacturer,
}

/// Saves parameters, and waits until the node says that it is done, for as long as that may take; one that does not answer at all is
/// waited for as ever.
///
/// # Errors
/// [`Problem::Failed`] if the node refuses or does not answer.
pub fn save<L: Line>(
    master: &mut Master<L>,
    node: &Node,
    group: Group,
    console: &mut Console<'_>,
) -> Result<(), Problem> {
    let address = Address::new(0x1010, group as u8 + 1);
    // Whoever is not there is not waited for as long as a save may take.
    match node.upload(master, address) {
        Ok(_) | Err(Failure::Abort { .. }) => {}
        Err(failure) => return Err(Problem::with_node(node.id, failure)),
    }
    let usual = master.set_answer_time(SAVE_TIME);
    let result = node.download(master, address, SIGNATURE);
    master.set_answer_time(usual);
    result.map_err(|failure| Problem::with_node(node.id, failure))?;
    console.say(&format!("node {} has saved its parameters", node.id))
}
