//! Rules: PDOs come as pairs of records, and their communication parameters make sense (CiA 301, 7.5.2.35 and 7.5.2.37).

use std::ops::RangeInclusive;

use crate::diagnostic::Findings;
use crate::model::Object;
use crate::rules::setting::{Setting, number};
use crate::rules::{Rule, Subject};

pub(crate) const RULES: &[&Rule] = &[
    &PDO_WITHOUT_MAPPING,
    &MAPPING_WITHOUT_PDO,
    &PDO_GAP,
    &PDO_WITHOUT_OBJECTS,
    &RESERVED_TRANSMISSION_TYPE,
    &SYNCHRONOUS_PDO_WITHOUT_SYNC,
    &SYNC_START_WITHOUT_COUNTER,
];

static PDO_WITHOUT_MAPPING: Rule = Rule::masters(
    "pdo-without-mapping",
    "Each PDO has a mapping record.",
    "The communication record 1400h+n goes with the mapping record 1600h+n, and 1800h+n with 1A00h+n. When this is silenced, the \
     PDO carries nothing.",
).strict();

static MAPPING_WITHOUT_PDO: Rule = Rule::masters(
    "mapping-without-pdo",
    "Each mapping record has a PDO.",
    "The mapping record 1600h+n goes with the communication record 1400h+n, and 1A00h+n with 1800h+n. When this is silenced, the \
     mapping can be written, and nothing comes of it.",
).strict();

static PDO_GAP: Rule = Rule::masters(
    "pdo-gap",
    "PDOs are numbered from 1 on, without gaps.",
    "Gaps are allowed, but the firmware keeps room for the PDOs that are left out, and masters that count upwards stop at the gap.",
);

static PDO_WITHOUT_OBJECTS: Rule = Rule::masters(
    "pdo-without-objects",
    "A PDO that is valid by default carries something.",
    "It would never be sent, and what is received with its identifier would be thrown away. Set bit 31 of the COB-ID, or map \
     something.",
);

static RESERVED_TRANSMISSION_TYPE: Rule = Rule::masters(
    "reserved-transmission-type",
    "The transmission type of a PDO is none of the reserved ones.",
    "0 to 240 is by SYNC, 254 and 255 by event; 252 and 253 are for transmit PDOs alone, which are sent on request (CiA 301, \
     tables 69 and 72). When this is silenced, the PDO is switched off until a master writes another type.",
).strict();

static SYNCHRONOUS_PDO_WITHOUT_SYNC: Rule = Rule::masters(
    "synchronous-pdo-without-sync",
    "A device with synchronous PDOs has 1005h.",
    "Without the COB-ID of SYNC the PDO would wait for ever.",
)
.strict();

static SYNC_START_WITHOUT_COUNTER: Rule = Rule::masters(
    "sync-start-without-counter",
    "A SYNC start value goes with a SYNC counter.",
    "Sub-index 6 of a transmit PDO waits for a count that only SYNC messages with a counter have: 1019h must be there and not 0.",
);

/// A PDO that is not valid.
const INVALID: i128 = 1 << 31;
/// PDOs in each direction.
const MOST: u16 = 512;

/// One of the two directions.
struct Direction {
    name: &'static str,
    communication: RangeInclusive<u16>,
    mapping: RangeInclusive<u16>,
}

const RECEIVE: Direction = Direction {
    name: "RPDO",
    communication: 0x1400..=0x15FF,
    mapping: 0x1600..=0x17FF,
};

const TRANSMIT: Direction = Direction {
    name: "TPDO",
    communication: 0x1800..=0x19FF,
    mapping: 0x1A00..=0x1BFF,
};

pub(crate) fn check(model: &Subject<'_>, findings: &mut Findings) {
    for direction in [RECEIVE, TRANSMIT] {
        let mut next = *direction.communication.start();
        for object in model.objects_in(direction.communication.clone()) {
            let number = object.index - direction.communication.start() + 1;
            let name = format!("{} {number}", direction.name);
            if object.index > next {
                let missing = format!("{next:04X}h");
                let message = format!("{name} follows a gap: {missing} is not there");
                findings.report(&PDO_GAP, object.places.section, message);
            }
            next = object.index + 1;
            let mapping = object.index + MOST;
            if model.lacks_object(mapping) {
                let message = format!("{name}: the mapping {mapping:04X}h is missing");
                findings.report(&PDO_WITHOUT_MAPPING, object.places.section, message);
            }
            check_use(model, object, mapping, &name, findings);
            check_transmission_type(model, object, &name, findings);
        }
        for object in model.objects_in(direction.mapping) {
            let communication = object.index - MOST;
            if model.lacks_object(communication) {
                let number = communication - direction.communication.start() + 1;
                let message = format!(
                    "{} {number}: the communication parameter {communication:04X}h is missing",
                    direction.name
                );
                findings.report(&MAPPING_WITHOUT_PDO, object.places.section, message);
            }
        }
    }
}

/// Whether a PDO is switched on by default.
fn is_valid(model: &Subject<'_>, communication: u16) -> bool {
    number(model, communication, 1).is_some_and(|cob_id| cob_id & INVALID == 0)
}

fn check_use(
    model: &Subject<'_>,
    object: &Object,
    mapping: u16,
    name: &str,
    findings: &mut Findings,
) {
    let Some(count) = Setting::at(model, mapping, 0).filter(|count| count.value == 0) else {
        return;
    };
    if is_valid(model, object.index) {
        let message = format!("{name} is valid, but nothing is mapped into it");
        let finding = findings.report(&PDO_WITHOUT_OBJECTS, count.span, message);
        finding.help(format!(
            "set bit 31 of {:04X}h:1, or map something",
            object.index
        ));
        if let Some(cob_id) = Setting::at(model, object.index, 1) {
            finding.also(cob_id.span, "its COB-ID");
        }
    }
}

fn check_transmission_type(
    model: &Subject<'_>,
    object: &Object,
    name: &str,
    findings: &mut Findings,
) {
    let index = object.index;
    let Some(kind) = Setting::at(model, index, 2) else {
        return;
    };
    let is_receive = RECEIVE.communication.contains(&index);
    let reserved = if is_receive { 241..=253 } else { 241..=251 };
    if reserved.contains(&kind.value) {
        let message = format!("{name} has the reserved transmission type {}", kind.value);
        let finding = findings.report(&RESERVED_TRANSMISSION_TYPE, kind.span, message);
        finding.help("0 to 240 is by SYNC, 254 and 255 by event");
    }
    let is_synchronous = matches!(kind.value, 0..=240) || (kind.value == 252 && !is_receive);
    if !is_synchronous {
        return;
    }
    if model.lacks_object(0x1005) && is_valid(model, index) {
        let message = format!("{name} waits for SYNC, but 1005h is not there");
        findings.report(&SYNCHRONOUS_PDO_WITHOUT_SYNC, kind.span, message);
    }
    let start = Setting::at(model, index, 6).filter(|start| start.value != 0);
    let counts = || match model.entry(0x1019, 0) {
        Some(entry) => Setting::of(entry).is_none_or(|counter| counter.value != 0),
        None => false,
    };
    if let Some(start) = start.filter(|_| !counts()) {
        let message = format!(
            "{name} waits for SYNC number {}, but 1019h counts none",
            start.value
        );
        let finding = findings.report(&SYNC_START_WITHOUT_COUNTER, start.span, message);
        if let Some(counter) = Setting::at(model, 0x1019, 0) {
            finding.also(counter.span, "the counter");
        }
    }
}
