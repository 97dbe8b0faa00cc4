//! The default mappings name objects that a PDO can carry, and fit in a frame.

use super::objects::Objects;
use super::sections::Sections;
use crate::data_type::DataType;
use crate::diagnostic::Findings;
use crate::model::{Entry, Object};
use crate::number::Number;

/// Bits in the eight bytes of a frame.
const FRAME_BITS: i128 = 64;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Direction {
    Receive,
    Transmit,
}

pub(super) fn check(sections: &Sections<'_>, objects: &Objects, findings: &mut Findings) {
    let dummies = read_dummies(sections, findings);
    for object in &objects.list {
        let direction = match object.index {
            0x1600..=0x17FF => Direction::Receive,
            0x1A00..=0x1BFF => Direction::Transmit,
            _ => continue,
        };
        check_mapping(object, direction, objects, &dummies, findings);
    }
}

fn check_mapping(
    object: &Object,
    direction: Direction,
    objects: &Objects,
    dummies: &[u16],
    findings: &mut Findings,
) {
    let number = |entry: &Entry| entry.default_number().unwrap_or_default();
    let count = object
        .entries
        .iter()
        .find(|entry| entry.sub == 0)
        .map_or(0, number);
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
        if let Err(why) = check_mapped(value, direction, objects, dummies) {
            findings.error(
                entry.line,
                format!(
                    "{:04X}h:{} maps {value:08X}h: {why}",
                    object.index, entry.sub
                ),
            );
        }
    }
    if bits > FRAME_BITS {
        findings.error(
            object.line,
            format!(
                "{:04X}h maps {bits} bits, a PDO carries {FRAME_BITS}",
                object.index
            ),
        );
    }
}

/// One mapping entry: index, sub-index, length in bits.
fn check_mapped(
    value: i128,
    direction: Direction,
    objects: &Objects,
    dummies: &[u16],
) -> Result<(), String> {
    let [high, low, sub, bits] = u32::try_from(value).unwrap_or_default().to_be_bytes();
    let index = u16::from_be_bytes([high, low]);
    let size = if index < 0x1000 {
        dummy_size(index, sub, direction, dummies)?
    } else {
        let Some(entry) = objects.entry(index, sub) else {
            let is_missing = objects.lacks(index, sub);
            return if is_missing {
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

/// The dummies that DummyUsage allows.
fn read_dummies(sections: &Sections<'_>, findings: &mut Findings) -> Vec<u16> {
    let mut dummies = Vec::new();
    for key in sections
        .dummy_usage
        .iter()
        .flat_map(|section| &section.keys)
    {
        let digits = key.name.get(5..).filter(|_| {
            key.name
                .get(..5)
                .is_some_and(|name| name.eq_ignore_ascii_case("Dummy"))
        });
        let index = digits.and_then(|digits| u16::from_str_radix(digits, 16).ok());
        let Some(index) = index.filter(|index| DataType::from_code((*index).into()).is_some())
        else {
            findings.error(
                key.line,
                format!("`{}` in [DummyUsage] is not supported", key.name),
            );
            continue;
        };
        if findings.take(key.line, Number::parse_within(&key.value, 0, 1)) == Some(1) {
            dummies.push(index);
        }
    }
    dummies
}
