//! The option codes 605Bh to 605Eh and 6007h: each value with its ramp.
//!
//! The motor cruises at 10,000 steps/s. The slow down ramp takes 500 steps, the quick stop ramp 50; the two segments that are
//! committed already come on top.

use crate::faults::UNDER_VOLTAGE;
use crate::option_codes::{AbortConnectionOption, Stop, StopRamp};
use crate::state_machine::State;
use crate::statusword;
use crate::testing::Rig;

const SLOW_DOWN: std::ops::Range<i64> = 500..540;
const QUICK_STOP: std::ops::Range<i64> = 50..90;

fn cruising() -> Rig {
    let mut rig = Rig::enabled();
    rig.set_point(100_000, 0);
    rig.ticks(200);
    assert_eq!(rig.speed(), 10);
    rig
}

/// Steps until the motor stands.
fn distance_to_rest(rig: &mut Rig) -> i64 {
    let begin = rig.motor.position;
    rig.rest() - begin
}

#[test]
fn m05_shutdown_with_605bh_1_slows_down_first() {
    let mut rig = cruising();
    rig.configuration.shutdown = Stop::on_leaving(1).unwrap();
    rig.write(0x06);
    rig.tick();
    assert_eq!(rig.state(), State::OperationEnabled);
    assert!(SLOW_DOWN.contains(&distance_to_rest(&mut rig)));
    assert_eq!(rig.state(), State::ReadyToSwitchOn);
    assert!(!rig.outputs.power_stage);
}

#[test]
fn m05_disable_operation_with_605ch_0_cuts_the_power() {
    let mut rig = cruising();
    rig.configuration.disable_operation = Stop::on_leaving(0).unwrap();
    rig.write(0x07);
    rig.tick();
    assert_eq!(rig.state(), State::SwitchedOn);
    assert!(!rig.outputs.power_stage && rig.outputs.drop_pulses);
}

#[test]
fn m35_halt_stops_on_the_ramp_of_605dh() {
    for (code, ramp) in [
        (1, SLOW_DOWN),
        (2, QUICK_STOP),
        (3, QUICK_STOP),
        (4, QUICK_STOP),
    ] {
        let mut rig = cruising();
        rig.configuration.halt = StopRamp::on_halt(code).unwrap();
        rig.write(0x10F);
        let distance = distance_to_rest(&mut rig);
        assert!(ramp.contains(&distance), "605Dh = {code}: {distance}");
        assert!(rig.reached());
        rig.write(0x0F);
        assert_eq!(rig.rest(), 100_000, "release goes on");
    }
}

#[test]
fn m10_the_fault_reaction_stops_on_the_ramp_of_605eh() {
    for (code, ramp) in [
        (1, SLOW_DOWN),
        (2, QUICK_STOP),
        (3, QUICK_STOP),
        (4, QUICK_STOP),
    ] {
        let mut rig = cruising();
        rig.configuration.fault_reaction = Stop::on_fault(code).unwrap();
        rig.post();
        rig.fault = Some(0x4210);
        let begin = rig.motor.position;
        rig.tick();
        assert_eq!(rig.state(), State::FaultReactionActive);
        assert!(rig.outputs.power_stage);
        let distance = rig.rest() - begin;
        assert!(ramp.contains(&distance), "605Eh = {code}: {distance}");
        assert_eq!(rig.state(), State::Fault);
    }
}

#[test]
fn m10_with_605eh_0_or_without_supply_the_power_goes_at_once() {
    for code in [0, 1] {
        let mut rig = cruising();
        rig.configuration.fault_reaction = Stop::on_fault(code).unwrap();
        rig.post();
        if code == 0 {
            rig.fault = Some(0x4210);
        } else {
            rig.supply = false;
        }
        rig.tick();
        assert_eq!(rig.state(), State::FaultReactionActive);
        assert!(!rig.outputs.power_stage && rig.outputs.drop_pulses);
        rig.tick();
        assert_eq!(rig.state(), State::Fault);
        let expected = if code == 0 { 0x4210 } else { UNDER_VOLTAGE };
        assert_eq!(rig.actuals().error_code, expected);
    }
}

/// A cruising drive that has lost the network.
fn abandoned(code: i16) -> Rig {
    let mut rig = cruising();
    rig.configuration.abort_connection = AbortConnectionOption::from_code(code).unwrap();
    rig.configuration.fault_reaction = Stop::on_fault(1).unwrap();
    rig.commands.remote = false;
    rig.commands.connection_error = Some(0x8130);
    rig.post();
    rig
}

#[test]
fn m16_without_action_the_motor_goes_on() {
    let mut rig = abandoned(0);
    assert_eq!(rig.rest(), 100_000);
    assert_eq!(rig.state(), State::OperationEnabled);
    assert!(!rig.has(statusword::REMOTE) && rig.reached());
}

#[test]
fn m16_a_fault_takes_the_ramp_of_605eh_and_a_reset() {
    let mut rig = abandoned(1);
    assert!(SLOW_DOWN.contains(&distance_to_rest(&mut rig)));
    assert_eq!(rig.state(), State::Fault);
    assert_eq!(rig.actuals().error_code, 0x8130);
    assert!(rig.notices().is_empty(), "the node tells of its errors");
    rig.commands.remote = true;
    rig.commands.connection_error = None;
    for controlword in [0x06, 0x0F] {
        rig.write(controlword);
        rig.ticks(3);
        assert_eq!(rig.state(), State::Fault);
    }
    rig.write(0x80);
    rig.tick();
    assert_eq!(rig.state(), State::SwitchOnDisabled);
}

#[test]
fn m16_disable_voltage_cuts_the_power() {
    let mut rig = abandoned(2);
    rig.tick();
    assert_eq!(rig.state(), State::SwitchOnDisabled);
    assert!(!rig.outputs.power_stage);
}

#[test]
fn m16_quick_stop_takes_the_quick_stop_ramp() {
    let mut rig = abandoned(3);
    rig.tick();
    assert_eq!(rig.state(), State::QuickStopActive);
    assert!(QUICK_STOP.contains(&(distance_to_rest(&mut rig) + 10)));
    assert_eq!(rig.state(), State::SwitchOnDisabled);
}

#[test]
fn a_drive_without_power_that_loses_the_network_has_no_fault() {
    for code in 1..=3 {
        let mut rig = abandoned(code);
        rig.rest();
        rig.commands.remote = true;
        rig.commands.connection_error = None;
        for controlword in [0x00, 0x80, 0x00, 0x06] {
            rig.write(controlword);
            rig.tick();
        }
        assert_eq!(rig.state(), State::ReadyToSwitchOn);
        rig.commands.remote = false;
        rig.commands.connection_error = Some(0x8130);
        rig.post();
        rig.ticks(3);
        assert_eq!(rig.state(), State::SwitchOnDisabled, "6007h = {code}");
    }
}
