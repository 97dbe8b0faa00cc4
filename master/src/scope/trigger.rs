//! How a person says what the trigger is.

use super::mapping;
use crate::data_sheet::DataSheet;

/// Which way a value goes, as 20D2h:2 has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Edge {
    /// From below the level to the level or above it.
    Rising = 1,
    /// From the level or above it to below the level.
    Falling = 2,
    /// Both.
    Either = 3,
}

/// What begins a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Trigger {
    /// This program, as soon as there are as many samples as shall be older than the trigger.
    Now,
    /// What the drive is set up for.
    AsSetUp,
    /// An edge of a value, as 20D2h has it.
    Edge {
        /// 20D2h:1.
        object: u32,
        /// 20D2h:2.
        edge: Edge,
        /// 20D2h:3.
        level: i32,
        /// 20D2h:4.
        mask: u32,
    },
}

/// Bit 3 of the statusword: the fault reaction is active, or there is a fault.
const FAULT: &str = "6041#3";

impl Trigger {
    /// `now`, `drive`, `fault`, `OBJECT>LEVEL`, `OBJECT<LEVEL`, `OBJECT~LEVEL` (either way), `OBJECT#BIT`, `OBJECT#BIT=0`.
    ///
    /// # Errors
    /// Why it means nothing.
    pub fn parse(text: &str, sheet: &DataSheet) -> Result<Self, String> {
        match text.trim() {
            "now" => return Ok(Self::Now),
            "drive" => return Ok(Self::AsSetUp),
            "fault" => return Self::parse(FAULT, sheet),
            _ => {}
        }
        if let Some((object, bit)) = text.split_once('#') {
            let (bit, edge) = match bit.split_once('=') {
                Some((bit, "0")) => (bit, Edge::Falling),
                Some((bit, "1")) => (bit, Edge::Rising),
                None => (bit, Edge::Rising),
                Some((_, other)) => return Err(format!("a bit becomes 0 or 1, and not {other}")),
            };
            let object = mapping(object, sheet)?;
            // A bit that is not there never changes, and nobody would be told.
            let bits = (object & 0xFF).min(32);
            let bit = bit.trim().parse().ok().filter(|bit| *bit < bits);
            let bit: u32 = bit
                .ok_or_else(|| format!("`{text}`: the bits of this value are 0 to {}", bits - 1))?;
            return Ok(Self::Edge {
                object,
                edge,
                level: 0,
                mask: 1 << bit,
            });
        }
        for (sign, edge) in [
            ('>', Edge::Rising),
            ('<', Edge::Falling),
            ('~', Edge::Either),
        ] {
            if let Some((object, level)) = text.split_once(sign) {
                let level = level.trim();
                let level = level.parse().map_err(|_| {
                    let (least, most) = (i32::MIN, i32::MAX);
                    format!("`{level}` in `{text}` is no level: a whole number, {least} to {most}")
                })?;
                within_range(object, level, sheet)?;
                return Ok(Self::Edge {
                    object: mapping(object, sheet)?,
                    edge,
                    level,
                    mask: 0,
                });
            }
        }
        Err(format!(
            "`{text}` is no trigger: now, drive, fault, OBJECT>LEVEL, OBJECT<LEVEL, OBJECT~LEVEL, OBJECT#BIT or OBJECT#BIT=0"
        ))
    }
}

/// A value is on the upper side from the level on: it must be able to come to both sides.
fn within_range(object: &str, level: i32, sheet: &DataSheet) -> Result<(), String> {
    let address = sheet.find(object.trim())?;
    let range = sheet.data_type(address).and_then(|known| known.range());
    match range {
        Some((least, most)) if i128::from(level) <= least || i128::from(level) > most => Err(
            format!("{address} never crosses {level}: its values are {least} to {most}"),
        ),
        _ => Ok(()),
    }
}
