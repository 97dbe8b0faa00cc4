//! MandatoryObjects, OptionalObjects, ManufacturerObjects: what is listed has a section, what has a section is listed.

use std::collections::BTreeMap;

use super::sections::Sections;
use crate::diagnostic::Findings;
use crate::document::Section;
use crate::number::Number;
use crate::rules::structure as rule;
use crate::source::Span;

/// The objects that every device has (CiA 306, MandatoryObjects).
const MANDATORY: [u16; 3] = [0x1000, 0x1001, 0x1018];

#[derive(Clone, Copy, PartialEq, Eq)]
enum List {
    Mandatory,
    Optional,
    Manufacturer,
}

impl List {
    fn name(self) -> &'static str {
        match self {
            Self::Mandatory => "MandatoryObjects",
            Self::Optional => "OptionalObjects",
            Self::Manufacturer => "ManufacturerObjects",
        }
    }

    /// The list in which an object belongs.
    fn of(index: u16) -> Self {
        match index {
            _ if MANDATORY.contains(&index) => Self::Mandatory,
            0x2000..=0x5FFF => Self::Manufacturer,
            _ => Self::Optional,
        }
    }
}

pub(super) fn check(sections: &Sections<'_>, findings: &mut Findings) {
    let mut listed = BTreeMap::new();
    for (list, section) in [
        (List::Mandatory, sections.mandatory),
        (List::Optional, sections.optional),
        (List::Manufacturer, sections.manufacturer),
    ] {
        if let Some(section) = section {
            let count_key = "SupportedObjects";
            let list = Some((list, sections));
            read(list, section, count_key, &mut listed, findings);
        }
    }
    for (index, span) in &listed {
        if !sections.objects.contains_key(index) {
            let message = format!("{index:04X}h is listed, but there is no section [{index:04X}]");
            let finding = findings.report(&rule::LISTED_WITHOUT_SECTION, *span, message);
            finding.help("add the section, or take it off the list");
        }
    }
    for (index, section) in sections.objects.range(0x1000..) {
        if !listed.contains_key(index) {
            let list = List::of(*index).name();
            let message = format!("{index:04X}h is not listed in [{list}]");
            let finding = findings.report(&rule::NOT_LISTED, section.span, message);
            finding.help(format!("add it to [{list}], or remove its sections"));
        }
    }
    for index in MANDATORY {
        // Listed without a section, or the other way round, has been reported.
        if !listed.contains_key(&index) && !sections.objects.contains_key(&index) {
            let message = format!("the mandatory object {index:04X}h is missing");
            findings.report(&rule::MISSING_MANDATORY_OBJECT, Span::START, message);
        }
    }
}

/// The indices of a list with their places.
pub(super) fn indices(
    section: &Section<'_>,
    count_key: &str,
    findings: &mut Findings,
) -> BTreeMap<u16, Span> {
    let mut listed = BTreeMap::new();
    read(None, section, count_key, &mut listed, findings);
    listed
}

/// Reads one list into `listed`: index and place.
fn read(
    list: Option<(List, &Sections<'_>)>,
    section: &Section<'_>,
    count_key: &str,
    listed: &mut BTreeMap<u16, Span>,
    findings: &mut Findings,
) {
    let (mut count, mut next) = (0, 1);
    let sections = list.map(|(_, sections)| sections);
    let list = list.map(|(list, _)| list);
    for key in &section.keys {
        if key.name.eq_ignore_ascii_case(count_key) {
            continue;
        }
        let number = Number::parse(&key.name).map(|number| number.value).ok();
        if number != Some(next) {
            let message = format!("`{}` where number {next} of the list should be", key.name);
            findings.report(&rule::LIST_NUMBERING, key.name_span, message);
        }
        next = number.unwrap_or(next) + 1;
        if key.value.is_empty() {
            continue;
        }
        count += 1;
        let number = Number::parse(&key.value).ok();
        // Types that the file defines may be listed like objects.
        let defined = |index: u16| {
            index >= 0x1000 || sections.is_some_and(|own| own.objects.contains_key(&index))
        };
        let Some(index) = number.and_then(index_of).filter(|index| defined(*index)) else {
            let message = format!("`{}` is not an index (0x1000 to 0xFFFF)", key.value);
            let finding = findings.report(&rule::NOT_AN_INDEX, key.span, message);
            // `1000` is 3E8h: the mark of a hexadecimal number is easily forgotten.
            let marked = format!("0x{}", key.value);
            let bare = Number::parse(&marked).ok().and_then(index_of);
            let bare = bare.filter(|index| defined(*index));
            if bare.is_some() {
                finding.help(format!("write `{marked}`"));
            }
            let meant = Number::meant(&key.value).and_then(index_of).or(bare);
            if let Some(index) = meant.filter(|index| defined(*index)) {
                listed.entry(index).or_insert(key.span);
            }
            continue;
        };
        if let Some(first) = listed.insert(index, key.span) {
            let message = format!("{index:04X}h is already listed on line {}", first.line);
            findings
                .report(&rule::LISTED_TWICE, key.span, message)
                .also(first, "the first one");
        } else if index >= 0x1000 && list.is_some_and(|list| List::of(index) != list) {
            let message = format!("{index:04X}h belongs in [{}]", List::of(index).name());
            findings.report(&rule::WRONG_LIST, key.span, message);
        }
    }
    check_count(section, count_key, count, findings);
}

/// The index of an object.
fn index_of(number: Number) -> Option<u16> {
    u16::try_from(number.value).ok().filter(|index| *index > 0)
}

/// A list has as many entries as its key says.
pub(super) fn check_count(section: &Section<'_>, name: &str, count: i128, findings: &mut Findings) {
    let Some(key) = section.key(name) else {
        let message = format!("`{name}` is missing in [{}]", section.name);
        let finding = findings.report(&rule::LIST_COUNT, section.span, message);
        finding.help(format!("write {name}={count}"));
        return;
    };
    match Number::parse(&key.value) {
        Ok(number) if number.value == count => {}
        Ok(_) => {
            let message = format!("{name} is {}, but {count} are listed", key.value);
            let finding = findings.report(&rule::LIST_COUNT, key.span, message);
            finding.help(format!("write {name}={count}, or list what {name} counts"));
        }
        Err(mistake) => {
            findings.take::<(), _>(&rule::LIST_COUNT, key.span, Err(mistake));
        }
    }
}
