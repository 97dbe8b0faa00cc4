//! The names of units: 60A8h to 60ABh (notation of CiA 303-2).
//!
//! They say to people and tools what a unit is called. They scale nothing: that is up to the factors.

use core::ops::RangeInclusive;

/// Prefixes, as powers of ten: from pico to tera.
const PREFIXES: RangeInclusive<i8> = -12..=12;

/// No unit: a plain number.
const NONE: u8 = 0x00;
const METRE: u8 = 0x01;
const SECOND: u8 = 0x03;
const RADIAN: u8 = 0x10;
const GON: u8 = 0x40;
const DEGREE: u8 = 0x41;
const ARC_MINUTE: u8 = 0x42;
const ARC_SECOND: u8 = 0x43;
const MINUTE: u8 = 0x47;
const SECOND_SQUARED: u8 = 0x57;
const SECOND_CUBED: u8 = 0xA0;
const STEP: u8 = 0xAC;
const REVOLUTION: u8 = 0xB4;
const INCREMENT: u8 = 0xB5;
const INCH: u8 = 0xC1;
const FOOT: u8 = 0xC2;

/// What a unit is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SiUnit {
    /// 60A8h.
    Position,
    /// 60A9h.
    Velocity,
    /// 60AAh.
    Acceleration,
    /// 60ABh.
    Jerk,
}

impl SiUnit {
    /// Whether a value names a unit of this kind: bits 31 to 24 a prefix from 10⁻¹² to 10¹², bits 23 to 16 a length, an angle,
    /// increments, steps or nothing, bits 15 to 8 the time that fits, bits 7 to 0 none. 0 is no name.
    pub fn is_named_by(self, value: u32) -> bool {
        let [reserved, time, length, prefix] = value.to_le_bytes();
        let is_length = matches!(
            length,
            NONE | METRE
                | RADIAN
                | GON
                | DEGREE
                | ARC_MINUTE
                | ARC_SECOND
                | STEP
                | REVOLUTION
                | INCREMENT
                | INCH
                | FOOT
        );
        let is_time = match self {
            Self::Position => time == NONE,
            Self::Velocity => time == SECOND || time == MINUTE,
            Self::Acceleration => time == SECOND_SQUARED,
            Self::Jerk => time == SECOND_CUBED,
        };
        value == 0
            || reserved == 0 && is_length && is_time && PREFIXES.contains(&prefix.cast_signed())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn m73_units_are_those_of_the_kind() {
        for (unit, value) in [
            (SiUnit::Position, 0xFD01_0000),
            (SiUnit::Position, 0x00B4_0000),
            (SiUnit::Velocity, 0x00B4_4700),
            (SiUnit::Velocity, 0xFD01_0300),
            (SiUnit::Acceleration, 0xFD01_5700),
            (SiUnit::Jerk, 0xFD01_A000),
        ] {
            assert!(unit.is_named_by(value), "{unit:?} {value:08X}");
            assert!(unit.is_named_by(0));
            assert!(!unit.is_named_by(value | 1), "bits 7 to 0 are reserved");
            assert!(!unit.is_named_by(value & 0xFFFF | 0x0002_0000), "kilograms");
            assert!(!unit.is_named_by(value & 0xFF_FFFF | 0x4000_0000), "10^64");
        }
        assert!(!SiUnit::Position.is_named_by(0x0001_0300));
        assert!(!SiUnit::Velocity.is_named_by(0x0001_5700));
        assert!(!SiUnit::Velocity.is_named_by(0x0001_0000));
    }
}
