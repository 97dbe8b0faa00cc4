//! The motor as the drive uses it: it moves, stops on a ramp, or is cut off, and always knows where it is.
//!
//! What holds for every [`Actuator`] is here: limit switches, stops that no other makes gentler, the home position, the direction of
//! counting. It counts as the master does, from the home position once that is known; the board counts on from where the motor stood at
//! power-on. Positions are increments, and do not wrap.

use core::ops::{Deref, DerefMut};

use motion::{FollowError, Limits, Position, Ramps, SignedSpeed, Speed, low};

use crate::actuator::{Actuator, AtPort, Refused, unwrapped};
use crate::cyclic::MicrosQ16;
use crate::inputs::{ActiveLimits, Count};

/// The longest distance of one motion, in steps.
pub(crate) const REACH: i64 = u32::MAX as i64;

/// A motor. The modes see it without knowing what moves it.
#[derive(Debug)]
pub(crate) struct Motor<A> {
    /// Pulses have been cut off: the actuator does not know where the motor is until it is told.
    cut: bool,
    /// What the master's count has beyond the board's.
    shift: i64,
    /// 2072h: the board counts the other way, and its pulses go the other way.
    is_reversed: bool,
    /// The home position is known.
    referenced: bool,
    active_limits: ActiveLimits,
    /// How the velocity is to change.
    ramps: Ramps,
    /// The deceleration of the stop under way, in steps/s².
    stopping: Option<u32>,
    /// That stop is linear, whatever the ramps are.
    stops_hard: bool,
    /// The deceleration with which a limit switch stops the motor, in steps/s², as long as it still moves into the switch.
    stopping_at_limit: Option<u32>,
    /// The stop under way has a harder ramp than it was asked for, because of a software limit.
    stops_early: bool,
    /// The deceleration that the motion under way is planned with, in steps/s²; 0 at rest.
    deceleration: u32,
    /// The hardest ramp on which it may end because it was planned so, in steps/s²; 0 at rest.
    hardest: u32,
    actuator: A,
}

impl<A> Deref for Motor<A> {
    type Target = A;

    fn deref(&self) -> &A {
        &self.actuator
    }
}

impl<A> DerefMut for Motor<A> {
    fn deref_mut(&mut self) -> &mut A {
        &mut self.actuator
    }
}

impl<A: Actuator> Motor<A> {
    /// A motor that stands at position 0.
    // Out of line, so that it is made where it stays.
    #[inline(never)]
    pub(crate) fn new(actuator: impl FnOnce() -> A) -> Self {
        Self {
            cut: false,
            shift: 0,
            is_reversed: false,
            referenced: false,
            active_limits: ActiveLimits::default(),
            ramps: Ramps::Linear,
            stopping: None,
            stops_hard: false,
            stopping_at_limit: None,
            stops_early: false,
            deceleration: 0,
            hardest: 0,
            actuator: actuator(),
        }
    }

    /// Looks at the motor at the start of a tick at `now`. `position` is where it really is; the actuator takes it over while the motor
    /// has no power, and after it has been cut off.
    pub(crate) fn observe<P>(&mut self, now: MicrosQ16, position: i64, power: bool, port: &P)
    where
        A: AtPort<P>,
    {
        if self.cut || !power && self.is_displaced(position, 0) {
            self.actuator.stand_at(position);
            self.cut = false;
        }
        self.actuator.observe(now, port);
        self.look_at_rest();
    }

    /// Commits what comes next.
    pub(crate) fn advance<P>(&mut self, port: &mut P)
    where
        A: AtPort<P>,
    {
        self.actuator.set_shift(self.shift);
        self.actuator.advance(port, self.is_reversed);
        self.look_at_rest();
    }

    /// At rest there is nothing left of the motion before.
    fn look_at_rest(&mut self) {
        if self.actuator.is_at_rest() {
            self.end_stop();
            self.plan_with(0);
            self.stopping_at_limit = None;
        }
    }
}

impl<A: Actuator> Motor<A> {
    /// The master's count for one of the board's, which may wrap.
    pub(crate) fn position_of(&self, count: i64) -> i64 {
        let count = if self.is_reversed {
            count.wrapping_neg()
        } else {
            count
        };
        unwrapped(
            count.wrapping_add(self.shift),
            self.actuator.committed_position(),
        )
    }

    /// How the master counts while the motor is at `position`.
    pub(crate) const fn count(&self, position: i64) -> Count {
        Count {
            position,
            shift: low::i32(self.shift),
            is_reversed: self.is_reversed,
        }
    }

    /// At power-up, with an absolute encoder: positions are its counts, in this direction.
    pub(crate) const fn count_as_encoder(&mut self, is_reversed: bool) {
        self.is_reversed = is_reversed;
        self.shift = 0;
    }

    /// Turns the direction round while there is no power; the board's count is `count`. The motor keeps its position, but the home position
    /// is no longer known.
    pub(crate) fn set_reversed(&mut self, is_reversed: bool, count: i64) {
        if is_reversed != self.is_reversed {
            let position = self.position_of(count);
            self.is_reversed = is_reversed;
            let change = position.wrapping_sub(self.position_of(count));
            self.shift = self.shift.wrapping_add(change);
            self.referenced = false;
        }
    }

    /// Whether the home position is known.
    pub(crate) const fn is_referenced(&self) -> bool {
        self.referenced
    }

    /// The position `home` (modulo 2³²) is found, and is to be called `name`. The motor stands at `position`. Returns by how much
    /// all positions have changed.
    pub(crate) fn set_home(&mut self, position: i64, home: i32, name: i64) -> i64 {
        let away = i64::from(home.wrapping_sub(low::i32(position)));
        let change = name.wrapping_sub(position.wrapping_add(away));
        self.shift = self.shift.wrapping_add(change);
        self.referenced = true;
        self.actuator.stand_at(position.wrapping_add(change));
        change
    }

    /// The motor is not where its demands should have taken it.
    pub(crate) const fn lose_reference(&mut self) {
        self.referenced = false;
    }

    /// A limit of its torque, or of the lead of its field, keeps it from where it is to be.
    pub(crate) fn is_held_back(&self) -> bool {
        self.torque().is_some_and(|torque| torque.is_limited)
    }

    /// Whether what is committed leads further than `position_tolerance` from this position.
    pub(crate) fn is_displaced(&self, position: i64, position_tolerance: u32) -> bool {
        self.actuator.committed_position().abs_diff(position) > position_tolerance.into()
    }

    /// Sets the limit switches that are active. Returns whether the motor runs into one of them and has not been told to stop there
    /// yet.
    pub(crate) fn take_limits(&mut self, limits: ActiveLimits) -> bool {
        self.active_limits = limits;
        if limits == ActiveLimits::default() {
            self.stopping_at_limit = None;
            return false;
        }
        let heading = self.actuator.heading();
        let into = heading.is_some_and(|direction| limits.block(direction));
        if !into {
            self.stopping_at_limit = None;
        }
        into && self.stopping_at_limit.is_none()
    }

    /// Whether no limit switch blocks a motion of this sign.
    #[inline(never)]
    pub(crate) fn is_free(&self, distance: i64) -> Result<(), Refused> {
        if distance > 0 && self.active_limits.forward || distance < 0 && self.active_limits.reverse
        {
            Err(Refused)
        } else {
            Ok(())
        }
    }

    /// Says how the velocity is to change, from the next motion on.
    pub(crate) const fn set_ramps(&mut self, ramps: Ramps) {
        self.ramps = ramps;
    }

    /// Moves to a position, from whatever the motor does now. On an error nothing changes.
    pub(crate) fn move_to(&mut self, target: i64, limits: Limits) -> Result<(), Refused> {
        self.is_free(target.saturating_sub(self.actuator.committed_position()))?;
        let (limits, ramps) = self.at_limit(limits);
        self.actuator.move_to(target, limits, ramps)?;
        self.begin_motion(limits);
        Ok(())
    }

    /// Moves to a position, with a start speed. On an error nothing changes.
    pub(crate) fn move_from_start_speed(
        &mut self,
        target: i64,
        start_speed: Speed,
        limits: Limits,
    ) -> Result<(), Refused> {
        self.is_free(target.saturating_sub(self.actuator.committed_position()))?;
        let (limits, ramps) = self.at_limit(limits);
        self.actuator
            .move_from_start_speed(target, start_speed, limits, ramps)?;
        self.begin_motion(limits);
        Ok(())
    }

    /// Moves through a position with an end velocity and keeps that. On an error nothing changes.
    pub(crate) fn move_through(
        &mut self,
        target: i64,
        end_velocity: Speed,
        limits: Limits,
    ) -> Result<(), Refused> {
        self.is_free(target.saturating_sub(self.actuator.committed_position()))?;
        let (limits, ramps) = self.at_limit(limits);
        self.actuator
            .move_through(target, end_velocity, limits, ramps)?;
        self.begin_motion(limits);
        Ok(())
    }

    /// Ramps to a velocity and keeps it, from whatever the motor does now. On an error nothing changes.
    pub(crate) fn ramp_to(&mut self, velocity: SignedSpeed, limits: Limits) -> Result<(), Refused> {
        self.is_free(velocity.bits())?;
        let (limits, ramps) = self.at_limit(limits);
        self.actuator.ramp_to(velocity, limits, ramps)?;
        self.begin_motion(limits);
        Ok(())
    }

    /// While a limit switch stops the motor, a motion away from it begins with no gentler ramp, and without delay.
    fn at_limit(&self, limits: Limits) -> (Limits, Ramps) {
        match self.stopping_at_limit {
            None => (limits, self.ramps),
            Some(least) => {
                let deceleration = limits.deceleration.max(least);
                let limits = Limits {
                    deceleration,
                    ..limits
                };
                (limits, Ramps::Linear)
            }
        }
    }

    /// A motion takes the place of a stop.
    const fn begin_motion(&mut self, limits: Limits) {
        self.end_stop();
        self.plan_with(limits.deceleration);
    }

    /// The stop under way is over.
    const fn end_stop(&mut self) {
        self.stopping = None;
        self.stops_early = false;
    }

    /// Notes the deceleration of the motion under way; 0 for none.
    const fn plan_with(&mut self, deceleration: u32) {
        self.deceleration = deceleration;
        // What is needed to end where it ends is rounded up.
        self.hardest = deceleration.saturating_add(deceleration / 16);
    }

    /// As [`Actuator::follow`].
    pub(crate) fn follow(&mut self, end: MicrosQ16, to: Position) -> Result<(), FollowError> {
        self.actuator.follow(end, to)?;
        self.begin_following();
        Ok(())
    }

    /// As [`Actuator::follow_smoothly`].
    pub(crate) fn follow_smoothly(
        &mut self,
        end: MicrosQ16,
        to: Position,
        velocity: (Position, MicrosQ16),
    ) -> Result<(), FollowError> {
        self.actuator.follow_smoothly(end, to, velocity)?;
        self.begin_following();
        Ok(())
    }

    /// As [`Actuator::follow_velocity`].
    pub(crate) fn follow_velocity(
        &mut self,
        end: MicrosQ16,
        velocity: SignedSpeed,
    ) -> Result<(), FollowError> {
        self.actuator.follow_velocity(end, velocity)?;
        self.begin_following();
        Ok(())
    }

    /// Holds a torque, in thousandths of the rated one, from whatever the motor does now.
    ///
    /// # Errors
    /// A limit switch blocks that direction, or the actuator has no torque; nothing changes.
    pub(crate) fn hold_torque(&mut self, torque: i16) -> Result<(), Refused> {
        self.is_free(torque.into())?;
        self.actuator.hold_torque(torque).map_err(|_| Refused)?;
        self.begin_following();
        Ok(())
    }

    /// Set-points take the place of a planned motion, and of its ramps.
    const fn begin_following(&mut self) {
        self.end_stop();
        self.plan_with(0);
    }

    /// The deceleration that the motion under way is planned with, in steps/s²: no gentler one may be needed to end where it ends. 0 at
    /// rest.
    pub(crate) const fn deceleration(&self) -> u32 {
        self.deceleration
    }

    /// The hardest ramp on which the motion under way may end because it was planned so, in steps/s²: its own and a little more, unless it
    /// has been held back. 0 at rest.
    pub(crate) const fn hardest(&self) -> u32 {
        self.hardest
    }

    /// The motion under way may end on this ramp, in steps/s², and on no harder one: its own is not what was asked for.
    pub(crate) const fn set_hardest(&mut self, hardest: u32) {
        self.hardest = hardest;
    }

    /// Whether a stop is under way.
    pub(crate) const fn is_stopping(&self) -> bool {
        self.stopping.is_some()
    }

    /// Slows down to a standstill. A deceleration that gives no ramp, such as 0, stops the motor at once: a drive that is
    /// told to stop never goes on.
    pub(crate) fn stop(&mut self, deceleration: u32) {
        self.stop_on(deceleration, true);
    }

    /// Slows down with the ramps chosen, or with a linear one.
    pub(crate) fn stop_on(&mut self, deceleration: u32, is_smooth: bool) {
        let is_smooth = is_smooth && self.stopping_at_limit.is_none();
        self.stops_hard = !is_smooth;
        let ramps = if is_smooth { self.ramps } else { Ramps::Linear };
        let deceleration = deceleration.max(self.stopping_at_limit.unwrap_or(0));
        if self.actuator.stop(deceleration, ramps).is_ok() {
            self.stopping = Some(deceleration);
            self.plan_with(deceleration);
        } else {
            self.cut_off();
        }
    }

    /// Where [`Motor::stop`] would end with these ramps. With `leaves`, a sin² ramp under way is broken off as a move with these limits to
    /// another target would break it off.
    #[inline(never)]
    pub(crate) fn stop_preview(
        &self,
        deceleration: u32,
        ramps: Ramps,
        leaves: Option<&Limits>,
    ) -> i64 {
        match self.stopping_at_limit {
            None => self.actuator.stop_preview(deceleration, ramps, leaves),
            Some(least) => {
                let deceleration = deceleration.max(least);
                self.actuator
                    .stop_preview(deceleration, Ramps::Linear, leaves)
            }
        }
    }

    /// Slows down because of a limit switch. Nothing gentler takes its place: no other stop, and no motion away from the switch.
    pub(crate) fn stop_at_limit(&mut self, deceleration: u32) {
        self.stop_no_gentler(deceleration, false);
        self.stopping_at_limit = self.stopping;
    }

    /// Slows down to a standstill, on the ramp of the stop that is under way if that is harder. No ramp is the hardest.
    #[inline(never)]
    pub(crate) fn stop_no_gentler(&mut self, deceleration: u32, is_smooth: bool) {
        let least = self.stopping.filter(|_| deceleration > 0).unwrap_or(0);
        let is_smooth = is_smooth && !(self.stopping.is_some() && self.stops_hard);
        self.stop_on(deceleration.max(least), is_smooth);
    }

    /// Keeps the stop under way within these software limits: if it would end beyond them, it goes on with this deceleration, unless
    /// its own is as hard. Returns whether the ramp that was asked for still holds.
    pub(crate) fn keep_stop_within(&mut self, (low, high): (i64, i64), deceleration: u32) -> bool {
        let end = self.actuator.destination();
        let committed = self.actuator.committed_position();
        let is_beyond = end > high.max(committed) || end < low.min(committed);
        let own = self.stopping.unwrap_or(0);
        if is_beyond && (own < deceleration || !self.stops_hard) {
            let harder = own.max(deceleration);
            let hardest = self.hardest.max(harder);
            self.stop_on(harder, false);
            self.hardest = hardest;
            self.stops_early = true;
        }
        !self.stops_early
    }

    /// Drops everything that has not been done yet. The board does so at the end of the tick.
    #[inline(never)]
    pub(crate) fn cut_off(&mut self) {
        // Without current a motor coasts to an unknown position.
        self.referenced &= self.actuator.standstill();
        self.end_stop();
        self.stopping_at_limit = None;
        self.actuator.cut_off();
        self.cut = true;
    }

    /// Whether the motor was cut off in this tick.
    pub(crate) const fn is_cut(&self) -> bool {
        self.cut
    }
}

#[cfg(test)]
mod tests;
