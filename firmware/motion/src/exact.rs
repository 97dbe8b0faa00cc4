//! Numbers as plans and polynomials keep them: a type for each format, so that they do not mix.
//!
//! | type | what it counts | bits behind the point |
//! |---|---|---|
//! | [`PositionQ96`] | a position, or the distance from one to another, in steps; modulo 2³² | 96 |
//! | [`DistanceQ96`] | an amount of distance in steps, less than 2³² | 96 |
//! | [`Q96`] | a velocity in steps per tick, or an acceleration, or half of one, in steps per tick² | 96 |
//! | [`Uq96`] | an amount of these | 96 |
//! | [`Q128`] | a sixth of a jerk in steps per tick³ | 128 |
//! | [`TicksQ32`] | a time in ticks | 32 |
//!
//! Positions wrap, and so do the distances between them. Nothing else overflows: plain operators, which debug builds check.

use crate::low;
use core::ops::{Add, Neg, Shr, Sub};

/// A position in steps, or the distance from one to another: 96 bits behind the point, modulo 2³².
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PositionQ96(i128);

/// How far it is in steps, less than 2³²: 96 bits behind the point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct DistanceQ96(u128);

/// A velocity in steps per tick, or an acceleration, or half of one, in steps per tick²: 96 bits behind the point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Q96(i128);

/// The amount of a [`Q96`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Uq96(u128);

/// A sixth of a jerk in steps per tick³, less than a half: 128 bits behind the point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Q128(i128);

/// A time in ticks, 32 bits behind the point: corners fall between ticks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct TicksQ32(u128);

/// What every format has.
macro_rules! format {
    ($($name:ident($bits:ty)),+) => {$(
        impl $name {
            pub(crate) const ZERO: Self = Self(0);

            #[inline]
            pub(crate) const fn from_bits(bits: $bits) -> Self {
                Self(bits)
            }

            #[inline]
            pub(crate) const fn bits(self) -> $bits {
                self.0
            }
        }
    )+};
}

/// What every format but a position has.
macro_rules! is_zero {
    ($($name:ident),+) => {$(
        impl $name {
            #[inline]
            pub(crate) const fn is_zero(self) -> bool {
                self.0 == 0
            }
        }
    )+};
}

format!(
    PositionQ96(i128),
    DistanceQ96(u128),
    Q96(i128),
    Uq96(u128),
    Q128(i128),
    TicksQ32(u128)
);
is_zero!(DistanceQ96, Q96, Uq96, Q128, TicksQ32);

/// An operator of a format: that of its bits, which wraps or is checked in debug builds.
macro_rules! operator {
    ($operator:ident::$method:ident($($other:ident)?) for $name:ident: $of_bits:path) => {
        impl $operator for $name {
            type Output = Self;

            #[inline]
            fn $method(self $(, $other: Self)?) -> Self {
                Self($of_bits(self.0 $(, $other.0)?))
            }
        }
    };
}

operator!(Add::add(other) for PositionQ96: i128::wrapping_add);
operator!(Sub::sub(other) for PositionQ96: i128::wrapping_sub);
operator!(Neg::neg() for PositionQ96: i128::wrapping_neg);
operator!(Add::add(other) for Q96: i128::add);
operator!(Sub::sub(other) for Q96: i128::sub);
operator!(Neg::neg() for Q96: i128::neg);
operator!(Add::add(other) for Uq96: u128::add);
operator!(Sub::sub(other) for Uq96: u128::sub);
operator!(Neg::neg() for Q128: i128::neg);
operator!(Add::add(other) for TicksQ32: u128::add);

impl Shr<u32> for Q96 {
    type Output = Self;

    #[inline]
    fn shr(self, bits: u32) -> Self {
        Self(self.0 >> bits)
    }
}

impl Shr<u32> for Q128 {
    type Output = Self;

    #[inline]
    fn shr(self, bits: u32) -> Self {
        Self(self.0 >> bits)
    }
}

impl PositionQ96 {
    /// A whole number of steps, taken modulo 2³².
    pub(crate) const fn from_steps(steps: i64) -> Self {
        Self((steps as i128).wrapping_shl(96))
    }

    /// The whole step where it is, or that below.
    pub(crate) const fn steps(self) -> i32 {
        (self.0 >> 96) as i32
    }

    /// Q32, rounded down.
    #[inline]
    pub(crate) const fn floor(self) -> i64 {
        (self.0 >> 64) as i64
    }

    /// The velocity at which a distance takes so many ticks, of which this is the reciprocal, Q64.
    pub(crate) fn per_tick(self, reciprocal: u64) -> Q96 {
        Q96(part(self.0, reciprocal))
    }

    /// self · factor / 2⁶⁴.
    pub(crate) fn part(self, factor: u64) -> Self {
        Self(part(self.0, factor))
    }

    pub(crate) const fn halved(self) -> Self {
        Self(self.0 >> 1)
    }
}

impl DistanceQ96 {
    /// From a position so far forwards.
    #[inline]
    pub(crate) const fn forwards(self) -> PositionQ96 {
        PositionQ96(self.0.cast_signed())
    }

    #[inline]
    pub(crate) fn checked_add(self, other: Self) -> Option<Self> {
        self.0.checked_add(other.0).map(Self)
    }

    #[inline]
    pub(crate) const fn saturating_sub(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0))
    }

    #[inline]
    pub(crate) const fn abs_diff(self, other: Self) -> Self {
        Self(self.0.abs_diff(other.0))
    }
}

impl Q96 {
    /// Q32, rounded down.
    #[inline]
    pub(crate) const fn floor(self) -> i64 {
        (self.0 >> 64) as i64
    }

    #[inline]
    pub(crate) const fn amount(self) -> Uq96 {
        Uq96(self.0.unsigned_abs())
    }

    #[inline]
    pub(crate) const fn doubled(self) -> Self {
        Self(self.0 * 2)
    }

    /// self · factor / 2⁶⁴.
    pub(crate) fn part(self, factor: u64) -> Self {
        Self(part(self.0, factor))
    }

    /// How far this velocity leads in a time.
    #[inline]
    pub(crate) fn distance<T: Time>(self, time: T) -> PositionQ96 {
        PositionQ96(time.times(self.0))
    }

    /// By how much this acceleration changes the velocity in a time.
    #[inline]
    pub(crate) fn gain<T: Time>(self, time: T) -> Self {
        Self(time.times(self.0))
    }
}

impl Uq96 {
    /// In the positive direction.
    #[inline]
    pub(crate) const fn forwards(self) -> Q96 {
        Q96(self.0.cast_signed())
    }

    #[inline]
    pub(crate) const fn doubled(self) -> Self {
        Self(self.0 << 1)
    }

    #[inline]
    pub(crate) const fn halved(self) -> Self {
        Self(self.0 >> 1)
    }

    #[inline]
    pub(crate) const fn saturating_sub(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0))
    }

    /// How far this speed leads in a time, rounded down and modulo 2³² steps.
    #[inline(always)]
    pub(crate) fn distance(self, time: TicksQ32) -> DistanceQ96 {
        DistanceQ96(product_q32(self.0, time.0))
    }

    /// By how much this acceleration changes the speed in a time, rounded down.
    #[inline(always)]
    pub(crate) fn gain(self, time: TicksQ32) -> Self {
        Self(product_q32(self.0, time.0))
    }
}

impl Q128 {
    /// The least above zero.
    pub(crate) const LEAST: Self = Self(1);

    #[inline]
    pub(crate) const fn abs(self) -> Self {
        Self(self.0.abs())
    }

    /// self · factor / 2⁶⁴.
    pub(crate) fn part(self, factor: u64) -> Self {
        Self(part(self.0, factor))
    }

    /// A third of what half of the acceleration changes by in a time, rounded down.
    #[inline]
    pub(crate) fn gain(self, ticks: u32) -> Q96 {
        Q96(product(self.0, ticks) >> 32)
    }

    /// The same rounded towards zero, which treats both directions alike.
    #[inline(always)]
    pub(crate) fn even_gain<T: Time>(self, time: T) -> Q96 {
        let gain = time.times(self.0);
        let magnitude = (gain.unsigned_abs() >> 32).cast_signed();
        with_sign(Q96(magnitude), gain < 0)
    }
}

impl From<Q96> for Q128 {
    fn from(value: Q96) -> Self {
        Self(value.0 << 32)
    }
}

impl TicksQ32 {
    #[inline]
    pub(crate) const fn saturating_sub(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0))
    }
}

/// A time: ticks, some of them negative, or a [`TicksQ32`].
pub(crate) trait Time: Copy {
    /// value · self modulo 2¹²⁸.
    fn times(self, value: i128) -> i128;
}

impl Time for u32 {
    #[inline]
    fn times(self, value: i128) -> i128 {
        product(value, self)
    }
}

impl Time for i64 {
    /// Within 2³² ticks, 25 s at 168 MHz, it is four short products.
    #[inline(always)]
    fn times(self, value: i128) -> i128 {
        match u32::try_from(self.unsigned_abs()) {
            Ok(ticks) => with_sign(PositionQ96(product(value, ticks)), self < 0).0,
            Err(_) => value.wrapping_mul(self.into()),
        }
    }
}

impl Time for TicksQ32 {
    /// Rounded towards zero.
    fn times(self, value: i128) -> i128 {
        let magnitude = product_q32(value.unsigned_abs(), self.0).cast_signed();
        with_sign(PositionQ96(magnitude), value < 0).0
    }
}

/// A number in its direction, or in the other one.
#[inline]
pub(crate) fn with_sign<T: Neg<Output = T>>(value: T, is_negative: bool) -> T {
    if is_negative { -value } else { value }
}

/// A product modulo 2¹²⁸, of four short ones.
#[inline]
pub(crate) fn product(value: i128, factor: u32) -> i128 {
    let value = value.cast_unsigned();
    let mut carry = 0;
    let mut digit = |shift: u32| {
        let digit = u64::from(low::u32(low::u64(value >> shift)));
        let sum = digit.wrapping_mul(factor.into()).wrapping_add(carry);
        carry = sum >> 32;
        u64::from(low::u32(sum))
    };
    let low = digit(0) | digit(32) << 32;
    let high = digit(64) | digit(96) << 32;
    (u128::from(high) << 64 | u128::from(low)).cast_signed()
}

/// ⌊value · factor / 2³²⌋ modulo 2¹²⁸.
#[inline(always)]
pub(crate) fn product_q32(value: u128, factor: u128) -> u128 {
    // Both in halves.
    let low = (u128::from(low::u64(value)) * u128::from(low::u64(factor))) >> 32;
    let high = ((value >> 64) * u128::from(low::u64(factor))) << 32;
    let product = low.wrapping_add(high);
    // Nearly all ramps take less than 2³² ticks, 25 s at 168 MHz.
    if factor >> 64 == 0 {
        return product;
    }
    product.wrapping_add(value.wrapping_mul(factor >> 64) << 32)
}

/// ⌊value · factor / 2⁶⁴⌋.
#[inline(never)]
fn part(value: i128, factor: u64) -> i128 {
    let low = u128::from(low::u64(value.cast_unsigned())).wrapping_mul(factor.into()) >> 64;
    (value >> 64)
        .wrapping_mul(factor.into())
        .wrapping_add(low.cast_signed())
}
