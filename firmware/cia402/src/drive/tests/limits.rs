//! Limit switches that become active while the motor stops, or turns round, for another reason.

use crate::configuration::VelocityConfiguration;
use crate::inputs::InputConfiguration;
use crate::mode::Mode;
use crate::option_codes::{AbortConnectionOption, Stop};
use crate::state_machine::State;
use crate::testing::{Rig, quick_stop};

/// Input 2 is the negative limit switch, 3 the positive one.
const POSITIVE: u8 = 4;

/// 30,000 steps/s, on 100,000 steps/s² 4,500 steps to rest and on 1,000,000 steps/s² 450; 90 are under way.
const QUICK: i64 = 600;

/// A drive that cruises at 30 steps a tick.
fn cruising(mode: Mode) -> Rig {
    let mut rig = Rig::new();
    rig.configuration.inputs = InputConfiguration {
        negative_limit: 2,
        positive_limit: 4,
        ..InputConfiguration::NONE
    };
    rig.configuration.velocity = VelocityConfiguration {
        acceleration: 100_000,
        deceleration: 100_000,
        quick_stop: 1_000_000,
        ..VelocityConfiguration::NONE
    };
    rig.commands.mode = mode.code();
    rig.commands.profile_velocity = 30_000.into();
    rig.enable();
    go(&mut rig, mode, 1);
    rig.ticks(400);
    assert_eq!(rig.speed(), 30);
    rig
}

fn go(rig: &mut Rig, mode: Mode, sign: i16) {
    match mode {
        Mode::Velocity => rig.commands.vl_target_velocity = 30_000 * sign,
        _ => rig.commands.target_velocity = (30_000 * i32::from(sign)).into(),
    }
    if mode == Mode::ProfilePosition {
        rig.set_point(1_000_000 * i32::from(sign), 0x20);
    } else {
        rig.write(0x7F);
    }
}

/// How much farther the motor goes before it stands or turns round.
fn overrun(rig: &mut Rig) -> i64 {
    let begin = rig.motor.position;
    while rig.speed() > 0 {}
    rig.motor.position - begin
}

#[test]
fn d31_a_command_away_from_a_limit_switch_makes_its_stop_no_gentler() {
    for mode in [Mode::ProfilePosition, Mode::ProfileVelocity, Mode::Velocity] {
        let mut rig = cruising(mode);
        rig.digital.levels = POSITIVE;
        rig.ticks(2);
        go(&mut rig, mode, -1);
        let distance = overrun(&mut rig);
        assert!(
            distance < QUICK,
            "{mode:?}: {distance} steps into the end stop"
        );
        rig.ticks(50);
        assert!(rig.speed() < 0, "{mode:?}: the way back is free");
    }
}

#[test]
fn m54_a_limit_switch_hardens_every_stop_that_leaves_operation() {
    type Leave = fn(&mut Rig);
    let ways: [(&str, Leave); 6] = [
        ("605Ch = 1", |rig| rig.write(0x07)),
        ("605Bh = 1", |rig| rig.write(0x06)),
        ("605Ah = 1", |rig| rig.write(0x02)),
        ("605Ah = 5", |rig| {
            rig.configuration.quick_stop = quick_stop(5);
            rig.write(0x02);
        }),
        ("605Eh = 1", |rig| rig.fault = Some(0x4210)),
        ("6007h = 1", |rig| {
            rig.commands.remote = false;
            rig.commands.connection_error = Some(0x8130);
            rig.post();
        }),
    ];
    for (what, leave) in ways {
        let mut rig = cruising(Mode::ProfilePosition);
        rig.configuration.quick_stop = quick_stop(1);
        rig.configuration.shutdown = Stop::on_leaving(1).unwrap();
        rig.configuration.fault_reaction = Stop::on_fault(1).unwrap();
        rig.configuration.abort_connection = AbortConnectionOption::FaultSignal;
        leave(&mut rig);
        rig.tick();
        assert!(rig.outputs.power_stage, "{what}");
        rig.digital.levels = POSITIVE;
        rig.tick();
        assert!(rig.limited(), "{what}: bit 11");
        let distance = overrun(&mut rig);
        assert!(
            distance < QUICK,
            "{what}: {distance} steps into the end stop"
        );
    }
}

#[test]
fn a_limit_switch_makes_no_stop_gentler() {
    let mut rig = cruising(Mode::ProfilePosition);
    rig.configuration.quick_stop_deceleration = 100_000;
    rig.commands.profile_deceleration = 1_000_000;
    rig.write(0x07);
    rig.tick();
    rig.digital.levels = POSITIVE;
    rig.tick();
    let distance = overrun(&mut rig);
    assert!(distance < QUICK, "{distance} steps");
}

#[test]
fn a_limit_switch_that_homing_looked_for_stops_it_once_it_is_left() {
    let mut rig = cruising(Mode::ProfilePosition);
    rig.configuration.homing.method = 18;
    rig.configuration.homing.search_speed = 30_000.into();
    rig.configuration.homing.zero_speed = 1_000.into();
    rig.configuration.homing.acceleration = 100_000;
    rig.write(0x10F);
    rig.rest();
    rig.commands.mode = Mode::Homing.code();
    rig.write(0x0F);
    rig.ticks(2);
    rig.write(0x1F);
    rig.ticks(400);
    assert_eq!(rig.speed(), 30);
    rig.write(0x07);
    rig.tick();
    rig.digital.levels = POSITIVE;
    let distance = overrun(&mut rig);
    assert!(distance < QUICK, "{distance} steps");
}

#[test]
fn m10_a_fault_makes_a_quick_stop_no_gentler() {
    let mut rig = cruising(Mode::ProfilePosition);
    rig.configuration.fault_reaction = Stop::on_fault(1).unwrap();
    rig.configuration.quick_stop = quick_stop(2);
    rig.write(0x02);
    rig.tick();
    rig.fault = Some(0x4210);
    rig.tick();
    assert_eq!(rig.state(), State::FaultReactionActive);
    let distance = overrun(&mut rig);
    assert!(distance < QUICK, "{distance} steps");
}

#[test]
fn a_halt_after_a_command_away_from_a_limit_switch_is_not_lost() {
    let mut rig = cruising(Mode::ProfilePosition);
    rig.digital.levels = POSITIVE;
    rig.ticks(2);
    go(&mut rig, Mode::ProfilePosition, -1);
    rig.ticks(2);
    rig.write(0x13F);
    let distance = overrun(&mut rig);
    assert!(distance < QUICK, "{distance} steps");
    rig.ticks(50);
    assert_eq!(rig.speed(), 0, "it is halted");
}

fn keep(rig: &mut Rig, mode: Mode, velocity: i16) {
    match mode {
        Mode::Velocity => rig.commands.vl_target_velocity = velocity,
        _ => rig.commands.target_velocity = i32::from(velocity).into(),
    }
    rig.post();
}

#[test]
fn a_velocity_that_a_limit_switch_ended_is_not_taken_up_by_itself() {
    for mode in [Mode::ProfileVelocity, Mode::Velocity] {
        let mut rig = cruising(mode);
        rig.digital.levels = POSITIVE;
        rig.ticks(200);
        assert!(rig.limited(), "{mode:?}");
        // The switch is released by hand.
        rig.digital.levels = 0;
        rig.ticks(50);
        assert!(rig.speed() == 0 && rig.limited(), "{mode:?}");
        rig.commands.profile_acceleration = 200_000;
        rig.configuration.velocity.acceleration = 200_000;
        rig.post();
        rig.ticks(50);
        assert!(rig.speed() == 0 && rig.limited(), "{mode:?}: a ramp");
        // 607Fh; 6046h and 604Ch.
        let before = rig.configuration;
        rig.configuration.max_velocity = 500.into();
        rig.configuration.velocity.max_amount = 400;
        rig.configuration.velocity.dimension = (1, 2);
        rig.post();
        rig.ticks(50);
        assert!(rig.speed() == 0 && rig.limited(), "{mode:?}: a limit");
        rig.configuration = before;
        rig.post();
        rig.ticks(50);
        assert!(rig.speed() == 0 && rig.limited(), "{mode:?}: no limit");
        rig.digital.levels = POSITIVE;
        rig.tick();
        keep(&mut rig, mode, 4_000);
        rig.ticks(50);
        rig.digital.levels = 0;
        rig.ticks(50);
        assert!(rig.speed() == 0 && rig.limited(), "{mode:?}: too early");
        keep(&mut rig, mode, 5_000);
        rig.ticks(100);
        assert!(rig.speed() == 5 && !rig.limited(), "{mode:?}");
    }
}

#[test]
fn a_limit_switch_met_while_turning_round_does_not_end_the_way_back() {
    for mode in [Mode::ProfilePosition, Mode::ProfileVelocity, Mode::Velocity] {
        let mut rig = cruising(mode);
        go(&mut rig, mode, -1);
        rig.ticks(20);
        rig.digital.levels = POSITIVE;
        let distance = overrun(&mut rig);
        assert!(distance < QUICK, "{mode:?}: {distance} steps");
        rig.ticks(50);
        assert!(rig.speed() < 0, "{mode:?}");
    }
}

#[test]
fn a_set_point_behind_a_limit_switch_is_reached_and_so_is_the_one_that_waits() {
    let mut rig = cruising(Mode::ProfilePosition);
    rig.set_point(-5_000, 0x20);
    rig.ticks(20);
    rig.set_point(-6_000, 0);
    rig.tick();
    rig.digital.levels = POSITIVE;
    rig.tick();
    assert!(rig.limited());
    let distance = overrun(&mut rig);
    assert!(distance < QUICK, "{distance} steps");
    rig.until("motion", |rig| rig.actuals().velocity_demand < -1_000);
    rig.digital.levels = 0;
    rig.until("the first target", |rig| rig.motor.position == -5_000);
    rig.until("the second target", |rig| rig.motor.position == -6_000);
    rig.ticks(20);
    assert!(rig.reached() && !rig.limited());
}

#[test]
fn a_set_point_beyond_a_limit_switch_is_given_up() {
    let mut rig = cruising(Mode::ProfilePosition);
    rig.digital.levels = POSITIVE;
    rig.ticks(100);
    rig.digital.levels = 0;
    rig.ticks(50);
    assert!(rig.speed() == 0 && rig.limited() && !rig.reached());
}
