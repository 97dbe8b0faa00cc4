//! The default mappings name objects that a PDO can carry, and fit in a frame.

use super::{Rule, Subject};
use crate::data_type::DataType;
use crate::diagnostic::Findings;
use crate::model::{Entry, Field, Object};

pub(super) const RULES: &[&Rule] = &[&MAPPING, &MAPPING_LENGTH];

static MAPPING: Rule = Rule::error(
    "mapping",
    "A default mapping names an object that is there, with its length, and that goes this way.",
    "A mapping entry is index, sub-index and length in bits (CiA 301, 7.5.2.36). The object must have PDOMapping=1 and an \
     access that goes the way of the PDO; a receive PDO can have gaps, named by a data type that DummyUsage allows.",
);

static MAPPING_LENGTH: Rule = Rule::error(
    "mapping-length",
    "A PDO carries at most 64 bits.",
    "A CAN frame has eight bytes.",
);

/// Bits in the eight bytes of a frame.
const FRAME_BITS: i128 = 64;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Direction {
    Receive,
    Transmit,
}

pub(super) fn check(subject: &Subject<'_>, findings: &mut Findings) {
    for object in &subject.model.objects {
        let direction = match object.index {
            0x1600..=0x17FF => Direction::Receive,
            0x1A00..=0x1BFF => Direction::Transmit,
            _ => continue,
        };
        check_mapping(object, direction, subject, findings);
    }
}

fn check_mapping(
    object: &Object,
    direction: Direction,
    subject: &Subject<'_>,
    findings: &mut Findings,
) {
    let number = |entry: &Entry| entry.default_number().unwrap_or_default();
    let count = object.entry(0).map_or(0, number);
    let mut bits = 0;
    for entry in object.entries.iter().filter(|entry| entry.sub != 0) {
        let value = number(entry);
        let is_used = i128::from(entry.sub) <= count;
        if !is_used && value == 0 {
            continue;
        }
        if is_used {
            bits += value & 0xFF;
        }
        if let Err(why) = check_mapped(value, direction, subject) {
            let (index, sub) = (object.index, entry.sub);
            let message = format!("{index:04X}h:{sub} maps {value:08X}h: {why}");
            findings.report(&MAPPING, entry.places.of(Field::DefaultValue), message);
        }
    }
    if bits > FRAME_BITS {
        let index = object.index;
        let message = format!("{index:04X}h maps {bits} bits, a PDO carries {FRAME_BITS}");
        findings.report(&MAPPING_LENGTH, object.places.section, message);
    }
}

/// One mapping entry: index, sub-index, length in bits.
fn check_mapped(value: i128, direction: Direction, subject: &Subject<'_>) -> Result<(), String> {
    let [high, low, sub, bits] = u32::try_from(value).unwrap_or_default().to_be_bytes();
    let index = u16::from_be_bytes([high, low]);
    let size = if index < 0x1000 {
        dummy_size(index, sub, direction, &subject.model.dummies)?
    } else {
        let Some(entry) = subject.model.entry(index, sub) else {
            return if subject.lacks(index, sub) {
                Err(format!("{index:04X}h:{sub} does not exist"))
            } else {
                Ok(())
            };
        };
        match direction {
            Direction::Receive if !entry.is_rpdo_mappable() => {
                return Err(format!(
                    "{index:04X}h:{sub} cannot be mapped into a receive PDO"
                ));
            }
            Direction::Transmit if !entry.is_tpdo_mappable() => {
                return Err(format!(
                    "{index:04X}h:{sub} cannot be mapped into a transmit PDO"
                ));
            }
            _ => entry.size,
        }
    };
    if u16::from(bits) == size * 8 {
        Ok(())
    } else {
        Err(format!("{index:04X}h:{sub} has {} bits", size * 8))
    }
}

/// A gap in a receive PDO, named by a data type (CiA 301, 7.4.7.1).
fn dummy_size(index: u16, sub: u8, direction: Direction, dummies: &[u16]) -> Result<u16, String> {
    let size = DataType::from_code(index.into())
        .and_then(DataType::size)
        .filter(|_| sub == 0);
    let size = size.ok_or_else(|| format!("{index:04X}h:{sub} is no dummy"))?;
    if direction == Direction::Transmit {
        return Err("a dummy is for receive PDOs".into());
    }
    if dummies.contains(&index) {
        Ok(size)
    } else {
        Err(format!("[DummyUsage] does not allow Dummy{index:04X}"))
    }
}
