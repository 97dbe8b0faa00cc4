//! How the cases write frames: `604: 40 00 10 00` is a data frame with identifier 604h and eight bytes, those not written being
//! zero; `000 [2] 01 04` gives the length. Bytes may be written together: `604: 23001801 C0000184`. In what is expected, `xx` stands for any
//! byte and `..` for any rest.
//! `604 [8] rtr` is a remote frame, and an identifier of more than three digits is a 29-bit one.

use canopen::Frame;
use embedded_can::{ExtendedId, Frame as _, Id, StandardId};

/// A frame as a case writes it. Panics on a spelling mistake: the case is wrong, not the device.
pub fn frame(text: &str) -> Frame {
    let pattern = Pattern::new(text);
    assert!(
        !pattern.any_rest && pattern.bytes.iter().all(Option::is_some),
        "a frame to send has no wildcards: {text}"
    );
    let length = pattern.length.unwrap_or(8);
    if pattern.remote {
        return Frame::new_remote(pattern.id, length).unwrap();
    }
    let mut bytes = [0; 8];
    for (to, from) in bytes.iter_mut().zip(&pattern.bytes) {
        *to = from.unwrap();
    }
    Frame::new(pattern.id, &bytes[..length]).unwrap()
}

/// A frame that is expected, with wildcards.
#[derive(Clone, Debug)]
pub struct Pattern {
    text: String,
    id: Id,
    remote: bool,
    length: Option<usize>,
    bytes: Vec<Option<u8>>,
    any_rest: bool,
}

impl Pattern {
    /// Reads the notation.
    pub fn new(text: &str) -> Self {
        let mut words = text.split_whitespace();
        let id_text = words
            .next()
            .unwrap_or_else(|| panic!("an empty frame"))
            .trim_end_matches(':');
        let number = u32::from_str_radix(id_text, 16)
            .unwrap_or_else(|_| panic!("not an identifier: {text}"));
        let id = if id_text.len() > 3 {
            Id::Extended(ExtendedId::new(number).unwrap())
        } else {
            Id::Standard(StandardId::new(u16::try_from(number).unwrap()).unwrap())
        };
        let mut pattern = Self {
            text: text.into(),
            id,
            remote: false,
            length: None,
            bytes: Vec::new(),
            any_rest: false,
        };
        for word in words {
            if let Some(length) = word
                .strip_prefix('[')
                .and_then(|word| word.strip_suffix(']'))
            {
                pattern.length = Some(length.parse().unwrap());
            } else if word == "rtr" {
                pattern.remote = true;
            } else if word == "xx" {
                pattern.bytes.push(None);
            } else if word == ".." {
                pattern.any_rest = true;
            } else {
                for place in (0..word.len()).step_by(2) {
                    let byte = word
                        .get(place..place + 2)
                        .and_then(|byte| u8::from_str_radix(byte, 16).ok())
                        .unwrap_or_else(|| panic!("not a byte: {word} in {text}"));
                    pattern.bytes.push(Some(byte));
                }
            }
        }
        pattern
    }

    /// Whether a frame is the one expected.
    pub fn matches(&self, frame: &Frame) -> bool {
        if frame.id() != self.id || frame.is_remote() != self.remote {
            return false;
        }
        let payload = frame.payload();
        if !self.remote && payload.len() != self.length.unwrap_or(8) {
            return false;
        }
        payload
            .iter()
            .enumerate()
            .all(|(position, byte)| match self.bytes.get(position) {
                Some(expected) => expected.is_none_or(|expected| expected == *byte),
                None => self.any_rest || *byte == 0,
            })
    }
}

impl std::fmt::Display for Pattern {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.text)
    }
}

/// A frame in the notation of the cases, with all of its bytes.
pub fn show(frame: &Frame) -> String {
    let id = match frame.id() {
        Id::Standard(id) => format!("{:03X}", id.as_raw()),
        Id::Extended(id) => format!("{:08X}", id.as_raw()),
    };
    if frame.is_remote() {
        return format!("{id} [{}] rtr", frame.length());
    }
    let bytes: Vec<String> = frame
        .payload()
        .iter()
        .map(|byte| format!("{byte:02X}"))
        .collect();
    let bytes = bytes.join(" ");
    match frame.length() {
        0 => format!("{id} [0]"),
        8 => format!("{id}: {bytes}"),
        length => format!("{id} [{length}] {bytes}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_text_is_padded_with_zeros() {
        assert_eq!(
            frame("604: 40 00 10").bytes(),
            &[0x40, 0, 0x10, 0, 0, 0, 0, 0]
        );
        assert_eq!(frame("604: 40 00 10").length(), 8);
    }

    #[test]
    fn a_length_in_brackets_is_kept() {
        assert_eq!(frame("000 [2] 01 04").payload(), [1, 4]);
        assert!(frame("080 [0]").payload().is_empty());
    }

    #[test]
    fn wildcards_match_any_byte_but_the_rest_must_be_zero() {
        let pattern = Pattern::new("584: 43 xx 10");
        assert!(pattern.matches(&frame("584: 43 17 10")));
        assert!(!pattern.matches(&frame("584: 43 17 10 01")));
        assert!(Pattern::new("584: 43 ..").matches(&frame("584: 43 17 10 01")));
        assert!(!pattern.matches(&frame("585: 43 17 10")));
    }

    #[test]
    fn frames_are_shown_as_they_are_written() {
        assert_eq!(show(&frame("000 [2] 01 04")), "000 [2] 01 04");
        assert_eq!(show(&frame("604 [0] rtr")), "604 [0] rtr");
        assert_eq!(show(&frame("080 [0]")), "080 [0]");
        assert_eq!(
            show(&frame("18000004: 0123")),
            "18000004: 01 23 00 00 00 00 00 00"
        );
    }
}
