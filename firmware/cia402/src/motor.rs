//! The axis as the drive uses it: it moves, stops on a ramp, or is cut off, and always knows where it is.

mod directed;
mod handing_out;

use motion::{
    Axis, AxisConfig, Demand, Direction, FollowError, Limits, PlanError, Position, PulseSink,
    Ramps, SignedSpeed, Speed, Ticks, Velocity,
};

use crate::cyclic::{Fine, Timescale};
use crate::inputs::Count;
use crate::pulse_timing::PulseTiming;

/// The directions that limit switches bar.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Barred {
    pub(crate) reverse: bool,
    pub(crate) forward: bool,
}

impl Barred {
    const fn bars(self, direction: Direction) -> bool {
        match direction {
            Direction::Forward => self.forward,
            Direction::Reverse => self.reverse,
        }
    }
}

/// A motion that cannot be: its limits make no plan, its target is out of range, or a limit switch is in the way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Refused;

/// The end of what is followed, as seen from a later moment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CourseEnd {
    /// How long it is from there to that moment; 0 if the moment is not later.
    pub(crate) left: Fine,
    /// Where the axis is there.
    pub(crate) position: Position,
    /// How far it would go on from there until that moment, in steps × 2³².
    pub(crate) way: i64,
}

/// An axis, and what has become of its pulses. It counts as the master does, from the home position once that is known; the board
/// counts on from where the motor stood at power-on. Positions are increments, and do not wrap.
#[derive(Debug)]
pub(crate) struct Motor {
    axis: Axis,
    built: AxisConfig,
    /// What the driver of the motor needs.
    timing: PulseTiming,
    /// Where the pulses handed out so far lead. The axis counts modulo 2³²; this goes on.
    committed: i64,
    /// Nothing is planned, and every pulse has been handed out.
    at_rest: bool,
    /// At rest, and every pulse had left at the start of this tick.
    standstill: bool,
    /// What was being played at the start of this tick.
    demand: Demand,
    /// The tick of the axis' time at the start of this tick.
    played: Ticks,
    /// Pulses have been cut off: the axis does not know where the motor is until it is told.
    cut: bool,
    /// What the master's count has beyond the board's.
    shift: i64,
    /// 2072h: the board counts the other way, and its pulses go the other way.
    is_reversed: bool,
    /// The home position is known.
    referenced: bool,
    barred: Barred,
    /// The axis' time in comparison with that of the control tick.
    timescale: Timescale,
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
    /// Pulses came too late, and nobody has asked for it yet.
    is_late: bool,
}

impl Motor {
    /// A motor that stands at position 0.
    pub(crate) fn new(config: AxisConfig) -> Self {
        Self {
            axis: Axis::new(config),
            built: config,
            timing: PulseTiming::AsBuilt,
            committed: 0,
            at_rest: true,
            standstill: true,
            demand: Demand::default(),
            played: 0,
            cut: false,
            shift: 0,
            is_reversed: false,
            referenced: false,
            barred: Barred::default(),
            timescale: Timescale::new(config.clock.hz()),
            ramps: Ramps::Linear,
            stopping: None,
            stops_hard: false,
            stopping_at_limit: None,
            stops_early: false,
            deceleration: 0,
            hardest: 0,
            is_late: false,
        }
    }

    /// What the driver of the motor needs. The motor has no power and stands.
    pub(crate) fn set_timing(&mut self, timing: PulseTiming) {
        if timing != self.timing {
            self.timing = timing;
            let ticks = timing.in_ticks(self.built.clock, self.built.timing);
            self.axis.set_timing(ticks);
        }
    }

    /// The master's count for one of the board's, which may wrap.
    pub(crate) const fn position_of(&self, count: i64) -> i64 {
        let count = if self.is_reversed {
            count.wrapping_neg()
        } else {
            count
        };
        self.near(count.wrapping_add(self.shift))
    }

    /// The position that is the same modulo 2³² and next to where the motor is.
    const fn near(&self, position: i64) -> i64 {
        let away = (position as i32).wrapping_sub(self.committed as i32);
        self.committed.wrapping_add(away as i64)
    }

    /// How the master counts while the motor is at `position`.
    pub(crate) const fn count(&self, position: i64) -> Count {
        Count {
            position,
            shift: self.shift as i32,
            is_reversed: self.is_reversed,
        }
    }

    /// Turns the direction round while there is no power; the board's count is `count`. The motor keeps its position, but where home is
    /// nobody knows any more.
    pub(crate) const fn set_reversed(&mut self, is_reversed: bool, count: i64) {
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
        let away = i64::from(home.wrapping_sub(position as i32));
        let change = name.wrapping_sub(position.wrapping_add(away));
        self.shift = self.shift.wrapping_add(change);
        self.referenced = true;
        self.stand_at(position.wrapping_add(change));
        self.demand = self.demand_of(0);
        change
    }

    /// The axis is told where the motor stands.
    fn stand_at(&mut self, position: i64) {
        self.axis.set_position(position);
        self.committed = position;
    }

    fn demand_of(&self, pending: Ticks) -> Demand {
        let demand = self.axis.demand(pending);
        Demand {
            position: self.near(demand.position),
            ..demand
        }
    }

    /// The motor is not where its pulses should have taken it.
    pub(crate) const fn lose_reference(&mut self) {
        self.referenced = false;
    }

    /// Takes the directions that are barred from now on. Returns whether the motor is running into a limit switch, and has not
    /// been told to stop there yet.
    pub(crate) fn meets_limit(&mut self, barred: Barred) -> bool {
        self.barred = barred;
        if barred == Barred::default() {
            self.stopping_at_limit = None;
            return false;
        }
        let into = self
            .axis
            .heading()
            .is_some_and(|direction| barred.bars(direction));
        if !into {
            self.stopping_at_limit = None;
        }
        into && self.stopping_at_limit.is_none()
    }

    /// Says how the velocity is to change, from the next motion on.
    pub(crate) const fn set_ramps(&mut self, ramps: Ramps) {
        self.ramps = ramps;
    }

    /// Says with which acceleration, in steps/s², the next motion is to be planned, for the stops that are tried out before it.
    pub(crate) const fn expect_acceleration(&mut self, acceleration: u32) {
        self.axis.expect_acceleration(acceleration);
    }

    /// Slows down because of a limit switch. Nothing gentler takes its place: no other stop, and no motion away from the switch.
    pub(crate) fn stop_at_limit(&mut self, deceleration: u32) {
        self.stop_no_gentler(deceleration, false);
        self.stopping_at_limit = self.stopping;
    }

    /// Slows down to a standstill, on the ramp of the stop that is under way if that is harder. No ramp is the hardest.
    pub(crate) fn stop_no_gentler(&mut self, deceleration: u32, is_smooth: bool) {
        let least = self.stopping.filter(|_| deceleration > 0).unwrap_or(0);
        let is_smooth = is_smooth && !(self.stopping.is_some() && self.stops_hard);
        self.stop_on(deceleration.max(least), is_smooth);
    }

    /// Whether the stop under way ends within these software limits on the ramp that it was asked for. If not, it goes on with this
    /// deceleration, unless its own is as hard.
    pub(crate) fn stops_within(&mut self, (low, high): (i64, i64), deceleration: u32) -> bool {
        let end = self.destination();
        let is_beyond = end > high.max(self.committed) || end < low.min(self.committed);
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

    /// While a limit switch stops the motor, a motion away from it begins with no gentler ramp.
    fn at_limit(&self, limits: Limits) -> Limits {
        let least = self.stopping_at_limit.unwrap_or(0);
        Limits {
            deceleration: limits.deceleration.max(least),
            ..limits
        }
    }

    /// The axis is to move with the ramps chosen; away from a limit switch without delay.
    const fn choose_ramps(&mut self) {
        let ramps = if self.stopping_at_limit.is_some() {
            Ramps::Linear
        } else {
            self.ramps
        };
        self.axis.set_ramps(ramps);
    }

    /// No stop is under way any more.
    const fn stopped(&mut self) {
        self.stopping = None;
        self.stops_early = false;
    }

    /// A motion takes the place of a stop, unless it is refused.
    fn begun(&mut self, result: Result<(), PlanError>, deceleration: u32) -> Result<(), Refused> {
        result.map_err(|_| Refused)?;
        self.stopped();
        self.planned_with(deceleration);
        Ok(())
    }

    /// The motion under way has this deceleration; 0 for none.
    const fn planned_with(&mut self, deceleration: u32) {
        self.deceleration = deceleration;
        // What is needed to end where it ends is rounded up.
        self.hardest = deceleration.saturating_add(deceleration / 16);
    }

    /// Looks at the motor at the start of a tick. `position` is where it really is; the axis takes it over while the motor
    /// has no power, and after its pulses have been cut off.
    pub(crate) fn observe<S: PulseSink>(&mut self, position: i64, power: bool, pulses: &S) {
        if self.cut || !power && self.is_displaced(position, 0) {
            self.stand_at(position);
            self.cut = false;
        }
        let pending = pulses.pending();
        self.standstill = self.at_rest && pending == 0;
        self.demand = self.demand_of(pending);
        self.played = self.axis.played(pending);
    }

    /// The tick that has just looked at the motor runs at `now`: what is followed goes by that.
    pub(crate) fn set_time(&mut self, now: Fine) {
        if self.at_rest {
            self.timescale.stop();
        }
        self.timescale.compare(now, self.played);
    }

    /// Whether the pulses handed out so far lead further than `slack` from this position.
    pub(crate) const fn is_displaced(&self, position: i64, slack: u32) -> bool {
        self.committed.abs_diff(position) > slack as u64
    }

    /// Whether the motor stood still at the start of this tick: nothing planned, and every pulse has left.
    pub(crate) const fn standstill(&self) -> bool {
        self.standstill
    }

    /// Whether the motor has nothing left to do at the end of this tick.
    pub(crate) fn is_settled<S: PulseSink>(&self, pulses: &S) -> bool {
        self.at_rest && pulses.pending() == 0
    }

    /// What was being played at the start of this tick.
    pub(crate) const fn demand(&self) -> Demand {
        self.demand
    }

    /// Where the present motion ends, in steps; at rest, where the motor stands.
    pub(crate) fn destination(&self) -> i64 {
        self.near(self.axis.target())
    }

    /// The position in the count of the axis. One that is too far away stays so.
    fn on_axis(&self, target: i64) -> i64 {
        let way = target.saturating_sub(self.committed);
        self.axis.committed_position().saturating_add(way)
    }

    /// The fastest the pulses can be sent.
    pub(crate) fn max_velocity(&self) -> Speed {
        self.axis.max_velocity()
    }

    /// The longest way of one motion, in steps.
    pub(crate) const REACH: i64 = u32::MAX as i64;

    /// Moves to a position, from whatever the motor does now. On an error nothing changes.
    pub(crate) fn move_to(&mut self, target: i64, limits: Limits) -> Result<(), Refused> {
        self.is_free(target.saturating_sub(self.committed))?;
        let limits = self.at_limit(limits);
        let target = self.on_axis(target);
        self.choose_ramps();
        let result = self.axis.move_to(target, limits);
        self.begun(result, limits.deceleration)
    }

    /// Moves through a position with an end velocity and keeps that. On an error nothing changes.
    pub(crate) fn move_through(
        &mut self,
        target: i64,
        end_velocity: Speed,
        limits: Limits,
    ) -> Result<(), Refused> {
        self.is_free(target.saturating_sub(self.committed))?;
        let limits = self.at_limit(limits);
        let target = self.on_axis(target);
        self.choose_ramps();
        let result = self.axis.move_through(target, end_velocity, limits);
        self.begun(result, limits.deceleration)
    }

    /// Goes to a position, from the one followed before, and is there at `end`: in a straight line, or with a velocity there, as a
    /// way and how long it takes. See [`Axis::follow`].
    pub(crate) fn follow(
        &mut self,
        end: Fine,
        to: Position,
        velocity: Option<(Position, Fine)>,
    ) -> Result<(), FollowError> {
        let tick = self.timescale.tick_at(end);
        let result = match velocity {
            None => self.axis.follow(tick, to),
            Some((way, time)) => {
                let ticks = self.timescale.ticks(time);
                let velocity = Velocity::over(way, ticks);
                self.axis.follow_smoothly(tick, to, velocity)
            }
        };
        if result.is_ok() {
            self.followed();
        }
        result
    }

    /// Reaches a velocity at `end`, evenly from the one at the end of what is followed. See [`Axis::follow_velocity`].
    pub(crate) fn follow_velocity(
        &mut self,
        end: Fine,
        velocity: SignedSpeed,
    ) -> Result<(), FollowError> {
        let tick = self.timescale.tick_at(end);
        self.axis.follow_velocity(tick, velocity)?;
        self.followed();
        Ok(())
    }

    /// Set-points take the place of a planned motion, and of its ramps.
    const fn followed(&mut self) {
        self.stopped();
        self.planned_with(0);
    }

    /// Where what is followed ends, in steps, and its velocity there.
    pub(crate) fn course_end(&self) -> Demand {
        let end = self.axis.course_end_demand();
        Demand {
            position: self.near(end.position),
            ..end
        }
    }

    /// From where, and in which time, something is followed that is to be done at `end`: from the last set-point given, or from where
    /// the pulses handed out lead if they go beyond that.
    pub(crate) fn course_to(&self, end: Fine) -> CourseEnd {
        let (tick, state) = self.axis.course_end();
        let left = self.timescale.tick_at(end).wrapping_sub(tick);
        let left = u32::try_from(left.cast_signed().max(0)).unwrap_or(u32::MAX);
        CourseEnd {
            left: self.timescale.span(left),
            position: state.position,
            way: state.velocity.way(left),
        }
    }

    /// Whether what is followed ends in motion, so soon that the motor would stand with no ramp within this time.
    pub(crate) fn is_running_out(&self, time: Fine) -> bool {
        let ticks = self.timescale.ticks(time);
        self.axis.is_running_out(ticks.into())
    }

    /// Whether the motor moves, and follows set-points that come in each period.
    pub(crate) const fn is_following(&self) -> bool {
        !self.at_rest && self.axis.is_following()
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

    /// Whether nothing is planned, and every pulse has been handed out.
    pub(crate) const fn is_at_rest(&self) -> bool {
        self.at_rest
    }

    /// The position from which the next command begins, in steps.
    pub(crate) const fn committed_position(&self) -> i64 {
        self.committed
    }

    /// Ramps to a velocity and keeps it, from whatever the motor does now. On an error nothing changes.
    pub(crate) fn ramp_to(&mut self, velocity: SignedSpeed, limits: Limits) -> Result<(), Refused> {
        self.is_free(velocity.bits())?;
        let limits = self.at_limit(limits);
        self.choose_ramps();
        let result = self.axis.ramp_to(velocity, limits);
        self.begun(result, limits.deceleration)
    }

    /// Whether no limit switch bars a motion of this sign.
    pub(crate) fn is_free(&self, way: i64) -> Result<(), Refused> {
        if way > 0 && self.barred.forward || way < 0 && self.barred.reverse {
            Err(Refused)
        } else {
            Ok(())
        }
    }

    /// The velocity from which the next command begins.
    pub(crate) fn committed_velocity(&self) -> SignedSpeed {
        self.axis.committed_velocity()
    }

    /// The window of the mean that the motor follows (6086h = 2), in microseconds, rounded up; 0 if it follows none.
    pub(crate) fn window(&self) -> u64 {
        let ticks = u64::from(self.axis.window()).wrapping_mul(1_000_000);
        let microseconds = ticks.checked_div(self.built.clock.hz().into());
        microseconds.map_or(0, |whole| whole.saturating_add(1))
    }

    /// Whether the motor is on the last ramp of its motion, or has come to rest.
    pub(crate) fn is_ending(&self) -> bool {
        self.axis.is_ending()
    }

    /// Slows down to a standstill. A deceleration that gives no ramp, such as 0, stops the pulses at once: a drive that is
    /// told to stop never goes on.
    pub(crate) fn stop(&mut self, deceleration: u32) {
        self.stop_on(deceleration, true);
    }

    /// Slows down with the ramps chosen, or with a linear one.
    pub(crate) fn stop_on(&mut self, deceleration: u32, is_smooth: bool) {
        let is_smooth = is_smooth && self.stopping_at_limit.is_none();
        self.axis
            .set_ramps(if is_smooth { self.ramps } else { Ramps::Linear });
        self.stops_hard = !is_smooth;
        let deceleration = deceleration.max(self.stopping_at_limit.unwrap_or(0));
        if self.axis.stop(deceleration).is_ok() {
            self.stopping = Some(deceleration);
            self.planned_with(deceleration);
        } else {
            self.cut_off();
        }
    }

    /// Drops every pulse that has not left yet. The board does so at the end of the tick.
    pub(crate) fn cut_off(&mut self) {
        // Without current a motor runs on, nobody knows where to.
        self.referenced &= self.standstill;
        self.stopped();
        self.stopping_at_limit = None;
        self.axis.abort();
        self.at_rest = true;
        self.cut = true;
    }

    /// Whether pulses were cut off in this tick.
    pub(crate) const fn is_cut(&self) -> bool {
        self.cut
    }
}

#[cfg(test)]
mod tests;
