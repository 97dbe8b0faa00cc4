//! Sections of several data sheets as those of one.

use std::collections::{BTreeSet, HashMap};
use std::env;
use std::ops::{Range, RangeInclusive};

use toml::{Spanned, Value};

use super::file::{File, Part};
use crate::bind;
use crate::diagnostic::Findings;
use crate::document::{self, Comment, Document, Key, Section};
use crate::number::Number;
use crate::rules::recipe as rule;
use crate::source::Span;

/// The lists of objects.
const LISTS: [&str; 3] = ["MandatoryObjects", "OptionalObjects", "ManufacturerObjects"];

/// Keys of `[identity]`: what DeviceInfo calls them, and the sub-index of 1018h that says the same.
const IDENTITY: [(&str, Option<&str>, Option<u8>); 7] = [
    ("vendor_name", Some("VendorName"), None),
    ("vendor_id", Some("VendorNumber"), Some(1)),
    ("product_name", Some("ProductName"), None),
    ("product_code", Some("ProductNumber"), Some(2)),
    ("revision_number", Some("RevisionNumber"), Some(3)),
    ("serial_number", None, Some(4)),
    ("order_code", Some("OrderCode"), None),
];

/// Where a range of a recipe is.
type Place<'f> = dyn Fn(Range<usize>) -> Span + 'f;

/// A data sheet that is put together.
pub(super) struct Merged<'a> {
    document: Document<'a>,
    /// Where each section is, by its name in lower case.
    places: HashMap<String, usize>,
    /// The objects of which sub-indices came or went.
    touched: BTreeSet<u16>,
    /// How many objects there were that PDOs have, before anything came or went.
    pdos: [usize; 2],
}

/// Keys that count PDOs, and the objects that they count.
const PDOS: [(&str, RangeInclusive<u16>); 2] = [
    ("NrOfRXPDO", 0x1400..=0x15FF),
    ("NrOfTXPDO", 0x1800..=0x19FF),
];

/// The object that a section belongs to, and its sub-index where it is of one.
fn object_of(name: &str) -> Option<(u16, Option<u8>)> {
    let (index, rest) = name.split_at_checked(4)?;
    let index = u16::from_str_radix(index, 16).ok()?;
    let sub = rest.strip_prefix("sub");
    Some((index, sub.and_then(|sub| u8::from_str_radix(sub, 16).ok())))
}

/// Objects, or one sub-index.
enum Selected {
    Objects(RangeInclusive<u16>),
    Entry(u16, u8),
}

impl Selected {
    fn read(text: &str) -> Option<Self> {
        if text.contains(':') {
            let (index, sub) = bind::entry(text)?;
            return Some(Self::Entry(index, sub));
        }
        bind::indices(text).map(Self::Objects)
    }

    fn has(&self, index: u16, sub: Option<u8>) -> bool {
        match self {
            Self::Objects(indices) => indices.contains(&index),
            Self::Entry(own, entry) => *own == index && sub == Some(*entry),
        }
    }
}

impl<'a> Merged<'a> {
    pub(super) fn new(document: Document<'a>) -> Self {
        let mut merged = Self {
            document,
            places: HashMap::new(),
            touched: BTreeSet::new(),
            pdos: [0; 2],
        };
        merged.index();
        merged.pdos = merged.count_pdos();
        merged
    }

    fn index(&mut self) {
        let sections = self.document.sections.iter().enumerate();
        let names = sections.map(|(at, section)| (document::identity(&section.name), at));
        self.places = names.collect();
    }

    fn section(&mut self, name: &str) -> Option<&mut Section<'a>> {
        let at = *self.places.get(&name.to_ascii_lowercase())?;
        self.document.sections.get_mut(at)
    }

    /// Adds a comment that is for the whole.
    pub(super) fn remark(&mut self, comment: Comment<'a>) {
        self.document.head.push(comment);
    }

    /// Reads what a recipe names; reports what is none, and what is not there.
    fn selected(
        &self,
        names: &[Spanned<String>],
        place: &Place<'_>,
        findings: &mut Findings,
    ) -> Vec<Selected> {
        let mut all = Vec::new();
        for name in names {
            let text = name.get_ref();
            let span = place(name.span());
            let Some(selected) = Selected::read(text) else {
                let message = format!("`{text}` is no object");
                let finding = findings.report(&rule::OBJECT, span, message);
                finding.help("objects are named as 2050h, 2050h-205Fh or 2050h:3");
                continue;
            };
            let sections = self.places.keys();
            let mut objects = sections.filter_map(|name| object_of(name));
            if !objects.any(|(index, sub)| selected.has(index, sub)) {
                let message = format!("there is no {text} here");
                findings.report(&rule::OBJECT, span, message);
            }
            all.push(selected);
        }
        all
    }

    /// Takes away what a part does not take.
    pub(super) fn select(&mut self, part: &Part, place: &Place<'_>, findings: &mut Findings) {
        let Some(names) = &part.objects else { return };
        let selected = self.selected(names, place, findings);
        self.keep(|index, sub| {
            let mut all = selected.iter();
            all.any(|own| own.has(index, sub))
        });
        let is_list = |name: &str| LISTS.iter().any(|list| list.eq_ignore_ascii_case(name));
        let is_kept = |name: &str| object_of(name).is_some() || is_list(name);
        self.document
            .sections
            .retain(|section| is_kept(&section.name));
        self.index();
    }

    /// Takes away what a part removes.
    pub(super) fn remove(&mut self, part: &Part, place: &Place<'_>, findings: &mut Findings) {
        if part.remove.is_empty() {
            return;
        }
        let selected = self.selected(&part.remove, place, findings);
        for own in &selected {
            if let Selected::Entry(index, _) = own {
                self.touched.insert(*index);
            }
        }
        self.keep(|index, sub| !selected.iter().any(|own| own.has(index, sub)));
    }

    /// Takes away the objects that are not asked for, of the lists too.
    fn keep(&mut self, is_kept: impl Fn(u16, Option<u8>) -> bool) {
        self.document.sections.retain(|section| {
            let object = object_of(&section.name.to_ascii_lowercase());
            object.is_none_or(|(index, sub)| is_kept(index, sub))
        });
        for section in &mut self.document.sections {
            if LISTS
                .iter()
                .any(|list| section.name.eq_ignore_ascii_case(list))
            {
                section.keys.retain(|key| {
                    let listed = listed(key);
                    listed.is_none_or(|index| is_kept(index, None))
                });
            }
        }
        self.index();
    }

    /// Adds the sections of another data sheet. What is there already gets the keys and the notes that the other one states.
    pub(super) fn add(&mut self, more: Merged<'a>) {
        self.document.head.extend(more.document.head);
        self.touched.extend(more.touched);
        for section in more.document.sections {
            let name = document::identity(&section.name);
            if LISTS.iter().any(|list| list.eq_ignore_ascii_case(&name)) {
                self.add_list(&name, section);
                continue;
            }
            let object = object_of(&name);
            match self.places.get(&name) {
                Some(at) => {
                    if let Some(own) = self.document.sections.get_mut(*at) {
                        overlay(own, section);
                    }
                }
                None => {
                    if let Some((index, Some(_))) = object {
                        self.touched.insert(index);
                    }
                    self.places.insert(name, self.document.sections.len());
                    self.document.sections.push(section);
                }
            }
        }
    }

    fn add_list(&mut self, name: &str, section: Section<'a>) {
        let Some(own) = self.section(name) else {
            self.places
                .insert(name.to_owned(), self.document.sections.len());
            self.document.sections.push(section);
            return;
        };
        let known: BTreeSet<u16> = own.keys.iter().filter_map(listed).collect();
        let new = section.keys.into_iter();
        let new = new.filter(|key| listed(key).is_some_and(|index| !known.contains(&index)));
        own.keys.extend(new);
    }

    /// Sets a key, here of a recipe.
    fn set(&mut self, section: &str, key: &'static str, value: String, span: Span) -> bool {
        let Some(section) = self.section(section) else {
            return false;
        };
        put(
            section,
            Key {
                name: key.into(),
                value: value.into(),
                name_span: span,
                span,
            },
        );
        true
    }

    /// Who the device is.
    pub(super) fn identify(&mut self, file: &File, place: &Place<'_>, findings: &mut Findings) {
        for (name, value) in &file.identity {
            let span = place(value.span());
            let known = IDENTITY.iter().find(|(own, ..)| own == name.get_ref());
            let Some((_, key, sub)) = known else {
                let message = format!("`{}` is nothing of an identity", name.get_ref());
                let finding = findings.report(&rule::IDENTITY, place(name.span()), message);
                let names: Vec<&str> = IDENTITY.iter().map(|(own, ..)| *own).collect();
                finding.help(names.join(", "));
                continue;
            };
            let Some(value) = text(value.get_ref(), span, findings) else {
                continue;
            };
            if let Some(key) = key
                && !self.set("DeviceInfo", key, value.clone(), span)
            {
                findings.report(&rule::IDENTITY, span, "there is no [DeviceInfo]");
            }
            if let Some(sub) = sub
                && !self.set(&format!("1018sub{sub}"), "DefaultValue", value, span)
            {
                // What an identity need not have is in DeviceInfo alone.
                if key.is_none() {
                    let message = format!("1018h has no sub-index {sub}");
                    findings.report(&rule::IDENTITY, span, message);
                }
            }
        }
    }

    /// Defaults that the recipe states.
    pub(super) fn put_defaults(&mut self, file: &File, place: &Place<'_>, findings: &mut Findings) {
        for (name, value) in &file.defaults {
            let span = place(value.span());
            let entry = bind::entry(name.get_ref());
            let section = entry.and_then(|(index, sub)| {
                let with_sub = format!("{index:04x}sub{sub:x}");
                let alone = format!("{index:04x}");
                let is_there = |name: &String| self.places.contains_key(name);
                let alone = Some(alone).filter(|_| sub == 0);
                Some(with_sub).filter(is_there).or(alone.filter(is_there))
            });
            let Some(section) = section else {
                let message = format!("there is no {} here", name.get_ref());
                findings.report(&rule::OBJECT, place(name.span()), message);
                continue;
            };
            if let Some(value) = text(value.get_ref(), span, findings) {
                self.set(&section, "DefaultValue", value, span);
            }
        }
    }

    /// One data sheet: what came is listed, and what is counted is counted anew.
    pub(super) fn into_document(mut self) -> Document<'a> {
        self.list_all();
        self.count_subs();
        // What a data sheet says of itself alone is its own.
        let counts = self.count_pdos().into_iter().zip(self.pdos);
        for ((key, _), (count, before)) in PDOS.into_iter().zip(counts) {
            if count != before
                && let Some(info) = self.section("DeviceInfo")
                && let Some(key) = key_of(info, key)
            {
                key.value = count.to_string().into();
            }
        }
        self.document
    }

    /// The receive and the transmit PDOs.
    fn count_pdos(&self) -> [usize; 2] {
        PDOS.map(|(_, range)| {
            let names = self.places.keys().filter(|name| name.len() == 4);
            let objects = names.filter_map(|name| object_of(name));
            objects.filter(|(index, _)| range.contains(index)).count()
        })
    }

    fn list_all(&mut self) {
        let mut known: BTreeSet<u16> = BTreeSet::new();
        for list in LISTS {
            if let Some(section) = self.section(list) {
                known.extend(section.keys.iter().filter_map(listed));
            }
        }
        let mut new: Vec<(u16, Span)> = Vec::new();
        for section in &self.document.sections {
            let name = section.name.to_ascii_lowercase();
            let object = object_of(&name).filter(|_| name.len() == 4);
            if let Some((index @ 0x1000.., _)) = object
                && known.insert(index)
            {
                new.push((index, section.span));
            }
        }
        for (index, span) in new {
            let list = match index {
                0x1000 | 0x1001 | 0x1018 => LISTS[0],
                0x2000..=0x5FFF => LISTS[2],
                _ => LISTS[1],
            };
            if self.section(list).is_none() {
                let name = list.to_ascii_lowercase();
                self.places.insert(name, self.document.sections.len());
                self.document.sections.push(Section::new(list));
            }
            if let Some(section) = self.section(list) {
                section.keys.push(Key {
                    name: String::new().into(),
                    value: format!("0x{index:04X}").into(),
                    name_span: span,
                    span,
                });
            }
        }
        for list in LISTS {
            let Some(section) = self.section(list) else {
                continue;
            };
            section.keys.retain(|key| listed(key).is_some());
            for (number, key) in (1..).zip(&mut section.keys) {
                key.name = number.to_string().into();
            }
            let count = section.keys.len().to_string();
            section.put("SupportedObjects", count);
        }
    }

    /// Counts the sub-indices where some came or went.
    fn count_subs(&mut self) {
        let mut counts: HashMap<u16, usize> = HashMap::new();
        for name in self.places.keys() {
            if let Some((index, Some(_))) = object_of(name) {
                *counts.entry(index).or_default() += 1;
            }
        }
        for index in std::mem::take(&mut self.touched) {
            let count = counts.get(&index).copied().unwrap_or_default().to_string();
            if let Some(section) = self.section(&format!("{index:04x}"))
                && let Some(key) = key_of(section, "SubNumber")
            {
                key.value = count.into();
            }
        }
    }
}

/// The index that an element of a list names.
fn listed(key: &Key<'_>) -> Option<u16> {
    if key.name.eq_ignore_ascii_case("SupportedObjects") {
        return None;
    }
    u16::try_from(Number::parse(&key.value).ok()?.value).ok()
}

fn key_of<'s, 'a>(section: &'s mut Section<'a>, name: &str) -> Option<&'s mut Key<'a>> {
    let mut keys = section.keys.iter_mut();
    keys.find(|key| key.name.eq_ignore_ascii_case(name))
}

fn put<'a>(section: &mut Section<'a>, key: Key<'a>) {
    match key_of(section, &key.name) {
        Some(own) => *own = key,
        None => section.keys.push(key),
    }
}

/// Puts what a later section states over an earlier one.
fn overlay<'a>(section: &mut Section<'a>, more: Section<'a>) {
    section.also.push(more.lines);
    section.also.extend(more.also);
    let notes = |comments: &[Comment<'a>]| -> Vec<String> {
        let notes = comments.iter().filter_map(Comment::note);
        notes.map(|(name, _)| name.to_ascii_lowercase()).collect()
    };
    let stated = notes(&more.comments);
    section.comments.retain(|comment| {
        let note = comment.note().map(|(name, _)| name.to_ascii_lowercase());
        note.is_none_or(|name| !stated.contains(&name))
    });
    for key in more.keys {
        put(section, key);
    }
    let position = section.keys.len();
    let comments = more.lead.into_iter().chain(more.comments);
    section.comments.extend(comments.map(|comment| Comment {
        position,
        ..comment
    }));
}

/// A value of a recipe as a data sheet would have it; `$NAME` is that of the environment.
fn text(value: &Value, span: Span, findings: &mut Findings) -> Option<String> {
    Some(match value {
        Value::Integer(number) => number.to_string(),
        Value::Float(number) => format!("{number:?}"),
        Value::Boolean(is_set) => u8::from(*is_set).to_string(),
        Value::String(text) => match text.strip_prefix('$') {
            Some(name) if !name.to_ascii_uppercase().starts_with("NODEID") => {
                match env::var(name) {
                    Ok(value) if !value.contains(char::is_control) => value,
                    _ => {
                        let message = format!("the environment has no `{name}`");
                        let finding = findings.report(&rule::IDENTITY, span, message);
                        finding.help(format!("set it for the build: `{name}=0x402 od-gen ...`"));
                        return None;
                    }
                }
            }
            _ => text.clone(),
        },
        other => {
            let message = format!("a value is a number or a text, not {}", other.type_str());
            findings.report(&rule::IDENTITY, span, message);
            return None;
        }
    })
}
