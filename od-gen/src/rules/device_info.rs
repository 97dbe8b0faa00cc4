//! What DeviceInfo repeats must be what the dictionary says.

use super::{Rule, Subject};
use crate::diagnostic::Findings;

pub(super) const RULES: &[&Rule] = &[&IDENTITY, &PDO_COUNT, &UNSUPPORTED];

static IDENTITY: Rule = Rule::error(
    "identity",
    "VendorNumber, ProductNumber and RevisionNumber are those of 1018h.",
    "Configuration tools compare what a device answers at 1018h with the numbers in DeviceInfo.",
);

static PDO_COUNT: Rule = Rule::error(
    "pdo-count",
    "NrOfRXPDO and NrOfTXPDO are how many PDOs are described.",
    "Configuration tools believe the numbers.",
);

static UNSUPPORTED: Rule = Rule::error(
    "unsupported-feature",
    "The file does not ask for dynamic channels, compact PDOs or group messaging.",
    "What such a device has beside the described objects is unknown here. When this is silenced, it has what is described.",
);

pub(super) fn check(subject: &Subject<'_>, findings: &mut Findings) {
    let (model, device) = (subject.model, &subject.model.device);
    for (name, is_set) in [
        ("DynamicChannelsSupported", device.dynamic_channels != 0),
        ("CompactPDO", device.compact_pdo != 0),
        ("GroupMessaging", device.group_messaging),
    ] {
        if is_set {
            let message = format!("{name} is not supported: it must be 0");
            findings.report(&UNSUPPORTED, device.places.of(name), message);
        }
    }
    for (name, sub, stated) in [
        ("VendorNumber", 1, device.vendor_number),
        ("ProductNumber", 2, device.product_number),
        ("RevisionNumber", 3, device.revision_number),
    ] {
        let Some(stated) = stated else { continue };
        let entry = model.entry(0x1018, sub);
        let Some(default) = entry.and_then(|entry| entry.default_number()) else {
            continue;
        };
        if default != i128::from(stated) {
            let message = format!("{name} is 0x{stated:08X}, but 1018h:{sub} is 0x{default:08X}");
            findings.report(&IDENTITY, device.places.of(name), message);
        }
    }
    for (name, first, stated) in [
        ("NrOfRXPDO", 0x1400, device.rpdos),
        ("NrOfTXPDO", 0x1800, device.tpdos),
    ] {
        let Some(stated) = stated else { continue };
        let records = first..=first + 511;
        let count =
            model.objects_in(records.clone()).len() + subject.broken.objects.range(records).count();
        if usize::from(stated) != count {
            let message =
                format!("{name} is {stated}, but {count} are described from {first:04X}h on");
            findings.report(&PDO_COUNT, device.places.of(name), message);
        }
    }
}
