//! The description as YAML has it: the keys are those of TOML, and so is the tree that is made of it.

use std::ops::Range;

use saphyr_parser::{Event, Marker, Parser, ScalarStyle, ScanError, Span, StrInput};
use toml::Spanned;
use toml::de::{DeArray, DeString, DeTable, DeValue};

/// The deepest that lists and maps stand in each other; a description needs 5.
const DEPTH: usize = 16;
/// The most values, those that an alias (`*name`) stands for counted each time.
const VALUES: usize = 1 << 16;

/// What is wrong, and the bytes where it is.
pub(super) type Error = (Range<usize>, String);

type Value<'i> = Spanned<DeValue<'i>>;

/// The tree of a text. Its spans are bytes of the text.
pub(super) fn read(text: &str) -> Result<Spanned<DeTable<'_>>, Error> {
    let starts = text.char_indices().map(|(at, _)| at);
    let mut reader = Reader {
        text,
        starts: starts.chain([text.len()]).collect(),
        parser: Parser::new_from_str(text),
        anchors: Vec::new(),
        values: 0,
    };
    reader.document()
}

struct Reader<'i> {
    text: &'i str,
    /// The first byte of each character, as the parser counts these.
    starts: Vec<usize>,
    parser: Parser<'i, StrInput<'i>>,
    /// What aliases stand for, with the number of values in it.
    anchors: Vec<(usize, Value<'i>, usize)>,
    values: usize,
}

impl<'i> Reader<'i> {
    fn document(&mut self) -> Result<Spanned<DeTable<'i>>, Error> {
        let mut root = None;
        loop {
            let (event, place) = self.event()?;
            match event {
                Event::StreamEnd => break,
                Event::DocumentStart(_) if root.is_none() => {
                    let (event, place) = self.event()?;
                    root = Some(self.value(event, place, 0)?);
                }
                Event::DocumentStart(_) => return Err((place, "a second document".into())),
                _ => {}
            }
        }
        let root = root.unwrap_or_else(|| Spanned::new(0..0, DeValue::Table(DeTable::new())));
        let place = root.span();
        match root.into_inner() {
            DeValue::Table(table) => Ok(Spanned::new(place, table)),
            _ => Err((place, "the keys of a description are expected".into())),
        }
    }

    /// The next event and its bytes.
    fn event(&mut self) -> Result<(Event<'i>, Range<usize>), Error> {
        match self.parser.next_event() {
            Some(Ok((event, span))) => Ok((event, self.place(span))),
            Some(Err(error)) => Err(self.error(&error)),
            None => Ok((Event::StreamEnd, self.text.len()..self.text.len())),
        }
    }

    fn error(&self, error: &ScanError) -> Error {
        let at = self.byte(*error.marker());
        (at..at, error.info().into())
    }

    fn byte(&self, marker: Marker) -> usize {
        let found = self.starts.get(marker.index()).copied();
        found.unwrap_or(self.text.len())
    }

    fn place(&self, span: Span) -> Range<usize> {
        self.byte(span.start)..self.byte(span.end)
    }

    /// The value that begins with an event.
    fn value(
        &mut self,
        event: Event<'i>,
        place: Range<usize>,
        depth: usize,
    ) -> Result<Value<'i>, Error> {
        let before = self.values;
        self.count(1, &place)?;
        if depth > DEPTH {
            return Err((place, format!("more than {DEPTH} lists in each other")));
        }
        let (anchor, value, end) = match event {
            Event::Scalar(_, _, _, Some(_))
            | Event::SequenceStart(_, Some(_))
            | Event::MappingStart(_, Some(_)) => {
                return Err((place, "tags (`!`) have no meaning here".into()));
            }
            Event::Scalar(text, style, anchor, None) => {
                (anchor, self.scalar(text, style, &place)?, place.end)
            }
            Event::SequenceStart(anchor, None) => {
                let mut list = DeArray::new();
                let end = loop {
                    match self.event()? {
                        (Event::SequenceEnd, place) => break place.end,
                        (event, place) => list.push(self.value(event, place, depth + 1)?),
                    }
                };
                (anchor, DeValue::Array(list), end)
            }
            Event::MappingStart(anchor, None) => {
                let (table, end) = self.table(depth)?;
                (anchor, DeValue::Table(table), end)
            }
            Event::Alias(anchor) => return self.alias(anchor, place),
            _ => return Err((place, "a value is expected".into())),
        };
        let value = Spanned::new(place.start..end, value);
        if anchor != 0 {
            let count = self.values - before;
            self.anchors.push((anchor, value.clone(), count));
        }
        Ok(value)
    }

    /// The keys of a map, and the byte behind it.
    fn table(&mut self, depth: usize) -> Result<(DeTable<'i>, usize), Error> {
        let mut table = DeTable::new();
        loop {
            let (key, place) = match self.event()? {
                (Event::MappingEnd, place) => return Ok((table, place.end)),
                (Event::Scalar(key, ..), place) => (key, place),
                (_, place) => return Err((place, "a key is a word or a number".into())),
            };
            let key: Spanned<DeString<'i>> = Spanned::new(place.clone(), key);
            if table.contains_key(&key) {
                let message = format!("there is a key `{}` already", key.get_ref());
                return Err((place, message));
            }
            let (event, place) = self.event()?;
            let value = self.value(event, place, depth + 1)?;
            table.insert(key, value);
        }
    }

    /// What was said before under this name.
    fn alias(&mut self, anchor: usize, place: Range<usize>) -> Result<Value<'i>, Error> {
        let mut anchors = self.anchors.iter();
        let Some((_, value, count)) = anchors.find(|(own, ..)| *own == anchor).cloned() else {
            return Err((place, "this stands for what it is a part of".into()));
        };
        self.count(count, &place)?;
        Ok(value)
    }

    fn count(&mut self, more: usize, place: &Range<usize>) -> Result<(), Error> {
        self.values = self.values.saturating_add(more);
        if self.values > VALUES {
            return Err((place.clone(), format!("more than {VALUES} values")));
        }
        Ok(())
    }

    /// A number, a truth value or a text: quoted it is always a text.
    fn scalar(
        &self,
        text: DeString<'i>,
        style: ScalarStyle,
        place: &Range<usize>,
    ) -> Result<DeValue<'i>, Error> {
        if style != ScalarStyle::Plain {
            return Ok(DeValue::String(text));
        }
        match &*text {
            "" | "~" | "null" | "Null" | "NULL" => {
                return Err((place.clone(), "a value is missing".into()));
            }
            "true" | "True" | "TRUE" => return Ok(DeValue::Boolean(true)),
            "false" | "False" | "FALSE" => return Ok(DeValue::Boolean(false)),
            _ => {}
        }
        let written = self.text.get(place.clone()).unwrap_or_default();
        Ok(number(written).unwrap_or(DeValue::String(text)))
    }
}

/// A number of YAML's core schema, most of which TOML writes alike: not so zeros in front, and a point without digits beside it.
fn number(text: &str) -> Option<DeValue<'_>> {
    let starts = text.starts_with(|first: char| first.is_ascii_digit() || "+-".contains(first));
    if !starts || text.contains('_') || text.starts_with("0b") {
        return None;
    }
    let is_decimal = text.bytes().all(|byte| byte.is_ascii_digit());
    let text = match text.trim_start_matches('0') {
        _ if !is_decimal => text,
        "" => "0",
        rest => rest,
    };
    let value = DeValue::parse(text).ok()?.into_inner();
    matches!(value, DeValue::Integer(_) | DeValue::Float(_)).then_some(value)
}

#[cfg(test)]
mod tests;
