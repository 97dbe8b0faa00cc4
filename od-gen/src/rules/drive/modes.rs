//! Rules: each mode that 6502h claims has its objects, and the other way round (CiA 402-2).

use super::axes;
use super::objects::claimed_modes;
use crate::diagnostic::Findings;
use crate::rules::setting::Setting;
use crate::rules::{Rule, Subject};

pub(crate) const RULES: &[&Rule] = &[
    &MODE_OBJECT,
    &MODE_NOT_CLAIMED,
    &RESERVED_MODE,
    &DEFAULT_MODE,
];

static MODE_OBJECT: Rule = Rule::masters(
    "mode-object",
    "A mode that 6502h claims has the objects that it cannot do without.",
    "A master that selects the mode writes its target and reads its actual value by the standard. When this is silenced, the mode \
     is claimed all the same.",
).strict();

static MODE_NOT_CLAIMED: Rule = Rule::masters(
    "mode-not-claimed",
    "Objects that only one mode has come with that mode.",
    "6502h tells masters which modes they may select; objects of another one suggest that a bit is missing there.",
);

static RESERVED_MODE: Rule = Rule::masters(
    "reserved-mode",
    "6502h claims no modes that CiA 402 has reserved.",
    "Bit 4 and bits 11 to 15 are reserved; modes of the manufacturer have bits 16 to 31.",
);

static DEFAULT_MODE: Rule = Rule::masters(
    "default-mode",
    "The drive starts in a mode that it has, or in none.",
    "6060h and 6061h are 0 (no mode), negative (a mode of the manufacturer), or a mode whose bit is set in 6502h.",
).strict();

/// A mode of CiA 402.
struct Mode {
    /// In 6502h, counted from 0; 6060h has one more.
    bit: u8,
    name: &'static str,
    /// It cannot do without them.
    needs: &'static [u16],
    /// No other mode has them.
    owns: &'static [u16],
}

const MODES: [Mode; 10] = [
    Mode {
        bit: 0,
        name: "profile position",
        needs: &[0x6064, 0x607A, 0x6081, 0x6083],
        owns: &[],
    },
    Mode {
        bit: 1,
        name: "velocity",
        needs: &[0x6042, 0x6043, 0x6044, 0x6046, 0x6048, 0x6049],
        owns: &[0x6042, 0x6043, 0x6044, 0x6046, 0x6048, 0x6049, 0x604A],
    },
    Mode {
        bit: 2,
        name: "profile velocity",
        needs: &[0x606C, 0x60FF],
        owns: &[],
    },
    Mode {
        bit: 3,
        name: "profile torque",
        needs: &[0x6071, 0x6077, 0x6087],
        owns: &[0x6087, 0x6088],
    },
    Mode {
        bit: 5,
        name: "homing",
        needs: &[0x6064, 0x6098, 0x6099],
        owns: &[0x6098, 0x6099, 0x609A, 0x60E3],
    },
    Mode {
        bit: 6,
        name: "interpolated position",
        needs: &[0x6064, 0x60C1],
        owns: &[0x60C0, 0x60C1, 0x60C4],
    },
    Mode {
        bit: 7,
        name: "cyclic synchronous position",
        needs: &[0x6064, 0x607A],
        owns: &[],
    },
    Mode {
        bit: 8,
        name: "cyclic synchronous velocity",
        needs: &[0x606C, 0x60FF],
        owns: &[],
    },
    Mode {
        bit: 9,
        name: "cyclic synchronous torque",
        needs: &[0x6071, 0x6077],
        owns: &[],
    },
    Mode {
        bit: 10,
        name: "cyclic synchronous torque with commutation angle",
        needs: &[0x6071, 0x6077, 0x60EA],
        owns: &[0x60EA],
    },
];

/// Bits 4 and 11 to 15.
const RESERVED: i128 = 0xF810;

pub(crate) fn check(model: &Subject<'_>, findings: &mut Findings) {
    for axis in axes(model) {
        let Some(claimed) = claimed_modes(model, axis) else {
            continue;
        };
        let span = Setting::at(model, 0x6502 + axis, 0).map(|setting| setting.span);
        let span = span.unwrap_or_default();
        for mode in &MODES {
            let is_claimed = claimed >> mode.bit & 1 != 0;
            if is_claimed {
                for index in mode.needs.iter().map(|index| index + axis) {
                    if model.lacks_object(index) {
                        let message = format!(
                            "{:04X}h claims {}, but {index:04X}h is missing",
                            0x6502 + axis,
                            mode.name
                        );
                        let finding = findings.report(&MODE_OBJECT, span, message);
                        finding.help(format!("add {index:04X}h, or clear bit {}", mode.bit));
                    }
                }
                continue;
            }
            let owned = mode
                .owns
                .iter()
                .filter_map(|index| model.object(index + axis));
            for object in owned.take(1) {
                let message = format!(
                    "{:04X}h belongs to {}, which {:04X}h does not claim",
                    object.index,
                    mode.name,
                    0x6502 + axis
                );
                let finding = findings.report(&MODE_NOT_CLAIMED, object.places.section, message);
                finding.help(format!(
                    "set bit {} of {:04X}h, or remove the object",
                    mode.bit,
                    0x6502 + axis
                ));
                finding.also(span, "the modes that are claimed");
            }
        }
        if claimed & RESERVED != 0 {
            let message = format!(
                "{:04X}h claims reserved modes: {:08X}h",
                0x6502 + axis,
                claimed & RESERVED
            );
            findings.report(&RESERVED_MODE, span, message);
        }
        check_default(model, axis, claimed, findings);
    }
}

fn check_default(model: &Subject<'_>, axis: u16, claimed: i128, findings: &mut Findings) {
    for index in [0x6060 + axis, 0x6061 + axis] {
        let Some(mode) = Setting::at(model, index, 0).filter(|mode| mode.value > 0) else {
            continue;
        };
        let is_there = mode.value <= 32 && claimed >> (mode.value - 1) & 1 != 0;
        if !is_there {
            let message = format!(
                "{index:04X}h is {}, a mode that {:04X}h does not claim",
                mode.value,
                0x6502 + axis
            );
            let finding = findings.report(&DEFAULT_MODE, mode.span, message);
            if let Some(claims) = Setting::at(model, 0x6502 + axis, 0) {
                finding.also(claims.span, "the modes that are claimed");
            }
        }
    }
}
