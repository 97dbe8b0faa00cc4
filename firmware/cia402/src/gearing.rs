//! Electronic gearing: a motor follows a second counter, an external encoder ([`crate::Actuals::counter`]), with a ratio.
//!
//! It is for the module of a product: [`Follower::tick`] gives a velocity in each control tick, which the module puts into
//! [`crate::Commands::target_velocity`] of profile velocity with ramps that have no bound. What the user's objects say becomes [`Ratio`],
//! [`Scheme`] and [`Ramps`] there.
//!
//! The contract:
//! - Counts become increments as a fraction whose remainder is kept: a million turns of the master end where they have to, in both directions, and
//!   the counter may pass the end of its 32 bits.
//! - While it is synchronised, what the position has lost is made up for: the velocity is that of the master and [`GAIN`] times the error.
//! - A coupling has one of three schemes; each begins with the speed that the motor has. Decoupling slows down to standstill on a ramp of its own.
//! - Another ratio makes no jump: a motor that is synchronised couples anew by the ramp, and counts from there.
//! - The velocity of the master is smoothed with [`SMOOTHING`], so that single counts are not felt.

use motion::SignedSpeed;

/// Increments/s for an increment of error.
pub const GAIN: i64 = 20;

/// Time constant of the velocity of the master, in microseconds.
pub const SMOOTHING: i64 = 16_000;

/// Bits behind the point of velocities here.
const POINT: u32 = 16;
const SECOND: i64 = 1_000_000;
/// Products of two numbers below have room.
const LARGEST: i64 = (1 << 31) - 1;

/// Increments of the motor in counts of the master, in lowest terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ratio {
    increments: i32,
    counts: i32,
}

impl Ratio {
    /// So many increments in so many counts; either may be negative. `None` for no counts, or what needs more than 31 bits in lowest terms.
    pub fn new(increments: i64, counts: i64) -> Option<Self> {
        let (mut divisor, mut rest) = (increments.unsigned_abs(), counts.unsigned_abs());
        while rest != 0 {
            (divisor, rest) = (rest, divisor.checked_rem(rest)?);
        }
        let divisor = i64::try_from(divisor).ok()?;
        let sign = if counts < 0 { -1 } else { 1 };
        let part =
            |number: i64| i32::try_from(number.checked_div(divisor)?.checked_mul(sign)?).ok();
        let (increments, counts) = (part(increments)?, part(counts)?);
        (counts > 0).then_some(Self { increments, counts })
    }

    /// Increments of so many counts, and what is left of them, in counts times the increments of the ratio.
    fn of(self, counts: i32, rest: i64) -> (i64, i64) {
        let all = (i64::from(counts) * i64::from(self.increments)).saturating_add(rest);
        let divisor = i64::from(self.counts);
        (
            all.checked_div(divisor).unwrap_or(0),
            all.checked_rem(divisor).unwrap_or(0),
        )
    }

    /// A velocity of the master as one of the motor.
    fn velocity(self, counts: i64) -> i64 {
        let counts = (counts >> 8).clamp(-LARGEST, LARGEST);
        let all = (counts * i64::from(self.increments)).checked_div(self.counts.into());
        all.unwrap_or(0).clamp(-LARGEST << 8, LARGEST << 8) << 8
    }
}

/// How a motor is coupled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// By the ramp up to the velocity of the master; it is synchronised there, and counts from there.
    Ramp,
    /// By the ramp, and what the master has gone since the coupling began is made up for, with so many increments more.
    CatchUp(i32),
    /// While the master goes so many counts its velocity is taken over evenly, as a function of where it is.
    Travel(u32),
}

/// The ramps in increments/s², at least 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ramps {
    /// To couple.
    pub couple: u32,
    /// To decouple.
    pub decouple: u32,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Coupling {
    /// Not coupled.
    #[default]
    Open,
    /// On the ramp to the velocity of the master.
    Ramps,
    /// The same, and it makes up for what the master has moved since the coupling began.
    CatchesUp,
    /// Takes the velocity over evenly while the master moves so many increments in all.
    Travels(i64),
    Synchronised,
    /// On the ramp to standstill.
    Leaves,
}

/// A motor that follows.
#[derive(Debug)]
pub struct Follower {
    ratio: Ratio,
    /// What is left of the counts of before, see [`Ratio::of`].
    rest: i64,
    coupling: Coupling,
    counter: i32,
    position: i32,
    /// Counts/s of the master, smoothed.
    master: i64,
    /// Increments/s that were asked for last.
    speed: i64,
    /// By how many increments the motor is behind.
    error: i64,
    /// Increments that the master has made since the coupling began, and those that the motor was to make.
    gone: i64,
    followed: i64,
}

impl Follower {
    /// A motor that is not coupled.
    pub const fn new() -> Self {
        Self {
            ratio: Ratio {
                increments: 1,
                counts: 1,
            },
            rest: 0,
            coupling: Coupling::Open,
            counter: 0,
            position: 0,
            master: 0,
            speed: 0,
            error: 0,
            gone: 0,
            followed: 0,
        }
    }

    /// Another ratio. A motor that is coupled goes to it by the ramp.
    pub fn set_ratio(&mut self, ratio: Ratio) {
        if ratio == self.ratio {
            return;
        }
        self.ratio = ratio;
        self.rest = 0;
        if self.is_coupled() {
            self.coupling = Coupling::Ramps;
        }
    }

    /// Begins to couple; `speed` is what the motor does now, in increments/s.
    pub fn couple(&mut self, scheme: Scheme, speed: i32) {
        if self.coupling == Coupling::Open {
            self.speed = i64::from(speed) << POINT;
        }
        (self.error, self.gone, self.followed, self.rest) = (0, 0, 0, 0);
        self.coupling = match scheme {
            Scheme::Ramp => Coupling::Ramps,
            Scheme::CatchUp(offset) => {
                self.error = offset.into();
                Coupling::CatchesUp
            }
            Scheme::Travel(counts) => {
                let counts = i32::try_from(counts).unwrap_or(i32::MAX);
                let (travel, _) = self.ratio.of(counts, 0);
                Coupling::Travels(travel.saturating_abs().clamp(1, LARGEST))
            }
        };
    }

    /// Slows down to standstill, and is not coupled any more.
    pub fn decouple(&mut self) {
        if self.is_coupled() {
            self.coupling = Coupling::Leaves;
        }
    }

    /// Something else moves the motor: nothing is coupled, and no ramp is run.
    pub const fn forget(&mut self) {
        self.coupling = Coupling::Open;
    }

    /// Whether the motor follows, or is about to.
    pub const fn is_coupled(&self) -> bool {
        !matches!(self.coupling, Coupling::Open | Coupling::Leaves)
    }

    /// Whether the follower moves the motor: it follows, or slows down to stand.
    pub const fn is_at_work(&self) -> bool {
        !matches!(self.coupling, Coupling::Open)
    }

    /// Whether the motor goes as the master does.
    pub const fn is_synchronised(&self) -> bool {
        matches!(self.coupling, Coupling::Synchronised)
    }

    /// A control tick, so many microseconds behind the last one; `position` is that of the motor in increments. Returns the velocity to keep.
    pub fn tick(
        &mut self,
        counter: i32,
        position: i32,
        elapsed: u32,
        ramps: &Ramps,
    ) -> SignedSpeed {
        let elapsed = i64::from(elapsed.clamp(1, 100_000));
        let counts = counter.wrapping_sub(self.counter);
        let moved = position.wrapping_sub(self.position);
        (self.counter, self.position) = (counter, position);
        self.smooth(counts, elapsed);
        let (gone, rest) = self.ratio.of(counts, self.rest);
        self.rest = rest;
        let master = self.ratio.velocity(self.master);
        let ticks = SECOND.checked_div(elapsed).unwrap_or(1);
        let step = |ramp: u32| {
            let change = i64::from(ramp.max(1)) << POINT;
            change.checked_div(ticks).unwrap_or(change)
        };
        let (goal, max) = match self.coupling {
            Coupling::Open => (0, i64::MAX),
            Coupling::Leaves => (0, step(ramps.decouple)),
            Coupling::Ramps => (master, step(ramps.couple)),
            Coupling::CatchesUp => {
                self.error = self.error.saturating_add(gone).saturating_sub(moved.into());
                let bound = braking(self.error, ramps.couple);
                let correction = correction(self.error).min(bound).max(-bound);
                (master.saturating_add(correction), step(ramps.couple))
            }
            Coupling::Travels(travel) => {
                self.gone = self.gone.saturating_add(gone).min(travel).max(-travel);
                // With all of its velocity at the end, half of the way was gone.
                let square = self.gone * self.gone.abs();
                let half = square.checked_div(travel * 2).unwrap_or(0);
                let step = half.saturating_sub(self.followed);
                self.followed = half;
                self.error = self.error.saturating_add(step).saturating_sub(moved.into());
                let part = ((master >> POINT) * self.gone.abs()).checked_div(travel);
                let part = part.unwrap_or(0) << POINT;
                (part.saturating_add(correction(self.error)), i64::MAX)
            }
            Coupling::Synchronised => {
                self.error = self.error.saturating_add(gone).saturating_sub(moved.into());
                (master.saturating_add(correction(self.error)), i64::MAX)
            }
        };
        let from = self.speed;
        self.speed = goal
            .max(from.saturating_sub(max))
            .min(from.saturating_add(max));
        let is_reached = self.speed == goal;
        match self.coupling {
            Coupling::Ramps if is_reached => {
                self.error = 0;
                self.coupling = Coupling::Synchronised;
            }
            Coupling::CatchesUp if is_reached && self.error.abs() <= WINDOW => {
                self.coupling = Coupling::Synchronised;
            }
            Coupling::Travels(travel) if self.gone.abs() == travel => {
                self.coupling = Coupling::Synchronised;
            }
            Coupling::Leaves if is_reached => self.coupling = Coupling::Open,
            _ => {}
        }
        SignedSpeed::from_bits(self.speed.saturating_mul(1 << (32 - POINT)))
    }

    fn smooth(&mut self, counts: i32, elapsed: i64) {
        let raw = (i64::from(counts).saturating_mul(SECOND << POINT))
            .checked_div(elapsed)
            .unwrap_or(0);
        let away = raw.saturating_sub(self.master);
        let step = away.saturating_mul(elapsed) / SMOOTHING;
        let step = if step == 0 { away.signum() } else { step };
        let is_all = elapsed >= SMOOTHING;
        self.master = if is_all {
            raw
        } else {
            self.master.saturating_add(step)
        };
    }
}

impl Default for Follower {
    fn default() -> Self {
        Self::new()
    }
}

/// Increments within which a motor has caught up.
const WINDOW: i64 = 16;

/// The velocity that makes up for an error.
fn correction(error: i64) -> i64 {
    (error.clamp(-(1 << 40), 1 << 40) * GAIN) << POINT
}

/// The velocity from which half of this deceleration comes to rest within so many increments.
fn braking(error: i64, ramp: u32) -> i64 {
    let square = error.unsigned_abs().saturating_mul(ramp.into());
    i64::try_from(square.isqrt()).unwrap_or(i64::MAX >> 20) << POINT
}

#[cfg(test)]
mod tests;
