//! Homing, mode 6 (CiA 402-2): the motor finds the home position, and positions count from there.
//!
//! A rising edge of controlword bit 4 begins with method 6098h, speeds 6099h, acceleration 609Ah, home offset 607Ch and the options
//! 2030h as they are at that moment; a later write counts for the next time. How the methods go is in [`motion::homing`].
//! - Afterwards 6064h is 607Ch at the home position; the motor has stopped a little behind it.
//! - Bit 4 that falls interrupts: the motor slows down with 609Ah, at most 60C6h, and what was known of the home position before
//!   is still known. So it is after a failure. On the way back to the home position that is already known anew.
//! - Halt (bit 8) slows down with 609Ah; releasing it goes on.
//! - 607Fh, 6080h, 60C5h and 60C6h hold here too; bit 11 is 1 while one of them cuts the motion under way. Software limits do not: homing
//!   gives them their places.
//! - Edges count while the mode is at work only, as in profile position. Nothing begins without operation enabled.
//! - A method that is not supported, or needs a switch that no input is for, fails at once and moves nothing. 2034h:2 tells why
//!   homing failed.
//!
//! | | bit 13 | bit 12 | bit 10 |
//! |---|---|---|---|
//! | not begun, interrupted | 0 | 0 | 1 at rest |
//! | home position known from before, when the mode is entered | 0 | 1 | 1 at rest |
//! | from the tick that takes the edge | 0 | 0 | 0; during halt 1 at rest |
//! | attained | 0 | 1 | 1 at rest, and not while a limit of the torque keeps the motor from there |
//! | failed | 1 | 0 | 1 at rest |

use motion::homing::{self as engine, Failure, Fitted, Inputs, Method, Order, Outcome};
use motion::{Direction, Limits, Speed, low};

use super::{Context, Types};
use crate::actuator::{Actuator, Refused};
use crate::configuration::HomingConfiguration;
use crate::controlword::NEW_SET_POINT;
use crate::inputs::InputConfiguration;
use crate::statusword::{HOMING_ATTAINED, HOMING_ERROR, INTERNAL_LIMIT, TARGET_REACHED};

/// 2034h:2 while homing has not failed.
pub(super) const NO_FAILURE: u8 = 0;
/// 2034h:2: 6098h is no method, or a speed or the acceleration is 0.
const NO_METHOD: u8 = 7;

/// 2034h:2.
const fn code(failure: Failure) -> u8 {
    match failure {
        Failure::NotFitted => 1,
        Failure::Limit => 2,
        Failure::BothLimits => 3,
        Failure::TooLong => 4,
        Failure::NoIndex => 5,
        Failure::TooNarrow => 6,
    }
}

/// How far it has come.
#[derive(Debug)]
enum Progress {
    /// Not begun, or interrupted.
    Idle,
    UnderWay(Search),
    Attained,
    Failed,
}

/// Homing under way, with the configuration it began with.
#[derive(Debug)]
struct Search {
    engine: engine::Homing,
    configuration: HomingConfiguration,
    /// What the master's count has beyond the engine's, modulo 2³²: home has its name before the motor drives back to it, while
    /// the engine goes on in the count in which it found home.
    shift: i32,
    /// The motion under way is slower, or gentler, than 6099h and 609Ah ask for.
    is_limited: bool,
}

impl Search {
    /// From now on the engine's position `home` has its name.
    fn set_home(&mut self, context: &mut Context<'_, impl Types>, home: i32) {
        let method = Method::from_code(self.configuration.method);
        if self.configuration.keeps_count() && !method.is_some_and(Method::is_immediate) {
            let from = context.position;
            let known_as = home.wrapping_add(self.shift);
            let away = known_as.wrapping_sub(low::i32(from));
            context
                .motor
                .set_home(from, known_as, from.wrapping_add(away.into()));
            return;
        }
        let user = self.configuration.position_at_home();
        let name = context.units().position(user.into());
        let known_as = home.wrapping_add(self.shift);
        let change = context.motor.set_home(context.position, known_as, name);
        context.frame.found_home(user, name);
        context.position = context.position.wrapping_add(change);
        self.shift = self.shift.wrapping_add(low::i32(change));
    }
}

/// The mode.
#[derive(Debug)]
pub(super) struct Homing {
    progress: Progress,
    failure: u8,
    /// The mode began in this tick: an edge of bit 4 is older than it.
    begins: bool,
}

impl Homing {
    /// The mode, that failed last for this reason.
    pub(super) const fn new(failure: u8) -> Self {
        Self {
            progress: Progress::Idle,
            failure,
            begins: true,
        }
    }

    /// The mode begins.
    pub(super) fn enter(&mut self) {
        self.progress = Progress::Idle;
        self.begins = true;
    }

    pub(super) const fn is_under_way(&self) -> bool {
        matches!(self.progress, Progress::UnderWay(_))
    }

    /// 2034h:2.
    pub(super) const fn failure(&self) -> u8 {
        self.failure
    }

    /// One control tick; returns statusword bits 10 to 13.
    #[inline(never)]
    pub(super) fn tick(&mut self, context: &mut Context<'_, impl Types>) -> u16 {
        let begins = core::mem::replace(&mut self.begins, false);
        if begins && context.motor.is_referenced() && !context.configuration.homing.starts_afresh()
        {
            self.progress = Progress::Attained;
        }
        let is_asked = context.commands.controlword & NEW_SET_POINT != 0;
        let edge = context.commands.rising & NEW_SET_POINT != 0 && !begins;
        if self.is_under_way() {
            if !is_asked {
                self.interrupt(context);
            } else if !context.is_early || context.is_held() {
                // A halt does not wait for the regular ticks, and everything else goes by them: when the motor stands, too.
                self.go_on(context);
            }
        } else if edge {
            self.begin(context);
            // Even what is done at once is seen to begin.
            return self.bits(context) & HOMING_ERROR;
        }
        self.bits(context)
    }

    fn begin(&mut self, context: &Context<'_, impl Types>) {
        self.failure = NO_FAILURE;
        let configuration = context.configuration.homing;
        let method = Method::from_code(configuration.method).filter(|method| {
            method.is_immediate()
                || configuration.search_speed != Speed::ZERO
                    && configuration.zero_speed != Speed::ZERO
                    && configuration.acceleration > 0
        });
        let Some(method) = method else {
            return self.fail(NO_METHOD);
        };
        let fitted = fitted(&context.configuration.inputs, context.blocked.is_some());
        match engine::Homing::begin(
            method,
            configuration.settings(),
            fitted,
            &inputs(context, 0),
        ) {
            Ok(engine) => {
                self.progress = Progress::UnderWay(Search {
                    engine,
                    configuration,
                    shift: 0,
                    is_limited: false,
                });
            }
            Err(failure) => self.fail(code(failure)),
        }
    }

    #[inline(never)]
    fn go_on(&mut self, context: &mut Context<'_, impl Types>) {
        let Progress::UnderWay(search) = &mut self.progress else {
            return;
        };
        match search.engine.tick(&inputs(context, search.shift)) {
            Outcome::UnderWay(order) => {
                if carry_out(order, search, context).is_err() {
                    self.interrupt(context);
                    self.fail(NO_METHOD);
                }
            }
            Outcome::Attained(home) => {
                search.set_home(context, home);
                self.progress = Progress::Attained;
            }
            Outcome::Failed(failure) => {
                self.interrupt(context);
                self.fail(code(failure));
            }
        }
    }

    /// Gives up what is under way.
    fn interrupt(&mut self, context: &mut Context<'_, impl Types>) {
        if let Progress::UnderWay(search) = &self.progress
            && !context.motor.standstill()
        {
            let max = context.configuration.max_deceleration;
            context
                .motor
                .stop(search.configuration.acceleration.min(max));
        }
        self.progress = Progress::Idle;
    }

    fn fail(&mut self, failure: u8) {
        self.failure = failure;
        self.progress = Progress::Failed;
    }

    fn bits(&self, context: &Context<'_, impl Types>) -> u16 {
        let at_rest = if context.motor.standstill() {
            TARGET_REACHED
        } else {
            0
        };
        match &self.progress {
            Progress::Idle => at_rest,
            Progress::UnderWay(search) => {
                let bits = if context.is_halted() { at_rest } else { 0 };
                if search.is_limited {
                    bits | INTERNAL_LIMIT
                } else {
                    bits
                }
            }
            Progress::Attained if context.motor.is_held_back() => HOMING_ATTAINED,
            Progress::Attained => HOMING_ATTAINED | at_rest,
            Progress::Failed => HOMING_ERROR | at_rest,
        }
    }
}

/// What the engine is told, where the master's count has `shift` beyond its own.
fn inputs(context: &Context<'_, impl Types>, shift: i32) -> Inputs {
    Inputs {
        elapsed: context.elapsed,
        position: low::i32(context.position).wrapping_sub(shift),
        standstill: context.motor.standstill(),
        halt: context.is_held(),
        negative_limit: context.switches.negative_limit.state,
        positive_limit: context.switches.positive_limit.state,
        home: context.switches.home.state,
        index: context.switches.index,
        blocked: context.blocked == Some(true),
    }
}

const fn fitted(inputs: &InputConfiguration, block: bool) -> Fitted {
    Fitted {
        negative_limit: inputs.negative_limit != 0,
        positive_limit: inputs.positive_limit != 0,
        home: inputs.home != 0,
        index: inputs.index != 0,
        block,
    }
}

/// What the engine wants.
fn carry_out(
    order: Order,
    search: &mut Search,
    context: &mut Context<'_, impl Types>,
) -> Result<(), Refused> {
    let configuration = search.configuration;
    // A motion that has ended is cut no longer.
    search.is_limited &= !context.motor.standstill();
    let mut within = |velocity: Speed| {
        let (limits, is_cut) = context.within(Limits {
            velocity,
            acceleration: configuration.acceleration,
            deceleration: configuration.acceleration,
        });
        search.is_limited = is_cut;
        limits
    };
    match order {
        Order::GoOn => {}
        Order::Run(direction, speed) => {
            let speed = match speed {
                engine::Speed::Search => configuration.search_speed,
                engine::Speed::Zero => configuration.zero_speed,
            };
            let velocity = speed.signed(direction == Direction::Reverse);
            let limits = within(speed);
            return context.motor.ramp_to(velocity, limits);
        }
        Order::Stop => {
            if !context.motor.standstill() {
                let max = context.configuration.max_deceleration;
                search.is_limited = configuration.acceleration > max;
                context.motor.stop(configuration.acceleration.min(max));
            }
        }
        Order::Go(target) | Order::Return(target) => {
            let limits = within(configuration.zero_speed);
            if let Order::Return(home) = order {
                search.set_home(context, home);
            }
            // The short way.
            let from = context.position;
            let distance = target
                .wrapping_add(search.shift)
                .wrapping_sub(low::i32(from));
            let target = from.saturating_add(distance.into());
            return context.motor.move_to(target, limits);
        }
        Order::CutOff => context.motor.cut_off(),
    }
    Ok(())
}

#[cfg(test)]
mod tests;
