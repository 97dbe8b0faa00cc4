//! Velocities as they are asked for and shown: steps/s with 32 bits behind the point.
//!
//! One unit is 2⁻³² steps/s, so one step in an hour is there to 4·10⁻⁷ of itself, and whole numbers of steps/s are exact. Amounts go
//! up to 2³² steps/s, velocities with a sign to 2³¹ steps/s in either direction, which is more than any timer can do.
//!
//! Nothing here rounds but [`Speed::whole`] and [`SignedSpeed::whole`]. Plans count in steps per tick with 96 bits behind the point;
//! on the way there a velocity is rounded down, so that a limit holds.

/// An amount of velocity in steps/s, Q32 (32 bits behind the point): a limit, or a speed in a direction that is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Speed(u64);

/// A velocity in steps/s, Q32 (32 bits behind the point); negative is backwards.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct SignedSpeed(i64);

impl Speed {
    /// Standing still.
    pub const ZERO: Self = Self(0);
    /// The lowest speed above zero: 2⁻³² steps/s.
    pub const LEAST: Self = Self(1);
    /// A little less than 2³² steps/s.
    pub const MAX: Self = Self(u64::MAX);
    /// How far a velocity that is kept may lie from the one that was asked for, 2⁻²⁴ steps/s: ticks are counted in whole numbers, and what
    /// is rounded down on the way to steps per tick comes back as a little less.
    pub const TOLERANCE: Self = Self(1 << 8);

    /// A whole number of steps/s.
    #[allow(clippy::cast_lossless, reason = "From is not const; the cast widens")]
    pub const fn per_second(steps: u32) -> Self {
        Self((steps as u64) << 32)
    }

    /// A speed from its bits: steps/s × 2³².
    pub const fn from_bits(bits: u64) -> Self {
        Self(bits)
    }

    /// Steps/s × 2³².
    pub const fn bits(self) -> u64 {
        self.0
    }

    /// The nearest whole number of steps/s, saturating; halves go up.
    pub const fn whole(self) -> u32 {
        (self.0.saturating_add(1 << 31) >> 32) as u32
    }

    /// The velocity of this amount, backwards if `reverse`. What is too large is cut to 2³¹ steps/s.
    pub const fn signed(self, reverse: bool) -> SignedSpeed {
        let amount = if self.0 > i64::MAX.cast_unsigned() {
            i64::MAX
        } else {
            self.0.cast_signed()
        };
        SignedSpeed(if reverse {
            amount.wrapping_neg()
        } else {
            amount
        })
    }

    /// The velocity of this amount with the sign of another one; forwards if that is 0.
    pub const fn with_sign_of(self, other: SignedSpeed) -> SignedSpeed {
        self.signed(other.0 < 0)
    }

    /// The sum, saturating.
    pub const fn plus(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }
}

impl SignedSpeed {
    /// Standing still.
    pub const ZERO: Self = Self(0);

    /// A whole number of steps/s.
    #[allow(clippy::cast_lossless, reason = "From is not const; the cast widens")]
    pub const fn per_second(steps: i32) -> Self {
        Self((steps as i64) << 32)
    }

    /// A velocity from its bits: steps/s × 2³².
    pub const fn from_bits(bits: i64) -> Self {
        Self(bits)
    }

    /// Steps/s × 2³².
    pub const fn bits(self) -> i64 {
        self.0
    }

    /// The amount.
    pub const fn unsigned_abs(self) -> Speed {
        Speed(self.0.unsigned_abs())
    }

    /// The nearest whole number of steps/s, saturating; halves go away from zero.
    pub const fn whole(self) -> i32 {
        // One less for what is negative, so that its halves go down.
        (self.0.saturating_add((1 << 31) + (self.0 >> 63)) >> 32) as i32
    }

    /// How far two velocities lie apart.
    pub const fn abs_diff(self, other: Self) -> Speed {
        Speed(self.0.abs_diff(other.0))
    }

    /// Whether a velocity that is kept is this one: they lie no further apart than [`Speed::TOLERANCE`].
    pub const fn is_close_to(self, other: Self) -> bool {
        self.0.abs_diff(other.0) <= Speed::TOLERANCE.0
    }

    /// The same the other way; 2³¹ steps/s backwards become a little less.
    pub const fn reversed(self) -> Self {
        Self(self.0.saturating_neg())
    }

    /// The sum, saturating.
    pub const fn plus(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }

    /// The difference, saturating.
    pub const fn minus(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0))
    }

    /// The velocity nearest to this one of an amount that is not greater than `max`.
    pub const fn within(self, max: Speed) -> Self {
        if self.0.unsigned_abs() > max.0 {
            max.with_sign_of(self)
        } else {
            self
        }
    }
}

impl From<u32> for Speed {
    fn from(steps: u32) -> Self {
        Self::per_second(steps)
    }
}

impl From<i32> for SignedSpeed {
    fn from(steps: i32) -> Self {
        Self::per_second(steps)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_whole_number_treats_both_directions_alike() {
        let half = |bits: i64| SignedSpeed::from_bits(bits).whole();
        assert_eq!((half(1 << 31), half(-(1 << 31))), (1, -1));
        assert_eq!((half((1 << 31) - 1), half(1 - (1 << 31))), (0, 0));
        assert_eq!((half(5 << 31), half(-(5 << 31))), (3, -3));
    }

    #[test]
    fn the_ends_of_the_range_saturate() {
        assert_eq!(Speed::MAX.whole(), u32::MAX);
        assert_eq!(Speed::MAX.signed(false).whole(), i32::MAX);
        assert_eq!(Speed::MAX.signed(true).whole(), i32::MIN);
        let least = SignedSpeed::from_bits(i64::MIN);
        assert_eq!(least, i32::MIN.into());
        assert_eq!(least.whole(), i32::MIN);
        assert_eq!(least.unsigned_abs(), Speed::per_second(1 << 31));
        assert_eq!(least.minus(1.into()), least);
        assert_eq!(Speed::MAX.plus(Speed::LEAST), Speed::MAX);
    }

    #[test]
    fn a_velocity_is_cut_in_its_direction() {
        let max = Speed::per_second(100);
        let within = |steps: i32| SignedSpeed::per_second(steps).within(max).whole();
        assert_eq!([within(99), within(101), within(-101)], [99, 100, -100]);
        assert_eq!(within(i32::MIN), -100);
    }
}
