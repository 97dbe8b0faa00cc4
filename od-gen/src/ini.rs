//! The INI layer of a data sheet: sections, keys and comments, each with its line.
//!
//! A library splits the lines. It is given one line at a time, because an INI line means the same wherever it stands, and so
//! each finding can name its line. Names are compared without regard to case, as CiA 306 asks.

use std::borrow::Cow;
use std::convert::Infallible;

use light_ini::{IniHandler, IniParser};

use crate::diagnostic::Findings;

/// `key=value`.
#[derive(Clone, Debug)]
pub(crate) struct Key {
    pub(crate) name: String,
    pub(crate) value: String,
    pub(crate) line: usize,
}

/// `; text`.
#[derive(Clone, Debug)]
pub(crate) struct Comment {
    pub(crate) text: String,
    pub(crate) line: usize,
}

/// `[name]` and what follows it.
#[derive(Clone, Debug)]
pub(crate) struct Section {
    pub(crate) name: String,
    pub(crate) line: usize,
    pub(crate) keys: Vec<Key>,
    pub(crate) comments: Vec<Comment>,
}

impl Section {
    /// A key that has a value; `key=` counts as absent.
    pub(crate) fn key(&self, name: &str) -> Option<&Key> {
        self.keys
            .iter()
            .find(|key| key.name.eq_ignore_ascii_case(name) && !key.value.is_empty())
    }
}

/// The sections of a file in their order, each name once.
pub(crate) fn read(text: &str, findings: &mut Findings) -> Vec<Section> {
    let mut lines = Lines {
        sections: Vec::new(),
        line: 0,
        findings,
    };
    // Editors on Windows like to put a byte order mark first.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    for (number, line) in (1..).zip(text.lines()) {
        lines.line = number;
        let line = lines.visible(line.trim());
        lines.take(line.trim());
    }
    lines.sections
}

/// Whether a character only controls how others are shown: NUL and its like but for the tab, and marks of direction.
fn is_control(letter: &char) -> bool {
    let is_direction = matches!(letter, '\u{202A}'..='\u{202E}' | '\u{2066}'..='\u{2069}');
    is_direction || (letter.is_control() && *letter != '\t')
}

struct Lines<'a> {
    sections: Vec<Section>,
    line: usize,
    findings: &'a mut Findings,
}

impl Lines<'_> {
    /// A line without its control characters: nobody sees them in an editor, and they do not belong into generated code.
    fn visible<'a>(&mut self, line: &'a str) -> Cow<'a, str> {
        let Some(first) = line.chars().find(is_control) else {
            return line.into();
        };
        self.findings.error(
            self.line,
            format!("control character U+{:04X}: remove it", u32::from(first)),
        );
        line.chars().filter(|letter| !is_control(letter)).collect()
    }

    fn take(&mut self, line: &str) {
        let mut line = line;
        if line.starts_with('[') && !line.ends_with(']') {
            self.findings.error(
                self.line,
                format!("`{line}` is not a section: it must end with its `]`"),
            );
            // It is one all the same, so that its keys are not taken for the section's before.
            line = line.split_inclusive(']').next().unwrap_or(line);
            if !line.ends_with(']') {
                let Ok(()) = self.section(line.trim_start_matches('['));
                return;
            }
        }
        if IniParser::new(self)
            .parse_buffered(line.as_bytes())
            .is_err()
        {
            self.findings.error(
                self.line,
                format!("`{line}` is neither a section nor key=value nor a ;comment"),
            );
        }
    }
}

impl IniHandler for Lines<'_> {
    type Error = Infallible;

    fn section(&mut self, name: &str) -> Result<(), Infallible> {
        if let Some(first) = self
            .sections
            .iter()
            .find(|section| section.name.eq_ignore_ascii_case(name))
        {
            self.findings.error(
                self.line,
                format!("section [{name}] is already on line {}", first.line),
            );
        }
        let (keys, comments) = (Vec::new(), Vec::new());
        self.sections.push(Section {
            name: name.into(),
            line: self.line,
            keys,
            comments,
        });
        Ok(())
    }

    fn option(&mut self, name: &str, value: &str) -> Result<(), Infallible> {
        let Some(section) = self.sections.last_mut() else {
            self.findings.error(
                self.line,
                format!("`{name}` stands before the first section"),
            );
            return Ok(());
        };
        // Some readers cut the value there, CiA 306 does not: whatever was meant, half of the readers would get it wrong.
        if value.starts_with(';') || value.contains(" ;") || value.contains("\t;") {
            self.findings.error(
                self.line,
                format!("a comment takes a line of its own: move `;` out of `{name}`"),
            );
        }
        if let Some(first) = section
            .keys
            .iter()
            .find(|key| key.name.eq_ignore_ascii_case(name))
        {
            self.findings.error(
                self.line,
                format!("`{name}` is already on line {}", first.line),
            );
        } else {
            section.keys.push(Key {
                name: name.into(),
                value: value.into(),
                line: self.line,
            });
        }
        Ok(())
    }

    fn comment(&mut self, text: &str) -> Result<(), Infallible> {
        if let Some(section) = self.sections.last_mut() {
            section.comments.push(Comment {
                text: text.into(),
                line: self.line,
            });
        }
        Ok(())
    }
}
