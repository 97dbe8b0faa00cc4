//! The communication objects have the types of CiA 301, and PDOs come in pairs of records.

use super::objects::Objects;
use super::sections::Sections;
use crate::data_type::DataType;
use crate::diagnostic::Findings;

/// PDOs of each direction (CiA 301, 7.5.2.35 to 7.5.2.38).
const PDOS: u16 = 512;

pub(super) fn check(sections: &Sections<'_>, objects: &Objects, findings: &mut Findings) {
    for object in &objects.list {
        for entry in &object.entries {
            let Some(standard) = standard_type(object.index, entry.sub) else {
                continue;
            };
            if entry.data_type != standard {
                let (index, sub) = (object.index, entry.sub);
                let (is, should) = (entry.data_type.name(), standard.name());
                findings.error(
                    entry.line,
                    format!("{index:04X}h:{sub} is {is}, but CiA 301 makes it {should}"),
                );
            }
        }
    }
    check_pairs("RPDO", 0x1400, 0x1600, sections, objects, findings);
    check_pairs("TPDO", 0x1800, 0x1A00, sections, objects, findings);
}

/// Each PDO has a communication record and a mapping record, and they are numbered without gaps.
fn check_pairs(
    what: &str,
    communication: u16,
    mapping: u16,
    sections: &Sections<'_>,
    objects: &Objects,
    findings: &mut Findings,
) {
    let is_there = |index: u16| sections.objects.contains_key(&index);
    let mut has_gap = false;
    for number in 0..PDOS {
        let (communication, mapping) = (communication + number, mapping + number);
        match (
            sections.objects.get(&communication),
            sections.objects.get(&mapping),
        ) {
            (None, None) => has_gap = true,
            (Some(section), None) => {
                findings.error(
                    section.line,
                    format!(
                        "{what} {}: the mapping {mapping:04X}h is missing",
                        number + 1
                    ),
                );
            }
            (None, Some(section)) => {
                let message = format!(
                    "{what} {}: the communication parameter {communication:04X}h is missing",
                    number + 1
                );
                findings.error(section.line, message);
            }
            (Some(section), Some(_)) => {
                if has_gap && !is_there(communication - 1) {
                    findings.error(
                        section.line,
                        format!("{what} {} follows a gap: number PDOs from 1 on", number + 1),
                    );
                }
                for sub in [1, 2]
                    .into_iter()
                    .filter(|sub| objects.lacks(communication, *sub))
                {
                    findings.error(
                        section.line,
                        format!("{communication:04X}h has no sub-index {sub}"),
                    );
                }
            }
        }
    }
}

/// The type that CiA 301 gives a communication object.
fn standard_type(index: u16, sub: u8) -> Option<DataType> {
    use DataType::{Unsigned8, Unsigned16, Unsigned32, VisibleString};
    Some(match (index, sub) {
        (0x1000 | 0x1002 | 0x1005 | 0x1006 | 0x1007 | 0x1012 | 0x1013 | 0x1014, _) => Unsigned32,
        (0x1001 | 0x100D | 0x1019, _) => Unsigned8,
        (0x1008..=0x100A, _) => VisibleString,
        (0x100C | 0x1015 | 0x1017, _) => Unsigned16,
        (0x1029, _) => Unsigned8,
        // Everything else here is a record or an array; its sub-index 0 is checked with all others.
        (0x1003..=0x1FFF, 0) => return None,
        (0x1003 | 0x1010 | 0x1011 | 0x1016 | 0x1018, _) => Unsigned32,
        (0x1200..=0x12FF, 1 | 2) => Unsigned32,
        (0x1400..=0x15FF | 0x1800..=0x19FF, 1) => Unsigned32,
        (0x1400..=0x15FF | 0x1800..=0x19FF, 2 | 4 | 6) => Unsigned8,
        (0x1400..=0x15FF | 0x1800..=0x19FF, 3 | 5) => Unsigned16,
        (0x1600..=0x17FF | 0x1A00..=0x1BFF, _) => Unsigned32,
        _ => return None,
    })
}
