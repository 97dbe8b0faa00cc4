//! One phase of a plan: a parabola, evaluated without rounding; a cubic, where the jerk is limited; or a sin² ramp.
//!
//! Coefficients are Q96 in 128 bits and time is a whole number of ticks from the phase's anchor, so x = x₀ + n·(v + n·h) in wrapping
//! arithmetic is exact modulo 2³² steps, which is the span of a position. There is no error to accumulate, however
//! long the phase; a cruise that never ends needs no new anchor. The coefficient of a cubic is Q128: over the time that a jerk lasts, its
//! rounding does not show.

use crate::clock::{Clock, Fine, Ticks};
use crate::divide::Divisor;
use crate::fixed::{Exact, Q96, Q128, State, product};
use crate::stepper::piece::Piece as Polynomial;
use crate::wide::Wide;

use super::rough::Rough;
use super::sine::Sine;

/// A time in ticks, Q32: corners fall between ticks.
pub(crate) type Offset = u128;

/// When that is: ticks as the axis counts them, Q32; 96 bits. What is later than ticks can count is never.
#[derive(Debug, Clone, Copy)]
pub(super) struct Instant(u128);

impl Instant {
    /// A tick.
    pub(super) const fn from(tick: Ticks) -> Self {
        Self((tick as u128) << 32)
    }

    #[inline]
    pub(super) fn after(self, time: Offset) -> Self {
        let sum = self.0.wrapping_add(time);
        if (sum | time) >> 96 == 0 {
            Self(sum)
        } else {
            Self::from(Ticks::MAX)
        }
    }

    /// The last tick that is not behind it.
    const fn tick(self) -> Ticks {
        (self.0 >> 32) as u64
    }

    /// The first tick that is not before it.
    pub(super) fn tick_up(self) -> Ticks {
        let is_behind = self.fraction() != 0;
        self.tick().saturating_add(is_behind.into())
    }

    /// How far it is behind the tick before it, Q32.
    const fn fraction(self) -> u32 {
        self.0 as u32
    }
}

/// What a phase is beyond a parabola.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Curve {
    /// Nothing.
    Parabola,
    /// A sixth of the jerk, Q128 steps per tick³.
    Cubic(i128),
    /// The velocity is that at the anchor, and this comes on top. The half acceleration is the greatest there is.
    Sine(Sine),
}

/// A stretch of constant acceleration or constant jerk, or a sin² ramp.
#[derive(Debug, Clone, Copy)]
pub struct Phase {
    /// The first tick that belongs to it.
    start: Ticks,
    /// The tick for which the coefficients hold.
    anchor: Ticks,
    position: i128,
    velocity: i128,
    half_acceleration: i128,
    curve: Curve,
    /// Of a sin² ramp: how far behind its tick the anchor really lies, Q32.
    lead: u32,
}

impl Phase {
    pub(crate) const NONE: Self = Self {
        start: 0,
        anchor: 0,
        position: 0,
        velocity: 0,
        half_acceleration: 0,
        curve: Curve::Parabola,
        lead: 0,
    };

    /// A parabola that begins in a state, with half of an acceleration, Q96 steps per tick².
    pub(crate) const fn parabola(start: Ticks, from: Exact, half_acceleration: i128) -> Self {
        Self {
            start,
            anchor: start,
            position: from.position,
            velocity: from.velocity,
            half_acceleration,
            ..Self::NONE
        }
    }

    /// The first tick of this phase.
    pub const fn start(&self) -> Ticks {
        self.start
    }

    /// The acceleration at the start of the phase in steps/s², to the nearest.
    pub fn acceleration(&self, clock: Clock) -> i64 {
        self.acceleration_at(clock, self.start)
    }

    /// The acceleration at tick `t` of the phase in steps/s², to the nearest.
    pub fn acceleration_at(&self, clock: Clock, t: Ticks) -> i64 {
        let acceleration = self.pull(t);
        let rate = u128::from(clock.hz());
        let magnitude = Wide::product(acceleration.unsigned_abs(), rate.wrapping_mul(rate))
            .plus(Wide::product(1 << 95, 1))
            .shifted_wrapping(96) as i64;
        if acceleration < 0 {
            magnitude.wrapping_neg()
        } else {
            magnitude
        }
    }

    /// The acceleration at tick `t`, Q96 steps per tick².
    pub(crate) fn pull(&self, t: Ticks) -> i128 {
        match &self.curve {
            Curve::Parabola => self.half_acceleration.wrapping_mul(2),
            Curve::Cubic(sixth_jerk) => {
                let bend = whole(times(*sixth_jerk, self.since_anchor(t)));
                let half = self.half_acceleration.wrapping_add(bend.wrapping_mul(3));
                half.wrapping_mul(2)
            }
            Curve::Sine(sine) => sine.acceleration(self.away(t)),
        }
    }

    /// Of a sin² ramp, its change of velocity by the square of its time.
    pub(super) fn steepness_of_sine(&self) -> Option<Rough> {
        match &self.curve {
            Curve::Sine(sine) => Some(sine.steepness()),
            Curve::Parabola | Curve::Cubic(_) => None,
        }
    }

    /// The state at tick `t` of the phase.
    pub fn state_at(&self, t: Ticks) -> State {
        self.at(t).rounded()
    }

    /// The exact state at tick `t`.
    #[inline(never)]
    pub(crate) fn at(&self, t: Ticks) -> Exact {
        let n = self.since_anchor(t);
        // Most of the time is spent in cruises, and wide products are dear.
        let gain = match &self.curve {
            Curve::Parabola if self.half_acceleration == 0 => 0,
            Curve::Parabola => times(self.half_acceleration, n),
            Curve::Cubic(_) | Curve::Sine(_) => return self.at_on_curve(t, n),
        };
        Exact {
            position: times(self.velocity.wrapping_add(gain), n).wrapping_add(self.position),
            velocity: self.velocity.wrapping_add(gain).wrapping_add(gain),
        }
    }

    /// The exact state at tick `t`, and the acceleration there, Q96 steps per tick².
    pub(crate) fn motion_at(&self, t: Ticks) -> (Exact, i128) {
        let Curve::Sine(sine) = &self.curve else {
            return (self.at(t), self.pull(t));
        };
        let (way, change, pull) = sine.at_with_acceleration(self.away(t));
        let n = self.since_anchor(t);
        (self.moved(times(self.velocity, n), way, change), pull)
    }

    fn at_on_curve(&self, t: Ticks, n: i128) -> Exact {
        match &self.curve {
            Curve::Cubic(sixth_jerk) => {
                let bend = whole(times(*sixth_jerk, n));
                let half = self.half_acceleration.wrapping_add(bend);
                let mean = self.velocity.wrapping_add(times(half, n));
                let rise = half.wrapping_mul(2).wrapping_add(bend);
                self.moved(times(mean, n), 0, times(rise, n))
            }
            Curve::Sine(sine) => {
                let (way, change) = sine.at(self.away(t));
                self.moved(times(self.velocity, n), way, change)
            }
            Curve::Parabola => self.moved(0, 0, 0),
        }
    }

    /// So far from the anchor, and further.
    fn moved(&self, way: i128, further: i128, change: i128) -> Exact {
        Exact {
            position: self.position.wrapping_add(way).wrapping_add(further),
            velocity: self.velocity.wrapping_add(change),
        }
    }

    /// How it goes on from tick `t` up to `end`, its own or an earlier one, as a polynomial: as much of it as is one.
    pub(crate) fn piece(&self, t: Ticks, end: Ticks) -> Polynomial {
        let sixth = match &self.curve {
            Curve::Parabola => Q128::ZERO,
            Curve::Cubic(sixth_jerk) => Q128(*sixth_jerk),
            Curve::Sine(_) => {
                // A 32nd of the ramp is a cubic, but for 0.001 steps.
                let part = (end.saturating_sub(self.start) >> 5).max(1 << 13);
                let length = part.min(end.saturating_sub(t)).clamp(1, 1 << 31) as u32;
                let end = t.saturating_add(length.into());
                return Polynomial::between(self.at(t), (end, self.at(end)), length);
            }
        };
        Polynomial {
            half: Q96(self.pull(t) >> 1),
            sixth,
            ..Polynomial::line(end, self.at(t))
        }
    }

    fn since_anchor(&self, t: Ticks) -> i128 {
        i128::from(t.wrapping_sub(self.anchor).cast_signed())
    }

    /// From where the anchor really lies to tick `t`, Q32.
    fn away(&self, t: Ticks) -> i128 {
        (self.since_anchor(t) << 32).wrapping_sub(self.lead.into())
    }

    /// Half of the acceleration at the anchor, Q96 steps per tick²; of a parabola, that everywhere.
    pub(crate) const fn half_acceleration(&self) -> i128 {
        self.half_acceleration
    }

    /// Whether it is one parabola.
    pub(crate) const fn is_parabola(&self) -> bool {
        matches!(self.curve, Curve::Parabola)
    }

    /// Whether its velocity stays.
    pub(crate) const fn is_line(&self) -> bool {
        self.is_parabola() && self.half_acceleration == 0
    }
}

/// A product modulo 2¹²⁸. Within 2³² ticks of the anchor, 25 s at 168 MHz, it is four short ones.
#[inline]
fn times(value: i128, ticks: i128) -> i128 {
    let Ok(factor) = u32::try_from(ticks.unsigned_abs()) else {
        return value.wrapping_mul(ticks);
    };
    let product = product(value, factor);
    if ticks < 0 {
        product.wrapping_neg()
    } else {
        product
    }
}

/// From where a plan counts: its positions from an origin, positive in the direction of the motion; its times from a tick.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    pub(super) start: Ticks,
    /// Q96 steps.
    pub(super) origin: i128,
    /// The motion goes backwards.
    pub(super) reverse: bool,
}

impl Frame {
    fn turn(&self, value: i128) -> i128 {
        if self.reverse {
            value.wrapping_neg()
        } else {
            value
        }
    }

    /// A position of the axis.
    pub(super) fn place(&self, position: i128) -> i128 {
        self.origin.wrapping_add(self.turn(position))
    }
}

/// What the curve of a draft is beyond a parabola.
#[derive(Debug, Clone, Copy)]
pub(super) enum Bend {
    /// Nothing.
    None,
    /// A sixth of the jerk, Q128 steps per tick³.
    Jerk(i128),
    /// The ramp is drawn as sin² and takes so long, which is not 0.
    Sine(Offset),
}

/// A phase in the frame, and as it is found: anchored between two ticks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    /// The first tick that belongs to it.
    pub(super) start: Ticks,
    /// When position and velocity hold.
    pub(super) anchor: Instant,
    pub(super) position: i128,
    pub(super) velocity: i128,
    /// Of a sin² ramp: that of the linear one in its place.
    pub(super) half_acceleration: i128,
    pub(super) bend: Bend,
}

impl Piece {
    pub(super) const NONE: Self = Self {
        start: 0,
        anchor: Instant::from(0),
        position: 0,
        velocity: 0,
        half_acceleration: 0,
        bend: Bend::None,
    };

    /// Whether its velocity stays.
    pub(super) const fn is_line(&self) -> bool {
        matches!(self.bend, Bend::None) && self.half_acceleration == 0
    }

    /// Writes the phase itself: brings the coefficients from the anchor down to the whole tick before it, and into the frame of the axis.
    #[inline(never)]
    pub(super) fn work_out(&self, frame: &Frame, phase: &mut Phase) {
        let turn = |value| frame.turn(value);
        let fraction = self.anchor.fraction();
        let half = self.half_acceleration;
        phase.start = self.start;
        phase.anchor = self.anchor.tick();
        phase.lead = fraction;
        let back = match self.bend {
            Bend::None => {
                // v − 2hφ and x − vφ + hφ²
                let once = part(half, fraction);
                let mean = self.velocity.wrapping_sub(once);
                phase.curve = Curve::Parabola;
                phase.half_acceleration = turn(half);
                phase.velocity = turn(mean.wrapping_sub(once));
                mean
            }
            Bend::Jerk(sixth_jerk) => {
                // h − 3cφ, v − 2hφ + 3cφ² and x − vφ + hφ² − cφ³
                let bend = part(sixth_jerk, fraction) >> 32;
                let first = half.wrapping_sub(bend);
                let second = first.wrapping_sub(bend);
                let mean = self.velocity.wrapping_sub(part(first, fraction));
                phase.curve = Curve::Cubic(turn(sixth_jerk));
                phase.half_acceleration = turn(second.wrapping_sub(bend));
                phase.velocity = turn(mean.wrapping_sub(part(second, fraction)));
                mean
            }
            Bend::Sine(time) => {
                phase.curve = Curve::Sine(Sine::new(turn(half), time));
                phase.half_acceleration = turn(half_peak(half));
                phase.velocity = turn(self.velocity);
                self.velocity
            }
        };
        phase.position = frame.place(self.position.wrapping_sub(part(back, fraction)));
    }
}

/// The greatest acceleration of a sin² ramp, from that of the linear one in its place, both halved: π/2 times as much, and a little more
/// rather than less.
pub(super) const fn half_peak(half_acceleration: i128) -> i128 {
    let half = half_acceleration.unsigned_abs().cast_signed();
    (half.wrapping_mul(13) >> 3).wrapping_add(1)
}

/// value / 2³² towards zero, which treats both directions alike.
fn whole(value: i128) -> i128 {
    let magnitude = (value.unsigned_abs() >> 32).cast_signed();
    if value < 0 {
        magnitude.wrapping_neg()
    } else {
        magnitude
    }
}

/// ⌊value · fraction / 2³²⌋ of a value of at most 96 bits.
#[inline]
fn part(value: i128, fraction: u32) -> i128 {
    let low = u128::from(value as u64).wrapping_mul(fraction.into()) >> 32;
    let high = i128::from((value >> 64) as i64).wrapping_mul(fraction.into()) << 32;
    high.wrapping_add(low.cast_signed())
}

/// ⌊value · time⌋ modulo 2¹²⁸.
#[inline(always)]
pub(crate) fn over_time(value: u128, time: Offset) -> u128 {
    // Both in halves.
    let low = u128::from(value as u64).wrapping_mul((time as u64).into()) >> 32;
    let high = (value >> 64).wrapping_mul((time as u64).into()) << 32;
    let way = low.wrapping_add(high);
    // Nearly all ramps take less than 2³² ticks, 25 s at 168 MHz.
    if time >> 64 == 0 {
        return way;
    }
    way.wrapping_add(value.wrapping_mul(time >> 64) << 32)
}

/// A constant acceleration. Made once for all ramps at it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slope {
    /// Half of it, Q96 steps per tick².
    pub(crate) half: Fine,
    divisor: Divisor,
}

impl Slope {
    /// From steps/s², at least 1: the clock's range keeps it above zero.
    pub(crate) fn new(clock: Clock, steps_per_second_squared: u32) -> Self {
        let half = clock.half_acceleration(steps_per_second_squared);
        Self {
            half,
            divisor: Divisor::new(half),
        }
    }

    /// How long it takes to change speed by `change`.
    #[inline]
    pub(crate) fn time(&self, change: Fine) -> Offset {
        // Speeds have at most 96 bits, so the shift loses nothing.
        self.divisor.quotient(change << 31, 0)
    }
}

/// The way of a ramp that lasts `time` and starts at `speed`: growing, or with `braking` falling. Modulo 2³² steps.
#[inline(never)]
pub(crate) fn ramp_way(speed: Fine, half_acceleration: Fine, time: Offset, braking: bool) -> u128 {
    if time == 0 {
        return 0;
    }
    let half_gain = over_time(half_acceleration, time);
    let mean = if braking {
        speed.saturating_sub(half_gain)
    } else {
        speed.wrapping_add(half_gain)
    };
    over_time(mean, time)
}
