//! An ideal servo: its shaft is where its trajectory is, and nothing is committed ahead of it. All that an actuator is, and no pulse.

use motion::{Demand, Direction, FollowError, Limits, Position, Ramps, SignedSpeed, Speed};

use crate::actuator::{
    Actuator, ActuatorErrors, AtPort, NotSupported, PathEnd, Refused, Torque, unwrapped,
};
use crate::configuration::Configuration;
use crate::cyclic::{MicrosQ16, POINT, span};

/// What the servo has in place of pulses: the position of its encoder.
pub(super) type Shaft = i64;

/// An increment/s.
const ONE: f64 = 4_294_967_296.0;
/// A control tick in seconds.
const TICK: f64 = 0.001;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Goal {
    #[default]
    Rest,
    /// A target, and the velocity there.
    Target(i64, f64, Limits),
    /// A velocity; 0 is a stop.
    Velocity(f64, Limits),
    Path,
    Torque(i16),
}

/// Positions in increments, velocities in increments/s.
#[derive(Debug, Default)]
pub(super) struct Servo {
    goal: Goal,
    position: f64,
    velocity: f64,
    now: MicrosQ16,
    /// When and where the set-points are that are followed.
    path: std::vec::Vec<(MicrosQ16, i64)>,
}

impl Servo {
    /// Goes on for a tick, towards a velocity.
    fn ramp(&mut self, wanted: f64, limits: Limits) {
        let grows = wanted.abs() > self.velocity.abs();
        let (up, down) = (limits.acceleration, limits.deceleration);
        let change = f64::from(if grows { up } else { down }) * TICK;
        let before = self.velocity;
        self.velocity = wanted.clamp(before - change, before + change);
        self.position += (before + self.velocity) / 2.0 * TICK;
    }

    fn stand(&mut self, position: f64) {
        (self.goal, self.position, self.velocity) = (Goal::Rest, position.round(), 0.0);
        self.path.clear();
    }

    fn target(&mut self, target: i64, end: f64, limits: Limits) {
        let sign = (target as f64 - self.position).signum();
        let left = |servo: &Self| (target as f64 - servo.position) * sign;
        let down = f64::from(limits.deceleration);
        // From this velocity, at the end of the tick, it still stops at the target.
        let reach = 2.0 * left(self) - self.velocity * sign * TICK;
        let square = (down * TICK).powi(2) / 4.0 + down * reach + end * end;
        let max = square.max(0.0).sqrt() - down * TICK / 2.0;
        let max = max.max(end).clamp(0.0, value(limits.velocity));
        self.ramp(sign * max, limits);
        if end > 0.0 && left(self) <= 0.0 {
            self.goal = Goal::Velocity(sign * end, limits);
        } else if end == 0.0 && left(self) < 1.0 && self.velocity.abs() <= down * TICK {
            self.stand(target as f64);
        }
    }

    fn follow_path(&mut self) {
        let at = self.now.wrapping_add(1_000 << POINT);
        while self.path.len() > 1 && span(self.path[1].0, at) > 0 {
            self.path.remove(0);
        }
        let before = self.position;
        let (begin, from) = self.path[0];
        match self.path.get(1) {
            _ if span(begin, at) < 0 => {}
            Some((end, to)) => {
                let part = span(begin, at) as f64 / span(begin, *end) as f64;
                self.position = from as f64 + part * (to - from) as f64;
                self.velocity = (self.position - before) / TICK;
            }
            None => self.stand(from as f64),
        }
    }

    /// When and where what is followed ends.
    fn last(&self) -> (MicrosQ16, i64) {
        let here = (self.now, self.committed_position());
        self.path.last().copied().unwrap_or(here)
    }

    fn take(&mut self, goal: Goal) -> Result<(), Refused> {
        self.path.clear();
        self.goal = goal;
        Ok(())
    }
}

fn value(speed: Speed) -> f64 {
    speed.bits() as f64 / ONE
}

fn signed(velocity: f64) -> SignedSpeed {
    SignedSpeed::from_bits((velocity * ONE) as i64)
}

impl AtPort<Shaft> for Servo {
    fn set_up(&mut self, _: &Configuration) {}

    fn observe(&mut self, now: MicrosQ16, _: &Shaft) {
        self.now = now;
    }

    fn look_again(&mut self, _: &Shaft) {}

    fn advance(&mut self, shaft: &mut Shaft, _: bool) {
        match self.goal {
            Goal::Rest => {}
            Goal::Torque(torque) => self.velocity += f64::from(torque) * TICK,
            Goal::Velocity(wanted, limits) => self.ramp(wanted, limits),
            Goal::Target(target, end, limits) => self.target(target, end, limits),
            Goal::Path => self.follow_path(),
        }
        if matches!(self.goal, Goal::Velocity(0.0, _)) && self.velocity == 0.0 {
            self.stand(self.position);
        }
        *shaft = self.committed_position();
    }

    fn refill(&mut self, _: &mut Shaft) {}
}

#[rustfmt::skip] // A table: most of it says one thing in a line.
impl Actuator for Servo {
    const MODES: u32 = u32::MAX;

    fn demand(&self) -> Demand { Demand { position: self.committed_position(), velocity: signed(self.velocity) } }
    fn torque(&self) -> Option<Torque> { Some(if let Goal::Torque(actual) = self.goal { Torque { actual, ..Torque::default() } } else { Torque::default() }) }
    fn take_errors(&mut self) -> ActuatorErrors { ActuatorErrors::default() }
    fn standstill(&self) -> bool { self.goal == Goal::Rest }
    fn is_at_rest(&self) -> bool { self.goal == Goal::Rest }
    fn committed_position(&self) -> i64 { self.position.round() as i64 }
    fn committed_velocity(&self) -> SignedSpeed { signed(self.velocity) }
    fn is_ending(&self) -> bool { matches!(self.goal, Goal::Rest | Goal::Velocity(0.0, _)) }
    fn max_velocity(&self) -> Speed { Speed::per_second(1_000_000) }
    fn window(&self) -> u64 { 0 }
    fn cut_off(&mut self) { self.stand(self.position); }
    fn stand_at(&mut self, position: i64) { self.stand(position as f64); }
    fn is_following(&self) -> bool { self.goal == Goal::Path }
    fn expect_acceleration(&mut self, _: u32) {}
    fn hold_torque(&mut self, torque: i16) -> Result<(), NotSupported> { self.take(Goal::Torque(torque)).map_err(|_| NotSupported) }

    fn destination(&self) -> i64 {
        match self.goal {
            Goal::Target(target, 0.0, _) => target,
            Goal::Velocity(0.0, limits) => self.stop_preview(limits.deceleration, Ramps::Linear, None),
            _ => self.committed_position(),
        }
    }

    fn heading(&self) -> Option<Direction> {
        let distance = self.destination().wrapping_sub(self.committed_position()) as f64 + self.velocity;
        let direction = if distance < 0.0 { Direction::Reverse } else { Direction::Forward };
        (self.goal != Goal::Rest).then_some(direction)
    }

    fn move_to(&mut self, target: i64, limits: Limits, _: Ramps) -> Result<(), Refused> { self.take(Goal::Target(target, 0.0, limits)) }

    fn move_through(&mut self, target: i64, end: Speed, limits: Limits, _: Ramps) -> Result<(), Refused> {
        self.take(Goal::Target(target, value(end), limits))
    }

    fn ramp_to(&mut self, velocity: SignedSpeed, limits: Limits, _: Ramps) -> Result<(), Refused> {
        self.take(Goal::Velocity(velocity.bits() as f64 / ONE, limits))
    }

    fn stop(&mut self, deceleration: u32, _: Ramps) -> Result<(), Refused> {
        let limits = Limits { velocity: Speed::ZERO, acceleration: deceleration, deceleration };
        if deceleration == 0 { Err(Refused) } else { self.take(Goal::Velocity(0.0, limits)) }
    }

    fn stop_preview(&self, deceleration: u32, _: Ramps, _: Option<&Limits>) -> i64 {
        (self.position + self.velocity * self.velocity.abs() / 2.0 / f64::from(deceleration)) as i64
    }

    fn follow_smoothly(&mut self, end: MicrosQ16, to: Position, _: (Position, MicrosQ16)) -> Result<(), FollowError> {
        self.follow(end, to)
    }

    fn follow(&mut self, end: MicrosQ16, to: Position) -> Result<(), FollowError> {
        self.path.push((end, unwrapped(to.whole_steps(), self.last().1)));
        self.goal = Goal::Path;
        Ok(())
    }

    fn follow_velocity(&mut self, _: MicrosQ16, _: SignedSpeed) -> Result<(), FollowError> { Err(FollowError::TooLate) }

    fn path_end(&self) -> Demand {
        Demand { position: self.last().1, velocity: signed(self.velocity) }
    }

    fn path_to(&self, end: MicrosQ16) -> PathEnd {
        let (time, position) = self.last();
        let left = span(time, end).max(0);
        let distance = (self.velocity * left as f64 / 65_536e6 * ONE) as i64;
        PathEnd { left: left.cast_unsigned(), position: Position::from_steps(position), distance }
    }

    fn is_running_out(&self, time: MicrosQ16) -> bool {
        self.is_following() && self.velocity != 0.0 && span(self.last().0, self.now.wrapping_add(time)) > 0
    }
}
