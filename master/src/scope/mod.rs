//! `sim scope`: what a drive records of itself, fetched and shown.
//!
//! It speaks to any drive with the objects 20D0h to 20D3h (`docs/scope.md`), on a real bus as `axis402` does, and on the simulated
//! one in the tests.

mod arguments;
mod recording;
mod report;
mod session;
mod trigger;

use std::io::{self, IsTerminal};

use od_gen::standard_output;

pub use arguments::Arguments;
pub use recording::{Channel, Recording};
pub use report::Report;
pub use session::{Armed, Before, Progress, Request, arm, disarm, fetch, record};
pub use trigger::{Edge, Trigger};

use crate::axis402::{Console, Node, Problem, go_on_bus, read_sheet};
use crate::data_sheet::DataSheet;
use crate::{Line, Master};

/// How many values a sample may have.
const CHANNELS: usize = 8;

/// Runs the command on the bus that it names; standard output and standard error are its console.
///
/// # Errors
/// Why there is nothing to show.
pub fn run(arguments: &Arguments) -> Result<(), Problem> {
    let (mut output, mut progress) = (standard_output::lock(), io::stderr().lock());
    let is_terminal = progress.is_terminal();
    let mut console = Console::new(&mut output, &mut progress, is_terminal);
    let mut master = go_on_bus(&arguments.bus)?;
    let result = show(&mut master, arguments, &mut console);
    crate::axis402::explain(result, master.line_mut())
}

/// Records, fetches and tells.
///
/// # Errors
/// [`Problem::Usage`] if the arguments mean nothing or a file cannot be written; [`Problem::Failed`] as [`record`].
pub fn show<L: Line>(
    master: &mut Master<L>,
    arguments: &Arguments,
    console: &mut Console<'_>,
) -> Result<(), Problem> {
    let sheet = read_sheet(&arguments.sheet, console)?;
    let node = Node::meet(master, arguments.node, sheet)?;
    let request = arguments.request(&node.sheet).map_err(Problem::Usage)?;
    if let Some(number) = arguments.sdo_server {
        node.use_sdo_server(master, number)?;
    }
    let recording = record(master, &node, &request, console)?;
    Report::new(node.id, &recording).give(arguments, console)
}

/// The mapping of an object: index, sub-index and length in bits.
fn mapping(object: &str, sheet: &DataSheet) -> Result<u32, String> {
    let object = object.trim();
    let address = sheet.find(object)?;
    let size = sheet.data_type(address).and_then(|known| known.size());
    let size = size.ok_or_else(|| {
        format!("the length of {address} is not known: --eds names the data sheet of the drive")
    })?;
    let bits = u32::from(size) * 8;
    Ok(u32::from(address.index) << 16 | u32::from(address.sub) << 8 | bits)
}
