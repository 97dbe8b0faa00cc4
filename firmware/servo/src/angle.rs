//! An angle as a fraction of a turn: 2³² is a whole one, so it wraps as turns do.

use core::f64::consts::TAU;

/// An angle, mechanical or electrical; whose turn it is a part of is told where it is used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Angle(u32);

/// Entries of the table in a turn.
const ENTRIES: usize = 256;

/// The sine at each entry, and the cosine a quarter of a turn further.
const SINES: [f32; ENTRIES + ENTRIES / 4] = sines();

impl Angle {
    /// No turn at all.
    pub const ZERO: Self = Self(0);

    /// A quarter of a turn.
    pub const QUARTER: Self = Self(1 << 30);

    /// Half a turn.
    pub const HALF: Self = Self(1 << 31);

    /// So many parts of 2³² of a turn.
    pub const fn from_bits(bits: u32) -> Self {
        Self(bits)
    }

    /// In parts of 2³² of a turn.
    pub const fn bits(self) -> u32 {
        self.0
    }

    /// An angle in turns. Whole turns are left out, up to 2³¹ of them; NaN is 0.
    #[inline(never)]
    pub fn from_turns(turns: f32) -> Self {
        Self((turns * 4_294_967_296.0) as i64 as u32)
    }

    /// In turns, from −½ to below ½.
    pub fn turns(self) -> f32 {
        self.0.cast_signed() as f32 * (1.0 / 4_294_967_296.0)
    }

    /// Turned on by another.
    #[must_use]
    pub const fn plus(self, other: Self) -> Self {
        Self(self.0.wrapping_add(other.0))
    }

    /// Turned back by another.
    #[must_use]
    pub const fn minus(self, other: Self) -> Self {
        Self(self.0.wrapping_sub(other.0))
    }

    /// Sine and cosine, both within 3 · 10⁻⁶: the nearest entry below, and two terms of Taylor's series from there.
    #[inline]
    pub fn sine_cosine(self) -> (f32, f32) {
        const PART: f32 = (TAU / 4_294_967_296.0) as f32;
        let entry = (self.0 >> 24) as u8 as usize;
        let sine = SINES.get(entry).copied().unwrap_or(0.0);
        let cosine = SINES.get(entry + ENTRIES / 4).copied().unwrap_or(0.0);
        let beyond = (self.0 & 0x00FF_FFFF) as f32 * PART;
        let near = 1.0 - 0.5 * beyond * beyond;
        (near * sine + beyond * cosine, near * cosine - beyond * sine)
    }
}

/// Sine and cosine of four times a small angle in rad, by Taylor's series up to its fourth power. Where that is up to a twentieth of a turn they are within 3 · 10⁻⁵, up to an
/// eighth within 2.5 · 10⁻³.
#[inline(always)]
pub(crate) fn sine_cosine_of_four(angle: f32) -> (f32, f32) {
    let square = angle * angle;
    let fourth = (32.0 / 3.0) * square;
    (angle * (4.0 - fourth), 1.0 - square * (8.0 - fourth))
}

#[allow(
    clippy::indexing_slicing,
    reason = "a constant: what is beyond the table does not compile"
)]
const fn sines() -> [f32; ENTRIES + ENTRIES / 4] {
    let mut table = [0.0; ENTRIES + ENTRIES / 4];
    let mut entry = 0;
    while entry < table.len() {
        table[entry] = sine(entry) as f32;
        entry += 1;
    }
    table
}

/// Of an entry, by Taylor's series within a quarter of a turn.
const fn sine(entry: usize) -> f64 {
    let entry = entry % ENTRIES;
    let (half, sign) = if entry < ENTRIES / 2 {
        (entry, 1.0)
    } else {
        (entry - ENTRIES / 2, -1.0)
    };
    let folded = if half > ENTRIES / 4 {
        ENTRIES / 2 - half
    } else {
        half
    };
    let angle = folded as f64 * TAU / ENTRIES as f64;
    let (mut term, mut sum, mut order) = (angle, angle, 1.0);
    while order < 25.0 {
        term = -term * angle * angle / ((order + 1.0) * (order + 2.0));
        sum += term;
        order += 2.0;
    }
    sign * sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_are_within_three_millionths() {
        for step in 0..100_003_u32 {
            let angle = Angle::from_bits(step.wrapping_mul(42_949));
            let exact = f64::from(angle.bits()) / 4_294_967_296.0 * TAU;
            let (sine, cosine) = angle.sine_cosine();
            assert!((f64::from(sine) - exact.sin()).abs() < 3e-6);
            assert!((f64::from(cosine) - exact.cos()).abs() < 3e-6);
        }
    }

    #[test]
    fn a_small_angle_has_its_sine_and_cosine() {
        for step in -1_000..=1_000_i32 {
            let eighth = step as f32 / 1_000.0 * core::f32::consts::FRAC_PI_4;
            let (sine, cosine) = sine_cosine_of_four(eighth / 4.0);
            let within = if step.abs() <= 400 { 3e-5 } else { 2.5e-3 };
            assert!((sine - eighth.sin()).abs() < within, "{step}");
            assert!((cosine - eighth.cos()).abs() < within, "{step}");
        }
    }

    #[test]
    fn turns_go_in_and_out() {
        assert_eq!(Angle::from_turns(0.25), Angle::QUARTER);
        assert_eq!(Angle::from_turns(-3.5), Angle::HALF);
        assert_eq!(Angle::from_turns(f32::NAN), Angle::ZERO);
        assert_eq!(Angle::QUARTER.minus(Angle::HALF).turns(), -0.25);
    }
}
