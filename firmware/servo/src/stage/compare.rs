//! Pulse widths as the compare values of a timer that counts up and down, and is on below them.
//!
//! ```text
//! top ───────╱╲───────────────╱╲──      samples are taken at the top: there the lower switches are on
//!           ╱  ╲             ╱  ╲
//! value ───╱────╲───────────╱────╲
//!         ╱      ╲         ╱      ╲
//! 0 ─────╱        ╲───────╱        ╲
//!  on ──┐          ┌─────┐          ┌    the upper switch
//! ```

use crate::number::between;

/// The greatest share of the time for which a chopper burns.
const MAX: f32 = 0.95;

/// A timer that counts from 0 to a top and back in each period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counter {
    top: u16,
}

impl Counter {
    /// With the greatest count, up to 65,534.
    pub const fn new(top: u16) -> Self {
        Self { top }
    }

    /// That of a half bridge, by its [width](crate::modulation::Widths).
    #[inline]
    pub const fn half_bridge(&self, width: i16) -> u16 {
        let on = (width as i32 + (1 << 15)).cast_unsigned();
        ((on * self.top as u32 + (1 << 15)) >> 16) as u16
    }

    /// Those of the two sides of a full bridge: half of its width more on one, half less on the other.
    #[inline]
    pub const fn full_bridge(&self, width: i16) -> [u16; 2] {
        let side = self.half_bridge(width);
        [side, self.top - side]
    }

    /// Those of a half bridge that burns for a share of the time, from 0 to 0.95, in a resistor against the lower side: the lower switch is on below the first, the
    /// upper one above the second, and between them neither for so many counts of dead time. With nothing to burn both are off. The lower one, whose time is never 0, charges
    /// what switches the upper one.
    pub fn chopper(&self, share: f32, dead: u16) -> [u16; 2] {
        let share = between(share, 0.0, MAX);
        if share <= 0.0 {
            return [0, self.top + 1];
        }
        let upper = self.top - (share * f32::from(self.top) + 0.5) as u16;
        [upper.saturating_sub(dead), upper]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const COUNTER: Counter = Counter::new(4_200);

    #[test]
    fn widths_become_counts() {
        let counts =
            [i16::MIN, -16_384, 0, 16_384, i16::MAX].map(|width| COUNTER.half_bridge(width));
        assert_eq!(counts, [0, 1_050, 2_100, 3_150, 4_200]);
        assert_eq!(COUNTER.full_bridge(0), [2_100, 2_100]);
        assert_eq!(COUNTER.full_bridge(-16_384), [1_050, 3_150]);
        assert_eq!(Counter::new(65_534).full_bridge(i16::MAX), [65_533, 1]);
    }

    #[test]
    fn a_chopper_burns_above_its_second_value() {
        assert_eq!(COUNTER.chopper(0.0, 40), [0, 4_201]);
        assert_eq!(COUNTER.chopper(f32::NAN, 40), [0, 4_201]);
        assert_eq!(COUNTER.chopper(0.5, 40), [2_060, 2_100]);
        assert_eq!(COUNTER.chopper(1.0, 40), [170, 210]);
    }

    proptest! {
        /// Never are both switches on, whatever is asked for.
        #[test]
        fn the_chopper_has_its_dead_time(bits: u32, top in 100..10_000_u16, dead in 0..100_u16) {
            let [lower, upper] = Counter::new(top).chopper(f32::from_bits(bits), dead);
            prop_assert!(upper <= top + 1);
            prop_assert!(upper - lower == dead || lower == 0);
        }
    }
}
