//! Rules: the default COB-IDs are such that the device would take them from a master, and no two services of the device send
//! with one identifier (CiA 301, 7.3.3 and 7.3.5), whatever the node-ID.

use std::collections::BTreeMap;

use crate::diagnostic::Findings;
use crate::rules::setting::Setting;
use crate::rules::{Rule, Subject};

pub(crate) const RULES: &[&Rule] = &[
    &RESTRICTED_COB_ID,
    &COB_ID_LEFT_OPEN,
    &EXTENDED_COB_ID,
    &RESERVED_COB_ID_BIT,
    &SDO_CLIENT_COB_ID,
    &COB_ID_USED_TWICE,
    &COB_ID_USED_TWICE_WITH_A_NODE_ID,
];

static RESTRICTED_COB_ID: Rule = Rule::error(
    "restricted-cob-id",
    "No COB-ID is one of the restricted ones.",
    "NMT, SDO, LSS and error control have identifiers that no other service may use (CiA 301, table 40): 000h to 07Fh, 101h to \
     180h, 581h to 5FFh, 601h to 67Fh, 6E0h to 6FFh, 701h to 7FFh. When this is silenced, the device starts with the COB-ID \
     all the same, and refuses it from a master.",
);

static COB_ID_LEFT_OPEN: Rule = Rule::masters(
    "cob-id-left-open",
    "The default of a COB-ID is an identifier that the service can have.",
    "Many data sheets write 0 for a COB-ID without a default, or the identifier of the predefined connection set without the node-ID (80h \
     in 1014h, 180h in 1800h:1), which the device adds. A master takes it by the letter, and finds NMT's 000h or SYNC's 080h. Write \
     $NODEID+ in front of it, set bit 31 where the service is off, or write no default.",
)
.strict();

static EXTENDED_COB_ID: Rule = Rule::firmware(
    "extended-cob-id",
    "COB-IDs have 11 bits.",
    "The firmware sends and receives base frames: bits 11 to 29 must be 0. When this is silenced, the service is switched off.",
);

static RESERVED_COB_ID_BIT: Rule = Rule::masters(
    "reserved-cob-id-bit",
    "The reserved bits of a COB-ID are 0.",
    "Bit 30 of 1014h and bits 30 of the SDO parameters mean nothing (CiA 301, tables 53 and 60).",
)
.strict();

static SDO_CLIENT_COB_ID: Rule = Rule::firmware(
    "sdo-client-cob-id",
    "An SDO client has identifiers of its own.",
    "A master's client at 601h and 581h asks the default SDO server of node 1, which is its right. The firmware takes no identifier \
     that is restricted to default servers (CiA 301, table 40). When this is silenced, the client is as if it was switched off.",
);

static COB_ID_USED_TWICE: Rule = Rule::error(
    "cob-id-used-twice",
    "What one service sends with an identifier, no other service sends or receives.",
    "Two frames with one identifier and different data that are sent at the same time destroy each other on the bus until a \
     controller gives up. Several services may receive one identifier. Switch one of them off (bit 31), or give it another \
     identifier.",
);

static COB_ID_USED_TWICE_WITH_A_NODE_ID: Rule = Rule::masters(
    "cob-id-used-twice-with-a-node-id",
    "Services with and without the node-ID in their identifiers do not meet, whatever the node-ID.",
    "An identifier that the node-ID is added to may be the one that another service always has: with that node-ID both send, or one hears \
     the other. Add the node-ID to both, or leave that node-ID out.",
)
.strict();

/// Switched off; means nothing in 1005h.
const INVALID: i128 = 1 << 31;
/// Produces, in 1005h and 1012h.
const PRODUCES: i128 = 1 << 30;
/// The identifier of a base frame.
const IDENTIFIER: i128 = 0x7FF;
/// A 29-bit identifier: its flag, and the bits that only such a one has.
const EXTENDED: i128 = 0x3FFF_F800;

/// What a service does with its identifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Use {
    sends: bool,
    receives: bool,
}

const SENDS: Use = Use {
    sends: true,
    receives: false,
};
const RECEIVES: Use = Use {
    sends: false,
    receives: true,
};
const OFF: Use = Use {
    sends: false,
    receives: false,
};

/// A COB-ID of the dictionary.
struct CobId {
    index: u16,
    sub: u8,
    setting: Setting,
    is_used_for: Use,
}

impl CobId {
    /// Whether its default says nothing: 0, or what the node-ID is still to be added to.
    fn is_left_open(&self) -> bool {
        is_left_open(self.index, self.setting) && self.is_used_for != OFF
    }

    fn place(&self) -> String {
        match (self.index, self.sub) {
            (index, 0) => format!("{index:04X}h"),
            (index, sub) => format!("{index:04X}h:{sub:X}"),
        }
    }
}

pub(crate) fn check(model: &Subject<'_>, findings: &mut Findings) {
    let cob_ids = cob_ids(model);
    for cob_id in &cob_ids {
        check_bits(model, cob_id, findings);
    }
    check_uses(model, &cob_ids, findings);
}

/// Every COB-ID that the device starts with.
fn cob_ids(model: &Subject<'_>) -> Vec<CobId> {
    let mut cob_ids = Vec::new();
    for (object, entry) in model.entries() {
        let (index, sub) = (object.index, entry.sub);
        let Some(setting) = Setting::of(entry) else {
            continue;
        };
        let value = setting.value;
        let unless_off = |way: Use| if value & INVALID == 0 { way } else { OFF };
        let is_used_for = match (index, sub) {
            (0x1005, 0) => Use {
                sends: value & PRODUCES != 0,
                receives: true,
            },
            (0x1012, 0) => Use {
                sends: value & PRODUCES != 0,
                receives: value & INVALID != 0,
            },
            (0x1014, 0) => unless_off(SENDS),
            (0x1028, 1..) => unless_off(RECEIVES),
            (0x1200..=0x127F, 1) | (0x1280..=0x12FF, 2) => unless_off(RECEIVES),
            (0x1200..=0x127F, 2) | (0x1280..=0x12FF, 1) => unless_off(SENDS),
            (0x1400..=0x15FF, 1) => unless_off(RECEIVES),
            (0x1800..=0x19FF, 1) => unless_off(SENDS),
            _ => continue,
        };
        cob_ids.push(CobId {
            index,
            sub,
            setting,
            is_used_for,
        });
    }
    cob_ids
}

fn check_bits(model: &Subject<'_>, cob_id: &CobId, findings: &mut Findings) {
    let setting = cob_id.setting;
    // The default SDO server uses what is restricted to it.
    let is_default_sdo = cob_id.index == 0x1200;
    let broken = setting.node_ids(model).find_map(|node_id| {
        let value = setting.with(node_id);
        let (rule, why) = broken(cob_id, value)?;
        (!is_default_sdo).then_some((node_id, value, rule, why))
    });
    let Some((node_id, value, rule, why)) = broken else {
        return;
    };
    let with = if setting.adds_node_id {
        format!(" with node-ID {node_id}")
    } else {
        String::new()
    };
    let message = format!("{} is {value:08X}h{with}: {why}", cob_id.place());
    findings.report(rule, setting.span, message);
}

/// Which rule a COB-ID breaks.
fn broken(cob_id: &CobId, value: i128) -> Option<(&'static Rule, String)> {
    if value & EXTENDED != 0 {
        let why = "bits 11 to 29 must be 0, as identifiers have 11 bits";
        return Some((&EXTENDED_COB_ID, why.into()));
    }
    let has_reserved_bit = matches!(cob_id.index, 0x1014 | 0x1028 | 0x1200..=0x12FF);
    if has_reserved_bit && value & PRODUCES != 0 {
        return Some((
            &RESERVED_COB_ID_BIT,
            "bit 30 is reserved and must be 0".into(),
        ));
    }
    let identifier = value & IDENTIFIER;
    if cob_id.is_left_open() {
        let why = match identifier {
            0 => "000h is NMT's, so it stands for no identifier",
            _ => "that is the predefined identifier without the node-ID",
        };
        return Some((&COB_ID_LEFT_OPEN, why.into()));
    }
    let is_default_server = matches!(identifier, 0x581..=0x5FF | 0x601..=0x67F);
    if matches!(cob_id.index, 0x1280..=0x12FF) && is_default_server {
        let why = format!("{identifier:03X}h belongs to a default SDO server");
        return (cob_id.is_used_for != OFF).then_some((&SDO_CLIENT_COB_ID, why));
    }
    (cob_id.is_used_for != OFF && is_restricted(identifier)).then(|| {
        let why = format!("the identifier {identifier:03X}h is restricted (CiA 301, table 40)");
        (&RESTRICTED_COB_ID, why)
    })
}

/// Whether a default is 0, or what the predefined connection set adds the node-ID to, where that is another service's.
pub(super) fn is_left_open(index: u16, setting: Setting) -> bool {
    let (value, produces) = (setting.value, matches!(index, 0x1005 | 0x1012));
    let is_none = value & IDENTIFIER == 0 && !(produces && value & PRODUCES != 0);
    let is_base = matches!(
        (index, value & IDENTIFIER),
        (0x1014, 0x080) | (0x1800, 0x180)
    );
    !setting.adds_node_id && value & EXTENDED == 0 && (is_none || is_base)
}

/// Whether a COB-ID is one that no service may have, with some node-ID.
pub(super) fn is_refused(model: &Subject<'_>, setting: Setting) -> bool {
    let mut values = setting.node_ids(model).map(|node_id| setting.with(node_id));
    values.any(|value| value & EXTENDED != 0 || is_restricted(value & IDENTIFIER))
}

/// Whether no configurable service may use this 11-bit identifier (CiA 301, table 40).
fn is_restricted(identifier: i128) -> bool {
    matches!(identifier, 0x000..=0x07F | 0x101..=0x180 | 0x581..=0x5FF | 0x601..=0x67F | 0x6E0..=0x6FF | 0x701..)
}

/// Pairs of services that meet on one identifier, each reported at the later one.
fn check_uses(model: &Subject<'_>, cob_ids: &[CobId], findings: &mut Findings) {
    // The services before, by identifier without the node-ID.
    let mut plain: BTreeMap<i128, &CobId> = BTreeMap::new();
    let mut relative: BTreeMap<i128, &CobId> = BTreeMap::new();
    let is_used = |cob_id: &&CobId| cob_id.is_used_for != OFF && !cob_id.is_left_open();
    for cob_id in cob_ids.iter().filter(is_used) {
        let identifier = cob_id.setting.value & IDENTIFIER;
        let node_ids = match &model.commissioning {
            Some(node) => node.node_id.max(1)..=node.node_id.max(1),
            None => 1..=127,
        };
        let (same, other) = if cob_id.setting.adds_node_id {
            (&mut relative, &plain)
        } else {
            (&mut plain, &relative)
        };
        let meets = |before: &CobId| {
            let (a, b) = (before.is_used_for, cob_id.is_used_for);
            (a.sends && (b.sends || b.receives)) || (b.sends && a.receives)
        };
        let alike = same.get(&identifier).map(|before| (*before, None));
        let mut crossing = node_ids.filter_map(|node_id| {
            let offset = i128::from(node_id);
            let offset = if cob_id.setting.adds_node_id {
                offset
            } else {
                -offset
            };
            Some((*other.get(&(identifier + offset))?, Some(node_id)))
        });
        let meeting = alike
            .filter(|(before, _)| meets(before))
            .or_else(|| crossing.find(|(before, _)| meets(before)));
        if let Some((before, node_id)) = meeting {
            let with = node_id.map_or_else(String::new, |id| format!(" with node-ID {id}"));
            let (place, first) = (cob_id.place(), before.place());
            let message = format!("{place} is the same identifier as {first}{with}");
            let node = model.commissioning.as_ref();
            let is_certain = node_id.is_none() || node.is_some_and(|node| node.node_id != 0);
            let rule = match is_certain {
                true => &COB_ID_USED_TWICE,
                false => &COB_ID_USED_TWICE_WITH_A_NODE_ID,
            };
            let finding = findings.report(rule, cob_id.setting.span, message);
            finding.also(before.setting.span, first);
        }
        // A sender hides a receiver, so that it is not forgotten.
        let slot = same.entry(identifier).or_insert(cob_id);
        if cob_id.is_used_for.sends {
            *slot = cob_id;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canopen::wire::cob_id;

    #[test]
    fn the_restricted_identifiers_are_those_of_the_firmware() {
        for identifier in 0..=0x7FF {
            assert_eq!(
                is_restricted(identifier.into()),
                cob_id::is_restricted(identifier),
                "{identifier:03X}h"
            );
        }
    }

    #[test]
    fn a_base_frame_is_what_the_firmware_takes_for_one() {
        for bit in 0..32 {
            let is_base_frame = cob_id::CobId(1 << bit).is_base_frame();
            assert_eq!((1 << bit) & EXTENDED == 0, is_base_frame, "bit {bit}");
        }
    }
}
