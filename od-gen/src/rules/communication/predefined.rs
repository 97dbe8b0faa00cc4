//! Rules: a device comes out of the box with the predefined connection set (CiA 301, 7.3.3), which every master knows.

use super::cob_id;
use crate::diagnostic::Findings;
use crate::model::FileKind;
use crate::rules::setting::Setting;
use crate::rules::{Rule, Subject};

pub(crate) const RULES: &[&Rule] = &[&PREDEFINED_COB_ID, &PDO_BEYOND_THE_SET, &DEFAULT_SDO_COB_ID];

static PREDEFINED_COB_ID: Rule = Rule::masters(
    "predefined-cob-id",
    "SYNC, TIME, EMCY and the first four PDOs have the identifiers of the predefined connection set.",
    "SYNC 80h, TIME 100h, EMCY 80h+node-ID, TPDO 180h, 280h, 380h and 480h+node-ID, RPDO 200h, 300h, 400h and 500h+node-ID. A \
     master that was not told otherwise expects them there.",
);

static PDO_BEYOND_THE_SET: Rule = Rule::masters(
    "pdo-beyond-the-predefined-set",
    "PDOs from the fifth on are off by default.",
    "The predefined connection set has no identifiers for them: what one chooses may belong to another device. Set bit 31 of the \
     COB-ID, and let the master give it one (CiA 301, 7.5.2.35 and 7.5.2.37).",
);

static DEFAULT_SDO_COB_ID: Rule = Rule::masters(
    "default-sdo-cob-id",
    "The default SDO server has 600h+node-ID and 580h+node-ID, and nobody can change that.",
    "It is how every master finds a device (CiA 301, 7.5.2.33): 1200h:1 is $NODEID+0x600, 1200h:2 is $NODEID+0x580, both ro or \
     const.",
).strict();

/// Switched off.
const INVALID: i128 = 1 << 31;
/// The identifier of a base frame.
const IDENTIFIER: i128 = 0x7FF;

pub(crate) fn check(model: &Subject<'_>, findings: &mut Findings) {
    check_default_sdo(model, findings);
    // What a DCF configures is nobody's default any more.
    if model.kind == FileKind::Dcf {
        return;
    }
    for (index, identifier, adds_node_id) in [
        (0x1005, 0x080, false),
        (0x1012, 0x100, false),
        (0x1014, 0x080, true),
    ] {
        expect(model, (index, 0), identifier, adds_node_id, findings);
    }
    for (first, base) in [(0x1400, 0x200), (0x1800, 0x180)] {
        for object in model.objects_in(first..=first + 0x1FF) {
            let number = object.index - first;
            if number < 4 {
                let identifier = base + 0x100 * i128::from(number);
                expect(model, (object.index, 1), identifier, true, findings);
                continue;
            }
            let setting = object.entry(1).and_then(Setting::of);
            if let Some(setting) = setting.filter(|setting| setting.value & INVALID == 0) {
                let message = format!(
                    "{:04X}h is PDO {}, and valid by default",
                    object.index,
                    number + 1
                );
                findings.report(&PDO_BEYOND_THE_SET, setting.span, message);
            }
        }
    }
}

fn expect(
    model: &Subject<'_>,
    (index, sub): (u16, u8),
    identifier: i128,
    adds_node_id: bool,
    findings: &mut Findings,
) {
    let Some(setting) = Setting::at(model, index, sub) else {
        return;
    };
    let is_off = index != 0x1005 && index != 0x1012 && setting.value & INVALID != 0;
    let is_right = setting.value & IDENTIFIER == identifier && setting.adds_node_id == adds_node_id;
    // A PDO that is switched off needs no identifier.
    if is_right || (is_off && setting.value & IDENTIFIER == 0) {
        return;
    }
    // One that nobody may use, or that says nothing, has been reported.
    if cob_id::is_refused(model, setting) || cob_id::is_left_open(index, setting) {
        return;
    }
    let node_id = |adds: bool| if adds { " + node-ID" } else { "" };
    let message = format!(
        "{index:04X}h:{sub:X} is {:03X}h{}, but {identifier:03X}h{} is predefined",
        setting.value & IDENTIFIER,
        node_id(setting.adds_node_id),
        node_id(adds_node_id)
    );
    let finding = findings.report(&PREDEFINED_COB_ID, setting.span, message);
    let flags = setting.value & !IDENTIFIER;
    let value = flags | identifier;
    finding.help(if adds_node_id {
        format!("write `$NODEID+0x{value:X}`")
    } else {
        format!("write `0x{value:X}`")
    });
}

fn check_default_sdo(model: &Subject<'_>, findings: &mut Findings) {
    for (sub, base) in [(1, 0x600), (2, 0x580)] {
        let Some(entry) = model.entry(0x1200, sub) else {
            continue;
        };
        if let Some(setting) = Setting::of(entry) {
            let is_right = setting.value == base && setting.adds_node_id;
            // A DCF, and a device without a node-ID of its own, may have the sum.
            let node_id = model
                .commissioning
                .as_ref()
                .map(|node| i128::from(node.node_id));
            let is_sum = !setting.adds_node_id && node_id == Some(setting.value - base);
            if !is_right && !is_sum {
                let message =
                    format!("1200h:{sub:X} is not the identifier of the default SDO server");
                let finding = findings.report(&DEFAULT_SDO_COB_ID, setting.span, message);
                finding.help(format!("write `DefaultValue=$NODEID+0x{base:X}`"));
            }
        }
        if entry.access.is_writable() {
            let message = format!(
                "1200h:{sub:X} is {}: a master could cut itself off",
                entry.access.name()
            );
            let span = entry.places.of(crate::model::Field::AccessType);
            let finding = findings.report(&DEFAULT_SDO_COB_ID, span, message);
            finding.help("write `AccessType=ro`");
        }
    }
}
