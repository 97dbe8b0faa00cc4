//! A velocity that is kept until another is asked for, within the software limits: what the velocity modes share.
//!
//! The contract:
//! - A change is a ramp from whatever the motor does: the acceleration rules while the speed grows, the deceleration while it
//!   falls, and a change of sign passes through standstill.
//! - With a limit ahead the motion is a move to the limit at this velocity, so it slows down in time and ends on the limit exactly.
//!   Motion away from a limit is always free, also from beyond it.

use motion::Limits;

use super::Context;
use crate::motor::Motor;

/// What is asked of the motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Order {
    /// In steps/s.
    pub(super) velocity: i32,
    /// Its velocity is the greatest amount of the velocity above.
    pub(super) limits: Limits,
    /// The lowest and the highest position in steps; see [`Context::travel`].
    pub(super) travel: (i64, i64),
}

/// How a velocity is being kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Course {
    /// No order is being carried out.
    None,
    /// There is nothing in the way.
    Free,
    /// It ends at a limit.
    ToLimit,
    /// It cannot be carried out for now: the motor stands, or comes to rest.
    Barred,
}

/// The motion.
#[derive(Debug)]
pub(super) struct KeptVelocity {
    order: Option<Order>,
    course: Course,
}

impl KeptVelocity {
    pub(super) const fn new() -> Self {
        Self {
            order: None,
            course: Course::None,
        }
    }

    /// Somebody else has moved or stopped the motor: the next order is carried out anew.
    pub(super) fn forget(&mut self) {
        *self = Self::new();
    }

    /// Carries out an order. Nothing is planned while it stays the same; what is barred is tried again.
    pub(super) fn follow(&mut self, order: Order, motor: &mut Motor) {
        if self.order != Some(order) || self.course == Course::Barred {
            self.order = Some(order);
            self.course = begin(order, motor);
        }
    }

    /// Whether a limit slows the motor down or holds it.
    pub(super) fn is_limited(&self, motor: &Motor) -> bool {
        match self.course {
            Course::None | Course::Free => false,
            Course::ToLimit => motor.is_ending(),
            Course::Barred => true,
        }
    }
}

fn begin(order: Order, motor: &mut Motor) -> Course {
    let Order {
        velocity,
        limits,
        travel: (low, high),
    } = order;
    if velocity == 0 {
        stop(motor, limits.deceleration);
        return Course::Free;
    }
    let end = if velocity > 0 { high } else { low };
    let result = if Context::NO_TRAVEL.0 < end && end < Context::NO_TRAVEL.1 {
        stop(motor, limits.deceleration);
        let rest = motor.destination();
        let is_ahead = if velocity > 0 { rest < end } else { rest > end };
        let result = is_ahead.then(|| motor.move_to(end, limits));
        result.map(|result| result.map(|()| Course::ToLimit))
    } else {
        Some(motor.ramp_to(velocity, limits).map(|()| Course::Free))
    };
    match result {
        Some(Ok(course)) => course,
        Some(Err(_)) | None => {
            stop(motor, limits.deceleration);
            Course::Barred
        }
    }
}

fn stop(motor: &mut Motor, deceleration: u32) {
    if !motor.standstill() {
        motor.stop(deceleration);
    }
}
