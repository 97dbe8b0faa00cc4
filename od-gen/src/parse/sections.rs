//! Which section of a data sheet is what.

use std::collections::{BTreeMap, BTreeSet};

use crate::diagnostic::Findings;
use crate::ini::Section;

/// The sections of a data sheet by meaning.
#[derive(Debug, Default)]
pub(super) struct Sections<'a> {
    pub(super) device_info: Option<&'a Section>,
    pub(super) dummy_usage: Option<&'a Section>,
    pub(super) mandatory: Option<&'a Section>,
    pub(super) optional: Option<&'a Section>,
    pub(super) manufacturer: Option<&'a Section>,
    /// `[1018]` by index.
    pub(super) objects: BTreeMap<u16, &'a Section>,
    /// `[1018sub1]` by index and sub-index.
    pub(super) subs: BTreeMap<(u16, u8), &'a Section>,
}

impl<'a> Sections<'a> {
    pub(super) fn sort(sections: &'a [Section], findings: &mut Findings) -> Self {
        let mut sorted = Self::default();
        let mut has_file_info = false;
        for section in sections {
            match section.name.to_ascii_lowercase().as_str() {
                "fileinfo" => {
                    has_file_info = true;
                    check_keys(section, &FILE_INFO_KEYS, findings);
                }
                "deviceinfo" => sorted.device_info = Some(section),
                "dummyusage" => sorted.dummy_usage = Some(section),
                "comments" => {}
                "mandatoryobjects" => sorted.mandatory = Some(section),
                "optionalobjects" => sorted.optional = Some(section),
                "manufacturerobjects" => sorted.manufacturer = Some(section),
                name => sorted.sort_object(name, section, findings),
            }
        }
        for (name, is_there) in [
            ("FileInfo", has_file_info),
            ("DeviceInfo", sorted.device_info.is_some()),
            ("MandatoryObjects", sorted.mandatory.is_some()),
        ] {
            if !is_there {
                findings.error(1, format!("the section [{name}] is missing"));
            }
        }
        sorted
    }

    fn sort_object(&mut self, name: &str, section: &'a Section, findings: &mut Findings) {
        let line = section.line;
        match ObjectName::parse(name) {
            Some(ObjectName::Object(index)) => {
                self.objects.entry(index).or_insert(section);
            }
            Some(ObjectName::Sub(index, sub)) => {
                self.subs.entry((index, sub)).or_insert(section);
            }
            Some(ObjectName::DataType(index)) => {
                findings.error(
                    line,
                    format!("{index:04X}h defines a data type, which is not supported"),
                );
            }
            Some(ObjectName::Compact) => {
                let message = format!(
                    "compact sub-indices are not supported: write [{}] out as sub sections",
                    section.name
                );
                findings.error(line, message);
            }
            None => findings.error(
                line,
                format!("the section [{}] is not supported", section.name),
            ),
        }
    }

    /// All indices that have a section.
    pub(super) fn indices(&self) -> BTreeSet<u16> {
        self.objects.keys().copied().collect()
    }
}

enum ObjectName {
    Object(u16),
    Sub(u16, u8),
    DataType(u16),
    Compact,
}

impl ObjectName {
    /// Reads a section name in lower case.
    fn parse(name: &str) -> Option<Self> {
        let (digits, rest) = name.split_at_checked(4)?;
        let is_hexadecimal = |text: &str| text.chars().all(|digit| digit.is_ascii_hexdigit());
        if !is_hexadecimal(digits) {
            return None;
        }
        let index = u16::from_str_radix(digits, 16).ok()?;
        match rest {
            _ if index < 0x1000 => Some(Self::DataType(index)),
            "" => Some(Self::Object(index)),
            "name" | "value" | "denotation" => Some(Self::Compact),
            _ => {
                let sub = rest.strip_prefix("sub").filter(|sub| is_hexadecimal(sub))?;
                Some(Self::Sub(index, u8::from_str_radix(sub, 16).ok()?))
            }
        }
    }
}

const FILE_INFO_KEYS: [&str; 11] = [
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
];

/// Keys that belong to a configured device (DCF), not to a data sheet.
const DCF_KEYS: [&str; 5] = [
    "ParameterValue",
    "UploadFile",
    "DownloadFile",
    "Denotation",
    "ParamRefd",
];

/// Reports keys that are not in the list: nothing is dropped in silence.
pub(super) fn check_keys(section: &Section, known: &[&str], findings: &mut Findings) {
    for key in &section.keys {
        let is_in = |list: &[&str]| list.iter().any(|name| name.eq_ignore_ascii_case(&key.name));
        if is_in(known) {
            continue;
        }
        let why = if is_in(&DCF_KEYS) {
            "belongs to a DCF, not to an EDS"
        } else {
            "is not supported here"
        };
        findings.error(
            key.line,
            format!("`{}` in [{}] {why}", key.name, section.name),
        );
    }
}
