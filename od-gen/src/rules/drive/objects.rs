//! Rules: what every drive has.

use super::axes;
use crate::diagnostic::Findings;
use crate::model::Field;
use crate::rules::setting::{Setting, number};
use crate::rules::{Rule, Subject};

pub(crate) const RULES: &[&Rule] = &[&DRIVE_OBJECT, &DRIVE_WORDS, &DRIVE_TYPE];

static DRIVE_OBJECT: Rule = Rule::masters(
    "drive-object",
    "A drive has controlword, statusword, modes of operation with their display, and supported drive modes.",
    "A master of CiA 402 commands with 6040h and 6060h, watches 6041h and 6061h, and learns from 6502h what there is. When this is \
     silenced, the device is a drive that generic masters cannot use.",
).strict();

static DRIVE_WORDS: Rule = Rule::masters(
    "drive-words-mappable",
    "The controlword goes into receive PDOs, the statusword into transmit PDOs.",
    "Masters command the state machine by PDO. Write PDOMapping=1 for both.",
);

static DRIVE_TYPE: Rule = Rule::masters(
    "drive-type",
    "The device type says what kind of drive it is.",
    "Bits 16 to 23 of 1000h: 01h frequency converter, 02h servo drive, 04h stepper motor (CiA 402-1).",
);

const MANDATORY: [(u16, &str); 5] = [
    (0x6040, "Controlword"),
    (0x6041, "Statusword"),
    (0x6060, "Modes of operation"),
    (0x6061, "Modes of operation display"),
    (0x6502, "Supported drive modes"),
];

pub(crate) fn check(model: &Subject<'_>, findings: &mut Findings) {
    for axis in axes(model) {
        for (index, name) in MANDATORY {
            let index = index + axis;
            if model.lacks_object(index) {
                let span = Setting::at(model, 0x1000, 0).map(|setting| setting.span);
                let message = format!("1000h claims CiA 402, but {index:04X}h ({name}) is missing");
                let span = span.unwrap_or(crate::source::Span::START);
                findings.report(&DRIVE_OBJECT, span, message);
            }
        }
        check_words(model, axis, findings);
    }
    if axes(model).next().is_some()
        && let Some(kind) = Setting::at(model, 0x1000, 0)
        && kind.value >> 16 & 0xFF == 0
    {
        let message = format!("1000h is {:08X}h: a drive of no kind", kind.value);
        let finding = findings.report(&DRIVE_TYPE, kind.span, message);
        finding.help("write 0x00020192 for a servo drive, 0x00040192 for a stepper motor");
    }
}

fn check_words(model: &Subject<'_>, axis: u16, findings: &mut Findings) {
    // A drive with fixed mappings may leave the flag out.
    let has_pdos = model.rpdo_count() != 0;
    for (index, is_command) in [(0x6040 + axis, true), (0x6041 + axis, false)] {
        let Some(entry) = model.entry(index, 0) else {
            continue;
        };
        let (is_mappable, direction) = if is_command {
            (entry.is_rpdo_mappable(), "receive")
        } else {
            (entry.is_tpdo_mappable(), "transmit")
        };
        if !is_mappable && has_pdos {
            let message = format!("{index:04X}h cannot be mapped into a {direction} PDO");
            let span = entry.places.of(Field::PdoMapping);
            findings
                .report(&DRIVE_WORDS, span, message)
                .help("write `PDOMapping=1`");
        }
    }
}

/// What 6502h claims; `None` where it is missing.
pub(super) fn claimed_modes(model: &Subject<'_>, axis: u16) -> Option<i128> {
    number(model, 0x6502 + axis, 0)
}
