//! Objects as bindings name them: `2054h`, `2054h:1`, `2100h-21FFh`.

use std::ops::RangeInclusive;

/// Index and sub-index: `2054h`, `0x2054`, `2054h:1`.
pub(crate) fn entry(text: &str) -> Option<(u16, u8)> {
    let (index, sub) = match text.split_once(':') {
        Some((index, sub)) => (index, hexadecimal(sub)?),
        None => (text, 0),
    };
    Some((
        u16::try_from(hexadecimal(index)?).ok()?,
        u8::try_from(sub).ok()?,
    ))
}

/// Indices: `2054h`, `2100h-21FFh`.
pub(crate) fn indices(text: &str) -> Option<RangeInclusive<u16>> {
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    let index = |text: &str| u16::try_from(hexadecimal(text)?).ok();
    let (first, last) = (index(first)?, index(last)?);
    (first <= last).then_some(first..=last)
}

/// A hexadecimal number, with or without its mark.
fn hexadecimal(text: &str) -> Option<u32> {
    let text = text.trim();
    let digits = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X"));
    let digits = digits.or_else(|| text.strip_suffix(['h', 'H']));
    let digits = digits.unwrap_or(text);
    if digits.starts_with('+') {
        return None;
    }
    u32::from_str_radix(digits, 16).ok()
}

/// An entry as people write it.
pub(super) fn name((index, sub): (u16, u8)) -> String {
    if sub == 0 {
        format!("{index:04X}h")
    } else {
        format!("{index:04X}h:{sub:X}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_are_named_as_people_do() {
        for text in ["2054h", "0x2054", "2054", " 2054H "] {
            assert_eq!(entry(text), Some((0x2054, 0)), "{text}");
        }
        assert_eq!(entry("2054h:1A"), Some((0x2054, 0x1A)));
        for text in ["", "h", "2054h:", "2054h:100", "12054h", "speed", "+2054"] {
            assert_eq!(entry(text), None, "{text}");
        }
        assert_eq!(indices("2100h-21FFh"), Some(0x2100..=0x21FF));
        assert_eq!(indices("2100h"), Some(0x2100..=0x2100));
        assert_eq!(indices("2200h-2100h"), None);
        assert_eq!(name((0x2054, 0)), "2054h");
        assert_eq!(name((0x2054, 26)), "2054h:1A");
    }
}
