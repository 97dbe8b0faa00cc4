//! The text of a file, and places in it.
//!
//! Vendors ship files in UTF-8 with and without byte order mark, in Latin-1, in Windows-1252 and in UTF-16, with any line ends. All of
//! them are read; what is not plain UTF-8 is reported, so that nobody wonders later where a letter went.

use std::borrow::Cow;
use std::mem;

use crate::diagnostic::Findings;
use crate::rules::reading;

/// A place in a file: a piece of one line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Span {
    /// Line, counted from 1; 0 for a place that is in no file.
    pub line: u32,
    /// First character, counted from 1.
    pub column: u32,
    /// Characters.
    pub length: u32,
}

impl Span {
    /// The beginning of a file, where what concerns the whole of it is reported.
    pub const START: Self = Self {
        line: 1,
        column: 1,
        length: 0,
    };

    /// The place of `part`, which is a piece of `line`.
    pub(crate) fn of(number: u32, line: &str, part: &str) -> Self {
        let at = (part.as_ptr() as usize).saturating_sub(line.as_ptr() as usize);
        let before = line.get(..at).unwrap_or_default();
        Self {
            line: number,
            column: count(before).saturating_add(1),
            length: count(part),
        }
    }
}

/// Whether the name of a file ends with this, capital and small letters being equal.
pub(crate) fn has_extension(file: &str, wanted: &str) -> bool {
    let extension = file.rsplit_once('.').map_or("", |(_, extension)| extension);
    extension.eq_ignore_ascii_case(wanted)
}

fn count(text: &str) -> u32 {
    u32::try_from(text.chars().count()).unwrap_or(u32::MAX)
}

/// A file as text: what the findings about it show.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Source {
    /// The file as its reader named it.
    pub file: String,
    text: String,
    /// Where each line begins.
    lines: Vec<usize>,
    /// The other files that a recipe is made of.
    parts: Vec<Source>,
}

impl Source {
    /// A text that is at hand.
    pub(crate) fn new(file: &str, text: &str, findings: &mut Findings) -> Self {
        // Editors on Windows like to put a byte order mark first.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let text = visible(&line_ends(text), findings).into_owned();
        let starts = text.match_indices('\n').map(|(at, _)| at + 1);
        let lines = std::iter::once(0).chain(starts).collect();
        let file = file.into();
        let parts = Vec::new();
        Self {
            file,
            text,
            lines,
            parts,
        }
    }

    /// The bytes of a file; `None` when they are no text, which has then been reported.
    pub(crate) fn decode(file: &str, bytes: &[u8], findings: &mut Findings) -> Option<Self> {
        if let Some(text) = utf_16(bytes) {
            let message = "this is not UTF-8: the file is read as UTF-16";
            let finding = findings.report(&reading::NOT_UTF_8, Span::START, message);
            finding.help("save the file in UTF-8");
            return Some(Self::new(file, &text, findings));
        }
        let zeros = bytes.iter().filter(|byte| **byte == 0).count();
        if zeros > bytes.len() / 8 {
            let message = format!("this is no text: {zeros} of its bytes are zero");
            findings.report(&reading::NOT_TEXT, Span::START, message);
            return None;
        }
        Some(match std::str::from_utf8(bytes) {
            Ok(text) => Self::new(file, text, findings),
            Err(error) => {
                let before = bytes.get(..error.valid_up_to()).unwrap_or_default();
                let before = String::from_utf8_lossy(before);
                let before = line_ends(&before);
                let at = before.rsplit('\n').next().unwrap_or_default();
                let span = Span {
                    line: u32::try_from(before.split('\n').count()).unwrap_or(u32::MAX),
                    column: count(at).saturating_add(1),
                    length: 1,
                };
                let finding = findings.report(
                    &reading::NOT_UTF_8,
                    span,
                    "this is not UTF-8: the file is read as Windows-1252",
                );
                finding.help("save the file in UTF-8");
                let text: String = bytes.iter().map(|byte| windows_1252(*byte)).collect();
                Self::new(file, &text, findings)
            }
        })
    }

    /// The text, without a byte order mark and without control characters.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The files that a recipe is made of.
    pub fn parts(&self) -> &[Self] {
        &self.parts
    }

    pub(crate) fn set_parts(&mut self, parts: Vec<Self>) {
        self.parts = parts;
    }

    /// This file, or the part of it with that name.
    pub fn of(&self, file: &str) -> &Self {
        let mut parts = self.parts.iter();
        parts.find(|part| part.file == file).unwrap_or(self)
    }

    /// A line by its number, without its end.
    pub fn line(&self, number: u32) -> Option<&str> {
        let number = usize::try_from(number).ok()?.checked_sub(1)?;
        let start = *self.lines.get(number)?;
        let rest = self.text.get(start..)?;
        Some(rest.lines().next().unwrap_or_default())
    }

    /// The place of a range of bytes; what goes on in the next line is left out.
    pub(crate) fn span(&self, range: std::ops::Range<usize>) -> Span {
        let line = self.lines.partition_point(|start| *start <= range.start);
        let start = self.lines.get(line.saturating_sub(1)).copied();
        let start = start.unwrap_or_default();
        let before = self.text.get(start..range.start).unwrap_or_default();
        let part = self.text.get(range).unwrap_or_default();
        Span {
            line: u32::try_from(line).unwrap_or(u32::MAX),
            column: count(before).saturating_add(1),
            length: count(part.lines().next().unwrap_or_default()),
        }
    }

    /// How many lines there are.
    pub fn line_count(&self) -> u32 {
        u32::try_from(self.lines.len()).unwrap_or(u32::MAX)
    }
}

/// The text of a file in UTF-16: with a byte order mark, or `[` or `;` and a zero byte first. `None` for anything else.
fn utf_16(bytes: &[u8]) -> Option<String> {
    let unit = match bytes {
        [0xFF, 0xFE, ..] | [b'[' | b';' | b'<' | b'\r' | b'\n', 0, ..] => u16::from_le_bytes,
        [0xFE, 0xFF, ..] | [0, b'[' | b';' | b'<' | b'\r' | b'\n', ..] => u16::from_be_bytes,
        _ => return None,
    };
    let (pairs, _) = bytes.as_chunks();
    let units: Vec<u16> = pairs.iter().map(|pair| unit(*pair)).collect();
    Some(String::from_utf16_lossy(&units))
}

/// What Windows-1252 has in place of the control characters 80h to 9Fh of Latin-1; where it has nothing, they stay.
const WINDOWS_1252: [char; 32] = [
    '\u{20AC}', '\u{81}', '\u{201A}', '\u{192}', '\u{201E}', '\u{2026}', '\u{2020}', '\u{2021}',
    '\u{2C6}', '\u{2030}', '\u{160}', '\u{2039}', '\u{152}', '\u{8D}', '\u{17D}', '\u{8F}',
    '\u{90}', '\u{2018}', '\u{2019}', '\u{201C}', '\u{201D}', '\u{2022}', '\u{2013}', '\u{2014}',
    '\u{2DC}', '\u{2122}', '\u{161}', '\u{203A}', '\u{153}', '\u{9D}', '\u{17E}', '\u{178}',
];

/// A letter of Windows-1252, which is Latin-1 but for its control characters.
fn windows_1252(byte: u8) -> char {
    let own = byte.checked_sub(0x80);
    let own = own.and_then(|at| WINDOWS_1252.get(usize::from(at)));
    own.copied().unwrap_or_else(|| char::from(byte))
}

/// A text whose lines all end in `\n`: old editors end them in `\r`, and copying in the wrong mode in `\r\r\n`.
fn line_ends(text: &str) -> Cow<'_, str> {
    if !text.contains('\r') {
        return text.into();
    }
    let mut lines = String::with_capacity(text.len());
    let mut returns = 0;
    for letter in text.chars() {
        match letter {
            '\r' => returns += 1,
            '\n' => {
                returns = 0;
                lines.push('\n');
            }
            _ => {
                lines.extend(std::iter::repeat_n('\n', mem::take(&mut returns)));
                lines.push(letter);
            }
        }
    }
    lines.extend(std::iter::repeat_n('\n', returns));
    lines.into()
}

/// Whether a character only controls how others are shown: NUL and its like but for the tab, and marks of direction.
pub(crate) fn is_control(letter: char) -> bool {
    let is_direction = matches!(letter, '\u{202A}'..='\u{202E}' | '\u{2066}'..='\u{2069}');
    is_direction || (letter.is_control() && letter != '\t')
}

/// A text without its control characters: nobody sees them in an editor, and they do not belong into generated code.
fn visible<'a>(text: &'a str, findings: &mut Findings) -> Cow<'a, str> {
    let is_end = |letter: char| letter == '\n';
    if !text
        .chars()
        .any(|letter| is_control(letter) && !is_end(letter))
    {
        return text.into();
    }
    let mut kept = String::with_capacity(text.len());
    for (number, line) in (1..).zip(text.split_inclusive('\n')) {
        let body = line.strip_suffix('\n').unwrap_or(line);
        let first = body
            .chars()
            .enumerate()
            .find(|(_, letter)| is_control(*letter));
        if let Some((column, letter)) = first {
            let span = Span {
                line: number,
                column: u32::try_from(column).unwrap_or(u32::MAX).saturating_add(1),
                length: 0,
            };
            let message = format!("control character U+{:04X} is left out", u32::from(letter));
            let finding = findings.report(&reading::CONTROL_CHARACTER, span, message);
            finding.help("remove it");
        }
        kept.extend(body.chars().filter(|letter| !is_control(*letter)));
        if line.ends_with('\n') {
            kept.push('\n');
        }
    }
    kept.into()
}
