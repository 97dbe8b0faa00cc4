//! The default COB-IDs are such that the device would take them from a master: base frames, and no restricted identifier
//! (CiA 301, table 40), whatever the node-ID.

use super::{Rule, Subject};
use crate::diagnostic::Findings;
use crate::model::{DefaultValue, Field};

pub(super) const RULES: &[&Rule] = &[&COB_ID];

static COB_ID: Rule = Rule::error(
    "cob-id",
    "A default COB-ID is one that the device takes from a master.",
    "Identifiers have 11 bits, reserved bits are 0, and the identifiers of CiA 301, table 40, belong to other services. A \
     device that starts with such a COB-ID disturbs the network.",
);

const SYNC: u16 = 0x1005;
const EMERGENCY: u16 = 0x1014;

/// Switched off; means nothing in 1005h.
const INVALID: u32 = 1 << 31;
/// Produce SYNC in 1005h, reserved in 1014h.
const BIT_30: u32 = 1 << 30;
/// The identifier of a base frame.
const IDENTIFIER: u32 = 0x7FF;
/// A 29-bit identifier: its flag, and the bits that only such a one has.
const EXTENDED: u32 = 0x3FFF_F800;

pub(super) fn check(subject: &Subject<'_>, findings: &mut Findings) {
    for object in &subject.model.objects {
        let index = object.index;
        let sub = match index {
            SYNC | EMERGENCY => 0,
            0x1400..=0x15FF | 0x1800..=0x19FF => 1,
            _ => continue,
        };
        let Some(entry) = object.entry(sub) else {
            continue;
        };
        let DefaultValue::Number {
            value,
            adds_node_id,
        } = entry.default
        else {
            continue;
        };
        let node_ids = if adds_node_id { 1..=127 } else { 0..=0 };
        let refused = node_ids.into_iter().find_map(|node_id| {
            // A value of another type than the standard's has been reported.
            let cob_id = u32::try_from(value + node_id).ok()?;
            refusal(index, cob_id).map(|why| (node_id, cob_id, why))
        });
        let Some((node_id, cob_id, why)) = refused else {
            continue;
        };
        let with = if adds_node_id {
            format!(" with node-ID {node_id}")
        } else {
            String::new()
        };
        let message = format!("{index:04X}h:{sub} is {cob_id:08X}h{with}: {why}");
        findings.report(&COB_ID, entry.places.of(Field::DefaultValue), message);
    }
}
/// Why the device would refuse this COB-ID.
fn refusal(index: u16, cob_id: u32) -> Option<String> {
    if cob_id & EXTENDED != 0 {
        return Some("bits 11 to 29 must be 0, as identifiers have 11 bits".into());
    }
    if index == SYNC && cob_id & BIT_30 != 0 {
        return Some("bit 30 must be 0, as producing SYNC is not supported".into());
    }
    if index == EMERGENCY && cob_id & BIT_30 != 0 {
        return Some("bit 30 is reserved and must be 0".into());
    }
    let identifier = cob_id & IDENTIFIER;
    let is_used = index == SYNC || cob_id & INVALID == 0;
    (is_used && is_restricted(identifier))
        .then(|| format!("the identifier {identifier:03X}h is restricted (CiA 301, table 40)"))
}

/// Whether no configurable service may use this 11-bit identifier (CiA 301, table 40).
fn is_restricted(identifier: u32) -> bool {
    matches!(identifier, 0x000..=0x07F | 0x101..=0x180 | 0x581..=0x5FF | 0x601..=0x67F | 0x6E0..=0x6FF | 0x701..)
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
