//! Which section of a data sheet is what.

use std::collections::BTreeMap;

use super::modules::{ModuleSections, module_name};
use crate::data_type::DataType;
use crate::diagnostic::Findings;
use crate::document::{self, Document, Key, Section};
use crate::model::ObjectType;
use crate::number::Number;
use crate::rules::{reading, structure, value};
use crate::source::{Span, has_extension};
use crate::spelling;

/// The sections of a data sheet by meaning.
#[derive(Debug, Default)]
pub(super) struct Sections<'a> {
    /// Whether the file is the configuration of one device.
    pub(super) is_dcf: bool,
    pub(super) file_info: Option<&'a Section<'a>>,
    pub(super) device_info: Option<&'a Section<'a>>,
    pub(super) commissioning: Option<&'a Section<'a>>,
    pub(super) dummy_usage: Option<&'a Section<'a>>,
    pub(super) comments: Option<&'a Section<'a>>,
    pub(super) dynamic_channels: Option<&'a Section<'a>>,
    pub(super) supported_modules: Option<&'a Section<'a>>,
    pub(super) connected_modules: Option<&'a Section<'a>>,
    /// `[M1ModuleInfo]` and its like by the module's number.
    pub(super) modules: BTreeMap<u8, ModuleSections<'a>>,
    pub(super) mandatory: Option<&'a Section<'a>>,
    pub(super) optional: Option<&'a Section<'a>>,
    pub(super) manufacturer: Option<&'a Section<'a>>,
    /// `[1018]` by index.
    pub(super) objects: BTreeMap<u16, &'a Section<'a>>,
    /// `[1018sub1]` by index and sub-index.
    pub(super) subs: BTreeMap<(u16, u8), &'a Section<'a>>,
    /// `[1003Name]`, `[1003Value]`, `[1003Denotation]` by index.
    pub(super) compact: BTreeMap<(u16, CompactList), &'a Section<'a>>,
    /// `[Tools]`, `[Tool1]` and their like, and `[StandardDataTypes]`.
    pub(super) tools: Vec<&'a Section<'a>>,
    /// What the types that the file defines (DEFTYPE) are made of, by index.
    pub(super) types: BTreeMap<u16, DataType>,
}

/// The lists that go with CompactSubObj.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum CompactList {
    Name,
    Value,
    Denotation,
}

impl<'a> Sections<'a> {
    pub(super) fn sort(document: &'a Document<'a>, file: &str, findings: &mut Findings) -> Self {
        let mut sorted = Self {
            is_dcf: has_extension(file, "dcf") || has_extension(file, "xdc"),
            ..Self::default()
        };
        for section in &document.sections {
            let place = match section.name.to_ascii_lowercase().as_str() {
                "fileinfo" => &mut sorted.file_info,
                "deviceinfo" => &mut sorted.device_info,
                // CiA 306 spells it like this.
                "devicecomissioning" | "devicecommissioning" => &mut sorted.commissioning,
                "dummyusage" => &mut sorted.dummy_usage,
                "comments" => &mut sorted.comments,
                "dynamicchannels" => &mut sorted.dynamic_channels,
                "supportedmodules" => &mut sorted.supported_modules,
                "connectedmodules" => &mut sorted.connected_modules,
                // What tools there are, and which data types they know: nothing about the device.
                name if is_of_tools(name) => {
                    sorted.tools.push(section);
                    continue;
                }
                "mandatoryobjects" => &mut sorted.mandatory,
                "optionalobjects" => &mut sorted.optional,
                "manufacturerobjects" => &mut sorted.manufacturer,
                name => {
                    if !sorted.take(name, section) {
                        unknown_section(section, findings);
                    }
                    continue;
                }
            };
            *place = Some(section);
        }
        sorted.is_dcf |= sorted.commissioning.is_some();
        sorted.types = base_types(&sorted.objects);
        for module in sorted.modules.values_mut() {
            module.objects.is_dcf = sorted.is_dcf;
            module.objects.types = sorted.types.clone();
        }
        let missing = &structure::MISSING_SECTION;
        for (name, section, rule) in [
            ("FileInfo", sorted.file_info, &structure::MISSING_FILE_INFO),
            ("DeviceInfo", sorted.device_info, missing),
            ("MandatoryObjects", sorted.mandatory, missing),
        ] {
            if section.is_none() {
                let message = format!("the section [{name}] is missing");
                findings.report(rule, Span::START, message);
            }
        }
        sorted
    }

    /// Takes a section of an object or a module by its name in lower case; `false` when it is none.
    fn take(&mut self, name: &str, section: &'a Section<'a>) -> bool {
        match module_name(name) {
            Some((number, rest)) => self.modules.entry(number).or_default().take(rest, section),
            None => self.take_object(name, section),
        }
    }

    /// Takes a section of an object by its name in lower case; `false` when it is none.
    pub(super) fn take_object(&mut self, name: &str, section: &'a Section<'a>) -> bool {
        match ObjectName::parse(name) {
            Some(ObjectName::Object(index)) => _ = self.objects.entry(index).or_insert(section),
            Some(ObjectName::Sub(index, sub)) => {
                self.subs.entry((index, sub)).or_insert(section);
            }
            Some(ObjectName::Compact(index, list)) => {
                self.compact.entry((index, list)).or_insert(section);
            }
            None => return false,
        }
        true
    }
}

/// Whether a section is one of an object or a sub-index.
pub(super) fn is_object(name: &str) -> bool {
    let name = ObjectName::parse(&name.to_ascii_lowercase());
    matches!(name, Some(ObjectName::Object(_) | ObjectName::Sub(..)))
}

/// Reports a section that means nothing.
fn unknown_section(section: &Section<'_>, findings: &mut Findings) {
    let name = &section.name;
    let message = format!("the section [{name}] is not known");
    let finding = findings.report(&reading::UNKNOWN_SECTION, section.span, message);
    let lower: String = name.to_ascii_lowercase().split_whitespace().collect();
    let bare = lower.strip_prefix("0x").unwrap_or(&lower);
    let near = match ObjectName::parse(bare) {
        Some(_) => Some(bare),
        None => spelling::nearest(name, document::SECTIONS),
    };
    if let Some(near) = near {
        finding.help(format!("is it `[{near}]`?"));
    }
}

/// What the types that the file defines are made of. A DEFTYPE may stand for another one; what goes round in a circle, and what does
/// not say its type, is none.
fn base_types(objects: &BTreeMap<u16, &Section<'_>>) -> BTreeMap<u16, DataType> {
    let stated = objects.range(..0x1000);
    let stated = stated.filter_map(|(index, section)| Some((*index, stated_type(section)?)));
    let stated: BTreeMap<u16, i128> = stated.collect();
    let base = |index: &u16| {
        // No chain is longer than all types together.
        let mut code = *stated.get(index)?;
        for _ in 0..stated.len() {
            match DataType::from_code(code) {
                Some(data_type) => return Some((*index, data_type)),
                None => code = *stated.get(&u16::try_from(code).ok()?)?,
            }
        }
        None
    };
    stated.keys().filter_map(base).collect()
}

/// The DataType of a DEFTYPE; `None` for what is no DEFTYPE, and for one that does not say it.
fn stated_type(section: &Section<'_>) -> Option<i128> {
    let code = |name: &str| Some(Number::parse(&section.key(name)?.value).ok()?.value);
    let kind = ObjectType::from_code(code("ObjectType")?)?;
    (kind == ObjectType::DefType).then(|| code("DataType"))?
}

/// `tools`, `tool1`, `standarddatatypes`.
fn is_of_tools(name: &str) -> bool {
    let number = name.strip_prefix("tool").unwrap_or("?");
    let is_number = !number.is_empty() && number.bytes().all(|digit| digit.is_ascii_digit());
    is_number || matches!(name, "tools" | "standarddatatypes")
}

enum ObjectName {
    Object(u16),
    Sub(u16, u8),
    Compact(u16, CompactList),
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
        Some(match rest {
            "" => Self::Object(index),
            "name" => Self::Compact(index, CompactList::Name),
            "value" => Self::Compact(index, CompactList::Value),
            "denotation" => Self::Compact(index, CompactList::Denotation),
            _ => {
                let sub = rest.strip_prefix("sub").filter(|sub| is_hexadecimal(sub))?;
                Self::Sub(index, u8::from_str_radix(sub, 16).ok()?)
            }
        })
    }
}

/// Reports keys that are not in the list: nothing is dropped in silence.
pub(super) fn check_keys(section: &Section<'_>, known: &[&'static str], findings: &mut Findings) {
    for key in &section.keys {
        if !known
            .iter()
            .any(|name| name.eq_ignore_ascii_case(&key.name))
        {
            unknown_key(key, section, known.iter().copied(), findings);
        }
    }
}

/// Reports a key that means nothing.
pub(super) fn unknown_key(
    key: &Key<'_>,
    section: &Section<'_>,
    known: impl Iterator<Item = &'static str>,
    findings: &mut Findings,
) {
    let message = format!("`{}` in [{}] is not known", key.name, section.name);
    let finding = findings.report(&reading::UNKNOWN_KEY, key.name_span, message);
    // `BaudRate_100` is no misspelled `BaudRate_10`: another number is another thing.
    let numbered = |name: &str| name.ends_with(|letter: char| letter.is_ascii_digit());
    let near = spelling::nearest(&key.name, known);
    if let Some(near) = near.filter(|near| !(numbered(&key.name) && numbered(near))) {
        finding.help(format!("is it `{near}`?"));
    }
}

/// A key's number between `low` and `high`; `None` when it is not there, or wrong and what was meant is not plain.
pub(super) fn number(
    section: &Section<'_>,
    name: &str,
    (low, high): (i128, i128),
    findings: &mut Findings,
) -> Option<i128> {
    let key = section.key(name)?;
    let spelled = Number::parse(&key.value).map_err(|why| why.of(name));
    let number = findings.take(&value::NOT_A_NUMBER, key.span, spelled);
    let value = number.or_else(|| Number::meant(&key.value))?.value;
    if (low..=high).contains(&value) {
        return Some(value);
    }
    let message = format!("{name}: {} is not between {low} and {high}", key.value);
    findings.report(&value::OUT_OF_RANGE, key.span, message);
    None
}

/// A key's text; empty when it is not there.
pub(super) fn text(section: &Section<'_>, name: &str) -> String {
    let key = section.key(name);
    key.map_or_else(String::new, |key| key.value.to_string())
}
