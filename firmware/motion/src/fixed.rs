//! Fixed-point position and velocity: integers only, so that nothing drifts.

use crate::clock::{Clock, TOP_SPEED};
use crate::divide::quotient;
use crate::exact::{PositionQ96, Q96, Uq96, with_sign};
use crate::low;
use crate::speed::SignedSpeed;

/// A position in steps, Q32 (32 bits behind the point).
///
/// Whole steps span −2³¹ ..= 2³¹−1, as the position objects of CiA 402 do, and wrap there as those do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Position(i64);

impl Position {
    /// A whole number of steps, taken modulo 2³².
    pub const fn from_steps(steps: i64) -> Self {
        Self(steps.wrapping_mul(1 << 32))
    }

    /// A position from its bits: steps × 2³².
    pub const fn from_bits(bits: i64) -> Self {
        Self(bits)
    }

    /// Steps × 2³².
    pub const fn bits(self) -> i64 {
        self.0
    }

    /// The nearest whole step; half a step counts upwards.
    pub const fn whole_steps(self) -> i64 {
        self.0.wrapping_add(1 << 31) >> 32
    }

    /// Rounds towards zero, which treats both directions alike.
    pub(crate) const fn from_exact(exact: PositionQ96) -> Self {
        let magnitude = (exact.bits().unsigned_abs() >> 64) as i64;
        Self(if exact.bits() < 0 {
            magnitude.wrapping_neg()
        } else {
            magnitude
        })
    }

    /// In the resolution of plans.
    pub(crate) const fn exact(self) -> PositionQ96 {
        PositionQ96::from_bits((self.0 as i128) << 64)
    }
}

/// A velocity in steps per tick, Q56.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Velocity(i64);

impl Velocity {
    /// Standing still.
    pub const ZERO: Self = Self(0);

    /// The velocity nearest to one in steps/s, cut to half a step per tick.
    pub fn from_speed(clock: Clock, speed: SignedSpeed) -> Self {
        let exact = clock.speed(speed.unsigned_abs());
        let magnitude = low::u64((exact.bits() + (1 << 39)) >> 40).cast_signed();
        Self(with_sign(magnitude, speed.bits() < 0))
    }

    /// A velocity from its bits: steps/tick × 2⁵⁶.
    pub const fn from_bits(bits: i64) -> Self {
        Self(bits)
    }

    /// Steps/tick × 2⁵⁶.
    pub const fn bits(self) -> i64 {
        self.0
    }

    /// The same in steps/s, to the nearest; cut to half a step per tick.
    pub fn speed(self, clock: Clock) -> SignedSpeed {
        let bits = self.0.unsigned_abs().min(1 << 55);
        let hz = u64::from(clock.hz());
        // Q56 becomes Q32. The upper product has 53 bits at most.
        let high = ((bits >> 32) * hz) << 8;
        let low = u64::from(low::u32(bits)) * hz;
        let low = (low + (1 << 23)) >> 24;
        let magnitude = (high + low).cast_signed();
        SignedSpeed::from_bits(with_sign(magnitude, self.0 < 0))
    }

    /// The velocity at which `distance` takes so many ticks; zero for no ticks.
    pub fn over(distance: Position, ticks: u32) -> Self {
        let magnitude = quotient(distance.bits().unsigned_abs().into(), 2, ticks.into());
        let velocity = Self::from_exact(Q96::from_bits(magnitude.cast_signed()));
        if distance.bits() < 0 {
            Self(velocity.0.wrapping_neg())
        } else {
            velocity
        }
    }

    /// Whether it covers less in a tick than a [`Position`] resolves: slower than 2⁻³² steps per tick.
    pub(crate) const fn is_below_resolution(self) -> bool {
        self.0.unsigned_abs() < 1 << 24
    }

    /// The distance over so many ticks, in steps × 2³².
    pub fn distance(self, ticks: u32) -> i64 {
        low::i64((i128::from(self.0) * i128::from(ticks)) >> 24)
    }

    /// In the resolution of plans.
    #[allow(clippy::cast_lossless, reason = "From is not const; the cast widens")]
    pub(crate) const fn exact(self) -> Q96 {
        Q96::from_bits((self.0 as i128) << 40)
    }

    /// Rounds towards zero.
    pub(crate) const fn from_exact(exact: Q96) -> Self {
        let magnitude = low::u64(exact.bits().unsigned_abs() >> 40).cast_signed();
        Self(if exact.bits() < 0 {
            magnitude.wrapping_neg()
        } else {
            magnitude
        })
    }
}

/// Where an axis is and how fast it moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct State {
    /// Position in steps.
    pub position: Position,
    /// Velocity in steps per tick.
    pub velocity: Velocity,
}

/// A [`State`] as plans keep it among themselves. Planning again from it loses nothing, so an
/// axis may be planned again in every control tick and still arrive when it would have arrived.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Exact {
    pub(crate) position: PositionQ96,
    /// At most half a step per tick either way.
    pub(crate) velocity: Q96,
}

impl Exact {
    /// Standing.
    pub(crate) const fn at_rest(position: PositionQ96) -> Self {
        Self {
            position,
            velocity: Q96::ZERO,
        }
    }

    /// The position as the stepper takes it, rounded down. Whoever asks which step is due rounds
    /// as it does: next to the middle between two steps [`Exact::rounded`] may be at another one.
    #[inline]
    pub(crate) const fn floor(self) -> Position {
        Position::from_bits(self.position.floor())
    }

    /// How many ticks ago this state crossed the middle before the whole step `steps` (modulo 2³²), at its present velocity. 0 at rest.
    pub(crate) fn since_middle(self, steps: i32) -> u128 {
        let distance = self.position - PositionQ96::from_steps(steps.into());
        let distance = with_sign(distance, self.velocity < Q96::ZERO);
        let beyond = distance.bits().wrapping_add(1 << 95).max(0).cast_unsigned();
        quotient(beyond, 0, self.velocity.amount().bits())
    }

    /// The same in the public resolution.
    #[inline]
    pub(crate) const fn rounded(self) -> State {
        State {
            position: Position::from_exact(self.position),
            velocity: Velocity::from_exact(self.velocity),
        }
    }
}

impl From<State> for Exact {
    fn from(state: State) -> Self {
        let speed = Uq96::from_bits(u128::from(state.velocity.0.unsigned_abs()) << 40);
        Self {
            position: state.position.exact(),
            velocity: with_sign(speed.min(TOP_SPEED).forwards(), state.velocity.0 < 0),
        }
    }
}
