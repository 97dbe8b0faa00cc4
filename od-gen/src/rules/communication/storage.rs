//! Rules: storing and restoring parameters (CiA 301, 7.5.2.13 and 7.5.2.14), and loading programs (CiA 302-3).

use crate::diagnostic::Findings;
use crate::rules::setting::Setting;
use crate::rules::{Rule, Subject};

pub(crate) const RULES: &[&Rule] = &[&STORE_WITHOUT_RESTORE, &STORE_CAPABILITY, &PROGRAM_DOWNLOAD];

static STORE_WITHOUT_RESTORE: Rule = Rule::masters(
    "store-without-restore",
    "1010h and 1011h come together, with the same sub-indices.",
    "What a user has stored, a user wants to get rid of again.",
);

static STORE_CAPABILITY: Rule = Rule::masters(
    "store-capability",
    "The default of 1010h and 1011h is what a master reads there: how the device stores.",
    "Bit 0 stores on command, bit 1 of 1010h on its own; all other bits are 0. The signatures `save` and `load` are what a master \
     writes.",
);

static PROGRAM_DOWNLOAD: Rule = Rule::masters(
    "program-download",
    "1F50h goes with 1F51h.",
    "A master loads a program into 1F50h, and starts and stops it with 1F51h (CiA 302-3).",
);

pub(crate) fn check(model: &Subject<'_>, findings: &mut Findings) {
    for (index, other) in [(0x1010_u16, 0x1011_u16), (0x1011, 0x1010)] {
        let Some(object) = model.object(index) else {
            continue;
        };
        if model.lacks_object(other) {
            let message = format!("{index:04X}h is there, but not {other:04X}h");
            findings.report(&STORE_WITHOUT_RESTORE, object.places.section, message);
            continue;
        }
        for entry in object.entries.iter().filter(|entry| entry.sub != 0) {
            if model.lacks(other, entry.sub) {
                let sub = entry.sub;
                let message =
                    format!("{index:04X}h:{sub:X} is there, but not {other:04X}h:{sub:X}");
                findings.report(&STORE_WITHOUT_RESTORE, entry.places.section, message);
            }
            let known = if index == 0x1010 { 0b11 } else { 0b01 };
            if let Some(setting) = Setting::of(entry)
                && setting.value & !known != 0
            {
                let sub = entry.sub;
                let message = format!(
                    "{index:04X}h:{sub:X} is {:08X}h, which is no capability",
                    setting.value
                );
                let finding = findings.report(&STORE_CAPABILITY, setting.span, message);
                finding.help("write `DefaultValue=0x00000001`: on command");
            }
        }
    }
    for (index, other) in [(0x1F50_u16, 0x1F51_u16), (0x1F51, 0x1F50)] {
        if let Some(object) = model.object(index)
            && model.lacks_object(other)
        {
            let message = format!("{index:04X}h is there, but not {other:04X}h");
            findings.report(&PROGRAM_DOWNLOAD, object.places.section, message);
        }
    }
}
