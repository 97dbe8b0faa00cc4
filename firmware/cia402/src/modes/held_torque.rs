//! Holding a torque: what profile torque and cyclic synchronous torque share.
//!
//! The contract:
//! - The torque is held within the limits of torque and current; the velocity is held within 6080h and 607Fh, by less torque.
//! - A torque into a limit switch is not held: the motor stops on the quick stop ramp and stays.
//! - Before a software limit 607Dh the motor slows down on the quick stop ramp and ends on the limit, whatever takes it there: a torque, its
//!   speed or its load. It is held there until the limit is another one.
//! - A torque the other way is held at once, as soon as it brakes harder than that ramp or takes the motor away.

use motion::{Direction, Limits, Ramps, Speed, low};

use super::braking::{self, Ramp};
use super::{Context, Types};
use crate::actuator::{Actuator, TORQUE_MODES};
use crate::motor::Motor;
use crate::option_codes::StopRamp;
use crate::statusword::INTERNAL_LIMIT;

/// What keeps a torque from being held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Obstacle {
    /// The direction in which it lies.
    sign: i16,
    /// The software limit at which the motion ends; `None` for a limit switch.
    end: Option<i64>,
}

/// The state of a held torque.
#[derive(Debug)]
pub(super) struct HeldTorque {
    obstacle: Option<Obstacle>,
    /// How fast the motor was in the tick before.
    speed: Speed,
}

impl HeldTorque {
    pub(super) const fn new() -> Self {
        Self {
            obstacle: None,
            speed: Speed::MAX,
        }
    }

    /// Somebody else has stopped the motor: the next torque is held anew.
    pub(super) fn forget(&mut self) {
        *self = Self::new();
    }

    /// A limit switch is stopping the motor.
    pub(super) fn on_limit<A: Actuator>(&mut self, motor: &Motor<A>) {
        // Nothing of this is linked where no torque is held.
        if A::MODES & TORQUE_MODES == 0 {
            return;
        }
        let sign = match motor.heading() {
            Some(Direction::Forward) => 1,
            Some(Direction::Reverse) => -1,
            None => return,
        };
        self.obstacle = Some(Obstacle { sign, end: None });
    }

    /// Holds a torque, in thousandths of the rated one. Returns bit 11.
    pub(super) fn hold(&mut self, asked: i16, context: &mut Context<'_, impl Types>) -> u16 {
        let limits = context.configuration.torque;
        let positive = limits.max.min(limits.positive);
        let negative = limits.max.min(limits.negative);
        let least = i16::try_from(negative).map_or(-i16::MAX, i16::wrapping_neg);
        let max = i16::try_from(positive).unwrap_or(i16::MAX);
        let torque = asked.min(max).max(least);
        let before = self.obstacle;
        self.obstacle = self.in_the_way(torque, context);
        self.speed = context.motor.committed_velocity().unsigned_abs();
        if let Some(obstacle) = self.obstacle {
            if before != self.obstacle {
                end_at(obstacle, context);
            }
            return INTERNAL_LIMIT;
        }
        // It is free, and a mode of torque is there only where the actuator has one.
        let _ = context.motor.hold_torque(torque);
        if torque == asked { 0 } else { INTERNAL_LIMIT }
    }

    /// What is in the way of a torque, or of the motor as it moves now.
    fn in_the_way(&self, torque: i16, context: &Context<'_, impl Types>) -> Option<Obstacle> {
        let sign = torque.signum();
        if context.motor.is_free(torque.into()).is_err() {
            return Some(Obstacle { sign, end: None });
        }
        if let Some(obstacle) = self.obstacle {
            let against = torque.saturating_mul(obstacle.sign);
            let holds = context.motor.torque().map_or(0, |torque| torque.demand);
            let is_overcome = against < 0 && against < holds.saturating_mul(obstacle.sign);
            let stands = obstacle
                .end
                .is_none_or(|end| end == end_of(obstacle.sign, context));
            if is_overcome {
                return None;
            } else if stands {
                return Some(obstacle);
            }
        }
        self.software_limit(sign, context)
    }

    /// The software limit that a motor which goes on for the next tick would pass on the quick stop ramp.
    fn software_limit(&self, sign: i16, context: &Context<'_, impl Types>) -> Option<Obstacle> {
        let velocity = context.motor.committed_velocity();
        let now = velocity.unsigned_abs();
        // It may gain as much again until then.
        let gained = now.bits().saturating_sub(self.speed.bits());
        let speed = Speed::from_bits(now.bits().saturating_add(gained));
        let (deceleration, _) = ramp_before_limit(context);
        let ramp = braking::distance(speed, (0, deceleration), Ramps::Linear);
        // What is told in the next tick takes effect some pulses later.
        let time = u64::from(context.elapsed).saturating_mul(2);
        let until = u64::from(speed.whole()).saturating_mul(time) / 1_000_000;
        let way = ramp.saturating_add(until);
        let way = i64::try_from(way).unwrap_or(i64::MAX);
        // What stands goes where it is pushed to.
        let sign = if way == 0 {
            sign
        } else {
            signum(velocity.bits())
        };
        let end = end_of(sign, context);
        let position = context.motor.committed_position();
        let left = match sign {
            1 => end.saturating_sub(position),
            -1 => position.saturating_sub(end),
            _ => return None,
        };
        let end = Some(end);
        (left <= way).then_some(Obstacle { sign, end })
    }
}

fn signum(value: i64) -> i16 {
    low::i16(value.signum())
}

/// The software limit in a direction.
const fn end_of(sign: i16, context: &Context<'_, impl Types>) -> i64 {
    let (low, high) = context.travel.increments;
    if sign < 0 { low } else { high }
}

/// The ramp on which the motor slows down before a software limit, in steps/s²: that of the quick stop, or what the limits of the torque
/// allow, less a part for the loops. And the hardest one, where the limit comes too near for that: by a torque that has taken the motor on
/// further in a tick than could be foreseen, or as it was written.
fn ramp_before_limit(context: &Context<'_, impl Types>) -> (u32, u32) {
    let most = context.motor.max_deceleration();
    let asked = context.deceleration(StopRamp::QuickStop);
    let within = most.saturating_sub(most / 8).max(1);
    let hardest = most.min(context.configuration.max_deceleration);
    (asked.min(within), hardest)
}

/// Ends the motion before an obstacle: on a software limit, if that is possible.
fn end_at(obstacle: Obstacle, context: &mut Context<'_, impl Types>) {
    let (deceleration, hardest) = ramp_before_limit(context);
    let travel = context.travel.increments;
    let motor = &mut *context.motor;
    let velocity = motor.committed_velocity();
    let limits = Limits {
        velocity: velocity.unsigned_abs(),
        acceleration: deceleration,
        deceleration,
    };
    let asked = Ramp {
        limits,
        ramps: Ramps::Linear,
    };
    if let Some(end) = obstacle.end
        && signum(velocity.bits()) == obstacle.sign
    {
        let braking = braking::between(motor, obstacle.end, travel, asked, hardest);
        if !braking.passes && motor.move_to(end, braking.ramp.limits).is_ok() {
            braking.taken(motor);
            return;
        }
    }
    if !motor.is_stopping() && !motor.standstill() {
        context.stop_on(StopRamp::QuickStop);
    }
}
