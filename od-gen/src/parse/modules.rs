//! The sections of modular devices: SupportedModules, `M1ModuleInfo`, `M1FixedObjects`, `M1SubExtends` and their like.
//!
//! The objects of a module are written as those of a device, with the module's number before the index: `[M1Fixed6423sub1]`.

use std::collections::BTreeMap;

use super::entry::{self, Context};
use super::lists::{check_count, indices};
use super::sections::{Sections, check_keys, number, text};
use super::{Broken, objects};
use crate::diagnostic::Findings;
use crate::document::Section;
use crate::model::{Extension, Model, Module};
use crate::rules::structure as rule;

/// The sections of one module.
#[derive(Debug, Default)]
pub(super) struct ModuleSections<'a> {
    info: Option<&'a Section<'a>>,
    comments: Option<&'a Section<'a>>,
    fixed: Option<&'a Section<'a>>,
    extends: Option<&'a Section<'a>>,
    /// Its fixed objects, named as those of a device.
    pub(super) objects: Sections<'a>,
    /// `[M1SubExt6000]` by index.
    extensions: BTreeMap<u16, &'a Section<'a>>,
}

const INFO_KEYS: [&str; 4] = [
    "ProductName",
    "ProductVersion",
    "ProductRevision",
    "OrderCode",
];

/// The number of a module and what follows it in the name of a section, in lower case.
pub(crate) fn module_name(name: &str) -> Option<(u8, &str)> {
    let rest = name.strip_prefix('m')?;
    let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
    let (number, rest) = rest.split_at_checked(digits)?;
    Some((number.parse().ok().filter(|number| *number > 0)?, rest))
}

impl<'a> ModuleSections<'a> {
    /// Takes a section by what follows the number of its module; `false` when it is none.
    pub(super) fn take(&mut self, rest: &str, section: &'a Section<'a>) -> bool {
        let place = match rest {
            "moduleinfo" => &mut self.info,
            "comments" => &mut self.comments,
            "fixedobjects" => &mut self.fixed,
            "subextends" => &mut self.extends,
            _ => {
                if let Some(name) = rest.strip_prefix("fixed") {
                    return self.objects.take_object(name, section);
                }
                let digits = rest
                    .strip_prefix("subext")
                    .filter(|digits| digits.len() == 4);
                let index = digits.and_then(|digits| u16::from_str_radix(digits, 16).ok());
                return index.is_some_and(|index| {
                    self.extensions.insert(index, section);
                    true
                });
            }
        };
        *place = Some(section);
        true
    }
}

/// Reads the modules, and which of them a DCF says are plugged.
pub(super) fn read(
    sections: &Sections<'_>,
    model: &mut Model,
    broken: &mut Broken,
    findings: &mut Findings,
) {
    for (number, module) in &sections.modules {
        let module = read_module(*number, module, sections.is_dcf, broken, findings);
        model.modules.push(module);
    }
    if let Some(section) = sections.supported_modules {
        let stated = number(section, "NrOfEntries", (0, 255), findings);
        if stated.is_some_and(|stated| stated != model.modules.len() as i128) {
            check_count(
                section,
                "NrOfEntries",
                model.modules.len() as i128,
                findings,
            );
        }
    }
    if let Some(section) = sections.connected_modules {
        let keys = section.keys.iter();
        for key in keys.filter(|key| !key.name.eq_ignore_ascii_case("NrOfEntries")) {
            let number = key.value.parse::<u8>().ok();
            let is_known =
                |number: &u8| model.modules.iter().any(|module| module.number == *number);
            match number.filter(is_known) {
                Some(number) => model.connected.push(number),
                None => {
                    let message = format!("there is no module {}", key.value);
                    findings.report(&rule::NO_MODULE, key.span, message);
                }
            }
        }
        check_count(
            section,
            "NrOfEntries",
            model.connected.len() as i128,
            findings,
        );
    }
}

fn read_module(
    module_number: u8,
    sections: &ModuleSections<'_>,
    is_dcf: bool,
    broken: &mut Broken,
    findings: &mut Findings,
) -> Module {
    let mut module = Module {
        number: module_number,
        comments: super::device::lines(sections.comments),
        ..Module::default()
    };
    if let Some(info) = sections.info {
        check_keys(info, &INFO_KEYS, findings);
        let mut byte = |name: &str| {
            let value = number(info, name, (0, 255), findings);
            value
                .and_then(|value| u8::try_from(value).ok())
                .unwrap_or_default()
        };
        module.product_version = byte("ProductVersion");
        module.product_revision = byte("ProductRevision");
        module.product_name = text(info, "ProductName");
        module.order_code = text(info, "OrderCode");
    }
    let mut objects = Model::default();
    objects::read(&sections.objects, &mut objects, broken, findings);
    module.fixed = objects.objects;
    check_list(sections.fixed, &sections.objects.objects, findings);
    check_list(sections.extends, &sections.extensions, findings);
    for (index, section) in &sections.extensions {
        let context = Context {
            index: *index,
            sub: 1,
            is_dcf,
            is_domain: false,
            is_compact: false,
            is_extension: true,
            types: &sections.objects.types,
        };
        let count = number(section, "Count", (0, 254), findings);
        let continues = number(section, "ObjExtend", (0, 1), findings) == Some(1);
        if let Some(entry) = entry::read(section, context, findings) {
            module.extensions.push(Extension {
                index: *index,
                entry,
                count: count
                    .and_then(|count| u8::try_from(count).ok())
                    .unwrap_or_default(),
                continues,
            });
        }
    }
    module
}

/// What a module lists has a section, and what has a section is listed.
fn check_list<'a>(
    list: Option<&Section<'_>>,
    sections: &BTreeMap<u16, &'a Section<'a>>,
    findings: &mut Findings,
) {
    let Some(list) = list else { return };
    let listed = indices(list, "NrOfEntries", findings);
    for (index, span) in &listed {
        if !sections.contains_key(index) {
            let message = format!("{index:04X}h is listed, but there is no section for it");
            findings.report(&rule::LISTED_WITHOUT_SECTION, *span, message);
        }
    }
    for (index, section) in sections {
        if !listed.contains_key(index) {
            let message = format!("{index:04X}h is not listed in [{}]", list.name);
            findings.report(&rule::NOT_LISTED, section.span, message);
        }
    }
}
