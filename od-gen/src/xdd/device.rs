//! DeviceIdentity, NetworkManagement and TransportLayers as the sections FileInfo, DeviceInfo and their like.

use roxmltree::Node;

use super::text::{eds_date, eds_time, one_line};
use super::{Reader, as_it_is, find, flag, is};
use crate::document::{Key, Section};
use crate::number::Number;
use crate::source::has_extension;

/// Elements of DeviceIdentity, and what DeviceInfo calls them.
pub(super) const IDENTITY: [(&str, &str); 5] = [
    ("vendorName", "VendorName"),
    ("vendorID", "VendorNumber"),
    ("productName", "ProductName"),
    ("productID", "ProductNumber"),
    ("orderNumber", "OrderCode"),
];

/// Keys of DeviceInfo, as attributes of CANopenGeneralFeatures, and whether they are `true` or `false`.
pub(super) const FEATURES: [(&str, &str, bool); 7] = [
    ("Granularity", "granularity", false),
    ("NrOfRXPDO", "nrOfRxPDO", false),
    ("NrOfTXPDO", "nrOfTxPDO", false),
    ("DynamicChannelsSupported", "dynamicChannels", false),
    ("GroupMessaging", "groupMessaging", true),
    ("SimpleBootUpSlave", "bootUpSlave", true),
    ("LSS_Supported", "layerSettingServiceSlave", true),
];

impl<'a, 'x> Reader<'a, 'x> {
    /// All sections that are no objects.
    pub(super) fn device(&self, root: Node<'x, 'x>) -> Vec<Section<'a>> {
        let mut sections = vec![self.file_info(root), self.device_info(root)];
        let node = find(root, "deviceCommissioning");
        sections.extend(match node {
            Some(node) if self.is_configured => Some(self.commissioning(node)),
            // Values without a node, in a file that is not called an XDC.
            None if self.is_configured && !has_extension(&self.source.file, "xdc") => {
                Some(Section::new("DeviceComissioning"))
            }
            _ => None,
        });
        sections.extend(find(root, "dummyUsage").map(|node| self.dummy_usage(node)));
        sections
    }

    /// Adds `key=value` with the text of an element.
    fn put_text(&self, section: &mut Section<'a>, key: &'static str, node: Option<Node<'_, '_>>) {
        let Some(node) = node else { return };
        let text = one_line(node.text().unwrap_or_default());
        if !text.is_empty() {
            let span = self.source.span(node.range());
            section.keys.push(Key {
                name: key.into(),
                value: text.into(),
                name_span: span,
                span,
            });
        }
    }

    fn file_info(&self, root: Node<'x, 'x>) -> Section<'a> {
        // There are two, and some tools fill in the second alone.
        let bodies = root.descendants().filter(|node| is(*node, "ProfileBody"));
        let bodies: Vec<_> = bodies.collect();
        let Some(body) = bodies.first().copied() else {
            return Section::new("FileInfo");
        };
        let mut section = self.section("FileInfo".into(), body);
        // The whole file is in it: its comments are for the whole file.
        section.lines = 0..0;
        for (key, attribute, spell) in [
            ("FileName", "fileName", as_it_is as fn(&str) -> String),
            ("CreatedBy", "fileCreator", as_it_is),
            ("CreationDate", "fileCreationDate", eds_date),
            ("CreationTime", "fileCreationTime", eds_time),
            ("ModifiedBy", "fileModifiedBy", as_it_is),
            ("ModificationDate", "fileModificationDate", eds_date),
            ("ModificationTime", "fileModificationTime", eds_time),
        ] {
            for body in &bodies {
                if section.key(key).is_none() {
                    self.put(&mut section, key, (*body, attribute), spell);
                }
            }
        }
        // A version is any text in XML, and two numbers in an EDS.
        let is_stated = |node: &&Node<'_, '_>| !version(**node).trim().is_empty();
        let body = bodies.iter().find(is_stated).copied().unwrap_or(body);
        let (number, revision) = version(body)
            .split_once('.')
            .unwrap_or((version(body), "0"));
        let is_number = |text: &str| Number::parse_within(text, 0, 255).is_ok();
        if is_number(number) && is_number(revision) {
            let whole = (body, "fileVersion");
            self.put(&mut section, "FileVersion", whole, |_| number.into());
            self.put(&mut section, "FileRevision", whole, |_| revision.into());
        }
        let text = find(root, "productText").and_then(|text| find(text, "description"));
        self.put_text(&mut section, "Description", text);
        section
    }

    fn device_info(&self, root: Node<'x, 'x>) -> Section<'a> {
        let Some(identity) = find(root, "DeviceIdentity") else {
            return Section::new("DeviceInfo");
        };
        let mut section = self.section("DeviceInfo".into(), identity);
        for (name, key) in IDENTITY {
            self.put_text(&mut section, key, find(identity, name));
        }
        if let Some(features) = find(root, "CANopenGeneralFeatures") {
            for (key, attribute, is_flag) in FEATURES {
                let spell = if is_flag { flag } else { as_it_is };
                self.put(&mut section, key, (features, attribute), spell);
            }
        }
        if let Some(features) = find(root, "CANopenMasterFeatures") {
            let master = (features, "bootUpMaster");
            self.put(&mut section, "SimpleBootUpMaster", master, flag);
        }
        for rate in root
            .descendants()
            .filter(|node| is(*node, "supportedBaudRate"))
        {
            let value = rate.attribute("value").unwrap_or_default();
            let name = match value.split_whitespace().next().unwrap_or_default() {
                "10" => "BaudRate_10",
                "20" => "BaudRate_20",
                "50" => "BaudRate_50",
                "125" => "BaudRate_125",
                "250" => "BaudRate_250",
                "500" => "BaudRate_500",
                "800" => "BaudRate_800",
                "1000" => "BaudRate_1000",
                // `auto-baudRate` is no rate.
                _ => continue,
            };
            self.put(&mut section, name, (rate, "value"), |_| "1".into());
        }
        section
    }

    fn commissioning(&self, node: Node<'_, '_>) -> Section<'a> {
        let mut section = self.section("DeviceComissioning".into(), node);
        for (key, attribute, spell) in [
            ("NodeID", "nodeID", as_it_is as fn(&str) -> String),
            ("NodeName", "nodeName", as_it_is),
            ("Baudrate", "actualBaudRate", bit_rate),
            ("NetNumber", "networkNumber", as_it_is),
            ("NetworkName", "networkName", as_it_is),
            ("CANopenManager", "CANopenManager", flag),
        ] {
            self.put(&mut section, key, (node, attribute), spell);
        }
        section
    }

    fn dummy_usage(&self, node: Node<'_, '_>) -> Section<'a> {
        let mut section = self.section("DummyUsage".into(), node);
        for dummy in node.children().filter(|node| is(*node, "dummy")) {
            let entry = one_line(dummy.attribute("entry").unwrap_or_default());
            let (name, value) = entry.split_once('=').unwrap_or((&entry, ""));
            let (name, value) = (name.trim().to_owned(), value.trim().to_owned());
            self.put(&mut section, "", (dummy, "entry"), |_| value.clone());
            if let Some(key) = section.keys.last_mut() {
                key.name = name.into();
            }
        }
        section
    }
}

/// The version of a ProfileBody.
fn version<'x>(body: Node<'x, 'x>) -> &'x str {
    body.attribute("fileVersion").unwrap_or_default()
}

/// `125 Kbps` is 125, and so is 125000: some tools count bits and not thousands of them.
fn bit_rate(value: &str) -> String {
    let number = value.split_whitespace().next().unwrap_or_default();
    let thousands = number.strip_suffix("000").filter(|rate| rate.len() > 1);
    thousands.unwrap_or(number).into()
}
