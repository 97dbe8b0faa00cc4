//! The sin² ramp: v = v₀ + Δv·sin²(π·s/2), with s from 0 to 1 over the ramp.
//!
//! It takes as long as the linear ramp between the same velocities and goes as far, so a move has its corners where the trapezoid
//! has them. Its acceleration begins and ends with nothing; in the middle it is π/2 times that of the linear ramp.
//!
//! The way is v₀·t + Δv·T·f(s) with f(s) = s/2 − sin(π·s)/2π, the integral of sin². So way, velocity and acceleration all come from the sine
//! and the cosine of π·s: those of the nearest 128th, from a table, turned by the rest of the angle, of which a few terms tell sine and
//! cosine to the last bits. f(s) is right to two units of 2⁻⁶⁴, sin² to eight.

use crate::plan::phase::{Offset, over_time};
use crate::plan::rough::{Kind, Rough};
use crate::wide::Wide;

/// sin(π·k/128) for k from 0 to 64, Q64. One is the greatest fraction there is.
#[rustfmt::skip]
static SINES: [u64; 65] = [
    0x0000_0000_0000_0000, 0x0648_557D_E8D9_9F7E, 0x0C8F_B2F8_86EC_09F3,
    0x12D5_2092_CE19_F5CD, 0x1917_A6BC_29B4_2BE2, 0x1F56_4E56_A973_0E34,
    0x2590_20DD_1CC2_7445, 0x2BC4_2889_167F_8CAA, 0x31F1_7078_D34C_156D,
    0x3817_04D4_FC9E_C5F9, 0x3E33_F2F6_42BE_355F, 0x4447_498A_C7D9_DD82,
    0x4A50_18BB_567C_16A3, 0x504D_7250_5D98_050D, 0x563E_69D6_AC7F_73F8,
    0x5C22_14C3_E916_7ABB, 0x61F7_8A9A_BAA5_8B47, 0x67BD_E50E_A3B6_28B7,
    0x6D74_4027_8573_00AE, 0x7319_BA64_C711_785A, 0x78AD_74E0_1BD8_EC78,
    0x7E2E_936F_E26A_E7ED, 0x839C_3CC9_17FF_6CB5, 0x88F5_9AA0_DA59_1422,
    0x8E39_D9CD_7346_4365, 0x9368_2A66_E896_F545, 0x987F_BFE7_0B81_A708,
    0x9D7F_D149_0285_C9E4, 0xA267_9928_48EE_B0C0, 0xA736_55DF_1F2F_489E,
    0xABEB_49A4_6764_FD15, 0xB085_BAA8_E966_F6DB, 0xB504_F333_F9DE_6484,
    0xB968_41BF_7FFC_B21B, 0xBDAE_F913_557D_76F1, 0xC1D8_705F_FCBB_6E91,
    0xC5E4_0358_A8BA_05A7, 0xC9D1_124C_931F_DA7B, 0xCD9F_023F_9C3A_059E,
    0xD14D_3D02_313C_0EED, 0xD4DB_3148_750D_181A, 0xD848_52C0_A80F_FCDB,
    0xDB94_1A28_CB71_EC87, 0xDEBE_0563_7CA9_4CFB, 0xE1C5_978C_05ED_8692,
    0xE4AA_5909_A08F_A7B4, 0xE76B_D7A1_E63B_9786, 0xEA09_A68A_6E49_CD62,
    0xEC83_5E79_946A_3145, 0xEED8_9DB6_6611_E308, 0xF109_0827_B437_25FD,
    0xF314_4762_4708_8F75, 0xF4FA_0AB6_316E_D2EC, 0xF6BA_073B_424B_19E8,
    0xF853_F7DC_9186_B953, 0xF9C7_9D63_272C_4628, 0xFB14_BE7F_BAE5_8156,
    0xFC3B_27D3_8A5D_49AB, 0xFD3A_ABF8_4528_B50C, 0xFE13_2387_0CFE_9A3E,
    0xFEC4_6D1E_8929_2CF0, 0xFF4E_6D68_0C41_D0A9, 0xFFB1_0F1B_CB6B_EF1D,
    0xFFEC_4304_2668_65D9, 0xFFFF_FFFF_FFFF_FFFF,
];

const HALF: u64 = 1 << 63;

/// Half of a 128th, Q64.
const HALF_PART: u64 = 1 << 56;

/// 1/2π, Q64, and π/2, Q63; rounded to the nearest.
const PART_OF_TURN: u64 = 2_935_890_503_282_001_226;
const HALF_PI: u64 = 14_488_038_916_154_245_685;

/// π²/2, Q61; rounded down.
const HALF_PI_SQUARED: u64 = 11_378_879_155_978_302_162;

/// A change of velocity, as it is seen from that end of the ramp at which the phase is anchored.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sine {
    /// The acceleration of the linear ramp in its place, Q96 steps per tick².
    mean: i128,
    /// From the velocity at the anchor to that at the other end, Q96 steps per tick.
    change: i128,
    /// How long it takes.
    time: Offset,
    /// How many bits that has: n. And 2ⁿ⁺⁶³ by it, rounded down.
    bits: u32,
    inverse: u64,
    /// The change times the time, Q64 steps.
    way: i128,
}

impl Sine {
    /// The ramp in the place of a linear one, of half of an acceleration, that takes `time`, which is not 0.
    pub(super) fn new(half_acceleration: i128, time: Offset) -> Self {
        let falls = half_acceleration < 0;
        let mean = half_acceleration.wrapping_mul(2);
        let change = over_time(mean.unsigned_abs(), time);
        let way = if (change | time) >> 96 == 0 && time >> 64 == 0 {
            let time = time as u64;
            let low = u128::from(change as u64).wrapping_mul(time.into()) >> 64;
            let high = u128::from((change >> 64) as u32).wrapping_mul(time.into());
            high.wrapping_add(low)
        } else {
            Wide::product(change, time).shifted_wrapping(64)
        };
        let bits = 128u32.wrapping_sub(time.leading_zeros());
        Self {
            mean,
            change: with_sign(change, falls),
            time,
            bits,
            inverse: inverse(time, bits),
            way: with_sign(way, falls),
        }
    }

    /// What the ramp adds to position and velocity at `away` ticks (Q32) behind the anchor, or before it if that is negative: Q96.
    pub(super) fn at(&self, away: i128) -> (i128, i128) {
        self.moved(&Arc::new(self.part(away)), away < 0)
    }

    /// The same, and the acceleration there, Q96 steps per tick².
    pub(super) fn at_with_acceleration(&self, away: i128) -> (i128, i128, i128) {
        let arc = Arc::new(self.part(away));
        let (way, change) = self.moved(&arc, away < 0);
        (way, change, self.pull(&arc, away < 0))
    }

    /// The acceleration there.
    pub(super) fn acceleration(&self, away: i128) -> i128 {
        self.pull(&Arc::new(self.part(away)), away < 0)
    }

    /// Way and change of velocity there.
    fn moved(&self, arc: &Arc, before: bool) -> (i128, i128) {
        (
            with_sign(
                scaled(self.way.unsigned_abs(), arc.way()),
                (self.way < 0) != before,
            ),
            with_sign(
                scaled(self.change.unsigned_abs(), arc.speed()) >> 32,
                self.change < 0,
            ),
        )
    }

    /// The acceleration there: π/2·sin(π·s) times that of the linear ramp.
    fn pull(&self, arc: &Arc, before: bool) -> i128 {
        let acceleration = scaled(self.mean.unsigned_abs(), times(arc.sine, HALF_PI)) >> 31;
        with_sign(acceleration, (self.mean < 0) != before)
    }

    /// Its change of velocity by the square of its time: by which the jerk goes with which it begins and ends, and which is the least at which it
    /// can be left without going beyond its velocity.
    pub(super) fn steepness(&self) -> Rough {
        let mean = Rough::of(self.mean.unsigned_abs(), Kind::Acceleration);
        // 2⁶³⁺ⁿ by the time in Q32 ticks, and rough numbers count 2²⁴ of them.
        let lead = Rough::whole((self.inverse >> 32) as u32);
        let unit = (32 + 24i32 + 32 - 63).wrapping_sub(self.bits.cast_signed());
        mean.times(lead).times(Rough::power(unit.max(-126)))
    }

    /// How much of the ramp's time that is, Q64.
    fn part(&self, away: i128) -> u64 {
        let away = away.unsigned_abs().min(self.time);
        // Both with their leading bit set, where the time has it: as 64 bits.
        let above = 64u32.saturating_sub(self.bits);
        let below = self.bits.saturating_sub(64);
        let leading = match below {
            0 => (away as u64) << (above & 63),
            _ => (away >> (below & 127)) as u64,
        };
        let part = u128::from(leading).wrapping_mul(self.inverse.into());
        u64::try_from(part >> 63).unwrap_or(u64::MAX)
    }
}

/// ⌊number · factor / 2³²⌋ modulo 2¹²⁸.
#[inline(never)]
fn scaled(number: u128, factor: u64) -> u128 {
    let [a, b, c, d] = [0, 32, 64, 96].map(|below| u64::from((number >> below) as u32));
    let (low, high) = (u64::from(factor as u32), factor >> 32);
    let upper = |sum: u64| sum >> 32;
    let lower = |sum: u64| u64::from(sum as u32);
    // The lower digit's products, of which the first digit is left out; and the higher one's on top of them.
    let first = a.wrapping_mul(low);
    let second = b.wrapping_mul(low).wrapping_add(upper(first));
    let third = c.wrapping_mul(low).wrapping_add(upper(second));
    let fourth = d.wrapping_mul(low).wrapping_add(upper(third));
    let one = a.wrapping_mul(high).wrapping_add(lower(second));
    let two = (b.wrapping_mul(high).wrapping_add(lower(third))).wrapping_add(upper(one));
    let three = (c.wrapping_mul(high).wrapping_add(lower(fourth))).wrapping_add(upper(two));
    let four = (d.wrapping_mul(high).wrapping_add(upper(fourth))).wrapping_add(upper(three));
    let pair = |low: u64, high: u64| u128::from(lower(low) | high << 32);
    pair(three, four) << 64 | pair(one, two)
}

fn with_sign(magnitude: u128, negative: bool) -> i128 {
    let value = magnitude.cast_signed();
    if negative {
        value.wrapping_neg()
    } else {
        value
    }
}

/// A part of half a turn, and what is to be known of it, all Q64.
struct Arc {
    part: u64,
    /// sin(π·s), and 1 − |cos(π·s)|.
    sine: u64,
    fall: u64,
}

impl Arc {
    #[inline(never)]
    fn new(part: u64) -> Self {
        // The sine is the same from either end.
        let near = if part > HALF {
            part.wrapping_neg()
        } else {
            part
        };
        let index = near.wrapping_add(HALF_PART) >> 57;
        // From there on, or back to here: a 256th at most, so that its bits move up by 8.
        let rest = near.wrapping_sub(index << 57).cast_signed();
        let is_before = rest < 0;
        let rest = (rest ^ (rest >> 63)).cast_unsigned() << 8;
        let (sine, fall) = small(rest);
        let index = index as usize & 127;
        let start = SINES.get(index).copied().unwrap_or(u64::MAX);
        let across = SINES.get(64usize.wrapping_sub(index)).copied().unwrap_or(0);
        let (up, down) = (times(across, sine), times(start, sine));
        let risen = start.wrapping_sub(times(start, fall));
        let fallen = (!across).wrapping_add(times(across, fall));
        let (sine, fall) = if is_before {
            (risen.wrapping_sub(up), fallen.wrapping_sub(down))
        } else {
            (risen.wrapping_add(up), fallen.wrapping_add(down))
        };
        Self { part, sine, fall }
    }

    /// f(s)
    fn way(&self) -> u64 {
        let back = times(self.sine, PART_OF_TURN);
        // f(s) − f(1 − s) = s − ½, and s/2 − sin is least near nothing, where a rounded sine may be too large.
        let (beyond, near) = if self.part > HALF {
            (self.part.wrapping_sub(HALF), self.part.wrapping_neg())
        } else {
            (0, self.part)
        };
        beyond.wrapping_add((near >> 1).saturating_sub(back))
    }

    /// sin²(π·s/2) = (1 − cos(π·s))/2
    fn speed(&self) -> u64 {
        let half = self.fall >> 1;
        if self.part > HALF { !half } else { half }
    }
}

/// sin b and 1 − cos b, Q64, of a small angle b = π/256·d, d Q64.
fn small(d: u64) -> (u64, u64) {
    let square = times(d, d);
    let lead = u64::from((square >> 32) as u32);
    // 1 − cos b = b²/2 − b⁴/24 + b⁶/720. In u = d²: π²/16 · u, Q64 · 2¹³; and the other two, as they bear on that, Q48.
    let less = 2_179_004_481u32.wrapping_sub((lead.wrapping_mul(10_938) >> 32) as u32);
    let bent = HALF_PI_SQUARED.wrapping_sub(lead.wrapping_mul(less.into()) >> 16);
    let fall = times(bent, square) >> 13;
    // 1 − sin b / b = (1 − cos b)/3 + b⁴/180 − (1/2160 − 1/5040)·b⁶.
    let fourth = lead.wrapping_mul(lead) >> 32;
    let more = 2_324_271_446u32.wrapping_sub((lead.wrapping_mul(16_668) >> 32) as u32);
    let less = times(fall, u64::MAX / 3).wrapping_add(fourth.wrapping_mul(more.into()) >> 32);
    // π/4 · d, Q70
    let line = times(d, HALF_PI);
    (line.wrapping_sub(times(line, less)) >> 6, fall)
}

/// 2ⁿ⁺⁶³ by a time of n bits, to the last one but one, and not more.
fn inverse(time: Offset, bits: u32) -> u64 {
    // From 2⁶³ to 2⁶⁴.
    let leading = match bits.saturating_sub(64) {
        0 => (time as u64) << (64u32.wrapping_sub(bits) & 63),
        below => (time >> (below & 127)) as u64,
    };
    let lead = ((leading >> 32) as u32) as f32;
    let rough = (9_223_372_036_854_775_808.0 / lead) as u32;
    // x·y = 2⁹⁵·(1 − e), and 2⁹⁵/x = y·(1 + e + e²); e has 63 bits.
    let product = (leading >> 32)
        .wrapping_mul(rough.into())
        .wrapping_add(u64::from(leading as u32).wrapping_mul(rough.into()) >> 32);
    let left = (1u64 << 63).wrapping_sub(product).cast_signed();
    let short = i64::from((left >> 21) as i32);
    let series = left.wrapping_add(short.wrapping_mul(short) >> 21);
    let upper = (series >> 32).wrapping_mul(rough.into()) << 1;
    let lower = u64::from(series as u32).wrapping_mul(rough.into()) >> 31;
    let near = u64::from(rough) << 32;
    let near = near.wrapping_add_signed(upper).wrapping_add(lower);
    // What is left of 2¹²⁷ are a few times x, so that a few bits tell how many.
    let product = u128::from(leading).wrapping_mul(near.into());
    let left = i64::from((product >> 60) as i32).wrapping_neg();
    let more = left.wrapping_mul((near >> 40).cast_signed()) >> 27;
    near.wrapping_add_signed(more).wrapping_sub(1)
}

/// The product of two fractions.
fn times(a: u64, b: u64) -> u64 {
    (u128::from(a).wrapping_mul(b.into()) >> 64) as u64
}

#[cfg(test)]
mod tests {
    use super::{Arc, HALF, HALF_PI, HALF_PI_SQUARED, SINES, Sine, inverse, scaled};
    use crate::plan::phase::half_peak;
    use crate::wide::Wide;
    use core::f64::consts::PI;
    use proptest::prelude::*;

    fn fraction(bits: u64) -> f64 {
        bits as f64 / 2f64.powi(64)
    }

    fn way(s: u64) -> u64 {
        Arc::new(s).way()
    }

    fn speed(s: u64) -> u64 {
        Arc::new(s).speed()
    }

    /// (π·s)ⁿ/n! − (π·s)ⁿ⁺²/(n+2)! + … for n = `first`, of which the first term is given; all Q64, for s up to a half.
    fn series(s: u64, first: u128, mut term: u128) -> u64 {
        let square = (u128::from(s) * u128::from(s)) >> 64;
        let square = (square * u128::from(HALF_PI_SQUARED)) >> 63;
        let (mut sum, mut n) = (0i128, first);
        let mut falls = false;
        while term != 0 {
            sum += if falls { -1 } else { 1 } * term.cast_signed();
            falls = !falls;
            term = ((term * square) >> 61) / ((n + 1) * (n + 2));
            n += 2;
        }
        u64::try_from(sum.max(0)).unwrap_or(u64::MAX)
    }

    #[test]
    fn sines_and_cosines_of_the_table_make_one() {
        for (sine, cosine) in SINES.iter().zip(SINES.iter().rev()) {
            let square = |value: u64| u128::from(value) * u128::from(value);
            let sum = square(*sine) >> 1;
            let sum = sum + (square(*cosine) >> 1);
            assert!(sum.abs_diff(1 << 127) <= 1 << 64, "{sine} {cosine}");
        }
    }

    #[test]
    fn the_ends_and_the_middle_are_exact() {
        assert_eq!((way(0), speed(0)), (0, 0));
        assert!(speed(HALF).abs_diff(HALF) <= 16);
        assert!(way(u64::MAX).abs_diff(HALF) <= 2);
        assert!(speed(u64::MAX) > u64::MAX - 2);
    }

    proptest! {
        #[test]
        fn the_series_are_the_functions(s: u64) {
            let x = fraction(s);
            prop_assert!((fraction(speed(s)) - (PI * x / 2.0).sin().powi(2)).abs() < 1e-15);
            prop_assert!((fraction(way(s)) - (x / 2.0 - (PI * x).sin() / (2.0 * PI))).abs() < 1e-15);
        }

        #[test]
        fn an_inverse_is_that_of_a_division(time in 1u128.., shift in 0u32..128, near in 0u128..9) {
            let power = 1u128 << (127 - shift);
            for time in [time >> shift, power + near, power - near.min(power)] {
                let bits = 128 - time.leading_zeros();
                let leading = if bits > 64 { time >> (bits - 64) } else { time << (64 - bits) };
                let exact = ((1 << 127) - 1) / leading.max(1);
                if time != 0 {
                    let off = exact - u128::from(inverse(time, bits));
                    prop_assert!(off <= 3, "{off} less than that of {time}");
                }
            }
        }

        #[test]
        fn a_scaled_number_is_its_product(number: u128, factor: u64) {
            let product = Wide::product(number, factor.into());
            prop_assert_eq!(scaled(number, factor), product.shifted_wrapping(32));
        }

        #[test]
        fn sine_and_cosine_are_right_to_their_last_bits(s in 0..HALF, index in 0u64..64, near in 0u64..9) {
            let corner = (index << 56).saturating_add(near).saturating_sub(4);
            for s in [s, s >> 8, s >> 32, corner] {
                let arc = Arc::new(s);
                // π·s, Q64, from π/2, Q63.
                let angle = (u128::from(s) * u128::from(HALF_PI)) >> 62;
                let sine = series(s, 1, angle);
                prop_assert!(sine.abs_diff(arc.sine) <= 64, "{sine} {}", arc.sine);
                let fall = series(s, 0, 1 << 64);
                prop_assert!((!fall).abs_diff(arc.fall) <= 64, "{} {}", !fall, arc.fall);
            }
        }

        #[test]
        fn neither_ever_falls(s: u64, step in 0u64..1 << 40) {
            let next = s.saturating_add(step);
            prop_assert!(way(next) + 4 >= way(s));
            prop_assert!(speed(next).saturating_add(16) >= speed(s));
        }

        #[test]
        fn the_acceleration_is_the_slope_of_the_velocity(part in 1u32..1 << 20, change in 1i128 << 70..1i128 << 90) {
            let ticks = 1i128 << 20;
            let half = change >> 21;
            let sine = Sine::new(half, (ticks << 32).cast_unsigned());
            let at = i128::from(part) << 32;
            let slope = sine.at(at + (8 << 32)).1 - sine.at(at - (8 << 32)).1;
            let slope = slope as f64 / 16.0;
            // That of the linear ramp, halved.
            let peak = half_peak(half) as f64 * 2.0;
            prop_assert!((sine.acceleration(at) as f64 - slope).abs() < 1e-4 * peak);
            prop_assert!(slope <= peak);
            prop_assert_eq!(sine.acceleration(-at), -sine.acceleration(at));
        }
    }
}
