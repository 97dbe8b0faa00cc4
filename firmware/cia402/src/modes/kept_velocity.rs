//! A velocity that is kept until another is asked for, within the software limits: what the velocity modes share.
//!
//! The contract:
//! - A change is a ramp from whatever the motor does: the acceleration rules while the speed grows, the deceleration while it
//!   falls, and a change of sign passes through standstill.
//! - With a limit ahead the motion is a move to the limit at this velocity, so it slows down in time and ends on the limit exactly.
//!   Motion away from a limit is always free, also from beyond it. Where the deceleration asked for would carry the motor through a limit,
//!   it takes as hard a one as is needed, up to the quick stop ramp or the one it was planned with before.
//! - A limit switch ends the motion into it for good: it takes another velocity to move again, even once the switch is released,
//!   and another limit of the velocity is not one.

use motion::{Limits, Ramps, SignedSpeed};

use super::braking::{self, Ramp};
use super::{Context, Types};
use crate::actuator::Actuator;
use crate::motor::{Motor, REACH};
use crate::travel::Travel;

/// What is asked of the motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Order {
    /// What the master asks for, before any limit cuts it, in whatever unit: it tells one velocity from another.
    pub(super) asked: SignedSpeed,
    /// What the limits leave of it.
    pub(super) velocity: SignedSpeed,
    /// Its velocity is the greatest amount of the velocity above.
    pub(super) limits: Limits,
    /// The lowest and the highest position in steps; see [`Travel`].
    pub(super) travel: (i64, i64),
    /// How the velocity is to change. Another profile counts from the next order on.
    pub(super) ramps: Ramps,
    /// The deceleration of the quick stop ramp in steps/s².
    pub(super) quick_stop: u32,
}

impl Order {
    /// Whether this is the same motion as before, the profile and the quick stop ramp aside.
    fn is_same_motion(&self, other: Self) -> bool {
        *self
            == Self {
                asked: self.asked,
                ramps: self.ramps,
                quick_stop: self.quick_stop,
                ..other
            }
    }
}

/// How a velocity is being kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Keeping {
    /// No order is being carried out.
    None,
    /// There is nothing in the way.
    Free,
    /// There is a limit, further away than a motion can go.
    Far,
    /// It ends at a limit.
    ToLimit,
    /// It cannot be carried out for now: the motor stands, or comes to rest.
    Blocked,
    /// A limit switch has ended it, or kept it from beginning.
    AtSwitch,
}

/// The motion.
#[derive(Debug)]
pub(super) struct KeptVelocity {
    order: Option<Order>,
    keeping: Keeping,
    /// The sign of the velocity that a software limit makes the motor lose on a harder ramp than it is asked to; 0 for none.
    held_back: i64,
}

impl KeptVelocity {
    pub(super) const fn new() -> Self {
        Self {
            order: None,
            keeping: Keeping::None,
            held_back: 0,
        }
    }

    /// Somebody else has moved or stopped the motor: the next order is carried out anew.
    pub(super) fn forget(&mut self) {
        *self = Self::new();
    }

    /// A limit switch is stopping the motor. A motion away from it goes on.
    pub(super) fn on_limit(&mut self, motor: &Motor<impl Actuator>) {
        let is_into = |order: Order| motor.is_free(order.velocity.bits()).is_err();
        if self.order.is_some_and(is_into) {
            self.keeping = Keeping::AtSwitch;
        } else {
            self.forget();
        }
    }

    /// The velocity of the order that is carried out; `None` if there is none, or the motor is to stand.
    pub(super) const fn velocity(&self) -> Option<SignedSpeed> {
        match (self.order, self.keeping) {
            (Some(order), Keeping::Free | Keeping::Far | Keeping::ToLimit)
                if order.velocity.bits() != 0 =>
            {
                Some(order.velocity)
            }
            _ => None,
        }
    }

    /// Whether an order is under way that goes on by itself, as long as it stays the same.
    pub(super) const fn goes_on(&self) -> bool {
        matches!(self.keeping, Keeping::Free | Keeping::ToLimit)
    }

    /// Carries out an order. Nothing is planned while it stays the same; what software limits block is tried again, what a limit
    /// switch has ended is not, unless another velocity is asked for.
    pub(super) fn follow(&mut self, order: Order, context: &mut Context<'_, impl Types>) {
        let motor = &mut *context.motor;
        let is_new = if self.keeping == Keeping::AtSwitch {
            // A limit that is written cuts the velocity otherwise, but asks for no other.
            self.order.map(|before| before.asked) != Some(order.asked)
        } else {
            !self
                .order
                .is_some_and(|before| order.is_same_motion(before))
                || self.keeping == Keeping::Blocked && motor.is_at_rest()
                || self.keeping == Keeping::Far && is_within_reach(end_of(order), motor)
        };
        if is_new {
            self.order = Some(order);
            (self.keeping, self.held_back) = begin(order, context.motor);
        } else if let Some(before) = &mut self.order {
            before.asked = order.asked;
        }
    }

    /// Whether a limit slows the motor down or holds it.
    pub(super) fn is_limited(&self, motor: &Motor<impl Actuator>) -> bool {
        let is_held_back =
            self.held_back != 0 && motor.committed_velocity().bits().signum() == self.held_back;
        is_held_back
            || match self.keeping {
                Keeping::None | Keeping::Free | Keeping::Far => false,
                Keeping::ToLimit => motor.is_ending(),
                Keeping::Blocked | Keeping::AtSwitch => true,
            }
    }
}

/// The limit in the direction of an order.
const fn end_of(order: Order) -> i64 {
    if order.velocity.bits() > 0 {
        order.travel.1
    } else {
        order.travel.0
    }
}

/// Whether a motion to a limit can be planned, the distance to stop included.
fn is_within_reach(end: i64, motor: &Motor<impl Actuator>) -> bool {
    let distance = end.saturating_sub(motor.committed_position());
    distance.unsigned_abs() < REACH.unsigned_abs() / 2
}

/// Plans the motion. Returns what has become of it, and the sign of the velocity that is lost on a harder ramp; 0 for none.
fn begin(order: Order, motor: &mut Motor<impl Actuator>) -> (Keeping, i64) {
    let Order {
        asked: _,
        velocity,
        limits,
        ramps,
        travel,
        quick_stop,
    } = order;
    motor.set_ramps(ramps);
    motor.expect_acceleration(limits.acceleration);
    if velocity == SignedSpeed::ZERO {
        stop(motor, limits.deceleration);
        return (Keeping::Free, 0);
    }
    if motor.is_free(velocity.bits()).is_err() {
        stop(motor, limits.deceleration);
        return (Keeping::AtSwitch, 0);
    }
    let asked = Ramp { limits, ramps };
    let heading = motor.committed_velocity().bits().signum();
    let braking = braking::between(motor, Some(end_of(order)), travel, asked, quick_stop);
    motor.set_ramps(braking.ramp.ramps);
    let limits = braking.ramp.limits;
    let end = end_of(order);
    let has_end = Travel::NONE.increments.0 < end && end < Travel::NONE.increments.1;
    let is_behind = if velocity.bits() > 0 {
        end <= motor.committed_position()
    } else {
        end >= motor.committed_position()
    };
    let result = if has_end && (is_behind || is_within_reach(end, motor)) {
        let rest = if motor.standstill() {
            motor.destination()
        } else {
            motor.stop_preview(limits.deceleration, braking.ramp.ramps, None)
        };
        let is_ahead = if velocity.bits() > 0 {
            rest < end
        } else {
            rest > end
        };
        // A harder ramp ends on the limit.
        let is_ahead = is_ahead || braking.is_harder && !braking.passes && !is_behind;
        let result = is_ahead.then(|| motor.move_to(end, limits));
        result.map(|result| result.map(|()| Keeping::ToLimit))
    } else {
        let keeping = if has_end { Keeping::Far } else { Keeping::Free };
        Some(motor.ramp_to(velocity, limits).map(|()| keeping))
    };
    let keeping = match result {
        Some(Ok(keeping)) => keeping,
        Some(Err(_)) | None => {
            stop(motor, limits.deceleration);
            Keeping::Blocked
        }
    };
    braking.taken(motor);
    let held_back = if braking.is_harder { heading } else { 0 };
    (keeping, held_back)
}

fn stop(motor: &mut Motor<impl Actuator>, deceleration: u32) {
    if !motor.standstill() {
        motor.stop(deceleration);
    }
}
