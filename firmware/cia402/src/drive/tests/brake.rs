//! The brake: it opens under current, and closes before the current goes.

use crate::configuration::BrakeTimes;
use crate::option_codes::Stop;
use crate::state_machine::State;
use crate::testing::Rig;

/// A drive with a brake that takes 30 ms to open and 50 ms to close, just enabled.
fn enabled() -> Rig {
    let mut rig = Rig::new();
    rig.configuration.brake = BrakeTimes {
        release: 30,
        engage: 50,
        power: 0,
    };
    rig.ticks(2);
    for controlword in [0x06, 0x07, 0x0F] {
        rig.write(controlword);
        rig.tick();
    }
    assert_eq!(
        rig.state(),
        State::OperationEnabled,
        "transition 4 waits for nothing"
    );
    assert!(rig.outputs.power_stage && rig.outputs.brake_released);
    rig
}

#[test]
fn the_brake_opens_when_the_current_has_flowed_for_its_time() {
    let mut rig = Rig::new();
    rig.configuration.brake.power = 40;
    rig.ticks(2);
    for controlword in [0x06, 0x07, 0x0F] {
        rig.write(controlword);
        rig.tick();
    }
    assert!(rig.outputs.power_stage && !rig.outputs.brake_released);
    let ticks = rig.until("open", |rig| rig.outputs.brake_released);
    assert!((39..=41).contains(&ticks), "{ticks}");
    // Power that comes anew has its time anew.
    rig.write(0x00);
    rig.ticks(3);
    assert!(!rig.outputs.power_stage && !rig.outputs.brake_released);
}

#[test]
fn a_set_point_waits_until_the_brake_is_open() {
    let mut rig = enabled();
    rig.set_point(1_000, 0);
    rig.tick();
    assert!(rig.acknowledged() && !rig.reached());
    rig.write(0x0F);
    rig.ticks(25);
    assert_eq!(rig.motor.position, 0);
    assert!(!rig.reached());
    rig.ticks(40);
    assert_eq!(rig.rest(), 1_000);
}

#[test]
fn a_velocity_waits_until_the_brake_is_open() {
    for mode in [2, 3] {
        let mut rig = enabled();
        rig.commands.mode = mode;
        rig.commands.target_velocity = 1_000.into();
        rig.commands.vl_target_velocity = 1_000;
        rig.configuration.velocity.acceleration = 100_000;
        rig.write(0x7F);
        rig.ticks(25);
        assert_eq!(rig.motor.position, 0);
        rig.ticks(40);
        assert_eq!(rig.speed(), 1, "mode {mode}");
    }
}

#[test]
fn m05_the_current_stays_until_the_brake_has_closed() {
    for (controlword, end) in [
        (0x07, State::SwitchedOn),
        (0x06, State::ReadyToSwitchOn),
        (0x02, State::SwitchOnDisabled),
    ] {
        let mut rig = enabled();
        rig.configuration.shutdown = Stop::on_leaving(1).unwrap();
        rig.ticks(40);
        rig.write(controlword);
        rig.ticks(2);
        assert!(!rig.outputs.brake_released && rig.outputs.power_stage);
        let ticks = rig.until("end", |rig| rig.state() == end);
        assert!((48..=51).contains(&ticks), "{ticks}");
        assert!(!rig.outputs.power_stage);
    }
}

#[test]
fn m10_the_brake_holds_the_motor_before_a_fault_takes_the_current() {
    let mut rig = enabled();
    rig.ticks(40);
    rig.fault = Some(0x4210);
    rig.ticks(2);
    assert_eq!(rig.state(), State::FaultReactionActive);
    assert!(!rig.outputs.brake_released && rig.outputs.power_stage);
    rig.ticks(52);
    assert_eq!(rig.state(), State::Fault);
    assert!(!rig.outputs.power_stage);
}

#[test]
fn enabled_again_while_the_brake_closes_it_opens_again() {
    let mut rig = enabled();
    rig.ticks(40);
    rig.write(0x07);
    rig.ticks(20);
    rig.write(0x0F);
    rig.tick();
    assert!(rig.outputs.brake_released && rig.outputs.power_stage);
    rig.ticks(100);
    assert_eq!(rig.state(), State::OperationEnabled);
}

#[test]
fn m04_where_the_current_goes_at_once_the_brake_falls_with_it() {
    let mut rig = enabled();
    rig.ticks(40);
    rig.write(0x00);
    rig.tick();
    assert!(!rig.outputs.brake_released && !rig.outputs.power_stage);
}

/// Writes 60FEh. Bit 0 is the brake: 1 closes it.
fn write_outputs(rig: &mut Rig, value: u32, mask: u32) {
    rig.configuration.outputs.is_brake_manual = true;
    rig.commands.digital_outputs = value;
    rig.commands.digital_outputs_mask = mask;
    rig.commands.outputs_written = true;
    rig.post();
    rig.tick();
}

#[test]
fn m71_a_brake_that_60feh_opens_takes_its_time_too() {
    for (value, mask) in [(0, 1), (1, 0)] {
        let mut rig = enabled();
        rig.ticks(1_000);
        write_outputs(&mut rig, 1, 1);
        assert!(!rig.outputs.brake_released);
        rig.set_point(1_000, 0);
        rig.ticks(10);
        write_outputs(&mut rig, value, mask);
        assert!(rig.outputs.brake_released);
        rig.ticks(25);
        assert_eq!(rig.motor.position, 0, "2040h:1 counts from its opening");
        rig.ticks(40);
        assert_eq!(rig.rest(), 1_000);
    }
}

#[test]
fn m71_60feh_closes_the_brake_on_a_motor_that_stands() {
    let mut rig = enabled();
    rig.ticks(40);
    rig.set_point(2_000, 0);
    rig.ticks(100);
    assert!(rig.speed() > 0);
    write_outputs(&mut rig, 1, 1);
    assert!(rig.outputs.brake_released, "the motor turns");
    rig.until("closed", |rig| !rig.outputs.brake_released);
    let position = rig.motor.position;
    rig.ticks(100);
    assert_eq!(rig.motor.position, position);
    assert!(position < 2_000, "the motion waits");
    write_outputs(&mut rig, 0, 1);
    rig.ticks(40);
    assert_eq!(rig.rest(), 2_000);
}

#[test]
fn m71_where_the_current_goes_at_once_the_brake_that_60feh_closes_does_not_wait() {
    let mut rig = enabled();
    rig.ticks(40);
    rig.set_point(2_000, 0);
    rig.ticks(100);
    write_outputs(&mut rig, 1, 1);
    rig.write(0x00);
    rig.tick();
    assert!(!rig.outputs.brake_released && !rig.outputs.power_stage);
}
