//! Rules: somebody notices when the device is gone, and the device notices when somebody else is (CiA 301, 7.2.8).

use std::collections::BTreeMap;

use crate::diagnostic::Findings;
use crate::rules::setting::{Setting, number};
use crate::rules::{Rule, Subject};

pub(crate) const RULES: &[&Rule] = &[
    &NO_ERROR_CONTROL,
    &HALF_A_GUARD,
    &GUARD_AND_HEARTBEAT,
    &HEARTBEAT_CONSUMER,
    &HEARTBEAT_CONSUMED_TWICE,
    &ERROR_BEHAVIOUR,
    &NMT_STARTUP,
];

static NO_ERROR_CONTROL: Rule = Rule::masters(
    "no-error-control",
    "A device has the heartbeat (1017h) or node guarding (100Ch and 100Dh).",
    "CiA 301 asks for one of them, and for new devices for the heartbeat: without it nobody notices that the device is gone.",
);

static HALF_A_GUARD: Rule = Rule::masters(
    "half-a-guard",
    "100Ch and 100Dh come together.",
    "The life time is guard time times life time factor: one of them alone means nothing.",
);

static GUARD_AND_HEARTBEAT: Rule = Rule::warning(
    "guarding-beside-heartbeat",
    "Heartbeat and life guarding are not both on by default.",
    "A device uses one of them at a time; where 1017h is not 0, guarding is off (CiA 301, 7.2.8.2).",
);

static HEARTBEAT_CONSUMER: Rule = Rule::masters(
    "heartbeat-consumer",
    "An entry of 1016h is a time in milliseconds and a node-ID.",
    "Bits 0 to 15 are the time, bits 16 to 23 the node-ID, 0 to 127, and bits 24 to 31 are 0 (CiA 301, 7.5.2.19). When this is \
     silenced, the entry is not used.",
).strict();

static HEARTBEAT_CONSUMED_TWICE: Rule = Rule::masters(
    "heartbeat-consumed-twice",
    "1016h names a node once.",
    "A device refuses a second time for one node with 06040043h.",
)
.strict();

static ERROR_BEHAVIOUR: Rule = Rule::masters(
    "error-behaviour",
    "1029h holds 0, 1 or 2, or a value of the manufacturer from 80h on.",
    "0 goes to Pre-operational, 1 stays, 2 stops (CiA 301, 7.5.2.32). The others are reserved.",
)
.strict();

static NMT_STARTUP: Rule = Rule::warning(
    "nmt-startup",
    "1F80h asks the device only for what it can do.",
    "Bit 0 makes the device the NMT master, for which DeviceInfo has SimpleBootUpMaster=1; bits 7 to 31 are reserved (CiA 302-2).",
);

pub(crate) fn check(model: &Subject<'_>, findings: &mut Findings) {
    let lacks_heartbeat = model.lacks_object(0x1017);
    let (guard, factor) = (model.object(0x100C), model.object(0x100D));
    match (guard, factor) {
        (None, None) if lacks_heartbeat => {
            // Without a device type there is no device that it could belong to.
            if let Some(device_type) = model.object(0x1000) {
                let message = "there is neither 1017h nor 100Ch and 100Dh";
                let span = device_type.places.section;
                let finding = findings.report(&NO_ERROR_CONTROL, span, message);
                finding.help("add 1017h, Producer heartbeat time");
            }
        }
        (Some(object), None) => {
            let message = "100Ch is there, but not 100Dh";
            findings.report(&HALF_A_GUARD, object.places.section, message);
        }
        (None, Some(object)) => {
            let message = "100Dh is there, but not 100Ch";
            findings.report(&HALF_A_GUARD, object.places.section, message);
        }
        _ => {}
    }
    let is_set = |index| number(model, index, 0).is_some_and(|value| value != 0);
    if let Some(time) = Setting::at(model, 0x1017, 0).filter(|time| time.value != 0)
        && is_set(0x100C)
        && is_set(0x100D)
    {
        let message = "1017h is not 0, and so are 100Ch and 100Dh";
        let finding = findings.report(&GUARD_AND_HEARTBEAT, time.span, message);
        finding.help("set one of them to 0: the heartbeat wins");
        if let Some(guard) = Setting::at(model, 0x100C, 0) {
            finding.also(guard.span, "the guard time");
        }
    }
    check_consumers(model, findings);
    check_error_behaviour(model, findings);
    check_startup(model, findings);
}

fn check_consumers(model: &Subject<'_>, findings: &mut Findings) {
    let mut nodes = BTreeMap::new();
    let entries = model
        .object(0x1016)
        .into_iter()
        .flat_map(|object| &object.entries);
    for entry in entries.filter(|entry| entry.sub != 0) {
        let Some(setting) = Setting::of(entry).filter(|setting| setting.value != 0) else {
            continue;
        };
        let (node_id, time) = (setting.value >> 16, setting.value & 0xFFFF);
        let place = format!("1016h:{:X}", entry.sub);
        if node_id > 127 {
            let message = format!(
                "{place} is {:08X}h: {node_id:X}h is no node-ID",
                setting.value
            );
            findings.report(&HEARTBEAT_CONSUMER, setting.span, message);
        } else if node_id != 0
            && time != 0
            && let Some((first, span)) = nodes.insert(node_id, (entry.sub, setting.span))
        {
            let message = format!("{place} waits for node {node_id}, as 1016h:{first:X} does");
            let finding = findings.report(&HEARTBEAT_CONSUMED_TWICE, setting.span, message);
            finding.also(span, "the first one");
        }
    }
}

fn check_error_behaviour(model: &Subject<'_>, findings: &mut Findings) {
    let entries = model
        .object(0x1029)
        .into_iter()
        .flat_map(|object| &object.entries);
    for entry in entries.filter(|entry| entry.sub != 0) {
        if let Some(setting) = Setting::of(entry)
            && (3..0x80).contains(&setting.value)
        {
            let message = format!(
                "1029h:{:X} is the reserved value {}",
                entry.sub, setting.value
            );
            let finding = findings.report(&ERROR_BEHAVIOUR, setting.span, message);
            finding.help("0 goes to Pre-operational, 1 stays, 2 stops");
        }
    }
}

fn check_startup(model: &Subject<'_>, findings: &mut Findings) {
    let Some(setting) = Setting::at(model, 0x1F80, 0) else {
        return;
    };
    if setting.value & 1 != 0 && !model.device.simple_boot_up_master {
        let message = "1F80h makes the device the NMT master, but SimpleBootUpMaster is not 1";
        let finding = findings.report(&NMT_STARTUP, setting.span, message);
        let key = "SimpleBootUpMaster";
        finding.also(model.device.places.of(key), "what DeviceInfo says");
        finding.help("either 1F80h is wrong, or SimpleBootUpMaster");
    } else if setting.value >> 7 != 0 {
        let message = format!("1F80h is {:08X}h: bits 7 to 31 are reserved", setting.value);
        findings.report(&NMT_STARTUP, setting.span, message);
    }
}
