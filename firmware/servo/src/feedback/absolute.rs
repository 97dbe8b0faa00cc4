//! An absolute angle within a turn: the word of a magnetic encoder, of 12 to 20 bits.
//!
//! A magnet off its centre shows an error that goes round with the turn. A table of [`ENTRIES`] takes it out, straight between them. The words become a
//! position that goes on. A word that is further from the last than the rotor can go in the time is a jump, and is not counted.

use super::FeedbackFault;
use crate::motor::Implausible;
use crate::{Angle, Motor};

/// Entries of the table in a turn.
pub const ENTRIES: usize = 64;

/// The table of a magnet on its centre.
pub const NO_ERROR: [i32; ENTRIES] = [0; ENTRIES];

/// Bits of an angle beyond the entry.
const BEYOND: u32 = 26;

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Absolute {
    bits: u8,
    pole_pairs: u32,
    /// What is to be taken from the shown angle there, in parts of 2³² of a turn.
    table: &'static [i32; ENTRIES],
    /// What the rotor may turn between two words, in parts of 2³² of a turn.
    reach: u32,
    last: Option<Angle>,
    /// In parts of 2³² of a turn, whole turns counted on.
    position: i64,
    offset: Angle,
}

impl Absolute {
    /// For words of so many bits, of a rotor that turns less than `reach` between two of them.
    ///
    /// # Errors
    /// With fewer than 12 or more than 20 bits, or a reach of half a turn or more.
    pub fn new(motor: &Motor, bits: u8, reach: Angle) -> Result<Self, Implausible> {
        Implausible::unless((12..=20).contains(&bits) && reach.bits() < 1 << 31)?;
        Ok(Self {
            bits,
            pole_pairs: motor.pole_pairs.into(),
            table: &NO_ERROR,
            reach: reach.bits(),
            last: None,
            position: 0,
            offset: Angle::ZERO,
        })
    }

    /// What the shown angle is too great by, at each entry, in parts of 2³² of a turn.
    #[must_use]
    pub fn with_table(self, table: &'static [i32; ENTRIES]) -> Self {
        Self { table, ..self }
    }

    /// A word came.
    ///
    /// # Errors
    /// It is too far from the last; nothing changes.
    #[inline]
    pub fn look(&mut self, word: u32) -> Result<(), FeedbackFault> {
        let angle = self.told(word);
        if self.moved(angle).unsigned_abs() > self.reach {
            return Err(FeedbackFault::Jump);
        }
        self.go_to(angle);
        Ok(())
    }

    /// A word came after others were missed: the position goes on by the shorter way.
    pub fn resume(&mut self, word: u32) {
        self.go_to(self.told(word));
    }

    fn told(&self, word: u32) -> Angle {
        let shift = 32_u32.saturating_sub(self.bits.into());
        // The middle of what the word stands for.
        let shown = (word << shift).wrapping_add(1 << shift.saturating_sub(1));
        Angle::from_bits(shown.wrapping_sub(self.error(shown).cast_unsigned()))
    }

    fn moved(&self, angle: Angle) -> i32 {
        let last = self.last.unwrap_or(angle);
        angle.minus(last).bits().cast_signed()
    }

    fn go_to(&mut self, angle: Angle) {
        self.position = match self.last {
            Some(_) => self.position.wrapping_add(self.moved(angle).into()),
            // The first word is where the position begins.
            None => angle.bits().into(),
        };
        self.last = Some(angle);
    }

    fn error(&self, shown: u32) -> i32 {
        let entry = (shown >> BEYOND) as usize;
        let here = self.table.get(entry).copied().unwrap_or(0);
        let next = self.table.get((entry + 1) % ENTRIES).copied().unwrap_or(0);
        let part = i64::from(shown & ((1 << BEYOND) - 1));
        let slope = i64::from(next) - i64::from(here);
        here.wrapping_add(((slope * part) >> BEYOND) as i32)
    }

    /// In parts of 2³² of a turn, whole turns counted on from the first word.
    pub fn position(&self) -> i64 {
        self.position
    }

    /// The electrical angle, by the offset that was found.
    #[inline]
    pub fn angle(&self) -> Angle {
        let turn = self.last.map_or(0, Angle::bits);
        Angle::from_bits(turn.wrapping_mul(self.pole_pairs)).plus(self.offset)
    }

    /// Other pole pairs.
    pub fn set_pole_pairs(&mut self, pole_pairs: u16) {
        self.pole_pairs = pole_pairs.into();
    }

    /// The rotor stands at this electrical angle now.
    pub fn set_angle(&mut self, angle: Angle) {
        self.offset = self.offset.plus(angle.minus(self.angle()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motor::tests::servo_100w;
    use core::f64::consts::TAU;
    use std::boxed::Box;

    /// The word of a magnet that is off its centre, at so many turns.
    fn word(turns: f64, bits: u8, off: f64) -> u32 {
        let shown = turns + off * (turns * TAU).sin();
        (shown.rem_euclid(1.0) * f64::from(1u32 << bits)) as u32 % (1 << bits)
    }

    #[test]
    fn a_table_takes_out_what_a_magnet_off_its_centre_shows() {
        const PARTS: f64 = 4_294_967_296.0;
        let off = 0.003;
        let table: &mut [i32; ENTRIES] = Box::leak(Box::new(NO_ERROR));
        for (entry, error) in table.iter_mut().enumerate() {
            let shown = entry as f64 / ENTRIES as f64;
            let mut turns = shown;
            for _ in 0..30 {
                turns = shown - off * (turns * TAU).sin();
            }
            *error = ((shown - turns) * PARTS) as i32;
        }
        let reach = Angle::from_turns(0.1);
        for (table, least, max) in [(&NO_ERROR, 0.002_9, 0.003_1), (&*table, 0.0, 0.000_07)] {
            let mut encoder = Absolute::new(&servo_100w(), 14, reach)
                .unwrap()
                .with_table(table);
            let mut worst = 0.0_f64;
            for step in 0..3_000 {
                let turns = f64::from(step) * 0.001;
                encoder.look(word(turns, 14, off)).unwrap();
                worst = worst.max((encoder.position() as f64 / PARTS - turns).abs());
            }
            assert!((least..=max).contains(&worst), "{worst}");
        }
    }

    #[test]
    fn a_jump_is_a_fault_and_is_not_counted() {
        let reach = Angle::from_turns(0.01);
        let mut encoder = Absolute::new(&servo_100w(), 12, reach).unwrap();
        encoder.look(4_090).unwrap();
        let first = encoder.position();
        encoder.look(4_095 - 4_080).unwrap();
        assert_eq!(
            (encoder.position() - first) >> 20,
            21,
            "over the end of the turn"
        );
        let before = encoder;
        assert_eq!(encoder.look(100), Err(FeedbackFault::Jump));
        assert_eq!(encoder, before);
        encoder.resume(100);
        assert_eq!((encoder.position() - first) >> 20, 106);
        assert_eq!(Absolute::new(&servo_100w(), 11, reach), Err(Implausible));
    }
}
