//! Profile position, mode 1 (CiA 402-2): the motor goes to set-points, each with its own velocity and ramps.
//!
//! A rising edge of controlword bit 4 hands over a set-point: 607Ah, 6081h, 6083h and 6084h as they are at that moment
//! (a later write counts for the next one). Bit 12 of the statusword acknowledges it and falls when bit 4 has fallen
//! and there is room for another.
//! - Bit 5 = 1: it replaces whatever is going on, smoothly. Bit 5 = 0: it waits until the one under way is done; one can
//!   wait, and bit 12 stays 1 meanwhile. One more is not taken.
//! - Bit 6 = 1: 607Ah counts from the previous target as it was carried out (60F2h = 0); after enabling, from where the
//!   motor stands.
//! - Edges count while the mode is at work only. Bit 4 that rises with the controlword that enables, or with the change
//!   of the mode, hands over nothing.
//! - Halt (bit 8) stops on the ramp of 605Dh and keeps the target; releasing it goes on. Set-points are taken but not started.
//! - A target outside 607Dh, or outside 32 bits, is cut to the limit; bit 11 shows it and bit 10 stays 0. The limits are off
//!   while the minimum is not below the maximum.
//! - A velocity above 607Fh, 6080h or what the pulses can reach, a ramp above 60C5h or 60C6h is cut (bit 11). A set-point that cannot be carried out (6081h = 0) is taken and
//!   acknowledged, the motor stops or stays, bit 10 stays 0 and bit 11 is 1; the next set-point replaces it at once.
//!
//! Bit 10, target reached: 0 in the tick that takes a set-point, even one that ends where the motor stands; then 1 as soon
//! as 6064h has been within 6067h of the target for 6068h. With 6067h = FFFFFFFFh it is 1 when the profile has ended.
//! During halt it says that the motor stands.

use motion::Limits;

use super::Context;
use crate::controlword::{CHANGE_IMMEDIATELY, NEW_SET_POINT, RELATIVE};
use crate::dwell::Dwell;
use crate::motor::Motor;
use crate::statusword::{INTERNAL_LIMIT, SET_POINT_ACKNOWLEDGE, TARGET_REACHED};

/// 6067h: the window is not looked at.
const WINDOW_OFF: u32 = u32::MAX;

/// A target with its profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct SetPoint {
    target: i64,
    limits: Limits,
    /// The target or the velocity is not what the master asked for.
    limited: Limited,
}

/// Which part of a set-point was cut to a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Limited {
    target: bool,
    profile: bool,
}

/// How far a set-point has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Progress {
    /// The motor is on its way (or halted on it).
    UnderWay,
    /// The profile has ended. So it is before the first set-point.
    Done,
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
    /// The target that relative ones count from, and that bit 10 means.
    target: i64,
    acknowledge: bool,
    halted: bool,
    /// The mode began in this tick: an edge of bit 4 is older than it.
    begins: bool,
    window: Dwell,
}

impl ProfilePosition {
    pub(super) const fn new() -> Self {
        Self {
            current: None,
            progress: Progress::Done,
            next: None,
            target: 0,
            acknowledge: false,
            halted: false,
            begins: true,
            window: Dwell::new(),
        }
    }

    /// The mode begins: no set-point, no acknowledge, the target is where the motor stands (or comes to rest).
    pub(super) fn enter(&mut self, motor: &Motor) {
        *self = Self::new();
        self.target = motor.destination();
    }

    /// One control tick; returns statusword bits 10 to 12.
    pub(super) fn tick(&mut self, context: &mut Context<'_>) -> u16 {
        let controlword = context.commands.controlword;
        let was_halted = self.halted;
        self.halted = context.is_halted();

        if self.progress == Progress::UnderWay && !was_halted && context.motor.standstill() {
            self.progress = Progress::Done;
        }
        if self.progress != Progress::UnderWay
            && let Some(next) = self.next.take()
        {
            self.begin(next, context);
        }
        let edge = context.commands.rising & NEW_SET_POINT != 0 && !self.begins;
        self.begins = false;
        let taken = edge && self.take(context);
        match (was_halted, self.halted) {
            (false, true) => context.halt(),
            (true, false) => self.resume(context),
            _ => {}
        }

        if taken {
            self.acknowledge = true;
        } else if controlword & NEW_SET_POINT == 0 && self.next.is_none() {
            self.acknowledge = false;
        }
        self.bits(context, taken)
    }

    /// Takes the set-point in the commands, if there is room. Returns whether it did.
    fn take(&mut self, context: &mut Context<'_>) -> bool {
        let set_point = self.read(context);
        let immediately = context.commands.controlword & CHANGE_IMMEDIATELY != 0;
        if immediately || self.progress != Progress::UnderWay {
            self.next = None;
            self.begin(set_point, context);
        } else if self.next.is_none() {
            self.next = Some(set_point);
        } else {
            return false;
        }
        true
    }

    /// The set-point in the commands, within all limits.
    fn read(&self, context: &Context<'_>) -> SetPoint {
        let commands = context.commands;
        let asked = i64::from(commands.target_position);
        let wanted = if commands.controlword & RELATIVE != 0 {
            self.target.saturating_add(asked)
        } else {
            asked
        };
        let (low, high) = context.travel;
        let low = low.max(i64::from(i32::MIN));
        let high = high.min(i64::from(i32::MAX));
        let target = wanted.max(low).min(high);
        let (limits, is_cut) = context.limits(commands.profile_velocity);
        SetPoint {
            target,
            limits,
            limited: Limited {
                target: target != wanted,
                profile: is_cut,
            },
        }
    }

    /// A set-point becomes the one under way.
    fn begin(&mut self, set_point: SetPoint, context: &mut Context<'_>) {
        self.current = Some(set_point);
        self.target = set_point.target;
        self.progress = Progress::UnderWay;
        self.window = Dwell::new();
        if !self.halted {
            self.start(set_point, context.motor);
        }
    }

    /// The halt is over: the set-point under way goes on.
    fn resume(&mut self, context: &mut Context<'_>) {
        if let (Progress::UnderWay, Some(set_point)) = (self.progress, self.current) {
            self.start(set_point, context.motor);
        }
    }

    fn start(&mut self, set_point: SetPoint, motor: &mut Motor) {
        if motor.move_to(set_point.target, set_point.limits).is_err() {
            self.progress = Progress::Impossible;
            if !motor.standstill() {
                motor.stop(set_point.limits.deceleration);
            }
        }
    }

    fn bits(&mut self, context: &Context<'_>, taken: bool) -> u16 {
        let limited = self
            .current
            .map_or(Limited::NONE, |set_point| set_point.limited);
        // The window time counts from the tick that takes the set-point on, so the window is looked at there too.
        let reached = self.is_reached(context, limited) && !taken;
        let mut bits = 0;
        if reached {
            bits |= TARGET_REACHED;
        }
        if limited.target || limited.profile || self.progress == Progress::Impossible {
            bits |= INTERNAL_LIMIT;
        }
        if self.acknowledge {
            bits |= SET_POINT_ACKNOWLEDGE;
        }
        bits
    }

    fn is_reached(&mut self, context: &Context<'_>, limited: Limited) -> bool {
        let configuration = context.configuration;
        if self.halted {
            return context.motor.standstill();
        }
        if limited.target || self.progress == Progress::Impossible {
            return false;
        }
        if configuration.position_window == WINDOW_OFF {
            return self.progress == Progress::Done;
        }
        let distance = distance(context.position, self.target);
        self.window.has_held(
            context.now,
            distance <= u64::from(configuration.position_window),
            configuration.position_window_time,
        )
    }
}

/// How far apart two positions are, modulo 2³² as they are shown.
fn distance(position: i64, target: i64) -> u64 {
    u64::from((position.wrapping_sub(target) as i32).unsigned_abs())
}

impl Limited {
    const NONE: Self = Self {
        target: false,
        profile: false,
    };
}

#[cfg(test)]
mod tests;
