//! The tables `[[word]]`, `[[mask]]` and `[[error]]`: what a maker's words are made of, and how its devices tell of errors.

use std::collections::BTreeMap;

use toml::Spanned;

use super::file::{ErrorRow, MaskRow, WordRow, place};
use super::place::{entry, name};
use crate::diagnostic::Findings;
use crate::model::Model;
use crate::rules::binding;
use crate::source::Source;

/// What a bit of a word tells.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fact {
    /// All sixteen bits of the statusword, from this bit on.
    Statusword,
    /// A bit of the statusword.
    StatusBit(u8),
    /// A bit of 60FDh.
    Input(u8),
    /// The motor has power.
    Power,
    /// The position is referenced.
    Referenced,
    /// The motor moves.
    Moving,
    /// The motor stands.
    Standstill,
    /// A mode of operation is at work, and the motor moves.
    Mode(i8),
    /// An error stands, of this code of the drive.
    Error(u16),
    /// It is always so.
    Always,
}

impl Fact {
    fn new(text: &str) -> Option<Self> {
        let (word, number) = text.split_once(' ').unwrap_or((text, ""));
        let bit = |most: u8| number.parse().ok().filter(|bit| *bit <= most);
        match (word, number.is_empty()) {
            ("statusword", true) => Some(Self::Statusword),
            ("statusword", false) => bit(15).map(Self::StatusBit),
            ("input", false) => bit(31).map(Self::Input),
            ("power", true) => Some(Self::Power),
            ("referenced", true) => Some(Self::Referenced),
            ("moving", true) => Some(Self::Moving),
            ("standstill", true) => Some(Self::Standstill),
            ("mode", false) => number.parse().ok().map(Self::Mode),
            ("error", false) => {
                let digits = number.strip_suffix('h')?;
                u16::from_str_radix(digits, 16).ok().map(Self::Error)
            }
            ("always", true) => Some(Self::Always),
            _ => None,
        }
    }

    /// How many bits it takes.
    const fn bits(&self) -> u32 {
        match self {
            Self::Statusword => 16,
            _ => 1,
        }
    }
}

/// An object whose bits are facts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Word {
    /// Index.
    pub index: u16,
    /// Sub-index.
    pub sub: u8,
    /// Its bits, each with what it tells.
    pub facts: BTreeMap<u8, Fact>,
}

/// How a maker tells of an error: `canopen::od::ErrorMapping`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ErrorMapping {
    /// The code of the device itself.
    pub cause: u16,
    /// The code that masters see.
    pub code: u16,
    /// Bits of the error register.
    pub register: u8,
    /// The manufacturer's bytes.
    pub info: [u8; 5],
    /// The high word in 1003h.
    pub history: u16,
    /// The byte of the message with the number of a PDO.
    pub number_byte: Option<u8>,
}

/// The tables `[[word]]`.
pub(super) fn words(
    rows: &[Spanned<WordRow>],
    source: &Source,
    model: &Model,
    findings: &mut Findings,
) -> Vec<Word> {
    let mut found: Vec<Word> = Vec::new();
    for row in rows {
        let WordRow { object, facts } = row.get_ref();
        let place = place(source, object.span());
        let known = entry(object.get_ref()).and_then(|(index, sub)| {
            let data_type = model.entry(index, sub)?.data_type;
            let bits = 8 * u32::from(data_type.range().and(data_type.size())?);
            Some((index, sub, bits))
        });
        let Some((index, sub, size)) = known else {
            let message = format!("`{}` is no number of the data sheet", object.get_ref());
            findings.report(&binding::OBJECT, place, message);
            continue;
        };
        let mut own = BTreeMap::new();
        for (bit, fact) in facts {
            let meant = bit.parse::<u8>().ok().zip(Fact::new(fact));
            let meant = meant.filter(|(bit, fact)| u32::from(*bit) + fact.bits() <= size);
            match meant {
                Some((bit, fact)) => {
                    own.insert(bit, fact);
                }
                None => {
                    let message = format!("bit {bit} of {} cannot be `{fact}`", name((index, sub)));
                    findings.report(&binding::HABIT, place, message);
                }
            }
        }
        found.push(Word {
            index,
            sub,
            facts: own,
        });
    }
    found
}

/// An object whose bits are inputs or outputs: those that have a function.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mask {
    /// Index.
    pub index: u16,
    /// Sub-index.
    pub sub: u8,
    /// It is one of outputs.
    pub is_of_outputs: bool,
    /// The function, as 2031h or 2060h of the generic drive have it.
    pub function: u8,
}

/// The tables `[[mask]]`.
pub(super) fn masks(
    rows: &[Spanned<MaskRow>],
    source: &Source,
    model: &Model,
    findings: &mut Findings,
) -> Vec<Mask> {
    let mut found: Vec<Mask> = Vec::new();
    for row in rows {
        let MaskRow {
            object,
            inputs,
            outputs,
        } = row.get_ref();
        let known = entry(object.get_ref()).filter(|(index, sub)| {
            let entry = model.entry(*index, *sub);
            entry.is_some_and(|entry| entry.data_type.range().is_some())
        });
        let (Some((index, sub)), Some(function)) = (known, inputs.xor(*outputs)) else {
            let message = format!(
                "`{}` is a number of the data sheet, and its bits are inputs or outputs",
                object.get_ref()
            );
            findings.report(&binding::OBJECT, place(source, object.span()), message);
            continue;
        };
        found.push(Mask {
            index,
            sub,
            is_of_outputs: outputs.is_some(),
            function,
        });
    }
    found
}

/// The tables `[[error]]`.
pub(super) fn errors(
    rows: &[Spanned<ErrorRow>],
    source: &Source,
    findings: &mut Findings,
) -> Vec<ErrorMapping> {
    let mut found: Vec<ErrorMapping> = Vec::new();
    for row in rows {
        let own = row.get_ref();
        let mut info = [0; 5];
        let is_short = own.info.len() <= info.len();
        for (place, byte) in info.iter_mut().zip(&own.info) {
            *place = *byte;
        }
        let is_byte = own.number_byte.is_none_or(|byte| (3..=7).contains(&byte));
        if !is_short || !is_byte || found.iter().any(|other| other.cause == own.cause) {
            let message = format!("{:04X}h is told once, in bytes 3 to 7", own.cause);
            findings.report(&binding::HABIT, place(source, row.span()), message);
            continue;
        }
        found.push(ErrorMapping {
            cause: own.cause,
            code: own.code,
            register: own.register,
            info,
            history: own.history,
            number_byte: own.number_byte,
        });
    }
    found
}
