//! Along a path of set-points: what a cyclic mode does in each of its periods.

use super::{Axis, Demand};
use crate::clock::Ticks;
use crate::fixed::{Position, State, Velocity};
use crate::low;
use crate::path::{FollowError, Interpolation, Path};
use crate::speed::SignedSpeed;

impl Axis {
    /// Follows set-points: goes in a straight line from the one before, or from where the axis is at the commit horizon, and is at `to`
    /// at tick `end` of its time. To stay somewhere for a while, follow the position where the axis is.
    ///
    /// Behind the last set-point the axis goes on at its velocity for two time slices, then it stands; so a set-point that
    /// is late by that much makes no pause.
    ///
    /// # Errors
    /// [`FollowError`]; the motion goes on as it was.
    pub fn follow(&mut self, end: Ticks, to: Position) -> Result<(), FollowError> {
        self.go_on(end, to, Interpolation::Linear)
    }

    /// As [`Axis::follow`], on a cubic that begins with the velocity that the axis has there and ends with `velocity`.
    ///
    /// # Errors
    /// [`FollowError`]; the motion goes on as it was.
    pub fn follow_smoothly(
        &mut self,
        end: Ticks,
        to: Position,
        velocity: Velocity,
    ) -> Result<(), FollowError> {
        self.go_on(end, to, Interpolation::Cubic(velocity))
    }

    /// Changes the velocity evenly to `velocity` (cut to [`Axis::max_velocity`]) until tick `end` of the axis' time; on
    /// behind that as with [`Axis::follow`].
    ///
    /// # Errors
    /// [`FollowError`]; the motion goes on as it was.
    pub fn follow_velocity(
        &mut self,
        end: Ticks,
        velocity: SignedSpeed,
    ) -> Result<(), FollowError> {
        let velocity = Velocity::from_speed(self.clock, velocity.within(self.max_velocity()));
        let (start, from) = self.path_end();
        let length = end.saturating_sub(start);
        let length = u32::try_from(length).map_err(|_| FollowError::TooFarAhead)?;
        let both = i128::from(from.velocity.bits()) + i128::from(velocity.bits());
        // Twice the distance in Q56: what a position cannot hold of it is kept for the next one, or slow velocities would drift.
        let distance = both * i128::from(length) + i128::from(self.carry);
        let to = from.position.bits().wrapping_add(low::i64(distance >> 25));
        let interpolation = if from.velocity == velocity {
            Interpolation::Steady(velocity)
        } else {
            Interpolation::Cubic(velocity)
        };
        self.go_on(end, Position::from_bits(to), interpolation)?;
        self.carry = low::u32(low::u64(distance.cast_unsigned())) & 0x1FF_FFFF;
        Ok(())
    }

    /// Whether set-points are followed, or were until the axis came to rest.
    pub const fn is_following(&self) -> bool {
        self.path.is_some()
    }

    /// Whether the last set-point is passed in motion, and the axis stands at once, with no ramp, within so many ticks behind the commit
    /// horizon if no other set-point comes.
    pub fn is_running_out(&self, ticks: Ticks) -> bool {
        self.path.as_ref().is_some_and(|path| {
            let rest = path.rest();
            path.ends_in_motion()
                && self.horizon() < rest
                && rest <= self.horizon().saturating_add(ticks)
        })
    }

    /// Whether the next path segment would begin at the commit horizon (and not at the last set-point), and that is beyond this tick.
    pub fn begins_beyond(&self, tick: Ticks) -> bool {
        let horizon = self.horizon();
        let is_ahead = |path: &Path| path.end().0 >= horizon;
        tick < horizon && !self.path.as_ref().is_some_and(is_ahead)
    }

    /// What [`Axis::path_end`] will be in whole steps and steps/s.
    pub fn path_end_demand(&self) -> Demand {
        self.demand_of(self.path_end().1)
    }

    /// Where the next path segment begins, and at which tick: at the last set-point, or at the commit horizon if that is later.
    pub fn path_end(&self) -> (Ticks, State) {
        match &self.path {
            Some(path) if path.end().0 >= self.horizon() => path.end(),
            _ => (self.horizon(), self.state_at(self.horizon())),
        }
    }

    fn go_on(
        &mut self,
        end: Ticks,
        to: Position,
        interpolation: Interpolation,
    ) -> Result<(), FollowError> {
        let horizon = self.horizon();
        if let Some(path) = &mut self.path {
            // The path segment that the axis is on stays as it is.
            if path.end().0 < horizon {
                self.stepper.leave();
            }
            return path.go_on(horizon, end, to, interpolation);
        }
        self.stepper.leave();
        let coasting = self.stepper.time_slice() * 2;
        let mut path = Path::new(horizon, self.state_at(horizon), coasting);
        path.go_on(horizon, end, to, interpolation)?;
        self.is_averaged = false;
        self.acceleration = 0;
        self.path = Some(path);
        Ok(())
    }
}
