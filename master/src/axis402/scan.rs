//! `axis402 scan`: who is on the bus?

use std::collections::BTreeMap;

use canopen::{Duration, Frame};

use super::{Console, Problem};
use crate::trace::node_state;
use crate::{Failure, Line, Master};

/// Nodes that are asked at once. Their answers have the right of way before the questions, so the last one comes soon after its
/// question even at 10 kbit/s.
const AT_ONCE: u8 = 8;

/// What is known of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// Its last heartbeat.
    pub state: Option<u8>,
    /// Whether its SDO server answers.
    pub answers: bool,
}

/// Who a node says that it is; `None` for what it does not tell.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Description {
    /// 1000h.
    pub device_type: Option<u32>,
    /// 1018h:1 to 4.
    pub identity: [Option<u32>; 4],
    /// 1008h.
    pub name: Option<String>,
}

impl Description {
    /// Asks a node.
    ///
    /// # Errors
    /// [`Problem`] if the bus cannot be used.
    pub fn ask<L: Line>(master: &mut Master<L>, id: u8) -> Result<Self, Problem> {
        let mut identity = [None; 4];
        let device_type = told(master.read(id, 0x1000, 0))?;
        for (sub, word) in (1..).zip(&mut identity) {
            *word = told(master.read(id, 0x1018, sub))?;
        }
        let name = told(master.read::<Vec<u8>>(id, 0x1008, 0))?
            .map(|bytes| (String::from_utf8_lossy(&bytes).trim_end_matches('\0')).to_owned());
        Ok(Self {
            device_type,
            identity,
            name,
        })
    }
}

/// Asks every node-ID, and tells who answers or sends heartbeats: state, device type, identity and name. Tells as well whether there
/// is a device without a node-ID.
///
/// # Errors
/// [`Problem::Failed`] if the bus cannot be used.
pub fn scan<L: Line>(master: &mut Master<L>, console: &mut Console<'_>) -> Result<(), Problem> {
    let nodes = present(master, console)?;
    if !nodes.is_empty() {
        console
            .say("node  state            device    vendor    product   revision  serial    name")?;
    }
    for (id, found) in &nodes {
        let line = describe(master, *id, found)?;
        console.say(line.trim_end())?;
    }
    let unconfigured = master.lss_is_anyone_unconfigured()?;
    let count = match nodes.len() {
        0 => "no node answers".to_owned(),
        1 => "1 node".to_owned(),
        count => format!("{count} nodes"),
    };
    console.say(&match unconfigured {
        true => format!("{count}, and at least one device without a node-ID (see `axis402 lss`)"),
        false => count,
    })
}

/// The node-IDs that are in use.
pub(super) fn used<L: Line>(
    master: &mut Master<L>,
    console: &mut Console<'_>,
) -> Result<Vec<u8>, Problem> {
    let nodes = present(master, console)?;
    Ok(nodes.into_keys().collect())
}

/// Asks every node-ID, and hears who answers or sends heartbeats.
///
/// # Errors
/// [`Problem::Failed`] if the bus cannot be used.
pub fn present<L: Line>(
    master: &mut Master<L>,
    console: &mut Console<'_>,
) -> Result<BTreeMap<u8, Found>, Problem> {
    master.take_received();
    let mut nodes: BTreeMap<u8, Found> = BTreeMap::new();
    for first in (1..=127).step_by(usize::from(AT_ONCE)) {
        console.progress("asking every node-ID", u32::from(first), 127);
        for id in first..(first + AT_ONCE).min(128) {
            master.send_data(0x600 + u16::from(id), &[0x40, 0x00, 0x10, 0, 0, 0, 0, 0]);
        }
        listen(master, &mut nodes)?;
    }
    Ok(nodes)
}

/// Hears answers and heartbeats until there was no answer for as long as one may take.
/// Answers that never end, to another master or of a device that is broken, do not keep it waiting.
fn listen<L: Line>(master: &mut Master<L>, nodes: &mut BTreeMap<u8, Found>) -> Result<(), Problem> {
    let quiet = QUIET.max(master.answer_time() / 20);
    let end = master.now() + quiet * u32::from(AT_ONCE);
    loop {
        let answer = master.wait_for("an answer", quiet, |frame| {
            id_of(frame, 0x580).filter(|_| frame.full_payload().is_some())
        });
        let is_over = match answer {
            Ok(id) => {
                nodes.entry(id).or_default().answers = true;
                false
            }
            Err(Failure::Timeout { .. }) => true,
            Err(failure) => return Err(failure.into()),
        };
        for (_, frame) in master.take_received() {
            if let (Some(id), [state]) = (id_of(&frame, 0x700), frame.payload()) {
                nodes.entry(id).or_default().state = Some(*state);
            } else if let Some(id) = id_of(&frame, 0x580) {
                nodes.entry(id).or_default().answers = true;
            }
        }
        if is_over || master.now() >= end {
            return Ok(());
        }
    }
}

/// The silence after which nobody answers any more; longer for a person who is patient.
const QUIET: Duration = Duration::from_ticks(150_000);

/// The node of a frame in this group of the predefined connection set.
fn id_of(frame: &Frame, group: u16) -> Option<u8> {
    let node = frame.standard_id()?.checked_sub(group)?;
    let is_node = (1..=127).contains(&node) && !frame.is_remote();
    u8::try_from(node).ok().filter(|_| is_node)
}

fn describe<L: Line>(master: &mut Master<L>, id: u8, found: &Found) -> Result<String, Problem> {
    let state = found.state.map_or("", node_state);
    if !found.answers {
        return Ok(format!("{id:>4}  {state:<15}  (answers no SDO)"));
    }
    let description = Description::ask(master, id)?;
    let words = std::iter::once(description.device_type).chain(description.identity);
    let columns: Vec<String> = words
        .map(|word| word.map_or_else(|| "-".repeat(8), |word| format!("{word:08X}")))
        .collect();
    Ok(format!(
        "{id:>4}  {state:<15}  {}  {}",
        columns.join("  "),
        description.name.unwrap_or_default()
    ))
}

/// What was told, if it was.
fn told<T>(answer: Result<T, Failure>) -> Result<Option<T>, Problem> {
    match answer {
        Ok(value) => Ok(Some(value)),
        Err(failure @ (Failure::LineDown(_) | Failure::TimeIsUp { .. })) => Err(failure.into()),
        Err(_) => Ok(None),
    }
}
