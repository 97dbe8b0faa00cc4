//! Text of XML: what is read of it, and how it is written.

use std::fmt::Write;

use crate::source::is_control;

/// A text of XML, where an EDS has one line: line ends with the white space around them, and what cannot be seen, are one space. References
/// such as `&#10;` are characters by now; a line end among them would go on into the lines of what is generated.
pub(super) fn one_line(text: &str) -> String {
    let is_break = |letter: char| matches!(letter, '\u{2028}' | '\u{2029}') || is_control(letter);
    let is_space = |letter: char| letter.is_whitespace() || is_break(letter);
    let mut line = String::with_capacity(text.len());
    let mut rest = text.trim_matches(is_space);
    while let Some(at) = rest.find(is_space) {
        let (word, behind) = rest.split_at(at);
        let next = behind.trim_start_matches(is_space);
        let (space, _) = behind.split_at(behind.len() - next.len());
        line.push_str(word);
        line.push_str(if space.contains(is_break) { " " } else { space });
        rest = next;
    }
    line.push_str(rest);
    line
}

/// A date of XML (`2026-11-21`) as an EDS has it (`11-21-2026`); what is none stays as it is.
pub(super) fn eds_date(value: &str) -> String {
    match parts(value, '-', [4, 2, 2]) {
        Some([year, month, day]) => format!("{month}-{day}-{year}"),
        None => value.into(),
    }
}

/// A date of an EDS as XML has it; what is none stays as it is.
pub(super) fn xml_date(value: &str) -> String {
    match parts(value, '-', [2, 2, 4]) {
        Some([month, day, year]) => format!("{year}-{month}-{day}"),
        None => value.into(),
    }
}

/// A time of XML (`17:05:00`) as an EDS has it (`05:05PM`); what is none stays as it is.
pub(super) fn eds_time(value: &str) -> String {
    let digits = value.get(..8).unwrap_or_default();
    let Some([hour, minute, _]) = parts(digits, ':', [2, 2, 2]) else {
        return value.into();
    };
    match hour.parse::<u8>() {
        Ok(hour @ 0..=23) => {
            let half = if hour < 12 { "AM" } else { "PM" };
            format!("{:02}:{minute}{half}", (hour + 11) % 12 + 1)
        }
        _ => value.into(),
    }
}

/// A time of an EDS as XML has it; what is none stays as it is.
pub(super) fn xml_time(value: &str) -> String {
    let (time, half) = value.split_at_checked(5).unwrap_or((value, ""));
    let hour = parts(time, ':', [2, 2]).and_then(|[hour, _]| hour.parse::<u8>().ok());
    let noon = match half {
        "AM" => 0,
        "PM" => 12,
        _ => return value.into(),
    };
    match (hour, time.get(3..)) {
        (Some(hour @ 1..=12), Some(minute)) => format!("{:02}:{minute}:00", hour % 12 + noon),
        _ => value.into(),
    }
}

/// Numbers of so many digits, with a letter between them.
fn parts<const N: usize>(value: &str, between: char, digits: [usize; N]) -> Option<[&str; N]> {
    let parts: Vec<&str> = value.split(between).collect();
    let parts: [&str; N] = parts.try_into().ok()?;
    let is_right = |(part, digits): (&&str, usize)| {
        part.len() == digits && part.bytes().all(|digit| digit.is_ascii_digit())
    };
    parts.iter().zip(digits).all(is_right).then_some(parts)
}

/// XML that is written.
pub(super) struct Writer {
    text: String,
    /// The elements that are open.
    open: Vec<&'static str>,
}

impl Writer {
    pub(super) fn new() -> Self {
        Self {
            text: "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n".into(),
            open: Vec::new(),
        }
    }

    fn start(&mut self, name: &str, attributes: &[(&str, &str)]) {
        self.indent();
        // Writing to a text cannot fail.
        let _ = write!(self.text, "<{name}");
        for (name, value) in attributes {
            let _ = write!(self.text, " {name}=\"{}\"", escape(value));
        }
    }

    fn indent(&mut self) {
        self.text.extend(self.open.iter().map(|_| "  "));
    }

    /// `<name ...>`; [`Writer::close`] ends it.
    pub(super) fn open(&mut self, name: &'static str, attributes: &[(&str, &str)]) {
        self.start(name, attributes);
        self.text.push_str(">\n");
        self.open.push(name);
    }

    /// Ends the last element that is open.
    pub(super) fn close(&mut self) {
        if let Some(name) = self.open.pop() {
            self.indent();
            let _ = writeln!(self.text, "</{name}>");
        }
    }

    /// `<name .../>`.
    pub(super) fn empty(&mut self, name: &str, attributes: &[(&str, &str)]) {
        self.start(name, attributes);
        self.text.push_str("/>\n");
    }

    /// `<name ...>text</name>`.
    pub(super) fn text(&mut self, name: &str, attributes: &[(&str, &str)], text: &str) {
        self.start(name, attributes);
        let _ = writeln!(self.text, ">{}</{name}>", escape(text));
    }

    /// `<!--text-->`, in which XML allows no `--`.
    pub(super) fn comment(&mut self, text: &str) {
        self.indent();
        let mut text: String = text.chars().filter(|letter| is_of_xml(*letter)).collect();
        while text.contains("--") {
            text = text.replace("--", "- -");
        }
        let _ = writeln!(self.text, "<!-- {} -->", text.trim());
    }

    /// Everything, with all elements ended.
    pub(super) fn finish(mut self) -> String {
        while !self.open.is_empty() {
            self.close();
        }
        self.text
    }
}

/// Whether XML 1.0 can hold a letter at all.
fn is_of_xml(letter: char) -> bool {
    let is_hidden = letter < ' ' && !matches!(letter, '\t' | '\n' | '\r');
    !(is_hidden || matches!(letter, '\u{FFFE}' | '\u{FFFF}'))
}

/// What means something to XML, as references.
fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for letter in text.chars().filter(|letter| is_of_xml(*letter)) {
        match letter {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\t' | '\n' | '\r' => {
                let _ = write!(escaped, "&#{};", u32::from(letter));
            }
            _ => escaped.push(letter),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_and_times_are_those_of_the_other_format() {
        for (eds, xml) in [
            ("12:00AM", "00:00:00"),
            ("12:59PM", "12:59:00"),
            ("01:07PM", "13:07:00"),
            ("11:30AM", "11:30:00"),
            ("11:59PM", "23:59:00"),
            ("noon", "noon"),
            ("13:00", "13:00"),
        ] {
            assert_eq!((xml_time(eds).as_str(), eds_time(xml).as_str()), (xml, eds));
        }
        assert_eq!(eds_time("17:05:30.5+01:00"), "05:05PM");
        for (eds, xml) in [
            ("11-21-2026", "2026-11-21"),
            ("2026", "2026"),
            ("1-2-3", "1-2-3"),
        ] {
            assert_eq!((xml_date(eds).as_str(), eds_date(xml).as_str()), (xml, eds));
        }
    }

    #[test]
    fn spaces_stay_and_line_ends_do_not() {
        assert_eq!(one_line("  a  b \n\t c\u{202E}d\te "), "a  b c d\te");
    }
}
