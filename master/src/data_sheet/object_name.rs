//! How a person names an object: by its index, or as the data sheet calls it.

use std::fmt;

use super::DataSheet;

/// An index and a sub-index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Address {
    /// Index.
    pub index: u16,
    /// Sub-index.
    pub sub: u8,
}

impl Address {
    /// At this place.
    pub const fn new(index: u16, sub: u8) -> Self {
        Self { index, sub }
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04X}h:{:02X}", self.index, self.sub)
    }
}

impl DataSheet {
    /// Finds what a person means: `6064`, `6064h`, `0x6064`, `1018:4` and `1018h:04` by number (hexadecimal); `Position actual
    /// value`, `Identity object: Serial number` and, where only one value is called so, `Serial number` by name, in any case.
    ///
    /// # Errors
    /// Why it means nothing, or more than one thing.
    pub fn find(&self, text: &str) -> Result<Address, String> {
        match number(text) {
            Some(address) => Ok(address),
            None => self.find_name(text),
        }
    }

    fn find_name(&self, text: &str) -> Result<Address, String> {
        let wanted = plain(text);
        let (mut whole, mut alone) = (Vec::new(), Vec::new());
        for (object, entry) in self.model().entries() {
            let address = Address::new(object.index, entry.sub);
            let in_object = plain(&format!("{}: {}", object.name, entry.name));
            let is_only = object.entries.len() == 1;
            if in_object == wanted || is_only && plain(&object.name) == wanted {
                whole.push(address);
            } else if plain(&entry.name) == wanted {
                alone.push(address);
            }
        }
        let found = if whole.is_empty() { alone } else { whole };
        match *found {
            [address] => Ok(address),
            [] => Err(self.unknown(text, &wanted)),
            _ => {
                let all: Vec<String> = found.iter().take(SHOWN).map(Address::to_string).collect();
                let more = if found.len() > SHOWN { ", ..." } else { "" };
                Err(format!("`{text}` is {}{more}: which?", all.join(", ")))
            }
        }
    }

    fn unknown(&self, text: &str, wanted: &str) -> String {
        let names = self.model().objects.iter();
        let close = names
            .map(|object| (strsim::jaro_winkler(&plain(&object.name), wanted), object))
            .filter(|(likeness, _)| *likeness > 0.85)
            .max_by(|a, b| a.0.total_cmp(&b.0));
        match close {
            Some((_, object)) => format!(
                "there is no object `{text}`; {:04X}h is `{}`",
                object.index, object.name
            ),
            None => format!("there is no object `{text}` in {}", self.title()),
        }
    }
}

/// Places that are named when a name means several.
const SHOWN: usize = 6;

/// A name for comparing: small letters, one space between words.
fn plain(name: &str) -> String {
    let words = name.split(|letter: char| letter.is_whitespace() || matches!(letter, '_' | '-'));
    let words: Vec<String> = words
        .filter(|word| !word.is_empty())
        .map(str::to_lowercase)
        .collect();
    words.join(" ")
}

/// An address in digits, with or without a sub-index.
fn number(text: &str) -> Option<Address> {
    let (index, sub) = match text.split_once([':', '.']) {
        Some((index, sub)) => (index, u8::try_from(hexadecimal(sub)?).ok()?),
        None => (text, 0),
    };
    let has_four_digits = index
        .trim_matches(|letter: char| !letter.is_ascii_hexdigit())
        .len()
        >= 4;
    let index = u16::try_from(hexadecimal(index)?).ok()?;
    has_four_digits.then_some(Address { index, sub })
}

/// `6064`, `6064h` or `0x6064`.
fn hexadecimal(text: &str) -> Option<u32> {
    let text = text.trim();
    let digits = match text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
        Some(digits) => digits,
        None => text.strip_suffix(['h', 'H']).unwrap_or(text),
    };
    let is_number = !digits.is_empty() && digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    is_number.then(|| u32::from_str_radix(digits, 16).ok())?
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> Result<Address, String> {
        DataSheet::axis402().find(text)
    }

    #[test]
    fn an_object_has_its_number_in_any_spelling() {
        for text in [
            "6064",
            "6064h",
            "0x6064",
            "6064:0",
            "0x6064:0x00",
            "6064h.0",
        ] {
            assert_eq!(found(text), Ok(Address::new(0x6064, 0)), "{text}");
        }
        assert_eq!(found("1018:4"), Ok(Address::new(0x1018, 4)));
        // No data sheet has to know it.
        assert_eq!(found("2FFF:1F"), Ok(Address::new(0x2FFF, 0x1F)));
    }

    #[test]
    fn an_object_has_its_name_in_any_spelling() {
        for text in [
            "Position actual value",
            "position_actual_value",
            "POSITION  ACTUAL-VALUE",
        ] {
            assert_eq!(found(text), Ok(Address::new(0x6064, 0)), "{text}");
        }
        assert_eq!(found("revision number"), Ok(Address::new(0x1018, 3)));
        assert_eq!(
            found("Identity object: Serial number"),
            Ok(Address::new(0x1018, 4))
        );
    }

    #[test]
    fn what_means_nothing_or_too_much_is_told() {
        let refused = found("Position actual valu").unwrap_err();
        assert_eq!(
            refused,
            "there is no object `Position actual valu`; 6064h is `Position actual value`"
        );
        let refused = found("flux capacitor").unwrap_err();
        assert_eq!(
            refused,
            "there is no object `flux capacitor` in axis402.eds"
        );
        let refused = found("Inhibit time").unwrap_err();
        assert!(
            refused.starts_with("`Inhibit time` is 1800h:03, 1801h:03, "),
            "{refused}"
        );
        for text in ["60640", "6064:100", "6064:", "64", ""] {
            assert!(found(text).is_err(), "{text}");
        }
    }
}
