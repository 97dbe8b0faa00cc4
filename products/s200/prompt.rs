//! The text interface, 1026h: a master writes a line into :1 (StdIn) and reads the answer from :2 (StdOut), a character at a time.
//!
//! The manual has examples of lines and none of answers. As in its series a line is a name and a number, or a name alone, which asks for
//! the number or gives a command; names are those of the parameters (`names.txt`), in capitals or not. A carriage return ends a line. The answer is the number, `OK`, or `ERR`
//! and the abort code that an SDO would have got, with carriage return and line feed; behind it StdOut is 0. A line writes as an SDO does, by the same rules.
//!
//! A character beyond the room of a line, or while a line is carried out, is refused with FF030000h.

use canopen::cia301::sdo::AbortCode;
use canopen::od::{self, Attributes, Dictionary, Entry};
use cia402::behaviour::number;

const PROMPT: u16 = 0x1026;
/// Characters of a line.
const ROOM: usize = 32;

/// Index and name of each parameter, a line each.
const NAMES: &str = include_str!("names.txt");

/// Commands that are no parameters, and what is written where.
const COMMANDS: [(&str, u16, u8, i64); 3] = [
    ("SAVE", 0x4000, 5, 1),
    ("RSTVAR", 0x4000, 4, 1),
    ("COLDSTART", 0x4000, 7, 1),
];

/// What a line is being answered with.
#[derive(Clone, Copy, Debug)]
enum Answer {
    Number(i64),
    Done,
    Refused(AbortCode),
}

/// The interface.
#[derive(Debug, Default)]
pub(super) struct Prompt {
    line: [u8; ROOM],
    length: usize,
    is_busy: bool,
    /// What a line is to write, which nobody has taken yet.
    order: Option<(u16, u8, i64)>,
    answer: [u8; 16],
    /// How much of it was read, and its end.
    read: usize,
    end: usize,
}

impl Prompt {
    pub(super) fn check(&self, entry: &Entry, value: i64) -> Result<(), AbortCode> {
        if (entry.index, entry.sub) != (PROMPT, 1) {
            return Ok(());
        }
        let ends = matches!(value, 0x0A | 0x0D);
        if self.is_busy || self.length == ROOM && !ends {
            return Err(AbortCode::BufferFull);
        }
        Ok(())
    }

    pub(super) fn written<D: Dictionary>(&mut self, dictionary: &D, entry: &Entry) {
        if (entry.index, entry.sub) != (PROMPT, 1) {
            return;
        }
        match u8::try_from(number(dictionary, PROMPT, 1)).unwrap_or(0) {
            b'\r' => self.carry_out(dictionary),
            b'\n' => {}
            character => {
                if let Some(place) = self.line.get_mut(self.length) {
                    *place = character;
                    self.length += 1;
                }
            }
        }
    }

    /// The next character of the answer; 0 behind its end.
    pub(super) fn read(&mut self, entry: &Entry) -> Option<i64> {
        if (entry.index, entry.sub) != (PROMPT, 2) {
            return None;
        }
        if self.read >= self.end {
            return Some(0);
        }
        let character = self.answer.get(self.read).copied().unwrap_or(0);
        self.read += 1;
        Some(character.into())
    }

    /// What a line is to write.
    pub(super) const fn order(&mut self) -> Option<(u16, u8, i64)> {
        self.order.take()
    }

    /// What the write of a line has come to.
    pub(super) fn wrote(&mut self, result: Result<(), AbortCode>) {
        // What others have written is not a line's.
        if !self.is_busy || self.order.is_some() {
            return;
        }
        self.is_busy = false;
        self.give(result.map_or_else(Answer::Refused, |()| Answer::Done));
    }

    fn carry_out<D: Dictionary>(&mut self, dictionary: &D) {
        let line = self.line.get(..self.length).unwrap_or_default();
        let line = core::str::from_utf8(line).unwrap_or("?");
        let mut words = line.split([' ', '=']).filter(|word| !word.is_empty());
        let name = words.next().unwrap_or_default();
        let given = words.next().map(str::parse::<i32>);
        self.length = 0;
        let answer = match (meant::<D>(name), given) {
            _ if name.is_empty() => Answer::Done,
            (None, _) => Answer::Refused(AbortCode::NoObject),
            (_, Some(Err(_))) => Answer::Refused(AbortCode::InvalidValue),
            (Some((entry, own)), given) => {
                let given = given.and_then(Result::ok).map(i64::from);
                let can_be_read = entry.attributes.has(Attributes::READ) && own.is_none();
                match given.or(own) {
                    None if can_be_read => {
                        Answer::Number(number(dictionary, entry.index, entry.sub))
                    }
                    value => {
                        self.order = Some((entry.index, entry.sub, value.unwrap_or(1)));
                        self.is_busy = true;
                        return;
                    }
                }
            }
        };
        self.give(answer);
    }

    fn give(&mut self, answer: Answer) {
        (self.read, self.end) = (0, 0);
        match answer {
            Answer::Done => self.put(b"OK"),
            Answer::Number(number) => {
                if number < 0 {
                    self.put(b"-");
                }
                self.digits(number.unsigned_abs(), 10);
            }
            Answer::Refused(code) => {
                self.put(b"ERR ");
                self.digits(code.get().into(), 16);
            }
        }
        self.put(b"\r\n");
    }

    fn digits(&mut self, number: u64, base: u64) {
        const DIGITS: &[u8; 16] = b"0123456789ABCDEF";
        let mut unit = 1_u64;
        // Hexadecimal numbers have all of their eight digits.
        while unit <= number / base || base == 16 && unit < 1 << 28 {
            unit *= base;
        }
        while unit != 0 {
            let digit = usize::try_from(number / unit % base).unwrap_or(0);
            self.put(DIGITS.get(digit..=digit).unwrap_or_default());
            unit /= base;
        }
    }

    fn put(&mut self, text: &[u8]) {
        for character in text {
            if let Some(place) = self.answer.get_mut(self.end) {
                *place = *character;
                self.end += 1;
            }
        }
    }
}

/// The entry of a name, and what a command writes there.
fn meant<D: Dictionary>(name: &str) -> Option<(&'static Entry, Option<i64>)> {
    let command = COMMANDS
        .iter()
        .find(|(own, ..)| own.eq_ignore_ascii_case(name));
    if let Some((_, index, sub, value)) = command {
        let entry = od::find::<D>(*index, *sub).ok()?;
        return Some((entry, Some(*value)));
    }
    let line = NAMES.lines().find(|line| {
        let own = line.get(5..).unwrap_or_default();
        own.eq_ignore_ascii_case(name)
    })?;
    let index = u16::from_str_radix(line.get(..4)?, 16).ok()?;
    Some((od::find::<D>(index, 1).ok()?, None))
}
