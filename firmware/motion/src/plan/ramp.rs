//! The jerk-limited ramp: from any velocity and acceleration to a velocity that is kept.
//!
//! The acceleration goes at the jerk j to a greatest value, stays there, and goes at j to nothing: at most three pieces. From
//! (v₀, a₀) to v₁ the greatest acceleration is √(j·Δ + a₀²) where Δ is the change that is left once a₀ has gone to
//! nothing, or the limit, if that is less. It is rounded down, and the middle piece takes up what that leaves; so nothing
//! has to be rounded twice.

use super::phase::{Offset, over_time};
use crate::clock::Fine;
use crate::divide::{Divisor, quotient};
use crate::wide::Wide;

/// The jerk, as it is worked with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Jerk {
    /// A sixth of it, Q128 steps per tick³: the coefficient of a cubic. At most `TOP_SIXTH_JERK`.
    pub(crate) sixth: Fine,
    divisor: Divisor,
}

impl Jerk {
    pub(super) fn new(sixth: Fine) -> Self {
        Self {
            sixth,
            divisor: Divisor::new(sixth.wrapping_mul(6)),
        }
    }

    /// All of it, Q128.
    pub(super) const fn whole(self) -> Fine {
        self.sixth.wrapping_mul(6)
    }

    /// How long it takes to change the acceleration by this much, Q96.
    pub(super) fn time(self, change: Fine) -> Offset {
        self.divisor.quotient(change, 2)
    }
}

/// Ways of 2³¹ steps and more saturate: from here on, a few steps below that, they count as if they had.
pub(super) const LONGEST: u128 = (1 << 127) - (1 << 100);

/// A stretch of constant jerk: what holds at its beginning, all Q96 but the jerk.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Piece {
    pub(super) time: Offset,
    pub(super) velocity: i128,
    pub(super) acceleration: i128,
    /// A sixth of the jerk, Q128.
    pub(super) sixth_jerk: i128,
    /// How far it goes, Q96 steps; saturates.
    pub(super) way: i128,
}

impl Piece {
    /// The velocity at its end.
    pub(super) fn end_velocity(&self) -> i128 {
        let half = scaled(self.sixth_jerk.saturating_mul(3), self.time) >> 32;
        let mean = self.acceleration.saturating_add(half);
        self.velocity.saturating_add(scaled(mean, self.time))
    }

    /// How far it goes.
    pub(super) fn goes(&self) -> i128 {
        scaled(self.mean_velocity(), self.time)
    }

    /// How far it moves the position: modulo 2³² steps where [`Piece::way`] is at its limit.
    pub(super) fn shift(&self) -> i128 {
        if self.way.unsigned_abs() < LONGEST {
            return self.way;
        }
        let mean = self.mean_velocity();
        let way = over_time(mean.unsigned_abs(), self.time).cast_signed();
        if mean < 0 { way.wrapping_neg() } else { way }
    }

    fn mean_velocity(&self) -> i128 {
        let bend = scaled(self.sixth_jerk, self.time) >> 32;
        let half = (self.acceleration >> 1).saturating_add(bend);
        self.velocity.saturating_add(scaled(half, self.time))
    }
}

/// A change of velocity.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Ramp {
    pub(super) pieces: [Piece; 3],
    pub(super) time: Offset,
    /// Q96 steps; saturates.
    pub(super) way: i128,
}

/// The velocity that is left when the acceleration has gone to nothing by the shortest way.
pub(super) fn coasting(velocity: i128, acceleration: i128, jerk: Jerk) -> i128 {
    if acceleration == 0 {
        return velocity;
    }
    let time = jerk.time(acceleration.unsigned_abs());
    velocity.saturating_add(scaled(acceleration, time) >> 1)
}

impl Ramp {
    /// From `velocity` with `acceleration` to the velocity `end`, with at most the acceleration `most`; all Q96.
    pub(super) fn new(
        velocity: i128,
        acceleration: i128,
        end: i128,
        most: Fine,
        jerk: Jerk,
    ) -> Self {
        let coasting = coasting(velocity, acceleration, jerk);
        if end < coasting {
            let mut ramp = Self::upwards(
                velocity.wrapping_neg(),
                acceleration.wrapping_neg(),
                (end.wrapping_neg(), coasting.wrapping_neg()),
                most,
                jerk,
            );
            ramp.mirror();
            return ramp;
        }
        Self::upwards(velocity, acceleration, (end, coasting), most, jerk)
    }

    /// To a velocity that is not below that of coasting.
    fn upwards(
        velocity: i128,
        acceleration: i128,
        (end, coasting): (i128, i128),
        most: Fine,
        jerk: Jerk,
    ) -> Self {
        let gain = end.wrapping_sub(coasting).unsigned_abs();
        let mut square = Wide::product(jerk.whole(), gain);
        if acceleration > 0 {
            // Q224 as the product is.
            let shifted = acceleration.unsigned_abs() << 16;
            square = square.plus(Wide::product(shifted, shifted));
        }
        let peak = (square.root() >> 16).min(most).cast_signed();
        let sixth = jerk.sixth.cast_signed();

        let entry = jerk.time(peak.abs_diff(acceleration));
        let exit = if acceleration == 0 {
            entry
        } else {
            jerk.time(peak.unsigned_abs())
        };
        let risen = velocity.saturating_add(scaled(acceleration.saturating_add(peak), entry) >> 1);
        let leaving = end.saturating_sub(scaled(peak, exit) >> 1);
        let hold = if leaving > risen && peak > 0 {
            quotient(
                leaving.wrapping_sub(risen).unsigned_abs(),
                1,
                peak.unsigned_abs(),
            )
        } else {
            0
        };
        let falls = acceleration > peak;
        let pieces = [
            Piece {
                time: entry,
                velocity,
                acceleration,
                sixth_jerk: if falls { sixth.wrapping_neg() } else { sixth },
                way: 0,
            },
            Piece {
                time: hold,
                velocity: risen,
                acceleration: peak,
                sixth_jerk: 0,
                way: 0,
            },
            Piece {
                time: exit,
                velocity: leaving,
                acceleration: peak,
                sixth_jerk: sixth.wrapping_neg(),
                way: 0,
            },
        ];
        let mut ramp = Self {
            pieces,
            time: 0,
            way: 0,
        };
        for piece in &mut ramp.pieces {
            if piece.time != 0 {
                piece.way = piece.goes();
                ramp.way = ramp.way.saturating_add(piece.way);
                ramp.time = ramp.time.saturating_add(piece.time);
            }
        }
        ramp
    }

    /// The way back down to rest of a ramp from rest to the velocity `end`: it is the same backwards in time.
    pub(super) fn back_to_rest(&self, end: i128) -> Self {
        let [entry, hold, exit] = &self.pieces;
        let falls = |piece: &Piece, velocity: i128, acceleration: i128| Piece {
            velocity,
            acceleration: acceleration.wrapping_neg(),
            ..*piece
        };
        Self {
            pieces: [
                falls(exit, end, 0),
                falls(hold, exit.velocity, hold.acceleration),
                falls(entry, hold.velocity, exit.acceleration),
            ],
            ..*self
        }
    }

    /// The same in the other direction of motion.
    fn mirror(&mut self) {
        for piece in &mut self.pieces {
            piece.velocity = piece.velocity.wrapping_neg();
            piece.acceleration = piece.acceleration.wrapping_neg();
            piece.sixth_jerk = piece.sixth_jerk.wrapping_neg();
            piece.way = piece.way.saturating_neg();
        }
        self.way = self.way.saturating_neg();
    }
}

/// How far a ramp goes that begins and ends with no acceleration, Q96 steps, saturating: half of both velocities over its time. What
/// [`Ramp::new`] would find, without its pieces.
pub(super) fn steady_way(velocity: i128, end: i128, most: Fine, jerk: Jerk) -> i128 {
    let gain = end.wrapping_sub(velocity).unsigned_abs();
    let peak = (Wide::product(jerk.whole(), gain).root() >> 16).min(most);
    if peak == 0 {
        return 0;
    }
    // What the acceleration gains while it comes and goes is as much as it would gain in half of that time.
    let entry = jerk.time(peak);
    let time = entry.saturating_add(quotient(gain, 1, peak));
    let least = entry.saturating_mul(2);
    scaled((velocity >> 1).saturating_add(end >> 1), time.max(least))
}

/// value · time, saturating.
fn scaled(value: i128, time: Offset) -> i128 {
    let magnitude = value.unsigned_abs();
    // Most times and velocities are so small that nothing is lost.
    let magnitude = if time >> 64 == 0 && magnitude >> 95 == 0 {
        over_time(magnitude, time).cast_signed()
    } else {
        let product = Wide::product(magnitude, time).shifted(32);
        let product = product.and_then(|product| i128::try_from(product).ok());
        product.unwrap_or(i128::MAX)
    };
    if value < 0 {
        magnitude.wrapping_neg()
    } else {
        magnitude
    }
}
