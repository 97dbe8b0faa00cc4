//! `axis402 od dump` and `axis402 od load`: the configuration of a device as a whole, as a DCF (CiA 306).
//!
//! A configuration is what can be written and is no command: neither controlword nor targets are among it, nor what stores or
//! restores. So a device that gets the configuration of another does not move.

use std::collections::BTreeSet;

use od_gen::model::{Access, DefaultValue, Entry, Object};
use od_gen::{DataType, Model, transfer};

use super::{Console, Node, Problem};
use crate::data_sheet::Address;
use crate::data_sheet::value::text;
use crate::{Failure, Line, Master};

/// What a master commands (CiA 402): controlword, targets, additive values, outputs.
const COMMANDS: [u16; 10] = [
    0x6040, 0x6042, 0x6071, 0x607A, 0x60B0, 0x60B1, 0x60B2, 0x60C1, 0x60FE, 0x60FF,
];

/// ObjFlags (CiA 306): not written when a configuration is downloaded.
const REFUSE_WRITE: u32 = 1 << 0;

/// ObjFlags: not read when it is scanned.
const REFUSE_READ: u32 = 1 << 1;

/// Reads every object of the data sheet and tells it as a line. Returns the data sheet with what belongs to a configuration as
/// ParameterValue.
///
/// # Errors
/// [`Problem::Failed`] if the node does not answer.
pub fn dump<L: Line>(
    master: &mut Master<L>,
    node: &Node,
    tells: bool,
    console: &mut Console<'_>,
) -> Result<Model, Problem> {
    let mut model = node.sheet.model().clone();
    let count = model.entries().count() as u32;
    let mut done = 0;
    let mut absent = 0;
    for object in &mut model.objects {
        let is_configuration: Vec<bool> = (object.entries.iter())
            .map(|entry| belongs(object, entry))
            .collect();
        let flags = object.flags;
        for (entry, is_configuration) in object.entries.iter_mut().zip(is_configuration) {
            console.progress("reading", done, count);
            done += 1;
            let address = Address::new(object.index, entry.sub);
            let is_scanned = (flags | entry.flags) & REFUSE_READ == 0;
            if !entry.access.is_readable() || entry.data_type == DataType::Domain || !is_scanned {
                continue;
            }
            let bytes = match node.upload(master, address) {
                Ok(bytes) => bytes,
                Err(Failure::Abort {
                    code: NO_OBJECT | NO_SUB_INDEX | NO_DATA,
                    ..
                }) => {
                    absent += 1;
                    continue;
                }
                Err(failure @ Failure::Abort { .. }) => {
                    if let Some(line) = Problem::with_node(node.id, failure).line() {
                        console.remark(&line);
                    }
                    continue;
                }
                Err(failure) => return Err(Problem::with_node(node.id, failure)),
            };
            if is_configuration {
                entry.configured = configured(&bytes, entry, node.id);
            }
            if tells {
                let value = text(address, &bytes, Some(entry.data_type));
                console.say(&format!("{}: {value}", node.title(address)))?;
            }
        }
    }
    if absent > 0 {
        console.remark(&format!("{absent} values of the data sheet are not there"));
    }
    Ok(model)
}

const NO_OBJECT: u32 = 0x0602_0000;
const NO_SUB_INDEX: u32 = 0x0609_0011;
const NO_DATA: u32 = 0x0800_0024;

/// A value as it stands in a DCF: with $NODEID where the data sheet has it, so that another node can take it.
fn configured(bytes: &[u8], entry: &Entry, node_id: u8) -> Option<DefaultValue> {
    let value = transfer::value(bytes, entry.data_type)?;
    Some(match value {
        DefaultValue::Number { value, .. } if entry.adds_node_id() => {
            let base = value - i128::from(node_id);
            let is_own = value & 0x7F == i128::from(node_id);
            DefaultValue::Number {
                value: if is_own { base } else { value },
                adds_node_id: is_own,
            }
        }
        other => other,
    })
}

/// Whether a value is a part of the configuration.
fn belongs(object: &Object, entry: &Entry) -> bool {
    let is_setting = entry.access == Access::ReadWrite && entry.storage.is_some();
    let is_written = (object.flags | entry.flags) & REFUSE_WRITE == 0;
    let is_domain = entry.data_type == DataType::Domain;
    is_setting && is_written && !is_domain && !COMMANDS.contains(&object.index)
}

/// Writes the configuration of a DCF. What the node has already is not written again; a PDO is switched off while it changes. Every
/// refusal is told, and the rest is written all the same.
///
/// # Errors
/// [`Problem::Failed`] if the node refuses a value or does not answer.
pub fn load<L: Line>(
    master: &mut Master<L>,
    node: &Node,
    configuration: &Model,
    console: &mut Console<'_>,
) -> Result<(), Problem> {
    let mut loading = Loading {
        node,
        written: 0,
        refused: 0,
    };
    let values = values(configuration, node.id, console);
    let mut changed = Vec::new();
    for (done, (address, bytes)) in (0..).zip(&values) {
        console.progress("comparing", done, values.len() as u32);
        if !loading.has(master, *address, bytes)? {
            changed.push((*address, bytes.as_slice()));
        }
    }
    // All of a PDO that changes is written, in the order that the standard asks for.
    let pdos: BTreeSet<u16> = changed
        .iter()
        .filter_map(|(address, _)| pdo(*address))
        .collect();
    for (address, bytes) in &changed {
        if pdo(*address).is_none() {
            loading.write(master, *address, bytes, console)?;
        }
    }
    for communication in pdos {
        let of_pdo: Vec<_> = (values.iter())
            .filter(|(address, _)| pdo(*address) == Some(communication))
            .map(|(address, bytes)| (*address, bytes.as_slice()))
            .collect();
        loading.write_pdo(master, communication, &of_pdo, console)?;
    }
    let Loading {
        written, refused, ..
    } = loading;
    let same = values.len() - changed.len();
    console.say(&format!("{written} values written, {same} were so already"))?;
    match refused {
        0 => Ok(()),
        1 => Err(Problem::Failed(format!("node {} refused 1 value", node.id))),
        _ => Err(Problem::Failed(format!(
            "node {} refused {refused} values",
            node.id
        ))),
    }
}

/// The values that a DCF configures, by address.
fn values(
    configuration: &Model,
    node_id: u8,
    console: &mut Console<'_>,
) -> Vec<(Address, Vec<u8>)> {
    let mut values = Vec::new();
    for (object, entry) in configuration.entries() {
        let Some(value) = &entry.configured else {
            continue;
        };
        let address = Address::new(object.index, entry.sub);
        if belongs(object, entry) {
            values.push((address, transfer::bytes(value, entry.data_type, node_id)));
        } else {
            console.remark(&format!(
                "{address} {} is no setting: left out",
                object.name
            ));
        }
    }
    values
}

/// The communication record of the PDO that an object belongs to.
fn pdo(address: Address) -> Option<u16> {
    match address.index {
        0x1400..=0x15FF | 0x1800..=0x19FF => Some(address.index),
        0x1600..=0x17FF | 0x1A00..=0x1BFF => Some(address.index - 0x200),
        _ => None,
    }
}

/// A download under way.
struct Loading<'a> {
    node: &'a Node,
    written: usize,
    refused: usize,
}

impl Loading<'_> {
    /// Whether the node has this value already.
    fn has<L: Line>(
        &self,
        master: &mut Master<L>,
        address: Address,
        bytes: &[u8],
    ) -> Result<bool, Problem> {
        match self.node.upload(master, address) {
            Ok(present) => Ok(present == bytes),
            // What cannot be read may be written all the same.
            Err(Failure::Abort { .. }) => Ok(false),
            Err(failure) => Err(Problem::with_node(self.node.id, failure)),
        }
    }

    fn write<L: Line>(
        &mut self,
        master: &mut Master<L>,
        address: Address,
        bytes: &[u8],
        console: &mut Console<'_>,
    ) -> Result<(), Problem> {
        match self.node.download(master, address, bytes) {
            Ok(()) => self.written += 1,
            Err(failure @ Failure::Abort { .. }) => {
                self.refused += 1;
                if let Some(line) = Problem::with_node(self.node.id, failure).line() {
                    console.remark(&line);
                }
            }
            Err(failure) => return Err(Problem::with_node(self.node.id, failure)),
        }
        Ok(())
    }

    /// Switch off, unmap, set up, map, switch on (CiA 301, 7.5.2.36). What the DCF does not say stays as it is.
    fn write_pdo<L: Line>(
        &mut self,
        master: &mut Master<L>,
        communication: u16,
        values: &[(Address, &[u8])],
        console: &mut Console<'_>,
    ) -> Result<(), Problem> {
        let (cob_id, count) = (
            Address::new(communication, 1),
            Address::new(communication + 0x200, 0),
        );
        let find = |wanted| (values.iter()).find(|(address, _)| *address == wanted);
        let present = match self.node.upload(master, cob_id) {
            Ok(bytes) => bytes,
            Err(failure) => return Err(Problem::with_node(self.node.id, failure)),
        };
        let switched_off: Vec<u8> = (present.iter().enumerate())
            .map(|(at, byte)| if at == 3 { byte | 0x80 } else { *byte })
            .collect();
        let before = self.written;
        self.write(master, cob_id, &switched_off, console)?;
        let mapped = find(count).map(|(_, bytes)| bytes.first().copied().unwrap_or(0));
        if mapped.is_some() {
            self.write(master, count, &[0], console)?;
        }
        self.written = before;
        for (address, bytes) in values {
            let is_mapping = address.index == count.index;
            // Places behind the last object that is mapped mean nothing, and some devices refuse a 0 there.
            let is_used = !is_mapping || mapped.is_none_or(|mapped| address.sub <= mapped);
            if *address != cob_id && *address != count && is_used {
                self.write(master, *address, bytes, console)?;
            }
        }
        if let Some((_, bytes)) = find(count) {
            self.write(master, count, bytes, console)?;
        }
        let last = find(cob_id).map_or(present.as_slice(), |(_, bytes)| bytes);
        self.write(master, cob_id, last, console)
    }
}
