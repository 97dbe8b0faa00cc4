//! Profile position, mode 1 (CiA 402-2): the motor goes to set-points, each with its own velocity and ramps.
//!
//! A rising edge of controlword bit 4 hands over a set-point: 607Ah and 6081h to 6084h as they are at that moment (a later
//! write counts for the next one). Bit 12 of the statusword acknowledges it and falls when bit 4 has fallen and there is room
//! for another.
//! - Bit 5 = 1: it replaces whatever is going on, smoothly. Bit 5 = 0: it waits until the one under way is done; one can
//!   wait, and bit 12 stays 1 meanwhile. One more is not taken.
//! - Bit 9 = 1 with bit 5 = 0: the one under way is not slowed down at its target, as far as the motor can still stop at the one
//!   that waits. If that leads back, the motor stops in between all the same.
//! - Bit 6 = 1: 607Ah counts from what 60F2h says: the previous target as it was carried out (0; after enabling, where the motor
//!   stands), the position demand (1) or the actual position (2). For one that waits they are all the target under way.
//! - 6082h is the velocity at the target. The motor keeps it beyond, until the next set-point or a software limit. For a product with a
//!   start speed (`Habits::start_speed`) it is the speed with which a move begins and ends, at once.
//! - Edges count while the mode is at work only. Bit 4 that rises with the controlword that enables, or with the change
//!   of the mode, hands over nothing.
//! - Halt (bit 8) stops on the ramp of 605Dh and keeps the target; releasing it goes on. Set-points are taken but not started.
//! - A target outside 607Dh, or outside 32 bits, is cut to the limit; bit 11 shows it and bit 10 stays 0. The limits are off
//!   while the minimum is not below the maximum. Where the motor is beyond a limit, it does not move to a target further out, and moves to
//!   one in the other direction as it is asked to.
//! - A velocity above 607Fh, 6080h or what the pulses can reach, a ramp above 60C5h or 60C6h is cut (bit 11). A set-point
//!   that cannot be carried out (6081h = 0) is taken and acknowledged, the motor stops or stays, bit 10 stays 0 and bit 11 is 1;
//!   the next set-point replaces it at once.
//!
//! Bit 10, target reached: 0 in the tick that takes a set-point, even one that ends where the motor stands; then 1 as soon
//! as 6064h has been within 6067h of the target for 6068h. With 6067h = FFFFFFFFh it is 1 when the profile has ended; with an
//! end velocity, when the target is passed. During halt it says that the motor stands.

mod set_point;
mod taking;

use motion::{Limits, SignedSpeed, Speed};

use super::braking::{self, Ramp};
use super::kept_velocity::{KeptVelocity, Order};
use super::{Context, Types};
use crate::actuator::{Actuator, Refused};
use crate::controlword::NEW_SET_POINT;
use crate::motor::Motor;
use crate::option_codes::StopRamp;
use crate::statusword::{INTERNAL_LIMIT, SET_POINT_ACKNOWLEDGE, TARGET_REACHED};
use crate::travel::Travel;
use crate::window_timer::WindowTimer;
use set_point::{Limited, SetPoint};

/// 6067h: the position window is off.
const WINDOW_OFF: u32 = u32::MAX;
/// 60F2h: what relative set-points count from.
const RELATIVE_TO: u16 = 3;

/// How far a set-point has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Progress {
    /// The motor is on its way (or halted on it).
    UnderWay,
    /// The profile has ended. So it is before the first set-point.
    Done,
    /// The target has been passed, and the end velocity is kept.
    Passed,
    /// It cannot be carried out.
    Impossible,
}

/// The mode.
#[derive(Debug)]
pub(super) struct ProfilePosition {
    /// The set-point that is carried out or was last; none since operation was enabled.
    current: Option<SetPoint>,
    progress: Progress,
    /// The set-point that waits.
    next: Option<SetPoint>,
    /// The target that bit 10 means.
    target: i64,
    /// The same in units of the user, that relative ones count from; none since operation was enabled.
    user: Option<i64>,
    /// On which side of the target the motor was when the set-point began: the sign of the distance to it.
    direction: i64,
    /// The motion behind a target that is passed.
    beyond: KeptVelocity,
    acknowledge: bool,
    /// Halt, or the brake is not open yet.
    is_held: bool,
    /// The mode began in this tick: an edge of bit 4 is older than it.
    begins: bool,
    /// The set-point under way is to be begun again: it is being stopped, or a limit has changed.
    starts_anew: bool,
    /// A limit that was written behind it has cut the target of the set-point under way, and it has not been begun again yet.
    is_recut: bool,
    /// A software limit makes the motor slow down harder than the set-point asks for.
    is_held_back: bool,
    /// The software limits that the set-points were cut to.
    travel: Travel,
    window: WindowTimer,
}

impl ProfilePosition {
    pub(super) const fn new() -> Self {
        Self {
            current: None,
            progress: Progress::Done,
            next: None,
            target: 0,
            user: None,
            direction: 0,
            beyond: KeptVelocity::new(),
            acknowledge: false,
            is_held: false,
            begins: true,
            starts_anew: false,
            is_recut: false,
            is_held_back: false,
            travel: Travel::NONE,
            window: WindowTimer::new(),
        }
    }

    /// The mode begins: no set-point, no acknowledge, the target is where the motor stands (or comes to rest).
    pub(super) fn enter(&mut self, motor: &Motor<impl Actuator>) {
        *self = Self::new();
        self.target = motor.destination();
    }

    /// The velocity that the motor is to keep behind the target; `None` if it is to stop there.
    pub(super) const fn end_velocity(&self) -> Option<SignedSpeed> {
        match (self.current, self.progress) {
            (Some(set_point), Progress::UnderWay | Progress::Passed)
                if set_point.end_velocity.bits() != 0 =>
            {
                Some(set_point.end_velocity.signed(self.direction < 0))
            }
            _ => None,
        }
    }

    /// A limit switch is stopping the motor: the set-points are not carried out. One that leads away from the switch is: the motor
    /// was turning round to it.
    pub(super) fn on_limit(&mut self, motor: &Motor<impl Actuator>) {
        let leads_away = self.current.is_some_and(|set_point| {
            let distance = set_point.target.saturating_sub(motor.committed_position());
            motor.is_free(distance).is_ok()
        });
        if leads_away && self.progress == Progress::UnderWay {
            self.starts_anew = true;
        } else {
            self.progress = Progress::Impossible;
            self.next = None;
        }
    }

    /// One control tick; returns statusword bits 10 to 12.
    #[inline(never)]
    pub(super) fn tick(&mut self, context: &mut Context<'_, impl Types>) -> u16 {
        let controlword = context.commands.controlword;
        let was_held = self.is_held;
        self.is_held = context.is_held();

        if self.progress == Progress::UnderWay && !was_held && !self.starts_anew {
            self.look_for_the_end(context);
        }
        let edge = context.commands.rising & NEW_SET_POINT != 0 && !self.begins;
        self.begins = false;
        if context.has_changed {
            self.look_at_limits(context);
        }
        if self.starts_anew && !self.is_held {
            self.go_on(context);
        }
        if self.progress != Progress::UnderWay
            && let Some(next) = self.next.take()
        {
            self.begin(next, context);
        }
        let taken = edge && self.take(context);
        match (was_held, self.is_held) {
            (false, true) => context.halt(),
            (true, false) => self.resume(context),
            _ => {}
        }
        if self.progress == Progress::Passed && !self.is_held {
            self.go_beyond(context);
        }

        if taken {
            self.acknowledge = true;
        } else if controlword & NEW_SET_POINT == 0 && self.next.is_none() {
            self.acknowledge = false;
        }
        self.bits(context, taken)
    }

    /// The set-point under way may have come to its end.
    fn look_for_the_end(&mut self, context: &Context<'_, impl Types>) {
        let Some(set_point) = self.current else {
            return;
        };
        let motor = &context.motor;
        if set_point.end_velocity == Speed::ZERO {
            if motor.standstill() {
                self.progress = Progress::Done;
            }
        } else {
            let distance = set_point.target.saturating_sub(motor.committed_position());
            if distance.saturating_mul(self.direction) <= 0 {
                self.progress = Progress::Passed;
            }
        }
    }

    /// A set-point becomes the one under way.
    fn begin(&mut self, mut set_point: SetPoint, context: &mut Context<'_, impl Types>) {
        self.is_recut = false;
        self.head_for(&mut set_point, context);
        self.current = Some(set_point);
        self.progress = Progress::UnderWay;
        if !self.is_held {
            self.start(set_point, context);
        }
    }

    /// The target of a set-point is the one that counts from now on.
    fn head_for(&mut self, set_point: &mut SetPoint, context: &mut Context<'_, impl Types>) {
        let distance = (set_point.target).saturating_sub(context.motor.committed_position());
        self.direction = distance.signum();
        set_point.end_within(*context.travel, self.direction, context.motor.window());
        self.target = set_point.target;
        self.user = Some(set_point.user);
        context.frame.remember(set_point.user, set_point.target);
        self.window = WindowTimer::new();
    }

    /// The set-point under way as it is left for the one that waits: with bit 9 without slowing down more than needed.
    fn blended(&self, mut current: SetPoint, motor: &Motor<impl Actuator>) -> SetPoint {
        if let Some(next) = self.next.filter(|next| next.blends) {
            let distance = next.target.saturating_sub(current.target);
            if distance.signum() == self.direction {
                current.blend(&next, distance.unsigned_abs(), motor.window());
            }
        }
        current
    }

    /// A limit may have changed: it counts for the set-points under way and in the buffer too. What is done stays as it is.
    #[cold]
    #[inline(never)]
    fn look_at_limits(&mut self, context: &mut Context<'_, impl Types>) {
        let is_cut_anew = core::mem::replace(&mut self.travel, *context.travel) != *context.travel;
        let is_under_way = self.progress == Progress::UnderWay;
        let before = (self.current).filter(|_| is_under_way || self.progress == Progress::Passed);
        let mut current = before;
        if let Some(current) = &mut current {
            current.limit_profile(context);
            if is_under_way && is_cut_anew {
                let target = current.target;
                self.aim(current, context, false);
                if current.target != target {
                    self.is_recut = true;
                    self.head_for(current, context);
                }
            }
            current.end_within(*context.travel, self.direction, context.motor.window());
        }
        if let Some(mut next) = self.next {
            next.limit_profile(context);
            if is_cut_anew {
                self.aim(&mut next, context, true);
            }
            self.next = Some(next);
        }
        if is_under_way {
            current = current.map(|current| self.blended(current, context.motor));
        }
        if current != before {
            self.current = current;
            self.starts_anew |= is_under_way;
        }
    }

    /// The target has been passed: the end velocity is kept, within the software limits.
    fn go_beyond(&mut self, context: &mut Context<'_, impl Types>) {
        let Some(set_point) = self.current else {
            return;
        };
        let velocity = set_point.end_velocity.min(set_point.limits.velocity);
        let order = Order {
            asked: set_point.end_velocity.signed(self.direction < 0),
            velocity: velocity.signed(self.direction < 0),
            limits: Limits {
                velocity,
                ..set_point.limits
            },
            travel: context.travel.increments,
            ramps: set_point.ramps,
            quick_stop: context.deceleration(StopRamp::QuickStop),
        };
        self.beyond.follow(order, context);
    }

    /// The halt is over: the set-point under way goes on.
    fn resume(&mut self, context: &mut Context<'_, impl Types>) {
        self.beyond.forget();
        self.go_on(context);
    }

    /// The set-point under way is begun again, from whatever the motor does.
    fn go_on(&mut self, context: &mut Context<'_, impl Types>) {
        if let (Progress::UnderWay, Some(set_point)) = (self.progress, self.current) {
            self.start(set_point, context);
        }
    }

    fn start(&mut self, set_point: SetPoint, context: &mut Context<'_, impl Types>) {
        let starts_anew = core::mem::take(&mut self.starts_anew);
        let is_recut = core::mem::take(&mut self.is_recut);
        self.beyond.forget();
        let quick_stop = context.deceleration(StopRamp::QuickStop);
        let units = context.units();
        let has_start_speed = context.habits().start_speed;
        let motor = &mut *context.motor;
        let asked = Ramp {
            limits: set_point.limits,
            ramps: set_point.ramps,
        };
        motor.expect_acceleration(set_point.limits.acceleration);
        let travel = context.travel.increments;
        let mut before = None;
        let target = Some(set_point.target).filter(|_| set_point.end_velocity == Speed::ZERO);
        if starts_anew && target.is_some() {
            // The motor brakes for its target perhaps: a lower 60C6h is no reason to pass it.
            let around = set_point.around(motor);
            before = Some(braking::between(motor, target, around, asked, 0));
        }
        let ramp = before.map_or(asked, |before| before.ramp);
        let braking = braking::between(motor, target, travel, ramp, quick_stop);
        let braking = before.map_or(braking, |before| braking.after(before));
        self.is_held_back = braking.is_harder;
        let Ramp { limits, ramps } = braking.ramp;
        motor.set_ramps(ramps);
        let SetPoint {
            target,
            end_velocity,
            ..
        } = set_point;
        let is_beyond = braking.passes || set_point.is_passed_by(motor, units);
        let result = if is_recut && set_point.limited.target && is_beyond {
            Err(Refused)
        } else if end_velocity == Speed::ZERO {
            match has_start_speed.then(|| set_point.start_speed()) {
                Some(speed) => motor.move_from_start_speed(target, speed, limits),
                None => motor.move_to(target, limits),
            }
        } else {
            motor.move_through(target, end_velocity, limits)
        };
        if result.is_err() {
            self.progress = Progress::Impossible;
            if !motor.standstill() {
                motor.stop(limits.deceleration);
            }
        }
        braking.taken(motor);
    }

    fn bits(&mut self, context: &Context<'_, impl Types>, taken: bool) -> u16 {
        let limited = self
            .current
            .map_or(Limited::NONE, |set_point| set_point.limited);
        // The window time counts from the tick that takes the set-point on, so the window is looked at there too.
        let reached = self.is_reached(context, limited) && !taken;
        let mut bits = 0;
        if reached {
            bits |= TARGET_REACHED;
        }
        let is_limited = limited.target
            || limited.profile
            || self.is_held_back
            || self.progress == Progress::Impossible
            || self.progress == Progress::Passed && self.beyond.is_limited(context.motor);
        if is_limited {
            bits |= INTERNAL_LIMIT;
        }
        if self.acknowledge {
            bits |= SET_POINT_ACKNOWLEDGE;
        }
        bits
    }

    fn is_reached(&mut self, context: &Context<'_, impl Types>, limited: Limited) -> bool {
        let configuration = context.configuration;
        let window = configuration.position_window;
        let distance = context.position.abs_diff(self.target);
        // Looked at whatever bit 10 says, so that no time counts in which the motor may have been elsewhere.
        let is_inside = self.window.has_held(
            context.now,
            window != WINDOW_OFF && distance <= u64::from(window),
            configuration.position_window_time,
        );
        if context.is_halted() {
            return context.motor.standstill();
        }
        if limited.target || self.progress == Progress::Impossible {
            return false;
        }
        if self.progress == Progress::Passed {
            return true;
        }
        if self
            .current
            .is_some_and(|set_point| set_point.end_velocity != Speed::ZERO)
        {
            return false;
        }
        if window == WINDOW_OFF {
            return self.progress == Progress::Done && !context.motor.is_held_back();
        }
        is_inside
    }
}

/// Where the motor comes to rest, in steps, with the ramps that the set-point would have.
fn rest(context: &Context<'_, impl Types>, deceleration: u32) -> i64 {
    let motor = &context.motor;
    if motor.is_at_rest() || motor.is_stopping() {
        return motor.destination();
    }
    let configuration = context.configuration;
    let deceleration = deceleration.min(configuration.max_deceleration);
    motor.stop_preview(deceleration, configuration.profile.ramps, None)
}

/// How far the motor may go until it stands, in steps: no less than it really is, but for a ramp that is under way.
fn longest_stop(context: &Context<'_, impl Types>, set_point: &SetPoint) -> i64 {
    let velocity = context.motor.committed_velocity().unsigned_abs();
    let deceleration = set_point
        .asked
        .deceleration
        .min(context.configuration.max_deceleration);
    let accelerations = (set_point.asked.acceleration, deceleration);
    let distance = braking::distance(velocity, accelerations, set_point.ramps);
    i64::try_from(distance)
        .unwrap_or(i64::MAX)
        .saturating_add(1)
}

#[cfg(test)]
mod tests;
