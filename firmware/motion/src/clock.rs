//! The step timer's clock: the unit of time of this crate.
//!
//! All times are counts of one hardware timer. A 64-bit count at 168 MHz wraps after 3480 years, so nothing here reasons
//! about wrap-around.

use crate::exact::{Q128, Uq96};
use crate::low;
use crate::speed::Speed;

/// Ticks of the step timer, counted from when the axis was made.
pub type Ticks = u64;

/// Half a step per tick: a pulse takes at least one tick high and one tick low.
pub(crate) const TOP_SPEED: Uq96 = Uq96::from_bits(1 << 95);

/// The highest sixth of a jerk: all of it has the 96 bits that a divisor may have.
pub(crate) const TOP_SIXTH_JERK: Q128 = Q128::from_bits(((1 << 96) - 1) / 6);

/// The rate of the step timer, with the reciprocals that turn limits per second into limits per tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Clock {
    hz: u32,
    /// ⌊2⁹⁶ / hz⌋
    second: u128,
    /// ⌊2¹²⁴ / hz²⌋: 28 bits more, so that even the slowest ramp keeps its precision
    second_squared: u128,
    /// ⌊2¹⁵⁶ / 6·hz³⌋: for a sixth of a jerk, also with 28 bits more
    sixth_second_cubed: u128,
}

impl Clock {
    /// The slowest timer, in Hz.
    pub const SLOWEST: u32 = 1_000_000;
    /// The fastest timer, in Hz.
    pub const FASTEST: u32 = 1_000_000_000;

    /// A timer of `hz` ticks per second; `None` outside [`Clock::SLOWEST`] to [`Clock::FASTEST`].
    pub const fn new(hz: u32) -> Option<Self> {
        if hz < Self::SLOWEST || hz > Self::FASTEST {
            return None;
        }
        let rate = hz as u128;
        // No divisor is zero here; `checked_div` says so without a panic path.
        let (Some(second), Some(second_squared)) = (
            (1u128 << 96).checked_div(rate),
            (1u128 << 124).checked_div(rate * rate),
        ) else {
            return None;
        };
        // The slowest timer makes it 117 bits.
        let Some(sixth_second_cubed) = (second_squared << 32).checked_div(6 * rate) else {
            return None;
        };
        Some(Self {
            hz,
            second,
            second_squared,
            sixth_second_cubed,
        })
    }

    /// Ticks per second.
    pub const fn hz(self) -> u32 {
        self.hz
    }

    /// A limit in steps/tick. Rounded down, so that the limit holds, and cut to half a step per tick.
    #[inline(never)]
    pub(crate) fn speed(self, speed: Speed) -> Uq96 {
        let (whole, part) = ((speed.bits() >> 32) as u32, low::u32(speed.bits()));
        // A second has 77 bits at most.
        let mut speed = self.second * u128::from(whole);
        if part != 0 {
            speed += (self.second * u128::from(part)) >> 32;
        }
        Uq96::from_bits(speed).min(TOP_SPEED)
    }

    /// Half of a limit in steps/s², in steps/tick². Rounded down, so that the limit holds.
    ///
    /// Half, because that is the coefficient of a parabola: x = x₀ + v·n + ½a·n².
    #[inline(never)]
    pub(crate) fn half_acceleration(self, steps_per_second_squared: u32) -> Uq96 {
        Uq96::from_bits((self.second_squared * u128::from(steps_per_second_squared)) >> 29)
    }

    /// A sixth of a limit in steps/s³, in steps/tick³. Rounded down, so that the limit holds, but never to nothing; cut to
    /// [`TOP_SIXTH_JERK`] (at 1 MHz 2.3·10⁸ steps/s³, at 84 MHz more than 32 bits hold).
    ///
    /// A sixth, because that is the coefficient of a cubic.
    pub(crate) fn sixth_jerk(self, steps_per_second_cubed: u32) -> Q128 {
        let sixth = (self.sixth_second_cubed * u128::from(steps_per_second_cubed)) >> 28;
        Q128::from_bits(sixth.cast_signed()).clamp(Q128::LEAST, TOP_SIXTH_JERK)
    }
}
