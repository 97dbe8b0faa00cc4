//! The servo axis: demands become positions that a loop follows, or a torque.
//!
//! A step axis plans where the motor is to be. Its records go to the port, which plays them for their time and makes no pulses. From the
//! time that is left to play, the axis knows position, velocity and acceleration of this moment, finer than a step, and gives them to the
//! port at each tick and refill. While a torque is held, the axis takes over the position of the rotor; the next motion begins there,
//! with the velocity of the rotor.
//!
//! Loops that identify the motor may move it by themselves where the axis stands and no torque is held. Until they are done, the axis
//! takes over the position of the rotor; any demand ends the measurement.
//!
//! Positions at the port are those of the board's encoder. Torques are in µN·m there: thousandths of 6076h, which is in mN·m.

use motion::low;
use motion::{
    Demand, Direction, FollowError, Limits, Position, PulseSink, Ramps, SignedSpeed, Speed,
};

use super::{
    Actuator, ActuatorErrors, AtPort, Emitter, EmitterLock, NotSupported, PathEnd, RatedMotor,
    Refused, StepAxis, Torque, TorqueLimits, unwrapped,
};
use crate::board::DriveConfig;
use crate::configuration::Configuration;
use crate::cyclic::MicrosQ16;

/// What the loops are to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ServoGoal {
    /// To be somewhere, and to go on from there.
    Position {
        /// Whole counts of the board's encoder.
        counts: i64,
        /// Parts of a count beyond, in 2⁻³².
        part: u32,
        /// In counts/s.
        velocity: SignedSpeed,
        /// In counts/s².
        acceleration: i32,
    },
    /// To hold the torque of the order.
    Torque,
    /// To move the motor by themselves: they identify it.
    Free,
}

/// An order, in the direction of the board's encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ServoOrder {
    /// What is to be done.
    pub goal: ServoGoal,
    /// The torque that is held, or that is given ahead of the loops, in µN·m.
    pub torque: i32,
    /// What is given ahead of the loops beside the velocity of the goal.
    pub velocity_ahead: SignedSpeed,
    /// The greatest positive and negative torque, in µN·m.
    pub max_torque: (u32, u32),
    /// The greatest current, in mA.
    pub current: u32,
    /// The fastest while a torque is held.
    pub velocity: Speed,
}

/// What has become of the orders, in the direction of the board's encoder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ServoReport {
    /// Counts of the board's encoder, as `Inputs` has them.
    pub counts: i64,
    /// In counts/s.
    pub velocity: SignedSpeed,
    /// What is wanted of the motor, in µN·m.
    pub demand: i32,
    /// What it gives, in µN·m.
    pub torque: i32,
    /// In mA, with the sign of the torque.
    pub current: i32,
    /// A limit of the torque or the current is in the way.
    pub is_limited: bool,
    /// The loops ask to move the motor by themselves, or do so.
    pub wants_free: bool,
}

impl ServoReport {
    /// Nothing was seen yet.
    pub const NONE: Self = Self {
        counts: 0,
        velocity: SignedSpeed::ZERO,
        demand: 0,
        torque: 0,
        current: 0,
        is_limited: false,
        wants_free: false,
    };
}

/// The port of a servo axis. Records are played for their time alone.
pub trait ServoPort: PulseSink {
    /// What is at the port.
    fn motor(&self) -> RatedMotor;

    /// What is to be done from now on.
    fn order(&mut self, order: &ServoOrder);

    /// What was seen last.
    fn report(&self) -> ServoReport;

    /// Drops the records that have not been played yet.
    fn forget(&mut self);
}

/// See the module.
#[derive(Debug)]
pub struct ServoAxis<L = Emitter> {
    /// The torque that is held, in place of a path.
    held: Option<i16>,
    /// The loops move the motor by themselves.
    is_free: bool,
    /// A path was left before it was played.
    has_left: bool,
    is_reversed: bool,
    shift: i64,
    /// The rotor, in the count of the positions here.
    rotor: Demand,
    torque: Torque,
    limits: TorqueLimits,
    ahead: i16,
    velocity_ahead: SignedSpeed,
    /// That of the board, and what is set up instead: 6075h, 6076h and 20C2h:5 where they are not 0.
    own: RatedMotor,
    motor: RatedMotor,
    /// Last, as it is large: so it is made where it stays.
    path: StepAxis<L>,
}

impl<L: EmitterLock> ServoAxis<L> {
    /// With an emitter that stands at position 0.
    #[inline(never)]
    pub fn new(config: DriveConfig, emitter: impl FnOnce() -> L) -> Self {
        Self {
            held: None,
            is_free: false,
            has_left: false,
            is_reversed: false,
            shift: 0,
            rotor: Demand::default(),
            torque: Torque::NONE,
            limits: TorqueLimits::NONE,
            ahead: 0,
            velocity_ahead: SignedSpeed::ZERO,
            own: RatedMotor::NONE,
            motor: RatedMotor::NONE,
            path: StepAxis::new(config, emitter),
        }
    }

    /// The path begins at the rotor, if a torque was held.
    fn take_up(&mut self) {
        self.is_free = false;
        if self.held.take().is_some() {
            self.path.take_up(self.rotor.position, self.rotor.velocity);
        }
    }

    /// Lets the loops move the motor by themselves, or ends that where it stands.
    fn let_go(&mut self, wants_free: bool) {
        if wants_free && self.held.is_none() && self.path.standstill() && self.path.is_at_rest() {
            self.path.cut_off();
            self.has_left = true;
            self.held = Some(0);
            self.is_free = true;
        } else if self.is_free && !wants_free {
            self.is_free = false;
            self.held = None;
            self.path.stand_at(self.rotor.position);
        }
    }

    const fn turned(&self, velocity: SignedSpeed) -> SignedSpeed {
        if self.is_reversed {
            velocity.reversed()
        } else {
            velocity
        }
    }

    fn order(&self, port: &mut impl ServoPort) {
        let goal = if self.is_free {
            ServoGoal::Free
        } else if self.held.is_some() {
            ServoGoal::Torque
        } else {
            let reference = self.path.reference(port.pending());
            let (position, acceleration) = if self.is_reversed {
                let position = reference.position.bits().wrapping_neg();
                (position, reference.acceleration.saturating_neg())
            } else {
                (reference.position.bits(), reference.acceleration)
            };
            let shift = if self.is_reversed {
                self.shift
            } else {
                self.shift.wrapping_neg()
            };
            // A step is where its middle is.
            let position = position.wrapping_add(1 << 31);
            let counts = (position >> 32).wrapping_add(shift);
            ServoGoal::Position {
                counts: unwrapped(counts, port.report().counts),
                part: low::u32(position.cast_unsigned()),
                velocity: self.turned(reference.velocity),
                acceleration,
            }
        };
        let torque = i32::from(self.held.unwrap_or(self.ahead));
        let rated = self.rated();
        let torque = torque.saturating_mul(i32::try_from(rated.torque).unwrap_or(i32::MAX));
        let max = |limit: u16, rated: u32| match limit {
            u16::MAX => u32::MAX,
            _ => u32::from(limit).saturating_mul(rated),
        };
        let positive = max(self.limits.positive, rated.torque);
        let negative = max(self.limits.negative, rated.torque);
        port.order(&ServoOrder {
            goal,
            torque: self.signed(torque),
            velocity_ahead: self.turned(self.velocity_ahead),
            max_torque: if self.is_reversed {
                (negative, positive)
            } else {
                (positive, negative)
            },
            current: match max(self.limits.current, rated.current) {
                u32::MAX => u32::MAX,
                limit => limit / 1_000,
            },
            velocity: self.limits.velocity,
        });
    }

    const fn signed(&self, value: i32) -> i32 {
        if self.is_reversed {
            value.saturating_neg()
        } else {
            value
        }
    }

    /// What thousandths are of.
    const fn rated(&self) -> RatedMotor {
        self.motor.or(self.own)
    }

    /// In thousandths of what is rated.
    fn share(&self, value: i32, rated: u32) -> i16 {
        let value = i64::from(self.signed(value));
        let half = i64::from(rated / 2);
        let rounded = if value < 0 {
            value - half
        } else {
            value + half
        };
        let share = rounded.checked_div(rated.into()).unwrap_or(0);
        low::i16(share.clamp(i16::MIN.into(), i16::MAX.into()))
    }
}

impl<L: EmitterLock> ServoAxis<L> {
    /// The deceleration, in counts/s², of what the limits leave of the torque against the motion.
    fn braking(&self) -> u32 {
        let (rated, own) = (self.rated(), self.own);
        let limit = if self.committed_velocity().bits() < 0 {
            self.limits.positive
        } else {
            self.limits.negative
        };
        // In µN·m; of the current in µA.
        let by_torque = u64::from(limit).saturating_mul(rated.torque.into());
        let by_current = u64::from(self.limits.current)
            .saturating_mul(rated.current.into())
            .saturating_mul(own.torque.into())
            .checked_div(own.current.into());
        let most = by_torque.min(by_current.unwrap_or(u64::MAX));
        // µN·m / g·mm² are 1000 rad/s², and 1000 / 2π is 159.155.
        let braking = most
            .saturating_mul(own.counts.into())
            .saturating_mul(159)
            .checked_div(rated.inertia.into());
        braking.map_or(u32::MAX, |braking| {
            u32::try_from(braking).unwrap_or(u32::MAX)
        })
    }
}

impl TorqueLimits {
    /// The motor's own.
    pub const NONE: Self = Self {
        positive: u16::MAX,
        negative: u16::MAX,
        current: u16::MAX,
        velocity: Speed::MAX,
    };
}

impl<L: EmitterLock, P: ServoPort> AtPort<P> for ServoAxis<L> {
    fn set_up(&mut self, configuration: &Configuration) {
        let torque = &configuration.torque;
        self.motor = RatedMotor {
            current: torque.rated_current,
            torque: torque.rated,
            inertia: torque.inertia,
            counts: 0,
        };
    }

    fn set_shift(&mut self, shift: i64) {
        self.shift = shift;
    }

    fn observe(&mut self, now: MicrosQ16, port: &P) {
        self.path.observe(now, port);
        let report = port.report();
        let counts = if self.is_reversed {
            report.counts.wrapping_neg()
        } else {
            report.counts
        };
        let before = self.committed_position();
        self.rotor = Demand {
            position: unwrapped(counts.wrapping_add(self.shift), before),
            velocity: self.turned(report.velocity),
        };
        self.own = port.motor();
        let rated = self.rated();
        self.torque = Torque {
            demand: self.share(report.demand, rated.torque),
            actual: self.share(report.torque, rated.torque),
            // mA become µA, as thousandths of mA are.
            current: self.share(report.current.saturating_mul(1_000), rated.current),
            is_limited: report.is_limited,
        };
        self.let_go(report.wants_free);
    }

    fn look_again(&mut self, port: &P) {
        self.path.look_again(port);
    }

    fn advance(&mut self, port: &mut P, is_reversed: bool) {
        self.is_reversed = is_reversed;
        if core::mem::take(&mut self.has_left) {
            port.forget();
        }
        if self.held.is_none() {
            self.path.advance(port, false);
        }
        self.order(port);
    }

    fn refill(&mut self, port: &mut P) {
        if self.held.is_none() {
            self.path.refill(port);
        }
        self.order(port);
    }
}

#[rustfmt::skip] // A table: most of it hands a demand on to the path.
impl<L: EmitterLock> Actuator for ServoAxis<L> {
    const MODES: u32 = u32::MAX;

    fn demand(&self) -> Demand { if self.held.is_some() { self.rotor } else { self.path.demand() } }
    fn torque(&self) -> Option<Torque> { Some(self.torque) }
    fn set_torque(&mut self, limits: TorqueLimits, ahead: i16) { (self.limits, self.ahead) = (limits, ahead); }
    fn set_velocity_ahead(&mut self, velocity: SignedSpeed) { self.velocity_ahead = velocity; }
    fn take_errors(&mut self) -> ActuatorErrors { self.path.take_errors() }
    fn standstill(&self) -> bool { self.held.is_none() && self.path.standstill() }
    fn is_at_rest(&self) -> bool { self.held.is_none() && self.path.is_at_rest() }
    fn committed_position(&self) -> i64 { if self.held.is_some() { self.rotor.position } else { self.path.committed_position() } }
    fn committed_velocity(&self) -> SignedSpeed { if self.held.is_some() { self.rotor.velocity } else { self.path.committed_velocity() } }
    fn destination(&self) -> i64 { if self.held.is_some() { self.rotor.position } else { self.path.destination() } }
    fn is_ending(&self) -> bool { self.held.is_none() && self.path.is_ending() }
    fn max_velocity(&self) -> Speed { self.path.max_velocity() }
    fn max_deceleration(&self) -> u32 { self.braking() }
    fn window(&self) -> u64 { if self.held.is_some() { 0 } else { self.path.window() } }
    fn is_following(&self) -> bool { self.held.is_none() && self.path.is_following() }
    fn is_running_out(&self, time: MicrosQ16) -> bool { self.held.is_none() && self.path.is_running_out(time) }
    fn expect_acceleration(&mut self, acceleration: u32) { self.path.expect_acceleration(acceleration); }

    fn heading(&self) -> Option<Direction> {
        match (self.held, self.rotor.velocity.bits()) {
            (None, _) => self.path.heading(),
            (Some(0), 0) => None,
            // What stands goes where it is pushed to.
            (Some(torque), 0) => Some(if torque < 0 { Direction::Reverse } else { Direction::Forward }),
            (Some(_), velocity) => Some(if velocity < 0 { Direction::Reverse } else { Direction::Forward }),
        }
    }

    fn move_to(&mut self, target: i64, limits: Limits, ramps: Ramps) -> Result<(), Refused> {
        self.take_up();
        self.path.move_to(target, limits, ramps)
    }

    fn move_through(&mut self, target: i64, end: Speed, limits: Limits, ramps: Ramps) -> Result<(), Refused> {
        self.take_up();
        self.path.move_through(target, end, limits, ramps)
    }

    fn ramp_to(&mut self, velocity: SignedSpeed, limits: Limits, ramps: Ramps) -> Result<(), Refused> {
        self.take_up();
        self.path.ramp_to(velocity, limits, ramps)
    }

    fn hold_torque(&mut self, torque: i16) -> Result<(), NotSupported> {
        if self.held.is_none() {
            self.path.cut_off();
            self.has_left = true;
        }
        self.is_free = false;
        self.held = Some(torque);
        Ok(())
    }

    fn stop(&mut self, deceleration: u32, ramps: Ramps) -> Result<(), Refused> {
        self.take_up();
        self.path.stop(deceleration, ramps)
    }

    fn stop_preview(&self, deceleration: u32, ramps: Ramps, leaves: Option<&Limits>) -> i64 {
        if self.held.is_none() {
            return self.path.stop_preview(deceleration, ramps, leaves);
        }
        // v² / 2a, in increments; Q16 of the velocity is fine enough.
        let velocity = i128::from(self.rotor.velocity.bits() >> 16);
        let twice = i128::from(deceleration).wrapping_shl(33);
        let distance = velocity.wrapping_mul(velocity.saturating_abs()).checked_div(twice);
        let distance = i64::try_from(distance.unwrap_or(0)).unwrap_or(0);
        self.rotor.position.saturating_add(distance)
    }

    fn cut_off(&mut self) {
        self.is_free = false;
        self.held = None;
        self.path.cut_off();
    }

    fn stand_at(&mut self, position: i64) {
        self.is_free = false;
        self.held = None;
        self.path.stand_at(position);
    }

    fn follow(&mut self, end: MicrosQ16, to: Position) -> Result<(), FollowError> {
        self.take_up();
        self.path.follow(end, to)
    }

    fn follow_smoothly(&mut self, end: MicrosQ16, to: Position, velocity: (Position, MicrosQ16)) -> Result<(), FollowError> {
        self.take_up();
        self.path.follow_smoothly(end, to, velocity)
    }

    fn follow_velocity(&mut self, end: MicrosQ16, velocity: SignedSpeed) -> Result<(), FollowError> {
        self.take_up();
        self.path.follow_velocity(end, velocity)
    }

    fn path_end(&self) -> Demand { if self.held.is_some() { self.rotor } else { self.path.path_end() } }

    fn path_to(&self, end: MicrosQ16) -> PathEnd { self.path.path_to(end) }
}
