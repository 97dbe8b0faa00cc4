//! Values in text: defaults, limits, what a DCF configures.

use crate::data_type::DataType;
use crate::diagnostic::Findings;
use crate::model::{DefaultValue, Limit};
use crate::number::{DefaultNumber, Number};
use crate::rules::{Rule, value as rule};
use crate::source::Span;

/// The largest node-ID: the most that $NODEID adds.
pub(super) const LARGEST_NODE_ID: i128 = 127;

/// A text with its place: what is read here, and what the findings are about.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Written<'a> {
    /// The key.
    pub(crate) key: &'a str,
    pub(crate) text: &'a str,
    pub(crate) span: Span,
}

/// Reads LowLimit or HighLimit; `None` where it is wrong or means nothing, which has been reported.
pub(super) fn limit(
    written: Written<'_>,
    data_type: DataType,
    findings: &mut Findings,
) -> Option<Limit> {
    if data_type.is_real() {
        return real(written, data_type, findings).map(Limit::Real);
    }
    if data_type.range().is_none() {
        let message = format!("{} does not go with {}", written.key, data_type.name());
        findings.report(&rule::LIMIT_OF_NO_NUMBER, written.span, message);
        return None;
    }
    let parsed = findings.take(
        &rule::NOT_A_NUMBER,
        written.span,
        DefaultNumber::parse(written.text),
    );
    let DefaultNumber {
        number,
        adds_node_id,
    } = parsed.or_else(|| DefaultNumber::meant(written.text))?;
    let nearest = |value: i128, (low, high)| value.clamp(low, high);
    let value = fit(
        number,
        data_type,
        written,
        (&rule::LIMIT_TYPE, nearest),
        findings,
    )?;
    if !adds_node_id {
        return Some(Limit::Integer(value));
    }
    let message = format!("{} {} differs from node to node", written.key, written.text);
    findings.report(&rule::LIMIT_OF_NODE, written.span, message);
    // The file has it; a generated dictionary does not.
    (!findings.is_for_code()).then_some(Limit::NodeId(value))
}

/// Reads a default, or what a DCF configures; `None` where it is wrong or means nothing, which has been reported.
pub(crate) fn value(
    written: Written<'_>,
    data_type: DataType,
    findings: &mut Findings,
) -> Option<DefaultValue> {
    match data_type {
        DataType::Domain => {
            let message = format!("{} of a DOMAIN means nothing", written.key);
            findings.report(&rule::VALUE_OF_A_DOMAIN, written.span, message);
            None
        }
        DataType::Real32 | DataType::Real64 => {
            real(written, data_type, findings).map(DefaultValue::Real)
        }
        DataType::VisibleString => {
            let is_visible = |letter: char| (' '..='~').contains(&letter);
            if !written.text.chars().all(is_visible) {
                let message = "a VISIBLE_STRING holds the characters 20h to 7Eh";
                findings.report(&rule::STRING, written.span, message);
            }
            Some(DefaultValue::Text(written.text.as_bytes().to_vec()))
        }
        DataType::UnicodeString => {
            let units = written.text.encode_utf16().flat_map(u16::to_le_bytes);
            Some(DefaultValue::Text(units.collect()))
        }
        DataType::OctetString => Some(octets(written, findings)),
        _ => number(written, data_type, findings),
    }
}

fn number(
    written: Written<'_>,
    data_type: DataType,
    findings: &mut Findings,
) -> Option<DefaultValue> {
    let Written { key, text, span } = written;
    let parsed = DefaultNumber::parse(text);
    let DefaultNumber {
        number,
        adds_node_id,
    } = findings
        .take(&rule::NOT_A_NUMBER, span, parsed)
        .or_else(|| DefaultNumber::meant(text))?;
    let lowest_bits = |value: i128, (low, high): (i128, i128)| match data_type {
        DataType::Boolean => value.signum().abs(),
        _ => low + (value - low).rem_euclid(high - low + 1),
    };
    let value = fit(
        number,
        data_type,
        written,
        (&rule::DEFAULT_TYPE, lowest_bits),
        findings,
    )?;
    if !adds_node_id {
        return Some(DefaultValue::number(value));
    }
    if data_type.is_signed() || data_type == DataType::Boolean {
        let message = format!("$NODEID does not go with {}", data_type.name());
        findings.report(&rule::NODE_ID_TYPE, span, message);
        return Some(DefaultValue::number(value));
    }
    let high = data_type.range().map_or(0, |(_, high)| high);
    if value + LARGEST_NODE_ID > high {
        let message = format!("{key} {text} leaves no room for the node-ID");
        findings.report(&rule::NODE_ID_ROOM, span, message);
    }
    Some(DefaultValue::Number {
        value,
        adds_node_id,
    })
}

/// A number as the type reads it: 0xFFFF is -1 in an INTEGER16. One that does not fit breaks a rule; what is made of it, given the
/// ends of the type, counts where that is allowed.
fn fit(
    number: Number,
    data_type: DataType,
    written: Written<'_>,
    (rule, made): (&'static Rule, impl Fn(i128, (i128, i128)) -> i128),
    findings: &mut Findings,
) -> Option<i128> {
    let (low, high) = data_type.range()?;
    let patterns = high - low + 1;
    let is_negative_pattern =
        number.is_pattern && data_type.is_signed() && (high + 1..patterns).contains(&number.value);
    let value = if is_negative_pattern {
        number.value - patterns
    } else {
        number.value
    };
    if (low..=high).contains(&value) {
        return Some(value);
    }
    let (Written { key, text, span }, name) = (written, data_type.name());
    let message = format!("{key} {text} does not fit {name} ({low} to {high})");
    findings.report(rule, span, message);
    findings.allowed(rule, span, made(value, (low, high)))
}

/// A REAL number: decimal, or its bits in hexadecimal.
fn real(written: Written<'_>, data_type: DataType, findings: &mut Findings) -> Option<f64> {
    let text = written.text;
    let is_pattern = text.starts_with("0x") || text.starts_with("0X");
    let value = if is_pattern {
        let bits = Number::parse(text).ok().map(|number| number.value);
        match data_type {
            DataType::Real32 => bits
                .and_then(|bits| u32::try_from(bits).ok())
                .map(|bits| f32::from_bits(bits).into()),
            _ => bits
                .and_then(|bits| u64::try_from(bits).ok())
                .map(f64::from_bits),
        }
    } else if data_type == DataType::Real32 {
        // Rounded once: what the firmware will hold.
        text.parse::<f32>().ok().map(f64::from)
    } else {
        text.parse::<f64>().ok()
    };
    let value = value.filter(|value| value.is_finite());
    if value.is_none() {
        let message = format!("`{text}` is not a {}", data_type.name());
        let finding = findings.report(&rule::NOT_A_NUMBER, written.span, message);
        finding.help("write a decimal number such as 1.5, or its bits in hexadecimal");
    }
    value
}

fn octets(written: Written<'_>, findings: &mut Findings) -> DefaultValue {
    let digits: Vec<u8> = written.text.bytes().filter(|byte| *byte != b' ').collect();
    let pairs = digits.chunks_exact(2);
    let is_whole = pairs.remainder().is_empty();
    let bytes =
        pairs.map(|pair| Some(hexadecimal(pair.first()?)? * 16 + hexadecimal(pair.last()?)?));
    let bytes = bytes.collect::<Option<Vec<u8>>>().filter(|_| is_whole);
    DefaultValue::Text(bytes.unwrap_or_else(|| {
        let text = written.text;
        let message = format!("`{text}` is not an OCTET_STRING: two hexadecimal digits a byte");
        findings.report(&rule::OCTET_STRING, written.span, message);
        text.as_bytes().to_vec()
    }))
}

fn hexadecimal(digit: &u8) -> Option<u8> {
    char::from(*digit).to_digit(16)?.try_into().ok()
}
