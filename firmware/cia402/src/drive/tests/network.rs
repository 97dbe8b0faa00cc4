use crate::faults::FaultNotice::Raised;
use crate::state_machine::State;
use crate::statusword;
use crate::testing::{Rig, quick_stop};

#[test]
fn d30_when_the_network_goes_the_motor_stops_and_stays() {
    let mut rig = Rig::enabled();
    rig.configuration.quick_stop = quick_stop(6);
    rig.set_point(100_000, 0);
    rig.ticks(200);
    let begin = rig.motor.position;
    rig.commands.remote = false;
    rig.post();
    assert!(!rig.exchange.is_safe());
    rig.tick();
    assert!(!rig.has(statusword::REMOTE));
    assert_eq!(rig.state(), State::QuickStopActive);
    rig.until("safe", |rig| rig.exchange.is_safe());
    assert_eq!(rig.state(), State::SwitchOnDisabled, "whatever 605Ah says");
    assert!(!rig.outputs.power_stage);
    let stopped = rig.motor.position - begin;
    assert!((50..90).contains(&stopped), "{stopped} steps");

    rig.commands.remote = true;
    rig.post();
    rig.ticks(20);
    assert_eq!(
        rig.state(),
        State::SwitchOnDisabled,
        "6040h is still 1Fh, and nothing happens"
    );
    assert_eq!(rig.motor.position - begin, stopped);
}

#[test]
fn m15_commands_are_ignored_without_the_network() {
    let mut rig = Rig::new();
    rig.commands.remote = false;
    rig.ticks(2);
    for controlword in [0x06, 0x07, 0x0F] {
        rig.write(controlword);
        rig.ticks(2);
        assert_eq!(rig.actuals().statusword, 0x0050);
    }
}

#[test]
fn a_drive_is_safe_only_after_it_has_seen_the_command() {
    let mut rig = Rig::enabled();
    rig.write(0x00);
    rig.ticks(3);
    assert!(rig.exchange.is_safe());
    rig.write(0x06);
    assert!(!rig.exchange.is_safe(), "a command is on its way");
    rig.tick();
    assert!(!rig.exchange.is_safe(), "ready to switch on");
}

#[test]
fn n18_a_restart_forgets_a_fault() {
    let mut rig = Rig::enabled();
    rig.fault = Some(0x4210);
    rig.ticks(5);
    rig.fault = None;
    assert_eq!(rig.state(), State::Fault);
    rig.commands.remote = false;
    rig.commands.restart = true;
    rig.post();
    let ticks = rig.until("safe", |rig| rig.exchange.is_safe());
    assert!(ticks < 5);
    assert_eq!(rig.state(), State::SwitchOnDisabled);
    assert_eq!(rig.actuals().error_code, 0);
    assert!(rig.notices().is_empty(), "what it had told is void");
    rig.ticks(5);
    assert!(rig.exchange.is_safe(), "one restart is enough");
}

#[test]
fn a_restart_with_the_cause_present_ends_in_the_fault_again() {
    let mut rig = Rig::enabled();
    rig.fault = Some(0x4210);
    rig.ticks(5);
    rig.commands.remote = false;
    rig.commands.restart = true;
    rig.post();
    rig.until("safe", |rig| rig.exchange.is_safe());
    assert_eq!(rig.state(), State::Fault);
    assert_eq!(rig.notices(), [Raised(0x4210)]);
}

#[test]
fn a_restart_on_the_way_stops_first() {
    let mut rig = Rig::enabled();
    rig.set_point(100_000, 0);
    rig.ticks(200);
    rig.commands.remote = false;
    rig.commands.restart = true;
    rig.post();
    rig.tick();
    assert_eq!(rig.state(), State::QuickStopActive);
    rig.until("safe", |rig| rig.exchange.is_safe());
    assert_eq!(rig.state(), State::SwitchOnDisabled);
}

#[test]
fn a_restart_during_the_fault_reaction_forgets_the_fault() {
    let mut rig = Rig::enabled();
    rig.set_point(100_000, 0);
    rig.ticks(200);
    rig.fault = Some(0x4210);
    rig.ticks(2);
    rig.fault = None;
    rig.commands.remote = false;
    rig.commands.restart = true;
    rig.post();
    rig.tick();
    assert_eq!(rig.state(), State::FaultReactionActive);
    rig.until("safe", |rig| rig.exchange.is_safe());
    assert_eq!(rig.state(), State::SwitchOnDisabled);
    assert_eq!(rig.actuals().error_code, 0);
}
