//! What a plan keeps of its phases until they are entered: most of a plan may never be reached.
//!
//! A piece is a polynomial, or a whole sin² ramp, in the frame of the plan: positions count from where the motion begins, and are positive
//! in its direction. So a mirrored motion is the exact mirror image, bit by bit.

use super::goal::SIN_SQUARED;
use super::phase::Phase;
use super::sine;
use super::smooth::Smooth;
use crate::clock::{Clock, Ticks};
use crate::divide::Divisor;
use crate::exact::{DistanceQ96, PositionQ96, Q96, Q128, TicksQ32, Time, Uq96, with_sign};
use crate::low;
use core::ops::Neg;

/// A moment in the axis' time: ticks, Q32. A ramp may be anchored behind the last tick that [`Ticks`] can tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Instant(u128);

impl Instant {
    /// A tick.
    pub(super) const fn from(tick: Ticks) -> Self {
        Self((tick as u128) << 32)
    }

    #[inline]
    pub(super) const fn after(self, time: TicksQ32) -> Self {
        Self(self.0.saturating_add(time.bits()))
    }

    /// So long before it.
    pub(super) const fn before(self, time: TicksQ32) -> Self {
        Self(self.0.saturating_sub(time.bits()))
    }

    /// How long it is from one to the other.
    pub(super) const fn apart(self, other: Self) -> TicksQ32 {
        TicksQ32::from_bits(self.0.abs_diff(other.0))
    }

    /// The last tick that is not behind it, modulo 2⁶⁴.
    const fn tick(self) -> Ticks {
        low::u64(self.0 >> 32)
    }

    /// The first tick that is not before it; the last one there is, if it lies behind that.
    pub(super) fn tick_up(self) -> Ticks {
        if self.0 >> 96 != 0 {
            return Ticks::MAX;
        }
        let is_behind = self.fraction().0 != 0;
        self.tick().saturating_add(is_behind.into())
    }

    /// How far it is behind the tick before it.
    const fn fraction(self) -> TickPart {
        TickPart(low::u32(low::u64(self.0)))
    }
}

/// The frame of a plan: its positions count from an origin, positive in the direction of the motion.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    /// The first tick of the plan.
    pub(super) start: Ticks,
    /// The position of the origin.
    pub(super) origin: PositionQ96,
    /// The motion goes backwards.
    pub(super) reverse: bool,
}

impl Frame {
    /// From its direction to that of the axis, or back.
    #[inline]
    pub(super) fn turn<T: Neg<Output = T>>(&self, value: T) -> T {
        with_sign(value, self.reverse)
    }

    /// A position of the axis.
    pub(super) fn place(&self, position: PositionQ96) -> PositionQ96 {
        self.origin + self.turn(position)
    }
}

/// What a piece is.
#[derive(Debug, Clone, Copy)]
pub(super) enum Shape {
    /// A polynomial of degree 3; a sixth of its jerk.
    Cubic(Q128),
    /// A sin² ramp that takes so long, at least [`sine::SHORTEST`], anchored at one of its ends. The acceleration is that of the linear ramp in its
    /// place, positive if the velocity at the other end is greater.
    Sine(TicksQ32),
}

/// A piece of a plan, anchored between two ticks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    /// The first tick that belongs to it.
    pub(super) start: Ticks,
    /// When position and velocity hold.
    pub(super) anchor: Instant,
    pub(super) position: PositionQ96,
    pub(super) velocity: Q96,
    pub(super) half_acceleration: Q96,
    pub(super) shape: Smooth<Shape>,
}

impl Piece {
    /// The same in a frame that may be turned round: what counts from its zero in one does so in the other.
    pub(super) fn seen_from(self, frame: &Frame) -> Self {
        if !frame.reverse {
            return self;
        }
        Self {
            position: -self.position,
            velocity: -self.velocity,
            half_acceleration: -self.half_acceleration,
            shape: Smooth::new(match *self.shape.get() {
                Shape::Cubic(sixth_jerk) => Shape::Cubic(-sixth_jerk),
                Shape::Sine(time) => Shape::Sine(time),
            }),
            ..self
        }
    }

    /// The same in the frame of the axis.
    pub(super) fn placed(self, frame: &Frame) -> Self {
        let mut placed = self.seen_from(frame);
        placed.position = placed.position + frame.origin;
        placed
    }

    pub(super) const fn is_sine(&self) -> bool {
        SIN_SQUARED && matches!(self.shape.get(), Shape::Sine(_))
    }

    /// A sixth of its jerk, or of that at which a sin² ramp is left.
    pub(super) fn sixth_jerk(&self) -> Q128 {
        match *self.shape.get() {
            Shape::Cubic(sixth_jerk) => sixth_jerk.abs(),
            Shape::Sine(time) if SIN_SQUARED => sine::jerk(self.half_acceleration, time),
            Shape::Sine(_) => Q128::ZERO,
        }
    }

    /// Whether its velocity is constant.
    pub(super) const fn is_line(&self) -> bool {
        matches!(self.shape.get(), Shape::Cubic(Q128::ZERO)) && self.half_acceleration.is_zero()
    }

    /// The next tick behind `t`, which lies within the piece, at which another of its phases begins, or `until`, at which it ends.
    pub(super) fn next_corner(&self, (t, until): (Ticks, Ticks)) -> Ticks {
        match *self.shape.get() {
            Shape::Sine(time) if SIN_SQUARED => sine::piece(self, time, t).2.min(until),
            Shape::Cubic(_) | Shape::Sine(_) => until,
        }
    }

    /// The phase at tick `t`, which lies within the piece, and the first tick behind it; `until` is that behind the piece.
    pub(super) fn work_out(&self, (t, until): (Ticks, Ticks), frame: &Frame) -> (Phase, Ticks) {
        match *self.shape.get() {
            Shape::Sine(time) if SIN_SQUARED => {
                let (piece, sixth_jerk, end) = sine::piece(self, time, t);
                (piece.work_out_cubic(sixth_jerk, frame), end.min(until))
            }
            Shape::Cubic(sixth_jerk) => (self.work_out_cubic(sixth_jerk, frame), until),
            // Not built in.
            Shape::Sine(_) => (self.work_out_cubic(Q128::ZERO, frame), until),
        }
    }

    /// The position at a tick that lies within it.
    pub(super) fn position_at(&self, tick: Ticks) -> PositionQ96 {
        let frame = Frame {
            start: tick,
            origin: PositionQ96::ZERO,
            reverse: false,
        };
        let (phase, _) = self.work_out((tick, Ticks::MAX), &frame);
        phase.at(tick).position
    }

    /// Brings the coefficients from the anchor down to the whole tick before it, by a part φ of a tick, and into the frame of the axis.
    #[inline(never)]
    fn work_out_cubic(&self, sixth_jerk: Q128, frame: &Frame) -> Phase {
        let fraction = self.anchor.fraction();
        // h − 3cφ, v − 2hφ + 3cφ² and x − vφ + hφ² − cφ³
        let half = self.half_acceleration;
        let (first, second, third) = if sixth_jerk.is_zero() {
            (half, half, half)
        } else {
            // Over hours the last bit of it shows. A lead is the same one in either frame.
            let rise = sixth_jerk.even_gain(TicksQ32::from_bits(fraction.0.into()));
            let twice = rise.doubled();
            (half - rise, half - twice, half - (twice + rise))
        };
        let once = first.gain(fraction);
        let twice = if sixth_jerk.is_zero() {
            once
        } else {
            second.gain(fraction)
        };
        let mean = self.velocity - once;
        let position = self.position - mean.distance(fraction);
        Phase::cubic(
            (self.start, self.anchor.tick()),
            frame.place(position),
            frame.turn(mean - twice),
            (frame.turn(third), frame.turn(sixth_jerk)),
        )
    }
}

/// A part of a tick, Q32.
#[derive(Clone, Copy)]
struct TickPart(u32);

impl Time for TickPart {
    /// Rounded down.
    #[inline]
    fn times(self, value: i128) -> i128 {
        let low = (u128::from(low::u64(value.cast_unsigned())) * u128::from(self.0)) >> 32;
        let high = (i128::from((value >> 64) as i64) * i128::from(self.0)) << 32;
        high + low.cast_signed()
    }
}

/// A constant acceleration. Made once for all ramps at it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Acceleration {
    /// Half of it.
    pub(crate) half: Uq96,
    divisor: Divisor,
}

impl Acceleration {
    /// From steps/s², at least 1: the clock's range keeps it above zero.
    pub(crate) fn new(clock: Clock, steps_per_second_squared: u32) -> Self {
        let half = clock.half_acceleration(steps_per_second_squared);
        Self {
            half,
            divisor: Divisor::new(half.bits()),
        }
    }

    /// How long it takes to change speed by `change`.
    #[inline]
    pub(crate) fn time(&self, change: Uq96) -> TicksQ32 {
        // Speeds have at most 96 bits, so the shift loses nothing.
        TicksQ32::from_bits(self.divisor.quotient(change.bits() << 31, 0))
    }
}

/// The distance of a ramp that lasts `time` and starts at `speed`: growing, or with `braking` falling. Modulo 2³² steps.
#[inline(never)]
pub(crate) fn ramp_distance(
    speed: Uq96,
    half_acceleration: Uq96,
    time: TicksQ32,
    braking: bool,
) -> DistanceQ96 {
    if time.is_zero() {
        return DistanceQ96::ZERO;
    }
    let half_gain = half_acceleration.gain(time);
    let mean = if braking {
        speed.saturating_sub(half_gain)
    } else {
        speed + half_gain
    };
    mean.distance(time)
}
