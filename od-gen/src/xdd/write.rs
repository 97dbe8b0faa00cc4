//! From a [`Model`] to the text of an XDD 1.1, or of an XDC when it is the configuration of one device.
//!
//! It goes by way of the sections that an EDS would have, as reading does, so that both formats say the same. What XML has no
//! attribute for (notes, allowances) is in comments, which are read again.

use std::collections::HashMap;

use super::text::{Writer, xml_date, xml_time};
use crate::document::Section;
use crate::model::{Access, Entry, FileInfo, FileKind, Model, Object};
use crate::print;

/// Attributes of an element: names and values.
type Attributes = Vec<(&'static str, String)>;

/// The sections by their names.
type Sections<'s, 'a> = HashMap<&'s str, &'s Section<'a>>;

/// Writes a model as an XDD; as an XDC when it is the configuration of one device.
pub fn write(model: &Model) -> String {
    let sections = print::sections(model);
    let sections: Sections<'_, '_> = sections
        .iter()
        .map(|section| (&*section.name, section))
        .collect();
    let section = |name: &str| sections.get(name).copied();
    let mut xml = Writer::new();
    let lines = model.remarks.0.iter().chain(&model.comments);
    for line in lines {
        xml.comment(line);
    }
    let container = [
        ("xmlns", "http://www.canopen.org/xml/1.1"),
        ("xmlns:xsi", "http://www.w3.org/2001/XMLSchema-instance"),
    ];
    xml.open("ISO15745ProfileContainer", &container);
    xml.open("ISO15745Profile", &[]);
    header(&mut xml, "Device");
    body(&mut xml, "ProfileBody_Device_CANopen", &model.file_info);
    identity(
        &mut xml,
        section("DeviceInfo"),
        &model.file_info.description,
    );
    parameters(&mut xml, model);
    xml.close();
    xml.close();

    xml.open("ISO15745Profile", &[]);
    header(&mut xml, "CommunicationNetwork");
    body(
        &mut xml,
        "ProfileBody_CommunicationNetwork_CANopen",
        &model.file_info,
    );
    xml.open("ApplicationLayers", &[]);
    xml.open("CANopenObjectList", &[]);
    for object in model.types.iter().chain(&model.objects) {
        write_object(&mut xml, object, &sections);
    }
    xml.close();
    if let Some(dummies) = section("DummyUsage") {
        xml.open("dummyUsage", &[]);
        for key in &dummies.keys {
            let entry = format!("{}={}", key.name, key.value);
            xml.empty("dummy", &[("entry", &entry)]);
        }
        xml.close();
    }
    xml.close();
    network(&mut xml, model, section("DeviceInfo"));
    xml.finish()
}

fn header(xml: &mut Writer, class: &str) {
    xml.open("ProfileHeader", &[]);
    let name = format!("CANopen {class}");
    for (element, text) in [
        ("ProfileIdentification", "CANopen device profile"),
        ("ProfileRevision", "1.1"),
        ("ProfileName", name.as_str()),
        ("ProfileSource", ""),
        ("ProfileClassID", class),
    ] {
        xml.text(element, &[], text);
    }
    xml.open("ISO15745Reference", &[]);
    xml.text("ISO15745Part", &[], "1");
    xml.text("ISO15745Edition", &[], "1");
    xml.text("ProfileTechnology", &[], "CANopen");
    xml.close();
    xml.close();
}

fn body(xml: &mut Writer, kind: &str, info: &FileInfo) {
    let attributes = vec![
        ("xsi:type", kind.to_owned()),
        ("formatName", "CANopen".into()),
        ("formatVersion", "1.0".into()),
        ("fileName", info.file_name.clone()),
        ("fileCreator", info.created_by.clone()),
        ("fileCreationDate", xml_date(&info.creation_date)),
        ("fileCreationTime", xml_time(&info.creation_time)),
        ("fileModifiedBy", info.modified_by.clone()),
        ("fileModificationDate", xml_date(&info.modification_date)),
        ("fileModificationTime", xml_time(&info.modification_time)),
        ("fileVersion", version(info)),
        ("supportedLanguages", "en".into()),
    ];
    xml.open("ProfileBody", &stated(&attributes));
}

/// FileVersion and FileRevision.
fn version(info: &FileInfo) -> String {
    match (info.file_version, info.file_revision) {
        (version, 0) => version.to_string(),
        (version, revision) => format!("{version}.{revision}"),
    }
}

/// The attributes that have a value.
fn stated(attributes: &Attributes) -> Vec<(&str, &str)> {
    let attributes = attributes.iter();
    let attributes = attributes.map(|(name, value)| (*name, value.as_str()));
    attributes.filter(|(_, value)| !value.is_empty()).collect()
}

fn identity(xml: &mut Writer, info: Option<&Section<'_>>, description: &str) {
    xml.open("DeviceIdentity", &[]);
    for (element, key) in super::device::IDENTITY {
        if let Some(key) = info.and_then(|info| info.key(key)) {
            xml.text(element, &[], &key.value);
        }
        // The schema has the text about the product behind its number.
        if element == "productID" && !description.is_empty() {
            xml.open("productText", &[]);
            xml.text("description", &[("lang", "en")], description);
            xml.close();
        }
    }
    xml.close();
}

/// Whether an object needs a parameter to say it: its unit, and an access that objects have no name for.
fn needs_parameter(entry: &Entry) -> bool {
    let is_process = matches!(
        entry.access,
        Access::ReadWriteInput | Access::ReadWriteOutput
    );
    entry.unit().is_some() || (is_process && !entry.pdo_mapping)
}

/// The name by which an object refers to its parameter.
fn parameter_id(index: u16, sub: u8) -> String {
    format!("UID_{index:04X}_{sub:02X}")
}

fn parameters(xml: &mut Writer, model: &Model) {
    let all = model.types.iter().chain(&model.objects);
    let all = all.flat_map(|object| object.entries.iter().map(move |entry| (object, entry)));
    let mut needed = all.filter(|(_, entry)| needs_parameter(entry)).peekable();
    if needed.peek().is_none() {
        return;
    }
    xml.open("ApplicationProcess", &[]);
    xml.open("parameterList", &[]);
    for (object, entry) in needed {
        let id = parameter_id(object.index, entry.sub);
        let access = super::object::parameter_access(entry.access);
        xml.open("parameter", &[("uniqueID", &id), ("access", access)]);
        xml.text("label", &[("lang", "en")], &entry.name);
        xml.empty(super::object::type_name(entry.data_type), &[]);
        if let Some(unit) = entry.unit() {
            xml.open("unit", &[("multiplier", "1")]);
            xml.text("label", &[("lang", "en")], unit);
            xml.close();
        }
        xml.close();
    }
    xml.close();
    xml.close();
}

fn write_object(xml: &mut Writer, object: &Object, sections: &Sections<'_, '_>) {
    let own = format!("{:04X}", object.index);
    let Some(section) = sections.get(own.as_str()) else {
        return;
    };
    let has_subs = object.object_type.has_subs();
    let entry = object.entries.first().filter(|_| !has_subs);
    let mut attributes = vec![("index", own.clone())];
    attributes.extend(value(section, object.index, entry));
    let comments = comments(section, entry);
    if !has_subs && comments.is_empty() {
        xml.empty("CANopenObject", &stated(&attributes));
        return;
    }
    xml.open("CANopenObject", &stated(&attributes));
    for comment in comments {
        xml.comment(comment);
    }
    for entry in object.entries.iter().filter(|_| has_subs) {
        let name = format!("{own}sub{:X}", entry.sub);
        let Some(section) = sections.get(name.as_str()) else {
            continue;
        };
        let mut attributes = vec![("subIndex", format!("{:02X}", entry.sub))];
        attributes.extend(value(section, object.index, Some(entry)));
        let comments = self::comments(section, Some(entry));
        if comments.is_empty() {
            xml.empty("CANopenSubObject", &stated(&attributes));
            continue;
        }
        xml.open("CANopenSubObject", &stated(&attributes));
        for comment in comments {
            xml.comment(comment);
        }
        xml.close();
    }
    xml.close();
}

/// What is said of a value beside its attributes, but for the unit, which its parameter says.
fn comments<'a>(section: &'a Section<'_>, entry: Option<&Entry>) -> Vec<&'a str> {
    let comments = section.comments.iter();
    let has_unit = entry.is_some_and(|entry| entry.unit().is_some());
    let is_unit = |text: &str| {
        let name = text.split('=').next().unwrap_or_default().trim();
        has_unit && name.eq_ignore_ascii_case("Unit")
    };
    let comments = comments.map(|comment| &*comment.text);
    comments.filter(|text| !is_unit(text)).collect()
}

/// The attributes of an object or of a value, as the keys of its section are.
fn value(section: &Section<'_>, index: u16, entry: Option<&Entry>) -> Attributes {
    let mut attributes = Attributes::new();
    for (key, attribute) in super::object::ATTRIBUTES {
        let Some(key) = section.key(key) else {
            continue;
        };
        let value = match attribute {
            "dataType" | "objFlags" => bare(&key.value),
            "objectType" => number(&key.value).map_or_else(String::new, |code| code.to_string()),
            _ => key.value.clone().into_owned(),
        };
        attributes.push((attribute, value));
    }
    if let Some(key) = section.key("SubNumber") {
        attributes.push(("subNumber", key.value.clone().into_owned()));
    }
    let Some(entry) = entry else {
        return attributes;
    };
    let access = attributes
        .iter_mut()
        .find(|(name, _)| *name == "accessType");
    let mapping = match (entry.access, entry.pdo_mapping) {
        (_, false) => "no",
        (Access::ReadWriteInput | Access::ReadOnly | Access::Constant, true) => "TPDO",
        (Access::ReadWriteOutput | Access::WriteOnly, true) => "RPDO",
        (Access::ReadWrite, true) => "optional",
    };
    if let Some((_, access)) = access
        && matches!(
            entry.access,
            Access::ReadWriteInput | Access::ReadWriteOutput
        )
    {
        // Where nothing is mapped the parameter says it.
        *access = if entry.pdo_mapping {
            "rw".into()
        } else {
            String::new()
        };
    }
    attributes.push(("PDOmapping", mapping.into()));
    if needs_parameter(entry) {
        attributes.push(("uniqueIDRef", parameter_id(index, entry.sub)));
    }
    attributes
}

/// Four hexadecimal digits without a mark.
fn bare(value: &str) -> String {
    number(value).map_or_else(|| value.to_owned(), |number| format!("{number:04X}"))
}

/// The number that a key was printed with.
fn number(value: &str) -> Option<u32> {
    let digits = value.strip_prefix("0x")?;
    u32::from_str_radix(digits, 16).ok()
}

fn network(xml: &mut Writer, model: &Model, info: Option<&Section<'_>>) {
    let key = |name: &str| info.and_then(|info| info.key(name)).map(|key| &*key.value);
    xml.open("TransportLayers", &[]);
    xml.open("PhysicalLayer", &[]);
    xml.open("baudRate", &[]);
    for rate in &model.device.bit_rates {
        let rate = format!("{rate} Kbps");
        xml.empty("supportedBaudRate", &[("value", &rate)]);
    }
    xml.close();
    xml.close();
    xml.close();
    xml.open("NetworkManagement", &[]);
    let flag = |value: &str| if value == "1" { "true" } else { "false" }.to_owned();
    let mut features = Attributes::new();
    for (name, attribute, is_flag) in super::device::FEATURES {
        if let Some(value) = key(name) {
            let value = if is_flag { flag(value) } else { value.into() };
            features.push((attribute, value));
        }
    }
    xml.empty("CANopenGeneralFeatures", &stated(&features));
    if let Some(master) = key("SimpleBootUpMaster") {
        xml.empty("CANopenMasterFeatures", &[("bootUpMaster", &flag(master))]);
    }
    if let Some(node) = &model.commissioning
        && model.kind == FileKind::Dcf
    {
        let node_id = node.node_id.to_string();
        let (bit_rate, number) = (node.bit_rate.to_string(), node.net_number.to_string());
        let is_manager = if node.is_manager { "true" } else { "false" };
        let attributes = [
            ("nodeID", node_id.as_str()),
            ("nodeName", &node.node_name),
            ("actualBaudRate", &bit_rate),
            ("networkNumber", &number),
            ("networkName", &node.network_name),
            ("CANopenManager", is_manager),
        ];
        xml.empty("deviceCommissioning", &attributes);
    }
    xml.close();
}
