//! Two actuators under the same modes: what a step axis cannot do, and a servo that no mode was written for.

mod servo;

use canopen::{Duration, Instant};
use motion::{AxisConfig, Clock, DriverTiming, Limits, PulseSink, Ramps};

use super::{Actuator, AtPort, Emitter, NotSupported, StepAxis, TORQUE_MODES};
use crate::commands::Commands;
use crate::configuration::Configuration;
use crate::controlword::ControlwordHistory;
use crate::cyclic::{SyncEvent, micros_q16};
use crate::exchange::{Actuals, Exchange};
use crate::objects::Everything;
use crate::state_machine::State;
use crate::statusword::{FOLLOWS, SET_POINT_ACKNOWLEDGE, TARGET_REACHED};
use crate::testing::Player;
use crate::{Drive, DriveConfig, Inputs};
use servo::{Servo, Shaft};

fn step_axis() -> StepAxis {
    refilled_axis(1)
}

/// Of which pulses are committed so often in a tick.
fn refilled_axis(refills: u32) -> StepAxis {
    let config = DriveConfig {
        axis: AxisConfig {
            clock: Clock::new(1_000_000).unwrap(),
            time_slice: 500,
            timing: DriverTiming {
                pulse_high: 2,
                pulse_low: 2,
                direction_setup: 5,
                direction_hold: 5,
            },
        },
        tick: Duration::from_ticks(1_000),
        refills,
    };
    StepAxis::new(config, || Emitter::new(config))
}

/// It was limited for where it was to begin; from where the axis has come to meanwhile it would be faster.
#[test]
fn a_set_point_that_a_refill_has_overtaken_is_too_late() {
    for refills in [0, 1] {
        let (mut axis, mut pulses) = (step_axis(), Player::with_capacity(256));
        let micros = |time: u64| micros_q16(Instant::from_ticks(time));
        axis.observe(micros(0), &pulses);
        axis.follow_velocity(micros(3_000), 1_000.into()).unwrap();
        axis.advance(&mut pulses, false);
        for tick in 1..3 {
            pulses.play(1_000);
            axis.observe(micros(1_000 * tick), &pulses);
            axis.advance(&mut pulses, false);
        }
        // All of it is committed, and a millisecond behind it.
        let path = axis.path_to(micros(6_000));
        assert!(path.left.abs_diff(micros(2_000)) < micros(2));
        for _ in 0..refills {
            pulses.play(100);
            axis.refill(&mut pulses);
        }
        let result = axis.follow_velocity(micros(6_000), 1_000.into());
        assert_eq!(result.is_err(), refills > 0);
        pulses.play(500);
        axis.observe(micros(3_000), &pulses);
        let next = axis.follow_velocity(micros(7_000), 1_000.into());
        assert_eq!(next, Ok(()), "in the next tick there is time");
    }
}

/// A motor that stood begins with the tick; one that moves has its pulses from refills, where there are some.
#[test]
fn a_tick_commits_what_no_refill_does_in_time() {
    for refills in [1, 4] {
        let (mut axis, mut pulses) = (refilled_axis(refills), Player::with_capacity(256));
        let limits = Limits {
            velocity: 10_000.into(),
            acceleration: 100_000,
            deceleration: 100_000,
        };
        let mut tick = |axis: &mut StepAxis, target: Option<i64>| {
            axis.observe(0, &pulses);
            if let Some(target) = target {
                axis.move_to(target, limits, Ramps::Linear).unwrap();
            }
            let before = pulses.pending();
            axis.advance(&mut pulses, false);
            let committed = pulses.pending() - before;
            pulses.play(1_000);
            committed
        };
        assert_eq!(tick(&mut axis, None), 0, "nothing is asked for");
        assert!(tick(&mut axis, Some(1_000)) >= 1_000, "two time slices");
        for target in [None, Some(2_000)] {
            let committed = tick(&mut axis, target);
            assert_eq!(committed > 0, refills == 1, "{committed}");
        }
    }
}

#[test]
fn a_step_axis_has_no_torque() {
    let mut axis = step_axis();
    assert_eq!(<StepAxis as Actuator>::MODES & TORQUE_MODES, 0);
    assert_eq!(axis.torque(), None);
    assert_eq!(axis.hold_torque(100), Err(NotSupported));
    assert!(axis.is_at_rest(), "nothing changes");
}

#[test]
fn a_servo_has_one() {
    let mut servo = Servo::default();
    assert_eq!(<Servo as Actuator>::MODES & TORQUE_MODES, TORQUE_MODES);
    servo.hold_torque(100).unwrap();
    assert_eq!(servo.torque().map(|torque| torque.actual), Some(100));
}

/// A drive whose motor is a servo.
struct Rig {
    drive: Drive<Everything, Servo>,
    shaft: Shaft,
    exchange: Exchange,
    history: ControlwordHistory,
    commands: Commands,
    now: Instant,
}

impl Rig {
    const TICK: Duration = Duration::from_ticks(1_000);

    /// In operation enabled.
    fn enabled(mode: i8) -> Self {
        let mut exchange = Exchange::new();
        exchange.configure(&Configuration {
            position_window: 10,
            velocity_window: 50.into(),
            quick_stop_deceleration: 1_000_000,
            ..Configuration::NONE
        });
        let mut rig = Self {
            drive: Drive::with_actuator(Servo::default, 0, Self::TICK),
            shaft: 0,
            exchange,
            history: ControlwordHistory::new(0),
            commands: Commands {
                remote: true,
                mode,
                profile_velocity: 10_000.into(),
                profile_acceleration: 100_000,
                profile_deceleration: 100_000,
                ..Commands::NONE
            },
            now: Instant::from_ticks(0),
        };
        for controlword in [0x00, 0x06, 0x07, 0x0F] {
            rig.write(controlword);
            rig.ticks(2);
        }
        assert_eq!(rig.drive.state(), State::OperationEnabled);
        // The rotor comes to rest in its field.
        rig.ticks(50);
        rig
    }

    fn write(&mut self, controlword: u16) {
        self.commands.controlword = controlword;
        self.history.write(controlword);
        let passed = self.history.take();
        self.exchange.post(Commands {
            rising: passed.rising,
            stop: passed.stop,
            ..self.commands
        });
    }

    fn ticks(&mut self, count: usize) -> Actuals {
        for _ in 0..count {
            let inputs = Inputs {
                supply: true,
                position: self.shaft,
                position_tolerance: 10,
                ..Inputs::default()
            };
            let (shaft, exchange) = (&mut self.shaft, &mut self.exchange);
            self.drive.tick(self.now, &inputs, shaft, exchange);
            self.now += Self::TICK;
        }
        self.exchange.actuals_at(self.now)
    }

    fn until(&mut self, condition: impl Fn(&Actuals) -> bool) -> Actuals {
        let mut seen = (0..10_000).map(|_| self.ticks(1));
        seen.find(condition).expect("within ten seconds")
    }
}

#[test]
fn profile_position_takes_a_servo_to_its_targets() {
    let mut rig = Rig::enabled(1);
    for target in [8_000, -500, -501] {
        rig.commands.target_position = target;
        rig.write(0x1F);
        let taken = rig.until(|seen| seen.statusword & SET_POINT_ACKNOWLEDGE != 0);
        assert_eq!(taken.statusword & TARGET_REACHED, 0);
        rig.write(0x0F);
        let there = rig.until(|seen| !seen.is_moving);
        assert_eq!((rig.shaft, there.position_actual), (target.into(), target));
        assert_ne!(rig.ticks(1).statusword & TARGET_REACHED, 0);
    }
}

#[test]
fn a_set_point_takes_the_place_of_another_and_halt_stops_the_servo() {
    let mut rig = Rig::enabled(1);
    rig.commands.target_position = 100_000;
    rig.write(0x1F);
    rig.until(|seen| seen.velocity_demand == 10_000);
    rig.write(0x0F);
    rig.ticks(100);
    rig.commands.target_position = 0;
    rig.write(0x3F);
    rig.until(|seen| seen.velocity_demand == -10_000);
    rig.write(0x13F);
    rig.until(|seen| !seen.is_moving);
    assert!(rig.shaft > 0);
    assert_ne!(rig.ticks(1).statusword & TARGET_REACHED, 0);
    rig.write(0x03F);
    rig.until(|seen| seen.position_actual == 0 && !seen.is_moving);
}

#[test]
fn profile_velocity_keeps_the_velocity_of_a_servo() {
    let mut rig = Rig::enabled(3);
    for velocity in [2_000, -3_000] {
        rig.commands.target_velocity = velocity.into();
        rig.write(0x0F);
        rig.until(|seen| seen.velocity_demand == velocity);
        let seen = rig.ticks(50);
        assert!(seen.velocity_actual.abs_diff(velocity) <= 50, "{seen:?}");
        assert_ne!(seen.statusword & TARGET_REACHED, 0);
    }
    rig.write(0x02);
    rig.until(|seen| !seen.is_moving && seen.safe);
    assert_eq!(rig.drive.state(), State::SwitchOnDisabled);
}

#[test]
fn cyclic_position_leads_a_servo_through_its_set_points() {
    let mut rig = Rig::enabled(8);
    // A ramp of 1,000 increments/s² for two seconds, at 2 ms, and the same down.
    let at = |period: i32| match period.min(800) {
        up @ ..400 => up * up / 500,
        down => 640 - (800 - down) * (800 - down) / 500,
    };
    let mut seen = std::vec::Vec::new();
    for period in 0..900 {
        rig.exchange.sync_event(SyncEvent {
            at: rig.now,
            is_sync: true,
            position: Some(at(period)),
            velocity: None,
            torque: None,
        });
        let shown = rig.ticks(2);
        if (100..800).contains(&period) {
            assert_ne!(shown.statusword & FOLLOWS, 0, "{period}");
        }
        seen.push(shown.position_demand);
    }
    assert_eq!(rig.shaft, 640);
    // It is where it should be, always so many periods later.
    let behind = (0..10).find(|periods| {
        (200..800).all(|period: i32| {
            let shown = seen[usize::try_from(period + periods).unwrap()];
            shown.abs_diff(at(period)) <= 2
        })
    });
    assert!(behind.is_some());
}
