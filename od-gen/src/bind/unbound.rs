//! Objects of the manufacturer that no line of a binding mentions.

use std::ops::RangeInclusive;

use super::file::File;
use super::place::entry;
use crate::diagnostic::Findings;
use crate::model::{Model, Object};
use crate::rules::binding;
use crate::source::Span;

/// The manufacturer's area (CiA 301, table 39).
const MANUFACTURER: RangeInclusive<u16> = 0x2000..=0x5FFF;

/// The objects of the manufacturer that no line of the file mentions, which is reported.
pub(super) fn unbound(
    file: &File,
    model: &Model,
    storage: Vec<RangeInclusive<u16>>,
    findings: &mut Findings,
) -> Vec<u16> {
    let mut known: Vec<RangeInclusive<u16>> = file
        .binding
        .iter()
        .filter_map(|row| entry(row.get_ref().object.get_ref()))
        .map(|(index, _)| index..=index)
        .collect();
    let words = file.word.iter().map(|row| row.get_ref().object.get_ref());
    let masks = file.mask.iter().map(|row| row.get_ref().object.get_ref());
    let made = words.chain(masks).filter_map(|object| entry(object));
    known.extend(made.map(|(index, _)| index..=index));
    let bound = known.clone();
    known.extend(storage);
    let is_in = |ranges: &[RangeInclusive<u16>], object: &Object| {
        ranges.iter().any(|range| range.contains(&object.index))
    };
    let own = model.objects_in(MANUFACTURER);
    let silent: Vec<&Object> = own.iter().filter(|object| !is_in(&known, object)).collect();
    if let Some(first) = silent.first() {
        let count = silent.len();
        let message = format!(
            "{count} objects of the manufacturer are plain storage, the first is {:04X}h, {}",
            first.index, first.name
        );
        let finding = findings.report(&binding::UNBOUND, Span::START, message);
        let list: Vec<String> = silent
            .iter()
            .map(|object| format!("{:04X}h", object.index))
            .collect();
        finding.help(format!(
            "bind them or list them in [storage]: {}",
            list.join(", ")
        ));
    }
    let stored = own.iter().filter(|object| !is_in(&bound, object));
    stored.map(|object| object.index).collect()
}
