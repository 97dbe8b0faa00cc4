//! Rules: SYNC, and emergencies (CiA 301, 7.2.5 and 7.2.7).

use crate::diagnostic::Findings;
use crate::model::Field;
use crate::rules::setting::{Setting, number};
use crate::rules::{Rule, Subject};

pub(crate) const RULES: &[&Rule] = &[
    &SYNC_WITHOUT_COB_ID,
    &SYNC_PRODUCER_WITHOUT_PERIOD,
    &SYNC_WINDOW,
    &SYNC_COUNTER,
    &EMERGENCY_WITHOUT_COB_ID,
    &ERROR_LIST,
];

static SYNC_WITHOUT_COB_ID: Rule = Rule::masters(
    "sync-without-cob-id",
    "1006h, 1007h and 1019h go with 1005h.",
    "Period, window and counter belong to a SYNC that the device does not know without its COB-ID.",
);

static SYNC_PRODUCER_WITHOUT_PERIOD: Rule = Rule::masters(
    "sync-producer-without-period",
    "A device that produces SYNC has a period.",
    "With bit 30 of 1005h the device sends SYNC every 1006h microseconds; 0, or no 1006h, is never. When this is silenced, it \
     sends none until a master writes 1006h.",
).strict();

static SYNC_WINDOW: Rule = Rule::masters(
    "sync-window",
    "The SYNC window is shorter than the SYNC period.",
    "Synchronous PDOs that come later than 1007h microseconds after SYNC are dropped: a window as long as the period, 1006h, \
     drops none.",
);

static SYNC_COUNTER: Rule = Rule::masters(
    "sync-counter",
    "1019h is 0 or 2 to 240.",
    "The counter runs from 1 to this number; 1 and 241 to 255 are reserved (CiA 301, 7.5.2.22).",
)
.strict();

static EMERGENCY_WITHOUT_COB_ID: Rule = Rule::masters(
    "emergency-without-cob-id",
    "1003h and 1015h go with 1014h.",
    "A list of errors and an inhibit time belong to emergencies, which the device cannot send without their COB-ID.",
);

static ERROR_LIST: Rule = Rule::masters(
    "error-list",
    "The list of errors, 1003h, is empty by default, and a master can clear it.",
    "A device starts without errors; writing 0 to sub-index 0 clears the list (CiA 301, 7.5.2.4).",
);

pub(crate) fn check(model: &Subject<'_>, findings: &mut Findings) {
    for (objects, cob_id, rule) in [
        (
            &[0x1006, 0x1007, 0x1019][..],
            0x1005_u16,
            &SYNC_WITHOUT_COB_ID,
        ),
        (&[0x1003, 0x1015], 0x1014, &EMERGENCY_WITHOUT_COB_ID),
    ] {
        if !model.lacks_object(cob_id) {
            continue;
        }
        for object in objects.iter().filter_map(|index| model.object(*index)) {
            let message = format!("{:04X}h is there, but not {cob_id:04X}h", object.index);
            findings.report(rule, object.places.section, message);
        }
    }
    // A period that the file does not state is not 0.
    let has_period = model.entry(0x1006, 0).is_some();
    let period = number(model, 0x1006, 0).unwrap_or(i128::from(has_period) * i128::MAX);
    if let Some(cob_id) = Setting::at(model, 0x1005, 0)
        && cob_id.value & 1 << 30 != 0
        && period == 0
    {
        let message = "1005h produces SYNC, but 1006h gives no period";
        let finding = findings.report(&SYNC_PRODUCER_WITHOUT_PERIOD, cob_id.span, message);
        if let Some(period) = Setting::at(model, 0x1006, 0) {
            finding.also(period.span, "the period");
        }
    }
    if let Some(window) = Setting::at(model, 0x1007, 0)
        && period != 0
        && window.value >= period
    {
        let message = format!(
            "the window, {} µs, is not shorter than the period, {period} µs",
            window.value
        );
        let finding = findings.report(&SYNC_WINDOW, window.span, message);
        if let Some(period) = Setting::at(model, 0x1006, 0) {
            finding.also(period.span, "the period");
        }
    }
    if let Some(counter) = Setting::at(model, 0x1019, 0)
        && matches!(counter.value, 1 | 241..)
    {
        let message = format!("1019h is the reserved value {}", counter.value);
        findings.report(&SYNC_COUNTER, counter.span, message);
    }
    check_error_list(model, findings);
}

fn check_error_list(model: &Subject<'_>, findings: &mut Findings) {
    let Some(object) = model.object(0x1003) else {
        return;
    };
    // CompactSubObj says of sub-index 0 how many there can be, and not how many there are; a generated device starts with it.
    let is_implied = object.places.has(Field::CompactSubObj) && !findings.is_for_code();
    let Some(entry) = object.entry(0).filter(|_| !is_implied) else {
        return;
    };
    if let Some(count) = Setting::of(entry).filter(|count| count.value != 0) {
        let message = format!(
            "1003h:0 is {}: the device would start with errors",
            count.value
        );
        findings.report(&ERROR_LIST, count.span, message);
    }
    if !entry.access.is_writable() {
        let message = format!(
            "1003h:0 is {}: nobody can clear the list",
            entry.access.name()
        );
        let span = entry.places.of(Field::AccessType);
        findings
            .report(&ERROR_LIST, span, message)
            .help("write `AccessType=rw`");
    }
}
