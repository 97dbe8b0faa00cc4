//! The sin² ramp: v = v₀ + Δv·sin²(π·s/2), with s from 0 to 1 over the ramp.
//!
//! It takes as long as the linear ramp between the same velocities and covers the same distance, so a move has its corners where the
//! trapezoid has them. Its acceleration begins and ends at zero; in the middle it is π/2 times that of the linear ramp.
//!
//! It is made of cubic pieces, in which the acceleration is a straight line. Their corners are at s = (k + ½)/n for k from 0 to n − 1, and there
//!
//! - acceleration = A·sin(π·s)·Δv/T
//! - velocity = v₀ + Δv·(½ − B·cos(π·s))
//! - distance = v₀·s·T + Δv·T·(s/2 − C·sin(π·s))
//!
//! hold exactly, for A, B and C that depend on n alone. So a piece is worked out from its two corners, without those before it. The greatest
//! acceleration is less than π/2 times that of the linear ramp. The position is off from the sin² by at most 0.076·n⁻⁴·Δv·T: n is
//! chosen so that this is less than 0.01 steps, for ramps of up to 17 million steps; longer ones are off by 3·10⁻¹⁰ of Δv·T.

use super::piece::{Instant, Piece, Shape};
use super::smooth::Smooth;
use crate::clock::Ticks;
use crate::divide::{estimate, quotient};
use crate::exact::{DistanceQ96, Q96, Q128, TicksQ32, Uq96, product_q32, with_sign};
use crate::low;

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

/// 1/cos(π/256), Q63, rounded down. Half of the sum of two neighbours in the table, times that, is the sine between them.
const BETWEEN: u64 = 9_224_066_592_104_769_579;

const HALF: u64 = 1 << 63;

/// Shorter ramps are linear: the difference is below a step, and their jerk may be too large for its number.
pub(super) const SHORTEST: TicksQ32 = TicksQ32::from_bits(8 << 32);

/// Δv·T of a ramp, steps, with 64 bits behind the point: it may be more than a position has room for.
#[derive(Clone, Copy)]
struct Product(u128);

impl Product {
    fn of(change: Uq96, time: TicksQ32) -> Self {
        let whole = change.bits() * (time.bits() >> 64);
        Self(share(change, low::u64(time.bits())).bits() + whole)
    }

    const fn steps(self) -> u128 {
        self.0 >> 64
    }

    /// A part of it, Q64.
    fn share(self, part: u64) -> DistanceQ96 {
        DistanceQ96::from_bits(product_q32(self.0, part.into()))
    }
}

/// How a ramp is divided, and what follows from that.
struct Division {
    /// 2ⁿ pieces, of which the first is cut into two halves: one of them becomes the last.
    bits: u32,
    /// For a Δv·T of fewer steps.
    below: u64,
    /// A, Q63, B and C, Q64; rounded down.
    acceleration: u64,
    velocity: u64,
    distance: u64,
}

static DIVISIONS: [Division; 5] = [
    Division {
        bits: 3,
        below: 532,
        acceleration: 14_674_380_134_951_303_800,
        velocity: 9_221_636_346_863_465_252,
        distance: 2_935_733_068_389_550_352,
    },
    Division {
        bits: 4,
        below: 8_652,
        acceleration: 14_534_596_368_387_935_979,
        velocity: 9_223_264_590_210_229_723,
        distance: 2_935_880_656_419_123_677,
    },
    Division {
        bits: 5,
        below: 138_961,
        acceleration: 14_499_676_265_856_326_470,
        velocity: 9_223_365_337_576_049_346,
        distance: 2_935_889_887_763_973_495,
    },
    Division {
        bits: 6,
        below: 2_225_495,
        acceleration: 14_490_948_123_541_535_172,
        velocity: 9_223_371_618_401_906_119,
        distance: 2_935_890_464_810_821_516,
    },
    Division {
        bits: 7,
        below: u64::MAX,
        acceleration: 14_488_766_209_808_216_242,
        velocity: 9_223_372_010_705_409_413,
        distance: 2_935_890_500_877_532_482,
    },
];

/// What of the ramp lies behind one of its corners.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Corner {
    /// Of Δv·T and Δv, Q64.
    distance: u64,
    velocity: u64,
    /// In parts of Δv/T, Q63.
    acceleration: u64,
}

impl Corner {
    const FIRST: Self = Self {
        distance: 0,
        velocity: 0,
        acceleration: 0,
    };
}

impl Division {
    /// For this Δv·T.
    fn of(distance: Product) -> &'static Self {
        let steps = u64::try_from(distance.steps()).unwrap_or(u64::MAX);
        let [.., last] = &DIVISIONS;
        let mut divisions = DIVISIONS.iter();
        divisions.find(|one| steps < one.below).unwrap_or(last)
    }

    /// How many corners there are between the ends.
    const fn corners(&self) -> u32 {
        1 << self.bits
    }

    /// Corner `number` is at so many parts of the time: ½ from end to end are 2ⁿ of them.
    const fn place(&self, number: u32) -> u32 {
        if number > self.corners() {
            2 << self.bits
        } else {
            (2 * number).saturating_sub(1)
        }
    }

    /// The same in 256ths of half a turn.
    const fn angle(&self, number: u32) -> u32 {
        self.place(number) << (7 - self.bits)
    }

    /// When corner `number` is, from 0, the beginning, to the end.
    fn time(&self, number: u32, time: TicksQ32) -> TicksQ32 {
        TicksQ32::from_bits((time.bits() * u128::from(self.angle(number))) >> 8)
    }

    /// In which piece lies what is `away` from the beginning of a ramp that takes `time`; when that piece begins and ends.
    fn find(&self, away: TicksQ32, time: TicksQ32) -> (u32, TicksQ32, TicksQ32) {
        // The leading 24 bits give a number that is right or next to it.
        let above = 104u32.saturating_sub(time.bits().leading_zeros());
        let leading = |time: TicksQ32| low::u32(low::u64(time.bits() >> above));
        let parts = (leading(away) << (self.bits + 1)).checked_div(leading(time));
        let number = parts.unwrap_or(0).div_ceil(2).min(self.corners());
        let (begin, end) = (self.time(number, time), self.time(number + 1, time));
        if away < begin && number > 0 {
            (number - 1, self.time(number - 1, time), begin)
        } else if away >= end && number < self.corners() {
            (number + 1, end, self.time(number + 2, time))
        } else {
            (number, begin, end)
        }
    }

    /// The acceleration at a corner, in parts of Δv/T, Q63; none at either end.
    fn acceleration(&self, number: u32) -> u64 {
        if number == 0 || number > self.corners() {
            return 0;
        }
        let angle = self.angle(number);
        times(self.acceleration, sine(angle.min(256 - angle)))
    }

    /// A corner that is not the end.
    fn corner(&self, number: u32) -> Corner {
        if number == 0 || number > self.corners() {
            return Corner::FIRST;
        }
        let angle = self.angle(number);
        let sine = sine(angle.min(256 - angle));
        let across = times(self.velocity, self::sine(angle.abs_diff(128)));
        Corner {
            distance: (u64::from(angle) << 55).saturating_sub(times(self.distance, sine)),
            velocity: if angle < 128 {
                HALF - across
            } else {
                HALF + across
            },
            acceleration: times(self.acceleration, sine),
        }
    }
}

/// sin(π·k/256) for k from 0 to 128, Q64.
fn sine(k: u32) -> u64 {
    let index = (k >> 1) as usize;
    let at = |index: usize| SINES.get(index).copied().unwrap_or(u64::MAX);
    if k & 1 == 0 {
        at(index)
    } else {
        times((at(index) >> 1) + (at(index + 1) >> 1), BETWEEN) << 1
    }
}

/// A sixth of the jerk at which a ramp of duration `time` is broken off. The jerk is 5.06·Δv/T², to some 30 bits;
/// the ramp itself begins and ends with 4.97·Δv/T² at most. So the acceleration is at zero before the velocity passes the end of the
/// ramp.
pub(super) fn jerk(half_acceleration: Q96, time: TicksQ32) -> Q128 {
    let (number, above) = leading((half_acceleration.amount().bits() * 27) >> 4);
    let (divisor, below) = leading(time.bits());
    // Less than one, so a digit with 31 bits behind the point. A time has more than 32 bits, an acceleration less than 90.
    let jerk = u128::from(estimate(u64::from(number) << 31, divisor)) << (above + 33);
    Q128::from_bits((jerk >> below).cast_signed()).max(Q128::LEAST)
}

/// The leading 32 bits, and the number of bits below them; a number of 32 bits or fewer as a whole.
fn leading(value: u128) -> (u32, u32) {
    let below = 96u32.saturating_sub(value.leading_zeros());
    let lead = low::u32(low::u64(value >> below));
    (lead, below)
}

/// The same of the ramp that changes the velocity by `change` within these limits: 5.06·a²/Δv, with one division.
pub(super) fn jerk_of(half_acceleration: Uq96, change: Uq96) -> Q128 {
    let half_acceleration = half_acceleration.bits();
    // 32 bits of it are plenty.
    let (lead, below) = leading(half_acceleration);
    let exact = quotient(
        (u128::from(lead) * u128::from(lead) * 27) >> 3,
        1,
        change.bits().max(1),
    );
    // No ramp is shorter than that.
    let most = (half_acceleration * 27) << 25;
    let jerk = exact
        .checked_shl(2 * below)
        .filter(|jerk| jerk >> (2 * below) == exact)
        .map_or(most, |jerk| jerk.min(most));
    Q128::from_bits(jerk.cast_signed()).max(Q128::LEAST)
}

/// The cubic piece at tick `t` of a sin² ramp that takes `time`, at least [`SHORTEST`]; with a sixth of its jerk, and the first tick behind
/// it. `ramp` is anchored at either end of the sin² ramp, and has half of the acceleration of the linear ramp in its place.
#[inline(never)]
pub(super) fn piece(ramp: &Piece, time: TicksQ32, t: Ticks) -> (Piece, Q128, Ticks) {
    let full = ramp.half_acceleration.amount().doubled();
    let change = full.gain(time);
    let distance = Product::of(change, time);
    let division = Division::of(distance);
    let here = Instant::from(t);
    let is_back = here < ramp.anchor;
    let away = here.apart(ramp.anchor).min(time);
    let (number, begin, end) = division.find(away, time);
    let (corner, next) = (division.corner(number), division.acceleration(number + 1));
    let falls = ramp.half_acceleration < Q96::ZERO;
    // Seen from the anchor: how far it is to the corner.
    let by_ramp = distance.share(corner.distance).forwards();
    let covered = ramp.velocity.distance(begin) + with_sign(by_ramp, falls);
    let gained = share(change, corner.velocity).forwards();
    let half_acceleration = share(full, corner.acceleration).forwards();
    // The sixth of a jerk is the change of half of the acceleration by three times the time.
    let rises = next > corner.acceleration;
    let rise = share(full, next.abs_diff(corner.acceleration)).bits();
    let places = division.place(number + 1) - division.place(number);
    let sixth_jerk = quotient(rise << (division.bits + 2 - places), 2, 3 * time.bits());
    let sixth_jerk = with_sign(Q128::from_bits(sixth_jerk.cast_signed()), falls == rises);
    let (anchor, start, until) = if is_back {
        let anchor = ramp.anchor.before(begin);
        (anchor, ramp.anchor.before(end), anchor)
    } else {
        let anchor = ramp.anchor.after(begin);
        (anchor, anchor, ramp.anchor.after(end))
    };
    let piece = Piece {
        // Rounded times do not move t out of its piece.
        start: start.tick_up().clamp(ramp.start.min(t), t),
        anchor,
        position: ramp.position + with_sign(covered, is_back),
        velocity: ramp.velocity + with_sign(gained, falls),
        half_acceleration: with_sign(half_acceleration, falls != is_back),
        shape: Smooth::new(Shape::Cubic(sixth_jerk)),
    };
    (piece, sixth_jerk, until.tick_up().max(t + 1))
}

/// ⌊number · factor / 2⁶⁴⌋.
#[inline(never)]
fn share(number: Uq96, factor: u64) -> Uq96 {
    let factor = u128::from(factor);
    let low = (u128::from(low::u64(number.bits())) * factor) >> 64;
    Uq96::from_bits((number.bits() >> 64) * factor + low)
}

/// The product of two fractions.
fn times(a: u64, b: u64) -> u64 {
    ((u128::from(a) * u128::from(b)) >> 64) as u64
}

#[cfg(all(test, feature = "sin-squared"))]
mod tests {
    use super::{Corner, DIVISIONS, SINES, piece, sine, times};
    use crate::exact::{PositionQ96, Q96, TicksQ32};
    use crate::plan::piece::{Instant, Piece, Shape};
    use crate::plan::smooth::Smooth;
    use core::f64::consts::PI;
    use proptest::prelude::*;

    fn fraction(bits: u64) -> f64 {
        bits as f64 / 2f64.powi(64)
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
    fn between_the_sines_of_the_table_are_those_of_half_the_angle() {
        for k in 0..=128 {
            let exact = (f64::from(k) * PI / 256.0).sin();
            assert!((fraction(sine(k)) - exact).abs() < 1e-15, "{k}");
        }
        for k in 0..=64 {
            // sin 2b = 2·sin b·cos b, to the last bits.
            let double = u128::from(times(sine(k), sine(128 - k))) << 1;
            assert!(double.abs_diff(sine(2 * k).into()) <= 16, "{k}");
        }
    }

    /// The corners are those of a motion whose acceleration is a straight line between them, to the last bits.
    #[test]
    fn a_corner_is_where_the_piece_before_it_leads() {
        for division in &DIVISIONS {
            let end = Corner {
                distance: 1 << 63,
                velocity: u64::MAX,
                acceleration: 0,
            };
            let number = |corner: u32| {
                if corner > division.corners() {
                    end
                } else {
                    division.corner(corner)
                }
            };
            let pieces = f64::from(division.corners());
            for k in 0..=division.corners() {
                let (one, other) = (number(k), number(k + 1));
                let time = f64::from(division.place(k + 1) - division.place(k)) / 2.0 / pieces;
                let acceleration = |corner: Corner| 2.0 * fraction(corner.acceleration);
                let gain = (acceleration(one) + acceleration(other)) / 2.0 * time;
                let gained = fraction(other.velocity - one.velocity);
                assert!((gained - gain).abs() < 1e-15, "{k}: {gained} and {gain}");
                let covered = fraction(other.distance - one.distance);
                let exact = fraction(one.velocity) * time
                    + (2.0 * acceleration(one) + acceleration(other)) / 6.0 * time * time;
                assert!(
                    (covered - exact).abs() < 1e-15,
                    "{k}: {covered} and {exact}"
                );
                assert!(acceleration(one) <= PI / 2.0);
            }
        }
    }

    proptest! {
        /// Less than 0.01 steps from the sin², seen from either end, and with the acceleration and the velocity of its corners.
        #[test]
        fn the_pieces_are_a_sine(
            part in 0u64..1 << 32,
            time in 1u64 << 20..1 << 34,
            (speed, below) in (1u64..1 << 30, 0u32..30),
            is_back: bool,
        ) {
            let speed = (speed >> below).max(1);
            // Up to an eighth of a step per tick.
            let (ticks, change) = (time as f64, speed as f64 / 2f64.powi(33));
            if ticks * change >= 35_000_000.0 {
                return Ok(());
            }
            let half = ((u128::from(speed) << 63) / u128::from(time) / 2).cast_signed();
            let whole_time = TicksQ32::from_bits(u128::from(time) << 32);
            let anchor = 1 << 40;
            let ramp = Piece {
                start: if is_back { anchor - time } else { anchor },
                anchor: Instant::from(anchor),
                position: PositionQ96::ZERO,
                velocity: Q96::ZERO,
                half_acceleration: Q96::from_bits(half),
                shape: Smooth::new(Shape::Sine(whole_time)),
            };
            let away = ((u128::from(time) * u128::from(part)) >> 32) as u64;
            let t = if is_back { anchor - away.max(1) } else { anchor + away };
            let (piece, _, until) = piece(&ramp, whole_time, t);
            prop_assert!(piece.start <= t && t < until);
            let s = t.abs_diff(anchor) as f64 / ticks;
            let sign = if is_back { -1.0 } else { 1.0 };
            let f = s / 2.0 - (PI * s).sin() / (2.0 * PI);
            let (position, velocity) = float_at(&piece, t);
            let exact = f * ticks * change * sign;
            prop_assert!((position - exact).abs() < 0.01 + 1e-12 * exact.abs(), "{position} and {exact}");
            let exact = change * (PI * s / 2.0).sin().powi(2);
            prop_assert!((velocity - exact).abs() < 1e-3 * change, "{velocity} and {exact}");
        }
    }

    /// Position and velocity of a piece.
    fn float_at(piece: &Piece, t: u64) -> (f64, f64) {
        let unit = 2f64.powi(-96);
        let n = Instant::from(t).apart(piece.anchor).bits() as f64 / 2f64.powi(32);
        let n = if Instant::from(t) < piece.anchor {
            -n
        } else {
            n
        };
        let Shape::Cubic(sixth) = *piece.shape.get() else {
            unreachable!()
        };
        let sixth = sixth.bits() as f64 * 2f64.powi(-128);
        let (v, half) = (
            piece.velocity.bits() as f64 * unit,
            piece.half_acceleration.bits() as f64 * unit,
        );
        let position = piece.position.bits() as f64 * unit + n * (v + n * (half + n * sixth));
        (position, v + n * (2.0 * half + 3.0 * n * sixth))
    }
}
