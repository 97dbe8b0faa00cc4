//! One value: type, access, limits, default.

use super::LARGEST_VALUE;
use crate::data_type::DataType;
use crate::diagnostic::Findings;
use crate::ini::{Key, Section};
use crate::model::{Access, DefaultValue, Entry};
use crate::number::{DefaultNumber, Number};

/// The keys that describe a value.
pub(super) const ENTRY_KEYS: [&str; 9] = [
    "ParameterName",
    "ObjectType",
    "DataType",
    "AccessType",
    "PDOMapping",
    "LowLimit",
    "HighLimit",
    "DefaultValue",
    "ObjFlags",
];

/// Characters that a string can hold when neither its default nor a comment asks for more.
const LEAST_CAPACITY: u16 = 32;

/// The largest node-ID: the most that $NODEID adds.
const LARGEST_NODE_ID: i128 = 127;

/// Reads a section; `None` when something in it is wrong, which has then been reported.
pub(super) fn read(section: &Section, sub: u8, findings: &mut Findings) -> Option<Entry> {
    let name = parameter_name(section, findings);
    let data_type =
        required(section, "DataType", findings).and_then(|key| data_type(key, findings));
    let access = required(section, "AccessType", findings).and_then(|key| access(key, findings));
    let pdo_mapping = pdo_mapping(section, data_type, findings);
    check_object_flags(section, findings);
    let (name, data_type, access, pdo_mapping) = (name?, data_type?, access?, pdo_mapping?);

    let low_limit = limit(section, "LowLimit", data_type, findings);
    let high_limit = limit(section, "HighLimit", data_type, findings);
    let default = match data_type.range() {
        Some(range) => default_number(section, data_type, range, findings),
        None => default_text(section, data_type, findings),
    };
    let (low_limit, high_limit, default) = (low_limit?, high_limit?, default?);
    check_limits(section, (low_limit, high_limit), &default, findings)?;
    if access == Access::Constant
        && section.key("DefaultValue").is_none()
        && data_type.size().is_some()
    {
        findings.error(
            section.line,
            format!("[{}] is const: it needs a DefaultValue", section.name),
        );
        return None;
    }
    let size = size(section, data_type, access, &default, findings)?;
    let (name, line) = (name.value.clone(), section.line);
    Some(Entry {
        sub,
        name,
        data_type,
        access,
        pdo_mapping,
        low_limit,
        high_limit,
        default,
        size,
        line,
    })
}

/// A key that must be there.
fn required<'a>(section: &'a Section, name: &str, findings: &mut Findings) -> Option<&'a Key> {
    let key = section.key(name);
    if key.is_none() {
        findings.error(
            section.line,
            format!("`{name}` is missing in [{}]", section.name),
        );
    }
    key
}

/// The name of an object or a sub-index. It becomes a name in Rust, so there must be something in it to make one of.
pub(super) fn parameter_name<'a>(section: &'a Section, findings: &mut Findings) -> Option<&'a Key> {
    let key = required(section, "ParameterName", findings)?;
    if !key
        .value
        .contains(|letter: char| letter.is_ascii_alphanumeric())
    {
        findings.error(
            key.line,
            format!(
                "ParameterName `{}` has none of the letters A to Z and no digit",
                key.value
            ),
        );
    }
    Some(key)
}

/// ObjFlags tell configuration tools what to leave out; the device has no use for them.
pub(super) fn check_object_flags(section: &Section, findings: &mut Findings) {
    if let Some(key) = section.key("ObjFlags") {
        findings.take(
            key.line,
            Number::parse_within(&key.value, 0, u32::MAX.into()),
        );
    }
}

fn data_type(key: &Key, findings: &mut Findings) -> Option<DataType> {
    let code = findings.take(key.line, Number::parse(&key.value))?.value;
    let data_type = DataType::from_code(code);
    if data_type.is_none() {
        let supported: Vec<&str> = DataType::ALL
            .iter()
            .map(|data_type| data_type.name())
            .collect();
        let message = format!(
            "DataType {} is not supported (supported: {})",
            key.value,
            supported.join(", ")
        );
        findings.error(key.line, message);
    }
    data_type
}

fn access(key: &Key, findings: &mut Findings) -> Option<Access> {
    let access = Access::from_name(&key.value);
    if access.is_none() {
        findings.error(
            key.line,
            format!(
                "AccessType `{}` is not ro, wo, rw, rwr, rww or const",
                key.value
            ),
        );
    }
    access
}

fn pdo_mapping(
    section: &Section,
    data_type: Option<DataType>,
    findings: &mut Findings,
) -> Option<bool> {
    let Some(key) = section.key("PDOMapping") else {
        return Some(false);
    };
    let is_mappable = findings.take(key.line, Number::parse_within(&key.value, 0, 1))? == 1;
    if is_mappable && data_type.is_some_and(|data_type| data_type.size().is_none()) {
        findings.error(key.line, "PDOMapping of a string is not supported");
        return None;
    }
    Some(is_mappable)
}

/// A limit, `None` inside where the type has none narrower than itself.
fn limit(
    section: &Section,
    name: &str,
    data_type: DataType,
    findings: &mut Findings,
) -> Option<Option<i64>> {
    let Some(key) = section.key(name) else {
        return Some(None);
    };
    let Some(range) = data_type.range() else {
        findings.error(
            key.line,
            format!("{name} does not go with {}", data_type.name()),
        );
        return None;
    };
    let number = findings.take(key.line, Number::parse(&key.value))?;
    let value = findings.take(key.line, fit(number, data_type, range, name, &key.value))?;
    let own = if name == "LowLimit" { range.0 } else { range.1 };
    if value == own {
        return Some(None);
    }
    // The firmware keeps limits in 64 signed bits, of which the largest means none.
    match i64::try_from(value).ok().filter(|value| *value < i64::MAX) {
        Some(value) => Some(Some(value)),
        None => {
            findings.error(
                key.line,
                format!(
                    "{name} {} is not supported: limits stay below 2^63-1",
                    key.value
                ),
            );
            None
        }
    }
}

/// A number as the type reads it: 0xFFFF is -1 in an INTEGER16.
fn fit(
    number: Number,
    data_type: DataType,
    range: (i128, i128),
    what: &str,
    text: &str,
) -> Result<i128, String> {
    let (low, high) = range;
    let patterns = high - low + 1;
    let is_negative_pattern =
        number.is_pattern && data_type.is_signed() && (high + 1..patterns).contains(&number.value);
    let value = if is_negative_pattern {
        number.value - patterns
    } else {
        number.value
    };
    if (low..=high).contains(&value) {
        Ok(value)
    } else {
        Err(format!(
            "{what} {text} does not fit {} ({low} to {high})",
            data_type.name()
        ))
    }
}

fn default_number(
    section: &Section,
    data_type: DataType,
    range: (i128, i128),
    findings: &mut Findings,
) -> Option<DefaultValue> {
    let Some(key) = section.key("DefaultValue") else {
        return Some(DefaultValue::Number {
            value: 0,
            adds_node_id: false,
        });
    };
    let DefaultNumber {
        number,
        adds_node_id,
    } = findings.take(key.line, DefaultNumber::parse(&key.value))?;
    if adds_node_id && (data_type.is_signed() || data_type == DataType::Boolean) {
        findings.error(
            key.line,
            format!("$NODEID does not go with {}", data_type.name()),
        );
        return None;
    }
    let value = findings.take(
        key.line,
        fit(number, data_type, range, "DefaultValue", &key.value),
    )?;
    if adds_node_id && value + LARGEST_NODE_ID > range.1 {
        findings.error(
            key.line,
            format!("DefaultValue {} leaves no room for the node-ID", key.value),
        );
        return None;
    }
    Some(DefaultValue::Number {
        value,
        adds_node_id,
    })
}

fn default_text(
    section: &Section,
    data_type: DataType,
    findings: &mut Findings,
) -> Option<DefaultValue> {
    let Some(key) = section.key("DefaultValue") else {
        return Some(DefaultValue::Text(Vec::new()));
    };
    if data_type == DataType::VisibleString {
        let is_visible = key.value.bytes().all(|byte| (0x20..=0x7E).contains(&byte));
        if !is_visible {
            findings.error(key.line, "a VISIBLE_STRING holds the characters 20h to 7Eh");
            return None;
        }
        return Some(DefaultValue::Text(key.value.as_bytes().to_vec()));
    }
    let digits: Vec<u8> = key.value.bytes().filter(|byte| *byte != b' ').collect();
    let pairs = digits.chunks_exact(2);
    let is_whole = pairs.remainder().is_empty();
    let bytes =
        pairs.map(|pair| Some(hexadecimal(pair.first()?)? * 16 + hexadecimal(pair.last()?)?));
    match bytes.collect::<Option<Vec<u8>>>().filter(|_| is_whole) {
        Some(bytes) => Some(DefaultValue::Text(bytes)),
        None => {
            findings.error(
                key.line,
                format!(
                    "`{}` is not an OCTET_STRING: two hexadecimal digits a byte",
                    key.value
                ),
            );
            None
        }
    }
}

fn hexadecimal(digit: &u8) -> Option<u8> {
    char::from(*digit).to_digit(16)?.try_into().ok()
}

/// The limits leave room, and the default is in it with every node-ID.
fn check_limits(
    section: &Section,
    (low, high): (Option<i64>, Option<i64>),
    default: &DefaultValue,
    findings: &mut Findings,
) -> Option<()> {
    let DefaultValue::Number {
        value,
        adds_node_id,
    } = *default
    else {
        return Some(());
    };
    if let (Some(low), Some(high)) = (low, high)
        && low > high
    {
        findings.error(
            section.line,
            format!("LowLimit {low} is above HighLimit {high}"),
        );
        return None;
    }
    let (least, most) = if adds_node_id {
        (value + 1, value + LARGEST_NODE_ID)
    } else {
        (value, value)
    };
    let key = section.key("DefaultValue");
    let line = key.map_or(section.line, |key| key.line);
    let text = key.map_or("0 (there is none)", |key| &key.value);
    if let Some(low) = low.filter(|low| least < i128::from(*low)) {
        findings.error(line, format!("DefaultValue {text} is below LowLimit {low}"));
        return None;
    }
    if let Some(high) = high.filter(|high| most > i128::from(*high)) {
        findings.error(
            line,
            format!("DefaultValue {text} is above HighLimit {high}"),
        );
        return None;
    }
    Some(())
}

/// The bytes a value takes; of a string that can be written, its capacity.
fn size(
    section: &Section,
    data_type: DataType,
    access: Access,
    default: &DefaultValue,
    findings: &mut Findings,
) -> Option<u16> {
    let capacity = capacity(section, findings)?;
    let DefaultValue::Text(text) = default else {
        if let Some((line, _)) = capacity {
            findings.error(
                line,
                format!("Capacity does not go with {}", data_type.name()),
            );
        }
        return data_type.size();
    };
    let length = u16::try_from(text.len()).unwrap_or(u16::MAX);
    let (line, size) = match capacity {
        Some((line, _)) if !access.is_writable() => {
            findings.error(line, "Capacity of a string that cannot be written");
            return None;
        }
        Some((line, capacity)) if capacity < length => {
            findings.error(
                line,
                format!("Capacity {capacity} is less than the {length} bytes of the default"),
            );
            return None;
        }
        Some((line, capacity)) => (line, capacity),
        None if access.is_writable() => (section.line, length.max(LEAST_CAPACITY)),
        None => (section.line, length),
    };
    if size > LARGEST_VALUE {
        findings.error(
            line,
            format!(
                "[{}] takes {size} bytes, an SDO transfer carries {LARGEST_VALUE}",
                section.name
            ),
        );
        return None;
    }
    Some(size)
}

/// The comment `;Capacity=64` with its line. CIA 306 has no key for it, and tools complain about keys that are not in it.
fn capacity(section: &Section, findings: &mut Findings) -> Option<Option<(usize, u16)>> {
    for comment in &section.comments {
        let Some((name, value)) = comment.text.split_once('=') else {
            continue;
        };
        if name.trim().eq_ignore_ascii_case("Capacity") {
            let capacity = Number::parse_within(value.trim(), 1, LARGEST_VALUE.into());
            let capacity = findings.take(
                comment.line,
                capacity.map_err(|why| format!("Capacity: {why}")),
            )?;
            return Some(Some((
                comment.line,
                u16::try_from(capacity).unwrap_or(LARGEST_VALUE),
            )));
        }
    }
    Some(None)
}
