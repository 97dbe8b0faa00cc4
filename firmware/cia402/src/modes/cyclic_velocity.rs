//! Cyclic synchronous velocity, mode 9 (CiA 402-2): the master gives a velocity in each period.
//!
//! - The set-point is 60FFh plus 60B1h, as they are at SYNC, or as 60FFh is written where there is none. From one to the next the velocity changes
//!   evenly, by no more than 60C5h and 60C6h allow.
//! - The velocity is cut to 607Fh, to 6080h and to what the pulses can reach; before a software limit 607Dh the motor slows down with 6085h
//!   and stops on it. Bit 11 shows each of these.
//! - The mode may begin while the motor moves: it goes on as it is until the first set-point. Where it followed set-points of another
//!   cyclic mode, the next one is awaited as within the mode.
//! - A missing set-point keeps the velocity, as often as 2051h:1 says. Then the motor stops with 6085h, and 2051h:2 says what else.
//! - Halt (bit 8) stops on the ramp of 605Dh; set-points that come after it count again.
//!
//! Bit 10: during halt, the motor stands. Bit 12, drive follows the command value.

use super::Context;
use super::following::{braking_way, gain, seconds};
use crate::cyclic::{POINT, Slot};
use crate::motor::Motor;
use crate::option_codes::StopRamp;
use crate::statusword::{FOLLOWS, INTERNAL_LIMIT, TARGET_REACHED};

/// The mode.
#[derive(Debug)]
pub(super) struct CyclicVelocity {
    follows: bool,
    is_limited: bool,
    held: bool,
    /// What is asked for, in steps/s.
    velocity: i32,
    /// What is carried out, in steps/s, Q16: slow ramps change it by less than 1 in a period.
    exact: i64,
    bridged: u8,
}

impl CyclicVelocity {
    pub(super) const fn new() -> Self {
        Self {
            follows: false,
            is_limited: false,
            held: false,
            velocity: 0,
            exact: 0,
            bridged: 0,
        }
    }

    /// The mode begins, whatever the motor does.
    pub(super) fn enter(&mut self, motor: &Motor) {
        *self = Self::new();
        if motor.is_following() {
            self.follows = true;
            self.velocity = motor.course_end().velocity;
        }
    }

    /// A limit switch is stopping the motor.
    pub(super) const fn limit_met(&mut self) {
        self.follows = false;
        self.is_limited = true;
    }

    /// One control tick; returns statusword bits 10 to 12.
    pub(super) fn tick(&mut self, context: &mut Context<'_>) -> u16 {
        if context.is_held() {
            if !self.held {
                self.held = true;
                self.follows = false;
                context.halt();
            }
        } else {
            self.held = false;
            for slot in context.slots {
                self.take(slot, context);
            }
        }
        let bit = |condition, bit| if condition { bit } else { 0 };
        bit(
            context.is_halted() && context.motor.standstill(),
            TARGET_REACHED,
        ) | bit(self.is_limited, INTERNAL_LIMIT)
            | bit(self.follows, FOLLOWS)
    }

    fn take(&mut self, slot: &Slot, context: &mut Context<'_>) {
        let asked = slot.beat.and_then(|beat| {
            let offset = beat.velocity_offset;
            Some(beat.velocity?.saturating_add(offset))
        });
        let lost = &context.configuration.cyclic.lost;
        match asked {
            Some(velocity) => {
                // A stop that is under way ends first.
                if !self.follows && context.motor.is_stopping() {
                    return;
                }
                self.follows = true;
                self.bridged = 0;
                self.velocity = velocity;
            }
            None if !self.follows => return,
            None if lost.is_as_before() || self.velocity == 0 => {}
            None if self.bridged >= lost.bridged => {
                self.follows = false;
                return context.lose_set_points();
            }
            None => self.bridged = self.bridged.saturating_add(1),
        }
        let end = slot.at.wrapping_add(context.latency(slot.period));
        let velocity = self.allowed(slot, context);
        if context.motor.is_at_rest() {
            if velocity == 0 {
                return;
            }
            let _ = context
                .motor
                .follow_velocity(end.wrapping_sub(slot.period), 0);
        }
        // A set-point that comes too late is passed by.
        let _ = context.motor.follow_velocity(end, velocity);
    }

    /// The velocity within all limits.
    fn allowed(&mut self, slot: &Slot, context: &Context<'_>) -> i32 {
        let asked = self.velocity;
        let before = context.motor.course_end();
        let most = i32::try_from(context.max_velocity()).unwrap_or(i32::MAX);
        let velocity = asked.max(most.wrapping_neg()).min(most);
        let velocity = before_limit(velocity, slot, before.position, context);
        let velocity = if context.motor.is_free(velocity.into()).is_err() {
            0
        } else {
            velocity
        };
        if whole(self.exact).abs_diff(before.velocity) > 1 {
            // Somebody else has moved the motor.
            self.exact = i64::from(before.velocity) << POINT;
        }
        self.exact = within_ramps(i64::from(velocity) << POINT, self.exact, slot, context);
        let velocity = whole(self.exact);
        self.is_limited = velocity != asked;
        velocity
    }
}

/// 60C5h and 60C6h, in steps/s, Q16.
fn within_ramps(velocity: i64, before: i64, slot: &Slot, context: &Context<'_>) -> i64 {
    let seconds = seconds(slot.period);
    let grows = velocity.unsigned_abs() > before.unsigned_abs();
    let ramp = if grows {
        context.configuration.max_acceleration
    } else {
        context.configuration.max_deceleration
    };
    let change = (u128::from(ramp).wrapping_mul(seconds.into()) >> (32 - POINT)).max(1);
    let change = i64::try_from(change).unwrap_or(i64::MAX);
    velocity
        .max(before.saturating_sub(change))
        .min(before.saturating_add(change))
}

/// The nearest whole velocity.
const fn whole(exact: i64) -> i32 {
    (exact.saturating_add(1 << (POINT - 1)) >> POINT) as i32
}

/// The velocity from which the motor can still stop at a software limit.
fn before_limit(velocity: i32, slot: &Slot, position: i64, context: &Context<'_>) -> i32 {
    let (low, high) = context.travel.increments;
    let room = match velocity {
        1.. => high.saturating_sub(position),
        ..=-1 => position.saturating_sub(low),
        0 => return 0,
    };
    if room > 1 << 46 {
        return velocity;
    }
    let seconds = seconds(slot.period);
    let deceleration = context.deceleration(StopRamp::QuickStop);
    // The velocities are whole ones: what one is too high, the next can make up for.
    let down = gain(deceleration.saturating_sub(deceleration / 32), seconds);
    let way = braking_way(room.max(0) << 16, down);
    let most = (way.unsigned_abs().min(1 << 47) << 16)
        .checked_div(seconds)
        .and_then(|most| i32::try_from(most).ok())
        .unwrap_or(i32::MAX);
    velocity.max(most.wrapping_neg()).min(most)
}
