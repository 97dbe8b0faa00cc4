//! Cyclic synchronous velocity, mode 9 (CiA 402-2): the master gives a velocity in each period.
//!
//! - The set-point is 60FFh plus 60B1h, as they are at SYNC, or as 60FFh is written where there is none. From one to the next the velocity changes
//!   evenly, by no more than 60C5h and 60C6h allow.
//! - The velocity is cut to 607Fh, to 6080h and to what the pulses can reach; before a software limit 607Dh the motor slows down with 6085h
//!   and stops on it. Bit 11 shows each of these.
//! - The mode may begin while the motor moves: it goes on as it is until the first set-point, within the software limits. Where it followed set-points of another
//!   cyclic mode, the next one is awaited as within the mode.
//! - A missing set-point keeps the velocity, as often as 2051h:1 says. Then the motor stops with 6085h, and 2051h:2 says what else.
//! - Halt (bit 8) stops on the ramp of 605Dh; set-points that come after it count again.
//!
//! Bit 10: during halt, the motor stands. Bit 12, drive follows the command value: 0 as well while a software limit or a limit switch keeps
//! it from that.

use super::{Context, Types};
use motion::{Limits, Ramps, SignedSpeed, Speed};

use super::following::{braking_distance, gain, seconds};
use super::kept_velocity::{KeptVelocity, Order};
use crate::actuator::Actuator;
use crate::cyclic::{MicrosQ16, Slot};
use crate::motor::Motor;
use crate::option_codes::StopRamp;
use crate::statusword::{FOLLOWS, INTERNAL_LIMIT, TARGET_REACHED};

/// The mode.
#[derive(Debug)]
pub(super) struct CyclicVelocity {
    follows: bool,
    is_limited: bool,
    /// A software limit or a limit switch is in the way.
    is_blocked: bool,
    is_held: bool,
    /// The velocity that the set-point asks for.
    velocity: SignedSpeed,
    /// The velocity that is carried out, within all limits.
    carried_out: SignedSpeed,
    bridged: u8,
    /// No set-point has come yet, and the motor goes on with the motion of the mode before.
    goes_on: bool,
    /// The velocity that it is to keep meanwhile.
    kept: Option<SignedSpeed>,
    motion: KeptVelocity,
}

impl CyclicVelocity {
    pub(super) const fn new() -> Self {
        Self {
            follows: false,
            is_limited: false,
            is_blocked: false,
            is_held: false,
            velocity: SignedSpeed::ZERO,
            carried_out: SignedSpeed::ZERO,
            bridged: 0,
            goes_on: false,
            kept: None,
            motion: KeptVelocity::new(),
        }
    }

    /// The mode begins, whatever the motor does.
    pub(super) fn enter(&mut self, motor: &Motor<impl Actuator>) {
        *self = Self::new();
        if motor.is_following() {
            self.follows = true;
            self.velocity = motor.path_end().velocity;
        } else {
            self.goes_on = !motor.is_stopping();
        }
    }

    /// What the motor was to keep in the mode before.
    pub(super) const fn go_on_with(&mut self, velocity: Option<SignedSpeed>) {
        self.kept = velocity;
    }

    /// A limit switch is stopping the motor.
    pub(super) const fn on_limit(&mut self) {
        self.follows = false;
        self.goes_on = false;
        self.is_limited = true;
        self.is_blocked = true;
    }

    /// One control tick; returns statusword bits 10 to 12.
    #[inline(never)]
    pub(super) fn tick(&mut self, context: &mut Context<'_, impl Types>) -> u16 {
        if context.is_held() {
            if !self.is_held {
                self.is_held = true;
                self.follows = false;
                self.goes_on = false;
                context.halt();
            }
        } else {
            self.is_held = false;
            for slot in context.slots {
                self.take(slot, context);
            }
            if context.is_running_out() {
                self.follows = false;
                context.lose_set_points();
            }
            if self.goes_on {
                self.go_on(context);
            }
        }
        let bit = |condition, bit| if condition { bit } else { 0 };
        bit(
            context.is_halted() && context.motor.standstill(),
            TARGET_REACHED,
        ) | bit(self.is_limited, INTERNAL_LIMIT)
            | bit(self.follows && !self.is_blocked, FOLLOWS)
    }

    fn take(&mut self, slot: &Slot, context: &mut Context<'_, impl Types>) {
        let asked = slot.event.and_then(|event| event.velocity);
        let lost = &context.configuration.cyclic.lost;
        match asked {
            Some(velocity) => {
                // A stop that is under way ends first.
                if !self.follows && context.motor.is_stopping() {
                    return;
                }
                self.follows = true;
                self.goes_on = false;
                self.bridged = 0;
                self.velocity = velocity;
            }
            None if !self.follows => return,
            None if lost.is_as_before() || self.velocity == SignedSpeed::ZERO => {}
            None if self.bridged >= lost.bridged => {
                self.follows = false;
                return context.lose_set_points();
            }
            None => self.bridged = self.bridged.saturating_add(1),
        }
        let is_at_rest = context.motor.is_at_rest();
        if is_at_rest && self.velocity == SignedSpeed::ZERO && self.carried_out == SignedSpeed::ZERO
        {
            self.is_blocked = false;
            self.is_limited = false;
            return;
        }
        let end = slot.due(false);
        let interval = if is_at_rest {
            slot.period
        } else {
            context.motor.path_to(end).left
        };
        if interval < slot.period / 4 {
            // What was given before the period changed lasts that long.
            return;
        }
        let velocity = self.allowed(interval, context);
        if is_at_rest {
            if velocity == SignedSpeed::ZERO {
                return;
            }
            let _ = context
                .motor
                .follow_velocity(end.wrapping_sub(slot.period), SignedSpeed::ZERO);
        }
        // A set-point that comes too late is passed by.
        let _ = context.motor.follow_velocity(end, velocity);
    }

    /// Until the first set-point: a motion that has no end, or ends beyond a software limit, becomes one that ends at the limit.
    fn go_on(&mut self, context: &mut Context<'_, impl Types>) {
        if context.motor.is_at_rest() {
            self.goes_on = false;
            return;
        }
        let travel = context.travel.increments;
        let here = context.motor.committed_position();
        let end = context.motor.destination();
        let velocity = match self.kept {
            Some(velocity) => velocity,
            None if end <= travel.1.max(here) && end >= travel.0.min(here) => return,
            None => context.motor.committed_velocity(),
        };
        self.kept = Some(velocity);
        let quick_stop = context.deceleration(StopRamp::QuickStop);
        let (limits, is_cut) = context.within(Limits {
            velocity: velocity.unsigned_abs(),
            acceleration: context.commands.profile_acceleration,
            deceleration: quick_stop,
        });
        let order = Order {
            asked: velocity,
            velocity: limits.velocity.with_sign_of(velocity),
            limits,
            travel,
            ramps: Ramps::Linear,
            quick_stop,
        };
        self.motion.follow(order, context);
        self.is_limited = is_cut || self.motion.is_limited(context.motor);
    }

    /// The velocity within all limits.
    fn allowed(&mut self, interval: MicrosQ16, context: &Context<'_, impl Types>) -> SignedSpeed {
        let asked = self.velocity;
        let before = context.motor.path_end();
        let wanted = asked.within(context.max_velocity());
        let velocity = before_limit(wanted, interval, before.position, context);
        let velocity = if context.motor.is_free(velocity.bits()).is_err() {
            SignedSpeed::ZERO
        } else {
            velocity
        };
        self.is_blocked = velocity != wanted;
        if self.carried_out.abs_diff(before.velocity) > Speed::per_second(1) {
            // Somebody else has moved the motor.
            self.carried_out = before.velocity;
        }
        self.carried_out = within_ramps(velocity, self.carried_out, interval, context);
        self.is_limited = self.carried_out != asked;
        self.carried_out
    }
}

/// 60C5h and 60C6h.
fn within_ramps(
    velocity: SignedSpeed,
    before: SignedSpeed,
    interval: MicrosQ16,
    context: &Context<'_, impl Types>,
) -> SignedSpeed {
    let seconds = seconds(interval);
    let grows = velocity.unsigned_abs() > before.unsigned_abs();
    let ramp = if grows {
        context.configuration.max_acceleration
    } else {
        context.configuration.max_deceleration
    };
    let change = u128::from(ramp).wrapping_mul(seconds.into()).max(1);
    let change = i64::try_from(change).unwrap_or(i64::MAX);
    let before = before.bits();
    let velocity = velocity.bits();
    SignedSpeed::from_bits(
        velocity
            .max(before.saturating_sub(change))
            .min(before.saturating_add(change)),
    )
}

/// The velocity from which the motor can still stop at a software limit.
fn before_limit(
    velocity: SignedSpeed,
    interval: MicrosQ16,
    position: i64,
    context: &Context<'_, impl Types>,
) -> SignedSpeed {
    let (low, high) = context.travel.increments;
    let available = match velocity.bits() {
        1.. => high.saturating_sub(position),
        ..=-1 => position.saturating_sub(low),
        0 => return velocity,
    };
    if available > 1 << 46 {
        return velocity;
    }
    let seconds = seconds(interval);
    let deceleration = context.deceleration(StopRamp::QuickStop);
    // Positions are whole ones here: what a velocity is too high, the next can make up for.
    let down = gain(deceleration.saturating_sub(deceleration / 32), seconds);
    let distance = braking_distance(available.max(0) << 16, down).unsigned_abs();
    velocity.within(rate(distance, seconds))
}

/// The speed at which a distance takes so many seconds; Q16 and Q32. Rounded down, to a whole number of steps/s where it is high.
fn rate(distance: u64, seconds: u64) -> Speed {
    let over = |shift| {
        distance
            .min(u64::MAX >> (shift + 1))
            .wrapping_shl(shift)
            .checked_div(seconds)
    };
    match over(16) {
        Some(slow) if slow < 1 << 10 => Speed::from_bits(over(32).unwrap_or(0) << 16),
        Some(fast) => u32::try_from(fast).map_or(Speed::MAX, Speed::per_second),
        None => Speed::MAX,
    }
}
