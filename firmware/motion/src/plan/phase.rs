//! One phase of a plan: a parabola, evaluated without rounding.
//!
//! Coefficients are Q96 in 128 bits and time is a whole number of ticks from the phase's anchor, so x = x₀ + n·(v + n·h) in wrapping
//! arithmetic is exact modulo 2³² steps, which is the span of a position. There is no error to accumulate, however
//! long the phase; a cruise that never ends needs no new anchor.

use crate::clock::{Clock, Ticks};
use crate::divide::quotient;
use crate::fixed::Exact;
use crate::wide::Wide;

/// Time from a plan's start in ticks, Q32: corners fall between ticks.
pub(crate) type Offset = u128;

/// A stretch of constant acceleration.
#[derive(Debug, Clone, Copy)]
pub struct Phase {
    /// The first tick that belongs to it.
    start: Ticks,
    /// The tick for which the coefficients hold.
    anchor: Ticks,
    position: i128,
    velocity: i128,
    half_acceleration: i128,
}

impl Phase {
    pub(crate) const NONE: Self = Self {
        start: 0,
        anchor: 0,
        position: 0,
        velocity: 0,
        half_acceleration: 0,
    };

    /// The first tick of this phase.
    pub const fn start(&self) -> Ticks {
        self.start
    }

    /// The acceleration in steps/s², to the nearest.
    pub fn acceleration(&self, clock: Clock) -> i64 {
        let rate = u128::from(clock.hz());
        let magnitude = Wide::product(
            self.half_acceleration.unsigned_abs(),
            rate.wrapping_mul(rate),
        )
        .plus(Wide::product(1 << 94, 1))
        .shifted_wrapping(95) as i64;
        if self.half_acceleration < 0 {
            magnitude.wrapping_neg()
        } else {
            magnitude
        }
    }

    /// The exact state at tick `t`.
    #[inline(never)]
    pub(crate) fn at(&self, t: Ticks) -> Exact {
        let n = i128::from(t.wrapping_sub(self.anchor).cast_signed());
        // Most of the time is spent in cruises, and wide products are dear.
        let gain = if self.half_acceleration == 0 {
            0
        } else {
            self.half_acceleration.wrapping_mul(n)
        };
        Exact {
            position: self
                .velocity
                .wrapping_add(gain)
                .wrapping_mul(n)
                .wrapping_add(self.position),
            velocity: self.velocity.wrapping_add(gain).wrapping_add(gain),
        }
    }

    /// The longest chord, in ticks, that stays within a quarter of a step of the parabola: ½a·len²/4 ≤ ¼.
    pub(crate) fn longest_chord(&self) -> u64 {
        let bits = 128u32.wrapping_sub(self.half_acceleration.unsigned_abs().leading_zeros());
        1u64.wrapping_shl(96u32.saturating_sub(bits) / 2)
    }
}

/// The parabola of a phase in the frame of its plan: positions count from the plan's start, positive towards the target.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Parabola {
    pub(crate) position: i128,
    pub(crate) velocity: i128,
    pub(crate) half_acceleration: i128,
}

impl Parabola {
    /// The phase that begins at tick `begin` and whose coefficients hold at `anchor`, which counts from tick `start`.
    ///
    /// `origin` is the position at `start`; `reverse` turns the frame round.
    pub(crate) fn phase(
        self,
        start: Ticks,
        begin: Ticks,
        anchor: Offset,
        origin: i128,
        reverse: bool,
    ) -> Phase {
        // Move the coefficients from the anchor down to the whole tick before it.
        let fraction = anchor as u32;
        let half_gain = part(self.half_acceleration, fraction);
        let back = part(self.velocity.wrapping_sub(half_gain), fraction);
        let velocity = self.velocity.wrapping_sub(half_gain.wrapping_mul(2));
        let position = self.position.wrapping_sub(back);
        let turn = |value: i128| if reverse { value.wrapping_neg() } else { value };
        Phase {
            start: begin,
            anchor: start.saturating_add((anchor >> 32) as u64),
            position: origin.wrapping_add(turn(position)),
            velocity: turn(velocity),
            half_acceleration: turn(self.half_acceleration),
        }
    }
}

/// ⌊value · fraction / 2³²⌋, for a value of at most 127 bits.
fn part(value: i128, fraction: u32) -> i128 {
    if value == 0 || fraction == 0 {
        return 0;
    }
    let high = (value >> 32).wrapping_mul(fraction.into());
    let low = u64::from(value as u32).wrapping_mul(fraction.into()) >> 32;
    high.wrapping_add(low.into())
}

/// An offset rounded up to whole ticks.
pub(crate) fn ticks_up(offset: Offset) -> Ticks {
    (offset.saturating_add(u128::from(u32::MAX)) >> 32) as u64
}

/// How long it takes to change speed by `change` at twice `half_acceleration`, as an [`Offset`].
pub(crate) fn ramp_time(change: u128, half_acceleration: u128) -> Offset {
    // Speeds have at most 96 bits, so the shift loses nothing. The clock's range keeps accelerations above zero.
    quotient(change << 31, 0, half_acceleration)
}

/// The way of a ramp that lasts `time` and starts at `speed`: growing, or with `braking` falling. Modulo 2³² steps.
#[inline(never)]
pub(crate) fn ramp_way(speed: u128, half_acceleration: u128, time: Offset, braking: bool) -> u128 {
    if time == 0 {
        return 0;
    }
    let half_gain = half_acceleration.wrapping_mul(time) >> 32;
    let mean = if braking {
        speed.saturating_sub(half_gain)
    } else {
        speed.wrapping_add(half_gain)
    };
    Wide::product(mean, time).shifted_wrapping(32)
}
