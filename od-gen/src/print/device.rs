//! The sections that describe the file and the device as a whole.

use crate::data_type::DataType;
use crate::document::Section;
use crate::model::{Commissioning, DeviceInfo, FileInfo, Model};

/// Bit rates that DeviceInfo can name, in kbit/s.
const BIT_RATES: [u16; 8] = [10, 20, 50, 125, 250, 500, 800, 1000];

/// The data types that DummyUsage names even where they are no dummies.
const DUMMIES: std::ops::RangeInclusive<u16> = 0x0001..=0x0007;

pub(super) fn sections(model: &Model) -> Vec<Section<'_>> {
    let mut sections = vec![file_info(&model.file_info), device_info(&model.device)];
    sections.extend(model.commissioning.as_ref().map(commissioning));
    sections.push(dummy_usage(&model.dummies));
    if !model.comments.is_empty() {
        let mut section = Section::new("Comments");
        section.put("Lines", model.comments.len().to_string());
        for (number, line) in (1..).zip(&model.comments) {
            section.put(format!("Line{number}"), line);
        }
        sections.push(section);
    }
    for (name, keys) in &model.tools.0 {
        let mut section = Section::new(name);
        for (key, value) in keys {
            section.put(key, value);
        }
        sections.push(section);
    }
    sections
}

/// A key that has a text.
fn text<'a>(section: &mut Section<'a>, name: &'a str, text: &'a str) {
    if !text.is_empty() {
        section.put(name, text);
    }
}

fn flag(section: &mut Section<'_>, name: &'static str, is_set: bool) {
    section.put(name, if is_set { "1" } else { "0" });
}

fn file_info(info: &FileInfo) -> Section<'_> {
    let mut section = Section::new("FileInfo");
    text(&mut section, "FileName", &info.file_name);
    section.put("FileVersion", info.file_version.to_string());
    section.put("FileRevision", info.file_revision.to_string());
    text(&mut section, "EDSVersion", &info.eds_version);
    text(&mut section, "Description", &info.description);
    text(&mut section, "CreationTime", &info.creation_time);
    text(&mut section, "CreationDate", &info.creation_date);
    text(&mut section, "CreatedBy", &info.created_by);
    text(&mut section, "ModificationTime", &info.modification_time);
    text(&mut section, "ModificationDate", &info.modification_date);
    text(&mut section, "ModifiedBy", &info.modified_by);
    text(&mut section, "LastEDS", &info.last_eds);
    section
}

fn device_info(device: &DeviceInfo) -> Section<'_> {
    let mut section = Section::new("DeviceInfo");
    let identity = |section: &mut Section<'_>, name: &'static str, number: Option<u32>| {
        if let Some(number) = number {
            section.put(name, format!("0x{number:08X}"));
        }
    };
    text(&mut section, "VendorName", &device.vendor_name);
    identity(&mut section, "VendorNumber", device.vendor_number);
    text(&mut section, "ProductName", &device.product_name);
    identity(&mut section, "ProductNumber", device.product_number);
    identity(&mut section, "RevisionNumber", device.revision_number);
    text(&mut section, "OrderCode", &device.order_code);
    for rate in BIT_RATES {
        let is_set = device.bit_rates.contains(&rate);
        section.put(format!("BaudRate_{rate}"), if is_set { "1" } else { "0" });
    }
    let (is_master, is_slave) = (device.simple_boot_up_master, device.simple_boot_up_slave);
    // Where nothing is known both are left out: to say that it is neither would be wrong.
    if is_master || is_slave {
        flag(&mut section, "SimpleBootUpMaster", is_master);
        flag(&mut section, "SimpleBootUpSlave", is_slave);
    }
    section.put("Granularity", device.granularity.to_string());
    section.put(
        "DynamicChannelsSupported",
        device.dynamic_channels.to_string(),
    );
    section.put("CompactPDO", device.compact_pdo.to_string());
    flag(&mut section, "GroupMessaging", device.group_messaging);
    for (name, count) in [("NrOfRXPDO", device.rpdos), ("NrOfTXPDO", device.tpdos)] {
        if let Some(count) = count {
            section.put(name, count.to_string());
        }
    }
    flag(&mut section, "LSS_Supported", device.lss);
    section
}

fn commissioning(node: &Commissioning) -> Section<'_> {
    // CiA 306 spells it like this.
    let mut section = Section::new("DeviceComissioning");
    section.put("NodeID", node.node_id.to_string());
    text(&mut section, "NodeName", &node.node_name);
    section.put("Baudrate", node.bit_rate.to_string());
    section.put("NetNumber", node.net_number.to_string());
    text(&mut section, "NetworkName", &node.network_name);
    flag(&mut section, "CANopenManager", node.is_manager);
    if let Some(number) = node.serial_number {
        section.put("LSS_SerialNumber", format!("0x{number:08X}"));
    }
    section
}

fn dummy_usage(dummies: &[u16]) -> Section<'static> {
    let mut section = Section::new("DummyUsage");
    let types = DataType::ALL.into_iter().map(DataType::code);
    let mut types: Vec<u16> = types.collect();
    types.sort_unstable();
    for code in types {
        let is_set = dummies.contains(&code);
        if is_set || DUMMIES.contains(&code) {
            section.put(format!("Dummy{code:04X}"), if is_set { "1" } else { "0" });
        }
    }
    section
}
