//! What two files say differently about the device as a whole.

use super::{Differences, Place};
use crate::model::{Commissioning, DeviceInfo, Model, Module};

pub(super) fn compare(before: &Model, after: &Model, out: &mut Differences) {
    let place = Place::Section("DeviceInfo");
    for ((key, first, breaks), (_, second, _)) in
        info(&before.device).into_iter().zip(info(&after.device))
    {
        out.change(&place, key, &first, &second, breaks);
    }
    // A master may use a bit rate that is gone.
    let rates = |device: &DeviceInfo| {
        let rates: Vec<String> = device.bit_rates.iter().map(u16::to_string).collect();
        rates.join(", ")
    };
    let mut kept = before.device.bit_rates.iter();
    let breaks = !kept.all(|rate| after.device.bit_rates.contains(rate));
    out.change(
        &place,
        "BaudRate",
        &rates(&before.device),
        &rates(&after.device),
        breaks,
    );

    let dummies = |model: &Model| {
        let names: Vec<String> = model
            .dummies
            .iter()
            .map(|index| format!("{index:04X}h"))
            .collect();
        names.join(", ")
    };
    let mut kept = before.dummies.iter();
    let breaks = !kept.all(|index| after.dummies.contains(index));
    out.change(
        &Place::Section("DummyUsage"),
        "Dummy",
        &dummies(before),
        &dummies(after),
        breaks,
    );

    let place = Place::Section("Comments");
    let lines = |model: &Model| model.comments.join(" / ");
    out.change(&place, "Line", &lines(before), &lines(after), false);
    modules(before, after, out);

    let place = Place::Section("DeviceComissioning");
    for ((key, first), (_, second)) in commissioning(before.commissioning.as_ref())
        .into_iter()
        .zip(commissioning(after.commissioning.as_ref()))
    {
        out.change(&place, key, &first, &second, false);
    }
}

/// Modules that are known, by their number, and those that are plugged. What is different in a module is told as a whole.
fn modules(before: &Model, after: &Model, out: &mut Differences) {
    let place = Place::Section("SupportedModules");
    let name =
        |module: Option<&Module>| module.map_or_else(String::new, |m| m.product_name.clone());
    for number in 1..=u8::MAX {
        let find = |model: &'_ Model| model.modules.iter().position(|m| m.number == number);
        let first = find(before).and_then(|at| before.modules.get(at));
        let second = find(after).and_then(|at| after.modules.get(at));
        if first != second {
            let (first, second) = (name(first), name(second));
            let same_name = if first == second {
                ", other content"
            } else {
                ""
            };
            let first = format!("{number} {first}");
            let second = format!("{number} {second}{same_name}");
            out.change(&place, "Module", &first, &second, true);
        }
    }
    let plugged = |model: &Model| {
        let numbers: Vec<String> = model.connected.iter().map(u8::to_string).collect();
        numbers.join(", ")
    };
    let place = Place::Section("ConnectedModules");
    out.change(&place, "Module", &plugged(before), &plugged(after), false);
    if before.dynamic_channels != after.dynamic_channels {
        let place = Place::Section("DynamicChannels");
        let count = |model: &Model| format!("{} segments", model.dynamic_channels.len());
        let (first, second) = (count(before), count(after) + ", other content");
        out.change(&place, "NrOfSeg", &first, &second, false);
    }
}

/// Each key with its value, and whether another value can break a master.
fn info(device: &DeviceInfo) -> Vec<(&'static str, String, bool)> {
    let number = |number: Option<u32>| number.map_or_else(String::new, |n| format!("0x{n:08X}"));
    let count = |number: Option<u16>| number.map_or_else(String::new, |n| n.to_string());
    let flag = |flag: bool| u8::from(flag).to_string();
    vec![
        ("VendorName", device.vendor_name.clone(), false),
        ("VendorNumber", number(device.vendor_number), true),
        ("ProductName", device.product_name.clone(), false),
        ("ProductNumber", number(device.product_number), true),
        ("RevisionNumber", number(device.revision_number), false),
        ("OrderCode", device.order_code.clone(), false),
        (
            "SimpleBootUpMaster",
            flag(device.simple_boot_up_master),
            false,
        ),
        (
            "SimpleBootUpSlave",
            flag(device.simple_boot_up_slave),
            false,
        ),
        ("Granularity", device.granularity.to_string(), false),
        (
            "DynamicChannelsSupported",
            device.dynamic_channels.to_string(),
            false,
        ),
        ("CompactPDO", device.compact_pdo.to_string(), false),
        ("GroupMessaging", flag(device.group_messaging), false),
        ("NrOfRXPDO", count(device.rpdos), false),
        ("NrOfTXPDO", count(device.tpdos), false),
        ("LSS_Supported", flag(device.lss), false),
    ]
}

/// Each key of the configured node, empty for a file that configures none.
fn commissioning(node: Option<&Commissioning>) -> Vec<(&'static str, String)> {
    let text = |read: fn(&Commissioning) -> String| node.map_or_else(String::new, read);
    vec![
        ("NodeID", text(|node| node.node_id.to_string())),
        ("NodeName", text(|node| node.node_name.clone())),
        ("Baudrate", text(|node| node.bit_rate.to_string())),
        ("NetNumber", text(|node| node.net_number.to_string())),
        ("NetworkName", text(|node| node.network_name.clone())),
        (
            "CANopenManager",
            text(|node| u8::from(node.is_manager).to_string()),
        ),
        (
            "LSS_SerialNumber",
            text(|node| {
                node.serial_number
                    .map_or_else(String::new, |n| n.to_string())
            }),
        ),
    ]
}
