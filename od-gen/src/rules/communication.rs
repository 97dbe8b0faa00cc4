//! The communication objects have the types of CiA 301, and PDOs come in pairs of records.

use super::{Rule, Subject};
use crate::data_type::DataType;
use crate::diagnostic::Findings;
use crate::model::Field;

pub(super) const RULES: &[&Rule] = &[&STANDARD_TYPE, &PDO_PAIR, &PDO_GAP, &PDO_RECORD];

static STANDARD_TYPE: Rule = Rule::error(
    "standard-type",
    "A communication object has the type that CiA 301 gives it.",
    "Masters read and write the objects 1000h to 1FFFh by the standard's types.",
);

static PDO_PAIR: Rule = Rule::error(
    "pdo-pair",
    "A PDO has a communication record and a mapping record.",
    "Of 1400h goes with 1600h, 1800h with 1A00h, and so on (CiA 301, 7.5.2.35 to 7.5.2.38).",
);

static PDO_GAP: Rule = Rule::error(
    "pdo-gap",
    "PDOs are numbered from 1 on, without gaps.",
    "The firmware counts its PDOs; there is none in a gap.",
);

static PDO_RECORD: Rule = Rule::error(
    "pdo-record",
    "The communication record of a PDO has the sub-indices 1 and 2.",
    "They are the COB-ID and the transmission type, without which there is no PDO.",
);

/// PDOs of each direction (CiA 301, 7.5.2.35 to 7.5.2.38).
const PDOS: u16 = 512;

pub(super) fn check(subject: &Subject<'_>, findings: &mut Findings) {
    for (object, entry) in subject.model.entries() {
        let (index, sub) = (object.index, entry.sub);
        let Some(standard) = standard_type(index, sub) else {
            continue;
        };
        if entry.data_type != standard {
            let (is, should) = (entry.data_type.name(), standard.name());
            let message = format!("{index:04X}h:{sub} is {is}, but CiA 301 makes it {should}");
            findings.report(&STANDARD_TYPE, entry.places.of(Field::DataType), message);
        }
    }
    check_pairs("RPDO", 0x1400, 0x1600, subject, findings);
    check_pairs("TPDO", 0x1800, 0x1A00, subject, findings);
}

/// Each PDO has a communication record and a mapping record, and they are numbered without gaps.
fn check_pairs(
    what: &str,
    communication: u16,
    mapping: u16,
    subject: &Subject<'_>,
    findings: &mut Findings,
) {
    let section = |index: u16| {
        subject
            .model
            .object(index)
            .map(|object| object.places.section)
    };
    let mut has_gap = false;
    for offset in 0..PDOS {
        let (communication, mapping) = (communication + offset, mapping + offset);
        let number = offset + 1;
        let has = |index| subject.has_object(index);
        match (has(communication), has(mapping)) {
            (false, false) => has_gap = true,
            (true, false) => {
                let message = format!("{what} {number}: the mapping {mapping:04X}h is missing");
                let span = section(communication).unwrap_or_default();
                findings.report(&PDO_PAIR, span, message);
            }
            (false, true) => {
                let message = format!(
                    "{what} {number}: the communication parameter {communication:04X}h is missing"
                );
                let span = section(mapping).unwrap_or_default();
                findings.report(&PDO_PAIR, span, message);
            }
            (true, true) => {
                let span = section(communication).unwrap_or_default();
                if has_gap && !has(communication - 1) {
                    let message = format!("{what} {number} follows a gap: number PDOs from 1 on");
                    findings.report(&PDO_GAP, span, message);
                }
                for sub in [1, 2]
                    .into_iter()
                    .filter(|sub| subject.lacks(communication, *sub))
                {
                    let message = format!("{communication:04X}h has no sub-index {sub}");
                    findings.report(&PDO_RECORD, span, message);
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
