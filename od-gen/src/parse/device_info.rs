//! DeviceInfo, and its agreement with the objects.

use super::objects::Objects;
use super::sections::{Sections, check_keys};
use crate::diagnostic::Findings;
use crate::ini::Section;
use crate::model::DeviceInfo;
use crate::number::Number;

/// Bit rates that DeviceInfo can name, in kbit/s.
const BIT_RATES: [u16; 8] = [10, 20, 50, 125, 250, 500, 800, 1000];

const FLAGS: [&str; 3] = ["SimpleBootUpMaster", "SimpleBootUpSlave", "LSS_Supported"];

/// Ways of a modular device, which the generated dictionary has no room for.
const UNSUPPORTED: [&str; 3] = ["DynamicChannelsSupported", "CompactPDO", "GroupMessaging"];

pub(super) fn read(
    sections: &Sections<'_>,
    objects: &Objects,
    findings: &mut Findings,
) -> DeviceInfo {
    let Some(section) = sections.device_info else {
        return DeviceInfo::default();
    };
    let rates: Vec<String> = BIT_RATES
        .iter()
        .map(|rate| format!("BaudRate_{rate}"))
        .collect();
    let mut known: Vec<&str> = rates.iter().map(String::as_str).collect();
    known.extend(FLAGS);
    known.extend(UNSUPPORTED);
    known.extend([
        "VendorName",
        "VendorNumber",
        "ProductName",
        "ProductNumber",
        "RevisionNumber",
        "OrderCode",
    ]);
    known.extend(["Granularity", "NrOfRXPDO", "NrOfTXPDO"]);
    check_keys(section, &known, findings);

    let text = |name: &str| {
        section
            .key(name)
            .map_or_else(String::new, |key| key.value.clone())
    };
    let (vendor_name, product_name) = (text("VendorName"), text("ProductName"));

    for name in UNSUPPORTED {
        if number(section, name, 255, findings).is_some_and(|value| value != 0) {
            let line = section.key(name).map_or(section.line, |key| key.line);
            findings.error(line, format!("{name} is not supported: it must be 0"));
        }
    }
    for name in FLAGS {
        number(section, name, 1, findings);
    }
    number(section, "Granularity", 64, findings);
    check_agreement(section, sections, objects, findings);

    let mut is_set = |name: &str| number(section, name, 1, findings) == Some(1);
    let rate_names = BIT_RATES.into_iter().zip(&rates);
    let bit_rates = rate_names
        .filter(|(_, name)| is_set(name))
        .map(|(rate, _)| rate)
        .collect();
    // Its spelling has been checked with the other flags.
    let lss = section
        .key("LSS_Supported")
        .is_some_and(|key| key.value == "1");
    DeviceInfo {
        vendor_name,
        product_name,
        bit_rates,
        lss,
    }
}

/// What DeviceInfo repeats must be what the dictionary says.
fn check_agreement(
    section: &Section,
    sections: &Sections<'_>,
    objects: &Objects,
    findings: &mut Findings,
) {
    for (name, sub) in [
        ("VendorNumber", 1),
        ("ProductNumber", 2),
        ("RevisionNumber", 3),
    ] {
        let Some(value) = number(section, name, u32::MAX.into(), findings) else {
            continue;
        };
        let default = objects
            .entry(0x1018, sub)
            .and_then(|entry| entry.default_number());
        if let Some(default) = default.filter(|default| *default != value) {
            let line = section.key(name).map_or(section.line, |key| key.line);
            findings.error(
                line,
                format!("{name} is 0x{value:08X}, but 1018h:{sub} is 0x{default:08X}"),
            );
        }
    }
    for (name, first) in [("NrOfRXPDO", 0x1400), ("NrOfTXPDO", 0x1800)] {
        let Some(value) = number(section, name, 512, findings) else {
            continue;
        };
        let count = sections.indices().range(first..first + 512).count();
        if value != count as i128 {
            let line = section.key(name).map_or(section.line, |key| key.line);
            findings.error(
                line,
                format!("{name} is {value}, but {count} are described from {first:04X}h on"),
            );
        }
    }
}

/// A key's number between 0 and `high`; `None` when it is not there or wrong.
fn number(section: &Section, name: &str, high: i128, findings: &mut Findings) -> Option<i128> {
    let key = section.key(name)?;
    let number = Number::parse_within(&key.value, 0, high);
    findings.take(key.line, number.map_err(|why| format!("{name}: {why}")))
}
