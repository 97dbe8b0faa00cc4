//! `axis402 monitor`: the traffic of the bus with its meaning.

use std::sync::Arc;

use canopen::{Duration, Frame};

use super::{Console, Node, Problem};
use crate::data_sheet::{Address, DataSheet};
use crate::trace::{Interpreter, candump};
use crate::{Failure, Line, LineDown, MappedObject, Master};

/// What to watch.
#[derive(Clone, Debug)]
pub struct Watch {
    /// Nodes whose PDOs are to be told by name: they are asked once what they carry. Only frames of these nodes are shown, and those
    /// that are of none; with no node here, all.
    pub nodes: Vec<Node>,
    /// What all other nodes are.
    pub sheet: Arc<DataSheet>,
    /// How many frames to show; `None` for all until it is stopped.
    pub count: Option<usize>,
}

/// Shows frames as they come: time, identifier, bytes, meaning.
///
/// # Errors
/// [`Problem::Failed`] if a node does not say what its PDOs carry, or the bus cannot be used.
pub fn monitor<L: Line>(
    master: &mut Master<L>,
    watch: &Watch,
    console: &mut Console<'_>,
) -> Result<(), Problem> {
    let mut interpreter = Interpreter::new(Arc::clone(&watch.sheet));
    let mut cob_ids = Vec::new();
    for node in &watch.nodes {
        interpreter.learn_sheet(node.id, Arc::clone(&node.sheet));
        for pdo in pdos(master, node)? {
            interpreter.learn_pdo(pdo.cob_id, node.id, &pdo.label, &pdo.objects);
            cob_ids.push(pdo.cob_id);
        }
    }
    master.take_received();
    let mut shown = 0;
    loop {
        let end = master.now() + Duration::from_ticks(1_000_000);
        match master.line_mut().step(end) {
            Ok(_) => {}
            Err(down) if down == LineDown::stopped() => return Ok(()),
            Err(down) => return Err(Failure::from(down).into()),
        }
        for (at, frame) in master.take_received() {
            // Frames that are not shown are followed all the same: a segment means nothing without its transfer.
            let meaning = interpreter.meaning(&frame);
            if !watch.nodes.is_empty() && !is_of(&watch.nodes, &cob_ids, &frame) {
                continue;
            }
            let line = candump::line(at, &frame);
            console.say(format!("{line:<58}  {meaning}").trim_end())?;
            shown += 1;
            if watch.count.is_some_and(|count| shown >= count) {
                return Ok(());
            }
        }
    }
}

/// Whether a frame belongs to one of the nodes, or to none at all (NMT, SYNC, TIME, LSS).
fn is_of(nodes: &[Node], cob_ids: &[u16], frame: &Frame) -> bool {
    let Some(cob_id) = frame.standard_id() else {
        return false;
    };
    let node = (cob_id & 0x7F) as u8;
    let is_broadcast = matches!(cob_id, 0x000 | 0x080 | 0x100 | 0x7E4 | 0x7E5);
    is_broadcast
        || cob_ids.contains(&cob_id)
        || (0x081..=0x77F).contains(&cob_id) && nodes.iter().any(|own| own.id == node)
}

/// A PDO that a node uses.
struct Pdo {
    cob_id: u16,
    label: String,
    objects: Vec<MappedObject>,
}

/// The PDOs that are valid, as the node says.
fn pdos<L: Line>(master: &mut Master<L>, node: &Node) -> Result<Vec<Pdo>, Problem> {
    /// Even a node that nobody knows has these by the predefined connection set.
    const USUAL: usize = 4;
    let model = node.sheet.model();
    let receive = (0x1400, "RPDO", model.rpdo_count().max(USUAL));
    let transmit = (0x1800, "TPDO", model.tpdo_count().max(USUAL));
    let mut found = Vec::new();
    for (first, kind, count) in [receive, transmit] {
        for (number, communication) in (1..=count).zip(first..) {
            let cob_id = number_at(master, node, Address::new(communication, 1))?;
            let Some(cob_id) = cob_id.filter(|cob_id| cob_id & INVALID == 0) else {
                continue;
            };
            found.push(Pdo {
                cob_id: (cob_id & 0x7FF) as u16,
                label: format!("{kind} {number}"),
                objects: mapped(master, node, communication + 0x200)?,
            });
        }
    }
    Ok(found)
}

/// Bits 31 (not valid) and 29 (29-bit identifier) of a COB-ID.
const INVALID: u32 = 1 << 31 | 1 << 29;

fn mapped<L: Line>(
    master: &mut Master<L>,
    node: &Node,
    mapping: u16,
) -> Result<Vec<MappedObject>, Problem> {
    let count = number_at(master, node, Address::new(mapping, 0))?.unwrap_or(0);
    let mut objects = Vec::new();
    for sub in 1..=count.min(64) as u8 {
        if let Some(entry) = number_at(master, node, Address::new(mapping, sub))? {
            objects.push(MappedObject {
                index: (entry >> 16) as u16,
                sub: (entry >> 8) as u8,
                bits: entry as u8,
            });
        }
    }
    Ok(objects)
}

/// A number of up to four bytes; `None` if the node refuses to tell.
fn number_at<L: Line>(
    master: &mut Master<L>,
    node: &Node,
    address: Address,
) -> Result<Option<u32>, Problem> {
    match node.upload(master, address) {
        Ok(bytes) => Ok(Some(
            bytes
                .iter()
                .rev()
                .fold(0, |number, byte| number << 8 | u32::from(*byte)),
        )),
        Err(Failure::Abort { .. }) => Ok(None),
        Err(failure) => Err(Problem::with_node(node.id, failure)),
    }
}
