//! The object dictionary of a node: what is in it, reading, and writing what the data sheet allows.

use master::Line;
use master::axis402::{self, Node, Problem};
use master::data_sheet::{Address, value};
use od_gen::model::{Access, DefaultValue, Entry};
use od_gen::{DataType, transfer};

use super::Session;
use crate::message::{Answer, DictionaryEntry};

impl<L: Line> Session<L> {
    pub(super) fn dictionary(&mut self, id: u8) -> Result<Answer, Problem> {
        let node = self.node(id)?;
        let model = node.sheet.model();
        let entries = model.entries().map(|(object, entry)| {
            let address = Address::new(object.index, entry.sub);
            describe(&node, address, entry)
        });
        Ok(Answer::Dictionary {
            title: node.sheet.title().to_owned(),
            entries: entries.collect(),
        })
    }

    pub(super) fn read(&mut self, id: u8, object: &str) -> Result<Answer, Problem> {
        let node = self.node(id)?;
        let address = node.sheet.find(object).map_err(Problem::Usage)?;
        let bytes = node.upload(&mut self.master, address);
        let bytes = bytes.map_err(|failure| Problem::with_node(id, failure))?;
        let data_type = node.sheet.data_type(address);
        Ok(Answer::Text(shown(address, &bytes, data_type)))
    }

    /// Type, access and limits are checked before the bus sees anything; then the value is read back, as the device may have rounded it.
    pub(super) fn write(&mut self, id: u8, object: &str, value: &str) -> Result<Answer, Problem> {
        let node = self.node(id)?;
        let address = node.sheet.find(object).map_err(Problem::Usage)?;
        let entry = node.sheet.entry(address.index, address.sub);
        if let Some(entry) = entry {
            let title = node.title(address);
            check(entry, value.trim()).map_err(|why| Problem::Usage(format!("{title}: {why}")))?;
        }
        axis402::write(&mut self.master, &node, object, value.trim(), None)?;
        if entry.is_some_and(|entry| is_readable(entry.access)) {
            return self.read(id, object);
        }
        Ok(Answer::Text(value.trim().to_owned()))
    }
}

/// A value as a person reads it.
pub(super) fn shown(address: Address, bytes: &[u8], data_type: Option<DataType>) -> String {
    let known = data_type.and_then(|data_type| transfer::value(bytes, data_type));
    match known {
        Some(DefaultValue::Number { value, .. }) if is_identifier(address) => {
            format!("0x{value:03X}")
        }
        Some(value) if is_decimal(address, &value) => decimal(&value),
        _ => value::text(address, bytes, data_type),
    }
}

/// Whether it is a COB-ID (CiA 301): those are told apart by their bits.
fn is_identifier(address: Address) -> bool {
    matches!(
        (address.index, address.sub),
        (0x1005 | 0x1012 | 0x1014, 0)
            | (0x1200..=0x12FF, 1 | 2)
            | (0x1400..=0x15FF | 0x1800..=0x19FF, 1)
    )
}

/// Numbers of the application are read as decimal; those of the communication are identifiers and bits.
fn is_decimal(address: Address, value: &DefaultValue) -> bool {
    matches!(
        value,
        DefaultValue::Number {
            adds_node_id: false,
            ..
        }
    ) && !matches!(address.index, 0x1000..=0x1FFF | 0x6040 | 0x6041)
}

fn decimal(value: &DefaultValue) -> String {
    match value {
        DefaultValue::Number { value, .. } => value.to_string(),
        _ => String::new(),
    }
}

fn is_readable(access: Access) -> bool {
    access != Access::WriteOnly
}

fn is_writable(access: Access) -> bool {
    !matches!(access, Access::ReadOnly | Access::Constant)
}

fn check(entry: &Entry, value: &str) -> Result<(), String> {
    if !is_writable(entry.access) {
        return Err("it can only be read".to_owned());
    }
    let data_type = match entry.data_type {
        DataType::Domain => DataType::OctetString,
        other => other,
    };
    let parsed = transfer::parse(value, data_type)?;
    if let DefaultValue::Number {
        value,
        adds_node_id: false,
    } = parsed
    {
        match entry.integer_limits() {
            (Some(low), _) if value < low => return Err(format!("{value} is below {low}")),
            (_, Some(high)) if value > high => return Err(format!("{value} is above {high}")),
            _ => {}
        }
    }
    Ok(())
}

fn describe(node: &Node, address: Address, entry: &Entry) -> DictionaryEntry {
    let (low, high) = entry.integer_limits();
    // In the words in which it would be read from this node: what is the same looks the same.
    let text = |value: &DefaultValue| {
        let bytes = transfer::bytes(value, entry.data_type, node.id);
        shown(address, &bytes, Some(entry.data_type))
    };
    DictionaryEntry {
        address: address.to_string(),
        name: node.sheet.name(address).unwrap_or_default(),
        data_type: entry.data_type.name(),
        readable: is_readable(entry.access),
        writable: is_writable(entry.access),
        low: low.map(|low| low.to_string()),
        high: high.map(|high| high.to_string()),
        default: entry.default.as_ref().map(text),
        unit: entry.unit().map(str::to_owned),
    }
}
