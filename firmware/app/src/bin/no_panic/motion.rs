//! Everything `motion` offers: plans, axes, homing, and the pulses on their way to a timer.

use cia402::{RatedMotor, ServoGoal, ServoOrder, ServoPort, ServoReport};
use motion::advanced_timer::{Output, Register, Registers};
use motion::homing::{self, Homing, Method};
use motion::step_interrupt::{Edge, Player, RecordQueue, StepTimer};
use motion::{
    Axis, AxisConfig, Clock, Direction, DriverTiming, Goal, Limits, Plan, Position, PulseSink,
    Ramps, Record, SignedSpeed, Speed, State, Velocity,
};

use super::{any, any_u64, look};

pub fn any_limits() -> Limits {
    Limits {
        velocity: Speed::from_bits(any_u64()),
        acceleration: any(),
        deceleration: any(),
    }
}

fn any_velocity() -> SignedSpeed {
    SignedSpeed::from_bits(any_u64() as i64)
}

pub fn any_config() -> Option<AxisConfig> {
    Some(AxisConfig {
        clock: Clock::new(any())?,
        time_slice: any(),
        timing: any_timing(),
    })
}

pub fn any_timing() -> DriverTiming {
    DriverTiming {
        pulse_high: any(),
        pulse_low: any(),
        direction_setup: any(),
        direction_hold: any(),
    }
}

fn any_ramps() -> Ramps {
    match any() {
        0 => Ramps::Linear,
        1 => Ramps::SinSquared,
        _ => Ramps::MovingAverage(any()),
    }
}

/// A sink that may say anything.
pub struct Sink;

impl PulseSink for Sink {
    fn push(&mut self, record: Record) -> Result<(), Record> {
        look(record.period ^ u32::from(record.repeat) ^ u32::from(record.width));
        look((record.direction == Direction::Forward).into());
        if any() == 0 {
            Ok(())
        } else {
            Err(record)
        }
    }

    fn pending(&self) -> u64 {
        any_u64()
    }

    fn free(&self) -> usize {
        any() as usize
    }
}

impl ServoPort for Sink {
    fn motor(&self) -> RatedMotor {
        RatedMotor {
            current: any(),
            torque: any(),
            inertia: any(),
            counts: any(),
        }
    }

    fn order(&mut self, order: &ServoOrder) {
        look(order.current ^ order.torque as u32 ^ order.max_torque.0 ^ order.max_torque.1);
        if let ServoGoal::Position { counts, part, .. } = order.goal {
            look(counts as u32 ^ part);
        }
    }

    fn report(&self) -> ServoReport {
        ServoReport {
            counts: any_u64() as i64,
            velocity: SignedSpeed::from_bits(any_u64() as i64),
            demand: any() as i32,
            torque: any() as i32,
            current: any() as i32,
            is_limited: any() == 0,
            wants_free: any() == 0,
        }
    }

    fn forget(&mut self) {
        look(0);
    }
}

#[inline(never)]
pub fn axis(axis: &mut Axis) {
    match any() {
        0 => look(axis.move_to(any_u64() as i64, any_limits()).is_ok().into()),
        1 => look(axis.ramp_to(any_velocity(), any_limits()).is_ok().into()),
        2 => look(axis.stop(any()).is_ok().into()),
        3 => look(axis.abort() as u32),
        7 => {
            let end = Speed::from_bits(any_u64());
            let through = axis.move_through(any_u64() as i64, end, any_limits());
            look(through.is_ok().into());
        }
        8 => look(axis.committed_velocity().whole() as u32 + u32::from(axis.is_ending())),
        4 => axis.set_position(any_u64() as i64),
        5 => look(axis.demand(any_u64()).position as u32),
        9 => {
            let to = Position::from_steps(any_u64() as i64);
            look(axis.follow(any_u64(), to).is_ok().into());
        }
        10 => {
            let to = Position::from_steps(any_u64() as i64);
            let velocity = Velocity::from_bits(any_u64() as i64);
            look(axis.follow_smoothly(any_u64(), to, velocity).is_ok().into());
        }
        11 => look(
            axis.follow_velocity(any_u64(), any_velocity())
                .is_ok()
                .into(),
        ),
        12 => axis.set_ramps(any_ramps()),
        6 => look(
            axis.committed_position() as u32 + axis.target() as u32 + u32::from(axis.is_at_rest()),
        ),
        _ => look(axis.advance(&mut Sink).is_ok().into()),
    }
}

#[inline(never)]
pub fn homing(homing: &mut Option<Homing>) {
    let switch = || homing::SwitchState {
        active: any() == 0,
        edge: (any() == 0).then(|| any() as i32),
        pending: (any() == 0).then(|| any() as i32),
    };
    let inputs = homing::Inputs {
        elapsed: any(),
        position: any() as i32,
        standstill: any() == 0,
        halt: any() == 0,
        negative_limit: switch(),
        positive_limit: switch(),
        home: switch(),
        index: (any() == 0).then(|| any() as i32),
        blocked: any() == 0,
    };
    if let Some(homing) = homing {
        if let homing::Outcome::Attained(home) = homing.tick(&inputs) {
            look(home as u32);
        }
        return;
    }
    let settings = homing::Settings {
        turns_at_limit: any() == 0,
        is_direct: any() == 0,
        returns: any() == 0,
        last_move_is_fast: any() == 0,
        other_block_signs: any() == 0,
        home_is_backed_off: any() == 0,
        longest_distance: any(),
        longest_time: any(),
        longest_distance_to_index: any(),
        block_time: any() as u16,
        back_off: any(),
    };
    let fitted = homing::Fitted {
        negative_limit: any() == 0,
        positive_limit: any() == 0,
        home: any() == 0,
        index: any() == 0,
        block: any() == 0,
    };
    *homing = Method::from_code(any() as i8)
        .and_then(|method| Homing::begin(method, settings, fitted, &inputs).ok());
}

/// A timer that may say anything.
pub struct Timer;

impl StepTimer for Timer {
    const FALLING_EDGES: bool = true;

    fn now() -> u32 {
        any()
    }

    fn schedule(&mut self, time: u32, edge: Edge) -> u32 {
        look(time + u32::from(edge == Edge::Rise));
        any()
    }

    fn stop(&mut self) -> bool {
        any() == 0
    }

    fn set_direction(&mut self, direction: Direction) {
        look((direction == Direction::Forward).into());
    }

    fn interrupt() {}
}

fn any_record() -> Record {
    Record {
        period: any(),
        repeat: any() as u16,
        width: any() as u16,
        direction: if any() == 0 {
            Direction::Forward
        } else {
            Direction::Reverse
        },
    }
}

#[inline(never)]
pub fn pulses(queue: &mut RecordQueue<'_, Timer>, player: &mut Player<'_, Timer>) {
    match any() {
        0 => look(queue.push(any_record()).is_ok().into()),
        1 => look(queue.position() as u32 + queue.pending() as u32 + queue.free() as u32),
        2 => queue.drop_all(),
        _ => player.on_interrupt(),
    }
}

/// Registers that show anything.
pub struct AnyRegisters;

impl Registers for AnyRegisters {
    fn write(&mut self, register: Register, value: u32) {
        look(register as u32 ^ value);
    }

    fn read(&self, register: Register) -> u32 {
        any() ^ register as u32
    }

    fn now(&self) -> u32 {
        any()
    }

    fn reset(&mut self) {
        look(any());
    }
}

#[inline(never)]
pub fn timer_pulses(output: &mut Output<'_, AnyRegisters>) {
    match any() {
        0 => look(output.push(any_record()).is_ok().into()),
        1 => output.service(),
        2 => output.drop_all(),
        3 => output.mend(),
        _ => {
            let position = output.position() ^ output.position_at(any());
            look(position as u32 ^ output.pending() as u32 ^ output.free() as u32);
            look(output.is_broken().into());
        }
    }
}

#[inline(never)]
pub fn plan(clock: Clock) {
    let from = State {
        position: Position::from_steps(any_u64() as i64),
        velocity: Velocity::from_speed(clock, any_velocity()),
    };
    let plan = match any() {
        0 => Plan::move_to(clock, any_u64(), from, any_u64() as i64, any_limits()),
        1 => Plan::velocity(clock, any_u64(), from, any_velocity(), any_limits()),
        _ => Ok(Plan::at_rest(any_u64() as i64, any_u64())),
    };
    if let Ok(mut plan) = plan {
        let goal = Goal::Rest(any_u64() as i64);
        let leaves = plan.replan(clock, any_u64(), goal, any_limits(), any_ramps());
        look(leaves.is_ok().into());
        let state = plan.state_at(any_u64());
        look(state.position.whole_steps() as u32 ^ state.velocity.speed(clock).whole() as u32);
        look(
            plan.next_corner(any_u64())
                .map_or(0, |corner| corner as u32),
        );
        look(plan.end().unwrap_or(plan.start()) as u32);
    }
}
