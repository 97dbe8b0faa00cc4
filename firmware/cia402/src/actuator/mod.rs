//! What moves the motor: the one thing that modes know of it.
//!
//! An actuator takes demands: a position with velocity and acceleration ahead, a velocity, or a torque. It tells position, velocity and
//! torque, whether the motor stands, and what is wrong. It stops on a ramp. It knows no mode, no limit and no unit: limits, limit switches, the
//! home position and the direction of counting are above it. There are a step axis, which refuses a torque, and a servo axis.
//!
//! [`Actuator`] is what the modes know. What the demands go through to the motor, pulses or a current loop, is the port of the actuator
//! ([`AtPort`]): the drive hands it on and never looks at it.
//!
//! Positions are increments of 64 bits, counted on from where the actuator was told that the motor stands. Each demand takes the place of
//! the one before, from whatever the motor does now. What has been committed already is done as it was: a demand begins at
//! [`Actuator::committed_position`], with [`Actuator::committed_velocity`].

mod rated_motor;
mod servo_axis;
mod step_axis;

use motion::{Demand, Direction, FollowError, Limits, Position, Ramps, SignedSpeed, Speed, low};

use crate::configuration::Configuration;
use crate::cyclic::MicrosQ16;

pub use rated_motor::RatedMotor;
pub use servo_axis::{ServoAxis, ServoGoal, ServoOrder, ServoPort, ServoReport};
pub use step_axis::{Emitter, EmitterLock, StepAxis};

pub use cia402_parameters::TORQUE_MODES;

/// A motion that is not possible: a limit is 0, the target is out of range, or a limit switch blocks it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refused;

/// A demand that the actuator does not take, whatever its numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotSupported;

/// The torque of a motor, in thousandths of the rated one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Torque {
    /// 6074h: what the loops or the master want, within all limits.
    pub demand: i16,
    /// 6077h.
    pub actual: i16,
    /// 6078h, in thousandths of the rated current.
    pub current: i16,
    /// More was wanted than a limit of the torque allows.
    pub is_limited: bool,
}

impl Torque {
    /// None at all.
    pub const NONE: Self = Self {
        demand: 0,
        actual: 0,
        current: 0,
        is_limited: false,
    };
}

/// What may be asked of a motor, in thousandths of the rated torque or current.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TorqueLimits {
    /// Of a positive torque.
    pub positive: u16,
    /// Of a negative one.
    pub negative: u16,
    /// Of the current, either way.
    pub current: u16,
    /// The fastest while a torque is held.
    pub velocity: Speed,
}

/// What is wrong with an actuator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ActuatorErrors {
    /// The motor was without a demand for a moment, and may not have followed (20A2h).
    pub is_late: bool,
    /// The actuator has failed, and where the motor goes is not known.
    pub is_broken: bool,
}

/// The end of what is followed, as seen from a later moment.
#[derive(Clone, Copy, Debug)]
pub struct PathEnd {
    /// How long it is from there to that moment; 0 if the moment is not later.
    pub left: MicrosQ16,
    /// Where the axis is there.
    pub position: Position,
    /// How far it would go on from there until that moment, in steps × 2³².
    pub distance: i64,
}

/// What moves the motor: takes demands, and tells position, velocity, torque, standstill and errors; see the module.
pub trait Actuator: 'static {
    /// The modes that it can do, bits as in 6502h. What else a data sheet offers is not there.
    const MODES: u32;

    /// The position and the velocity that were being done at the start of this tick.
    fn demand(&self) -> Demand;

    /// The torque of the motor; `None` if the actuator has none to tell of.
    fn torque(&self) -> Option<Torque> {
        None
    }

    /// The limits of torque and current from now on, and the torque feed-forward, in thousandths of the rated torque.
    fn set_torque(&mut self, limits: TorqueLimits, ahead: i16) {
        let _ = (limits, ahead);
    }

    /// The velocity feed-forward from now on, added to the velocity of the path.
    fn set_velocity_ahead(&mut self, velocity: SignedSpeed) {
        let _ = velocity;
    }

    /// What has been wrong since the last call.
    fn take_errors(&mut self) -> ActuatorErrors;

    /// Whether the motor stands: nothing is planned, and all of it is done. As of the start of this tick; at its end, as of then.
    fn standstill(&self) -> bool;

    /// Whether the demand is at rest: nothing is planned, and all of it is committed.
    fn is_at_rest(&self) -> bool;

    /// The position from which the next demand begins.
    fn committed_position(&self) -> i64;

    /// The velocity from which the next demand begins.
    fn committed_velocity(&self) -> SignedSpeed;

    /// Where the present motion ends; at rest, where the motor stands.
    fn destination(&self) -> i64;

    /// The direction of the present motion; `None` at rest.
    fn heading(&self) -> Option<Direction>;

    /// Whether the motor is on the last ramp of its motion, or has come to rest.
    fn is_ending(&self) -> bool;

    /// The fastest that the motor can go.
    fn max_velocity(&self) -> Speed;

    /// The hardest ramp, in steps/s², on which the motor can slow down from its present velocity within the limits of its torque, as far as
    /// that is known: what drives it aside.
    fn max_deceleration(&self) -> u32 {
        u32::MAX
    }

    /// The window of the mean that the motor follows (6086h = 2), in microseconds, rounded up; 0 if it follows none.
    fn window(&self) -> u64;

    /// Moves to a position. On an error nothing changes.
    fn move_to(&mut self, target: i64, limits: Limits, ramps: Ramps) -> Result<(), Refused>;

    /// Moves to a position, and begins and ends with a speed which the motor takes and loses at once. On an error nothing changes. An actuator
    /// that cannot do so moves as [`Actuator::move_to`] does.
    fn move_from_start_speed(
        &mut self,
        target: i64,
        start_speed: Speed,
        limits: Limits,
        ramps: Ramps,
    ) -> Result<(), Refused> {
        let _ = start_speed;
        self.move_to(target, limits, ramps)
    }

    /// Moves through a position with an end velocity and keeps that. On an error nothing changes.
    fn move_through(
        &mut self,
        target: i64,
        end_velocity: Speed,
        limits: Limits,
        ramps: Ramps,
    ) -> Result<(), Refused>;

    /// Ramps to a velocity and keeps it. On an error nothing changes.
    fn ramp_to(
        &mut self,
        velocity: SignedSpeed,
        limits: Limits,
        ramps: Ramps,
    ) -> Result<(), Refused>;

    /// Holds a torque, in thousandths of the rated one. The motor goes where that and its load take it.
    fn hold_torque(&mut self, torque: i16) -> Result<(), NotSupported>;

    /// Slows down to a standstill. On an error, a deceleration that gives no ramp, nothing changes.
    fn stop(&mut self, deceleration: u32, ramps: Ramps) -> Result<(), Refused>;

    /// Where [`Actuator::stop`] would end; where the motor is, if it would be an error. A sin² ramp under way is finished; with
    /// `leaves`, it is broken off as a move with these limits to another target would break it off.
    fn stop_preview(&self, deceleration: u32, ramps: Ramps, leaves: Option<&Limits>) -> i64;

    /// The power is off, or must not move the motor any further: what is not done yet is forgotten.
    fn cut_off(&mut self);

    /// The motor stands at this position.
    fn stand_at(&mut self, position: i64);

    /// Goes to a position, from the one followed before, and is there at `end`, in a straight line.
    fn follow(&mut self, end: MicrosQ16, to: Position) -> Result<(), FollowError>;

    /// The same on a cubic that ends with a velocity: a distance, and how long it takes.
    fn follow_smoothly(
        &mut self,
        end: MicrosQ16,
        to: Position,
        velocity: (Position, MicrosQ16),
    ) -> Result<(), FollowError>;

    /// Reaches a velocity at `end`, evenly from the one at the end of what is followed.
    fn follow_velocity(&mut self, end: MicrosQ16, velocity: SignedSpeed)
    -> Result<(), FollowError>;

    /// Where what is followed ends, and its velocity there.
    fn path_end(&self) -> Demand;

    /// From where, and in how much time, a set-point that is due at `end` is followed: from the last set-point given, or from what is
    /// committed if that goes beyond it.
    fn path_to(&self, end: MicrosQ16) -> PathEnd;

    /// Whether the motor moves, and follows set-points that come in each period.
    fn is_following(&self) -> bool;

    /// Whether what is followed ends in motion, so soon that the motor would stand with no ramp within this time.
    fn is_running_out(&self, time: MicrosQ16) -> bool;

    /// Says with which acceleration, in steps/s², the next motion is to be planned, for the stops that are asked about before it.
    fn expect_acceleration(&mut self, acceleration: u32);
}

/// An actuator at its port `P`: what the board gives it to move the motor with.
pub trait AtPort<P>: Actuator {
    /// Takes the configuration. The motor has no power and stands.
    fn set_up(&mut self, configuration: &Configuration);

    /// What the positions here have beyond those of the board, for an actuator that gives positions to its port.
    fn set_shift(&mut self, shift: i64) {
        let _ = shift;
    }

    /// Looks at what has become of the demands, at the start of a tick at `now`.
    fn observe(&mut self, now: MicrosQ16, port: &P);

    /// The same at the end of a tick, for whether the motor stands.
    fn look_again(&mut self, port: &P);

    /// Commits what comes next, unless a refill does so soon enough. With `is_reversed` the motor is to turn the other way (2072h).
    fn advance(&mut self, port: &mut P, is_reversed: bool);

    /// The same between two ticks, where these and the refills come one after the other. Nothing is decided here.
    fn refill(&mut self, port: &mut P);
}

/// A position that is counted modulo 2³², unwrapped: the same one, next to another.
pub(crate) const fn unwrapped(position: i64, beside: i64) -> i64 {
    let away = low::i32(position).wrapping_sub(low::i32(beside));
    beside.wrapping_add(away as i64)
}

#[cfg(test)]
mod tests;
