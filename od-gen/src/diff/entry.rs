//! What two values mean differently.

use super::text;
use super::{Differences, Place};
use crate::model::{DefaultValue, Entry, Limit};

pub(super) fn compare(place: &Place, before: &Entry, after: &Entry, out: &mut Differences) {
    let (first, second) = (before.data_type.name(), after.data_type.name());
    out.change(place, "DataType", first, second, true);
    let (first, second) = (before.access, after.access);
    let is_less = (first.is_writable() && !second.is_writable())
        || (first.is_readable() && !second.is_readable());
    out.change(place, "AccessType", first.name(), second.name(), is_less);

    let breaks = (before.is_rpdo_mappable() && !after.is_rpdo_mappable())
        || (before.is_tpdo_mappable() && !after.is_tpdo_mappable());
    let flag = |entry: &Entry| if entry.pdo_mapping { "1" } else { "0" };
    out.change(place, "PDOMapping", flag(before), flag(after), breaks);

    // A limit as wide as the type is none.
    let stated = |entry: &Entry| {
        let range = entry.data_type.range();
        let keep = |limit: Option<Limit>, own: Option<i128>| {
            limit.filter(|limit| limit.integer().is_none() || limit.integer() != own)
        };
        (
            keep(entry.low_limit, range.map(|range| range.0)),
            keep(entry.high_limit, range.map(|range| range.1)),
        )
    };
    let ((low, high), (new_low, new_high)) = (stated(before), stated(after));
    let is_narrower = |before: Option<Limit>, after: Option<Limit>, order: std::cmp::Ordering| {
        let Some(after) = after else { return false };
        before.is_none_or(|before| after.partial_cmp(&before) == Some(order))
    };
    let breaks = is_narrower(low, new_low, std::cmp::Ordering::Greater);
    out.change(
        place,
        "LowLimit",
        &text::limit(low),
        &text::limit(new_low),
        breaks,
    );
    let breaks = is_narrower(high, new_high, std::cmp::Ordering::Less);
    out.change(
        place,
        "HighLimit",
        &text::limit(high),
        &text::limit(new_high),
        breaks,
    );

    let value = |entry: &Entry, value: &Option<DefaultValue>| {
        let value = value.as_ref();
        value.map_or_else(String::new, |value| text::default(value, entry.data_type))
    };
    let default = |entry: &Entry| value(entry, &entry.default);
    out.change(
        place,
        "DefaultValue",
        &default(before),
        &default(after),
        false,
    );
    let configured = |entry: &Entry| value(entry, &entry.configured);
    out.change(
        place,
        "ParameterValue",
        &configured(before),
        &configured(after),
        false,
    );

    let is_shorter = before.data_type == after.data_type && after.size < before.size;
    // The length of everything else is that of its type or its default.
    if before.data_type.size().is_none()
        && before.access.is_writable()
        && after.access.is_writable()
    {
        let (first, second) = (before.size.to_string(), after.size.to_string());
        out.change(place, "Capacity", &first, &second, is_shorter);
    }
    let flags = |entry: &Entry| format!("0x{:X}", entry.flags);
    out.change(place, "ObjFlags", &flags(before), &flags(after), false);
    let group = |entry: &Entry| entry.storage.map_or("none", |group| group.name());
    out.change(place, "Storage", group(before), group(after), false);
    let memory = |entry: &Entry| match entry.is_with_application {
        true => "application",
        false => "dictionary",
    };
    out.change(place, "Memory", memory(before), memory(after), false);
    let unit = |entry: &Entry| entry.unit().unwrap_or_default().to_owned();
    out.change(
        place,
        "Unit",
        &unit(before),
        &unit(after),
        !unit(before).is_empty(),
    );
    let text = |text: &Option<String>| text.clone().unwrap_or_default();
    for (key, before, after) in [
        ("Denotation", &before.denotation, &after.denotation),
        ("UploadFile", &before.upload_file, &after.upload_file),
        ("DownloadFile", &before.download_file, &after.download_file),
    ] {
        out.change(place, key, &text(before), &text(after), false);
    }
}
