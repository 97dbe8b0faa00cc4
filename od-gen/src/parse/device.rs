//! The sections that describe the file and the device as a whole (CiA 306, 4.5 and 5).

use super::sections::{Sections, check_keys, number, text};
use crate::data_type::DataType;
use crate::diagnostic::Findings;
use crate::document::Section;
use crate::model::{Access, Commissioning, DeviceInfo, DynamicChannel, FileInfo, KeyPlaces, Tools};
use crate::number::Number;
use crate::rules::{reading, value};

/// Bit rates that DeviceInfo can name, in kbit/s.
const BIT_RATES: [u16; 8] = [10, 20, 50, 125, 250, 500, 800, 1000];

/// The keys of the section.
pub(crate) const FILE_INFO_KEYS: [&str; 12] = [
    "FileName",
    "FileVersion",
    "FileRevision",
    "EDSVersion",
    "Description",
    "CreationTime",
    "CreationDate",
    "CreatedBy",
    "ModificationTime",
    "ModificationDate",
    "ModifiedBy",
    "LastEDS",
];

/// The keys of the section.
pub(crate) const DEVICE_INFO_KEYS: [&str; 23] = [
    "VendorName",
    "VendorNumber",
    "ProductName",
    "ProductNumber",
    "RevisionNumber",
    "OrderCode",
    "BaudRate_10",
    "BaudRate_20",
    "BaudRate_50",
    "BaudRate_125",
    "BaudRate_250",
    "BaudRate_500",
    "BaudRate_800",
    "BaudRate_1000",
    "SimpleBootUpMaster",
    "SimpleBootUpSlave",
    "Granularity",
    "DynamicChannelsSupported",
    "CompactPDO",
    "GroupMessaging",
    "NrOfRXPDO",
    "NrOfTXPDO",
    "LSS_Supported",
];

/// The keys of the section.
pub(crate) const COMMISSIONING_KEYS: [&str; 9] = [
    "NodeID",
    "NodeName",
    "NodeRefd",
    "NetRefd",
    "Baudrate",
    "NetNumber",
    "NetworkName",
    "CANopenManager",
    "LSS_SerialNumber",
];

/// Reads FileInfo.
pub(super) fn file_info(sections: &Sections<'_>, findings: &mut Findings) -> FileInfo {
    let Some(section) = sections.file_info else {
        return FileInfo::default();
    };
    check_keys(section, &FILE_INFO_KEYS, findings);
    let mut byte = |name: &str| version(section, name, findings);
    FileInfo {
        file_name: text(section, "FileName"),
        file_version: byte("FileVersion"),
        file_revision: byte("FileRevision"),
        eds_version: text(section, "EDSVersion"),
        description: text(section, "Description"),
        creation_time: text(section, "CreationTime"),
        creation_date: text(section, "CreationDate"),
        created_by: text(section, "CreatedBy"),
        modification_time: text(section, "ModificationTime"),
        modification_date: text(section, "ModificationDate"),
        modified_by: text(section, "ModifiedBy"),
        last_eds: text(section, "LastEDS"),
    }
}

/// FileVersion and FileRevision; of `1.0` what is before the point.
fn version(section: &Section<'_>, name: &str, findings: &mut Findings) -> u8 {
    let Some(key) = section.key(name) else {
        return 0;
    };
    let text: &str = &key.value;
    // 08 is no octal number, and what is meant is plain.
    let byte = |text: &str| match Number::parse(text) {
        Ok(number) => u8::try_from(number.value).ok(),
        Err(_) => text.parse().ok(),
    };
    byte(text).unwrap_or_else(|| {
        let message = format!("{name} `{text}` is no number from 0 to 255");
        let near = text.split(['.', ',']).next().and_then(byte);
        let finding = findings.report(&value::FILE_VERSION, key.span, message);
        if let Some(near) = near {
            finding.help(format!("write `{name}={near}`"));
        }
        near.unwrap_or_default()
    })
}

/// A number whose range has been checked.
fn narrow<T: TryFrom<i128> + Default>(number: i128) -> T {
    T::try_from(number).unwrap_or_default()
}

/// Reads DeviceInfo.
pub(super) fn device_info(sections: &Sections<'_>, findings: &mut Findings) -> DeviceInfo {
    let Some(section) = sections.device_info else {
        return DeviceInfo::default();
    };
    check_keys(section, &DEVICE_INFO_KEYS, findings);
    let mut flag = |name: &str| number(section, name, (0, 1), findings) == Some(1);
    let bit_rates = BIT_RATES
        .into_iter()
        .filter(|rate| flag(&format!("BaudRate_{rate}")))
        .collect();
    let (simple_boot_up_master, simple_boot_up_slave) =
        (flag("SimpleBootUpMaster"), flag("SimpleBootUpSlave"));
    let (group_messaging, lss) = (flag("GroupMessaging"), flag("LSS_Supported"));
    let mut identity =
        |name: &str| number(section, name, (0, u32::MAX.into()), findings).map(narrow);
    let vendor_number = identity("VendorNumber");
    let product_number = identity("ProductNumber");
    let revision_number = identity("RevisionNumber");
    let mut byte =
        |name: &str, high: i128| number(section, name, (0, high), findings).map_or(0, narrow);
    let granularity = byte("Granularity", 64);
    let dynamic_channels = byte("DynamicChannelsSupported", 255);
    let compact_pdo = byte("CompactPDO", 255);
    let mut count = |name: &str| number(section, name, (0, 512), findings).map(narrow);
    let (rpdos, tpdos) = (count("NrOfRXPDO"), count("NrOfTXPDO"));
    DeviceInfo {
        vendor_name: text(section, "VendorName"),
        vendor_number,
        product_name: text(section, "ProductName"),
        product_number,
        revision_number,
        order_code: text(section, "OrderCode"),
        bit_rates,
        simple_boot_up_master,
        simple_boot_up_slave,
        granularity,
        dynamic_channels,
        compact_pdo,
        group_messaging,
        rpdos,
        tpdos,
        lss,
        places: places(section),
    }
}

fn places(section: &Section<'_>) -> KeyPlaces {
    let keys = section.keys.iter().map(|key| (&*key.name, key.span));
    KeyPlaces::new(section.span, keys)
}

/// Reads DeviceComissioning.
pub(super) fn commissioning(
    sections: &Sections<'_>,
    findings: &mut Findings,
) -> Option<Commissioning> {
    let section = sections.commissioning?;
    check_keys(section, &COMMISSIONING_KEYS, findings);
    let mut of = |name: &str, range| number(section, name, range, findings);
    let largest = i128::from(u32::MAX);
    Some(Commissioning {
        // Some tools write 0 while it is for no node yet.
        node_id: of("NodeID", (0, 127)).map_or(0, narrow),
        bit_rate: of("Baudrate", (0, 1000)).map_or(0, narrow),
        net_number: of("NetNumber", (0, largest)).map_or(0, narrow),
        is_manager: of("CANopenManager", (0, 1)) == Some(1),
        serial_number: of("LSS_SerialNumber", (0, largest)).map(narrow),
        node_name: text(section, "NodeName"),
        network_name: text(section, "NetworkName"),
    })
}

/// The dummies that DummyUsage allows.
pub(super) fn dummies(sections: &Sections<'_>, findings: &mut Findings) -> Vec<u16> {
    let mut dummies = Vec::new();
    let Some(section) = sections.dummy_usage else {
        return dummies;
    };
    for key in &section.keys {
        let name = key.name.to_ascii_lowercase();
        let digits = name.strip_prefix("dummy");
        let index = digits.and_then(|digits| u16::from_str_radix(digits, 16).ok());
        let Some(index) = index.filter(|index| DataType::from_code((*index).into()).is_some())
        else {
            let message = format!("`{}` in [{}] is no data type", key.name, section.name);
            findings.report(&reading::UNKNOWN_KEY, key.name_span, message);
            continue;
        };
        if number(section, &key.name, (0, 1), findings) == Some(1) {
            dummies.push(index);
        }
    }
    dummies.sort_unstable();
    dummies.dedup();
    dummies
}

/// The sections that are for tools.
pub(super) fn tools(sections: &Sections<'_>) -> Tools {
    let keys = |section: &Section<'_>| {
        let keys = section.keys.iter();
        let pairs = keys.map(|key| (key.name.to_string(), key.value.to_string()));
        pairs.collect()
    };
    let sections = sections.tools.iter();
    Tools(
        sections
            .map(|section| (section.name.to_string(), keys(section)))
            .collect(),
    )
}

/// The lines of a section Comments, in the order of their numbers.
pub(super) fn lines(section: Option<&Section<'_>>) -> Vec<String> {
    let mut lines: Vec<(u32, String)> = Vec::new();
    for key in section.iter().flat_map(|section| &section.keys) {
        let name = key.name.to_ascii_lowercase();
        if let Some(number) = name
            .strip_prefix("line")
            .and_then(|digits| digits.parse().ok())
        {
            lines.push((number, key.value.to_string()));
        }
    }
    lines.sort_by_key(|(number, _)| *number);
    lines.into_iter().map(|(_, text)| text).collect()
}

/// The ranges of indices that DynamicChannels gives to variables.
pub(super) fn dynamic_channels(
    sections: &Sections<'_>,
    findings: &mut Findings,
) -> Vec<DynamicChannel> {
    let Some(section) = sections.dynamic_channels else {
        return Vec::new();
    };
    let count = number(section, "NrOfSeg", (0, 255), findings).unwrap_or_default();
    let numbers = (1..=count).map(|segment| {
        let mut of = |name: &str, high| {
            let value = number(section, &format!("{name}{segment}"), (0, high), findings);
            value.unwrap_or_default()
        };
        let data_type = of("Type", 0xFFFF);
        let (offset, difference) = offset(section, segment, findings);
        let range = text(section, &format!("Range{segment}"));
        let (first, last) = range.split_once('-').unwrap_or((&range, &range));
        let index = |text: &str| Number::parse(text.trim()).map_or(0, |number| number.value);
        DynamicChannel {
            data_type: narrow(data_type),
            access: Access::from_name(&text(section, &format!("Dir{segment}"))),
            first: narrow(index(first)),
            last: narrow(index(last)),
            offset,
            difference,
        }
    });
    numbers.collect()
}

/// PPOffset of a segment: a number, of BOOLEANs with the difference of their addresses behind a comma.
fn offset(section: &Section<'_>, segment: i128, findings: &mut Findings) -> (u32, Option<u32>) {
    let name = format!("PPOffset{segment}");
    let Some(key) = section.key(&name) else {
        return (0, None);
    };
    let numbers = key
        .value
        .splitn(2, ',')
        .map(|text| Number::parse(text.trim()));
    match numbers.collect::<Result<Vec<_>, _>>() {
        Ok(numbers) => {
            let mut numbers = numbers.iter().map(|number| narrow(number.value));
            (numbers.next().unwrap_or_default(), numbers.next())
        }
        Err(why) => {
            let why = why.of(&name);
            findings.take::<(), _>(&value::NOT_A_NUMBER, key.span, Err(why));
            (0, None)
        }
    }
}
