use proptest::prelude::*;

use crate::state_machine::{State, TRANSITIONS, Trigger};
use crate::testing::{Rig, quick_stop};
use crate::{Command, statusword};

#[test]
fn d01_power_on_leads_to_switch_on_disabled() {
    let mut rig = Rig::new();
    assert_eq!(rig.state(), State::NotReadyToSwitchOn);
    rig.tick();
    assert_eq!(
        rig.actuals().statusword,
        0x0050,
        "no command yet, so not remote"
    );
    rig.post();
    assert_eq!(rig.tick().statusword, 0x0250);
    assert!(!rig.outputs.power_stage);
}

#[test]
fn d02_enabling_goes_through_every_state() {
    let mut rig = Rig::new();
    rig.ticks(2);
    for (controlword, state) in [(0x06, 0x21), (0x07, 0x23), (0x0F, 0x27)] {
        rig.write(controlword);
        assert_eq!(rig.tick().statusword & 0x6F, state);
        assert_eq!(rig.outputs.power_stage, state == 0x27);
    }
}

#[test]
fn d03_enabling_needs_shutdown_first() {
    let mut rig = Rig::new();
    rig.ticks(2);
    rig.write(0x0F);
    rig.ticks(10);
    assert_eq!(rig.state(), State::SwitchOnDisabled);
    rig.write(0x07);
    rig.ticks(10);
    assert_eq!(rig.state(), State::SwitchOnDisabled);
}

#[test]
fn d04_enable_operation_passes_switched_on() {
    let mut rig = Rig::new();
    rig.ticks(2);
    rig.write(0x06);
    rig.tick();
    rig.write(0x0F);
    rig.tick();
    assert_eq!(rig.state(), State::SwitchedOn);
    rig.tick();
    assert_eq!(rig.state(), State::OperationEnabled);
}

#[test]
fn m03_transitions_3_and_4_need_ready_to_switch_on() {
    for (path, states) in [
        (&[0x0F][..], [State::SwitchOnDisabled; 3]),
        (
            &[0x06, 0x0F],
            [
                State::SwitchedOn,
                State::OperationEnabled,
                State::OperationEnabled,
            ],
        ),
        (&[0x06, 0x06], [State::ReadyToSwitchOn; 3]),
    ] {
        let mut rig = Rig::new();
        rig.ticks(2);
        let (last, before) = path.split_last().unwrap();
        for &controlword in before {
            rig.write(controlword);
            rig.tick();
        }
        rig.write(*last);
        for state in states {
            rig.tick();
            assert_eq!(rig.state(), state);
        }
    }
}

#[test]
fn d05_operation_enabled_is_left_by_every_command() {
    for (controlword, state) in [
        (0x07, State::SwitchedOn),
        (0x06, State::ReadyToSwitchOn),
        (0x00, State::SwitchOnDisabled),
        (0x02, State::QuickStopActive),
    ] {
        let mut rig = Rig::enabled();
        rig.write(controlword);
        rig.tick();
        assert_eq!(rig.state(), state);
        assert_eq!(rig.outputs.power_stage, state == State::QuickStopActive);
    }
}

#[test]
fn d06_stopping_before_operation_leads_to_switch_on_disabled() {
    for path in [&[0x06][..], &[0x06, 0x07]] {
        for stop in [0x00, 0x02] {
            let mut rig = Rig::new();
            rig.ticks(2);
            for &controlword in path {
                rig.write(controlword);
                rig.tick();
            }
            rig.write(stop);
            rig.tick();
            assert_eq!(
                rig.state(),
                State::SwitchOnDisabled,
                "{path:02X?} {stop:02X}"
            );
        }
    }
}

#[test]
fn m13_voltage_enabled_follows_the_supply_in_every_state() {
    let mut rig = Rig::new();
    rig.ticks(2);
    for supply in [false, true, false] {
        rig.supply = supply;
        rig.tick();
        assert_eq!(rig.has(statusword::VOLTAGE_ENABLED), supply);
        assert_eq!(rig.state(), State::SwitchOnDisabled);
    }
}

#[test]
fn m04_disable_voltage_cuts_the_power_at_once() {
    let mut rig = Rig::enabled();
    rig.set_point(100_000, 0);
    rig.ticks(200);
    assert_eq!(rig.speed(), 10);
    rig.write(0x00);
    rig.tick();
    assert_eq!(rig.state(), State::SwitchOnDisabled);
    assert!(!rig.outputs.power_stage && rig.outputs.drop_pulses);
    let stopped = rig.seen;
    rig.ticks(10);
    assert_eq!(rig.motor.position, stopped, "no pulse leaves without power");
    assert_eq!(i64::from(rig.actuals().position_demand), stopped);
}

#[test]
fn m17_reserved_bits_change_nothing() {
    let mut rig = Rig::new();
    rig.ticks(2);
    for (controlword, state) in [
        (0xF806, 0x21),
        (0xF807, 0x23),
        (0xF80F, 0x27),
        (0x080F, 0x27),
    ] {
        rig.write(controlword);
        assert_eq!(rig.tick().statusword & 0x6F, state);
    }
}

#[test]
fn m38_disabled_on_the_way_the_target_is_forgotten() {
    let mut rig = Rig::enabled();
    rig.set_point(100_000, 0);
    rig.ticks(200);
    rig.write(0x07);
    rig.tick();
    assert_eq!(rig.state(), State::OperationEnabled, "it slows down first");
    rig.until("switched on", |rig| rig.state() == State::SwitchedOn);
    assert!(!rig.outputs.power_stage);
    let stopped = rig.motor.position;
    assert!(stopped > 1_500 && stopped < 3_000, "{stopped}");
    rig.write(0x0F);
    rig.ticks(100);
    assert_eq!(rig.state(), State::OperationEnabled);
    assert!(!rig.acknowledged());
    assert_eq!(rig.motor.position, stopped);
}

#[test]
fn enabled_again_while_it_slows_down_the_target_is_forgotten() {
    let mut rig = Rig::enabled();
    rig.set_point(100_000, 0);
    rig.ticks(200);
    rig.write(0x07);
    rig.ticks(3);
    rig.write(0x0F);
    let stopped = rig.rest();
    assert_eq!(rig.state(), State::OperationEnabled);
    assert!(stopped < 3_000, "{stopped}");
    rig.set_point(10, 0);
    assert_eq!(rig.rest(), 10);
}

/// What a master and the world may do between two ticks.
#[derive(Clone, Debug)]
enum Action {
    Write(u16),
    Target(i32),
    Mode(i8),
    Option(i16),
    Remote(bool),
    Fault(Option<u16>),
    Supply(bool),
    Wait(usize),
}

/// What masters write; "enable operation" more often than the others.
const CONTROLWORDS: &[u16] = &[
    0x06, 0x07, 0x0F, 0x0F, 0x0F, 0x1F, 0x3F, 0x5F, 0x10F, 0x80, 0x02, 0x00,
];

const ERROR_CODES: &[u16] = &[0x2310, 0x4210, 0x7121, 0xFF00];

fn any_action() -> impl Strategy<Value = Action> {
    prop_oneof![
        4 => prop::sample::select(CONTROLWORDS).prop_map(Action::Write),
        1 => any::<u16>().prop_map(Action::Write),
        1 => (-20_000..20_000).prop_map(Action::Target),
        1 => any::<i32>().prop_map(Action::Target),
        1 => (-1i8..3).prop_map(Action::Mode),
        1 => (0i16..9).prop_map(Action::Option),
        1 => prop::bool::weighted(0.9).prop_map(Action::Remote),
        1 => prop::option::weighted(0.2, prop::sample::select(ERROR_CODES)).prop_map(Action::Fault),
        1 => prop::bool::weighted(0.9).prop_map(Action::Supply),
        4 => (1usize..60).prop_map(Action::Wait),
    ]
}

proptest! {
    /// Whatever is asked: the drive goes from state to state by the table only, has power only where it may, loses no
    /// pulse, and ends where its pulses led.
    #[test]
    fn d33_the_drive_follows_the_transition_table(actions in prop::collection::vec(any_action(), 1..120)) {
        let mut rig = Rig::new();
        rig.ticks(2);
        let mut before = rig.state();
        for action in actions {
            let mut ticks = 1;
            match action {
                Action::Write(controlword) => rig.write(controlword),
                Action::Target(target) => rig.commands.target_position = target,
                Action::Mode(mode) => rig.commands.mode = mode,
                Action::Option(option) => rig.configuration.quick_stop = quick_stop(option),
                Action::Remote(remote) => rig.commands.remote = remote,
                Action::Fault(fault) => rig.fault = fault,
                Action::Supply(supply) => rig.supply = supply,
                Action::Wait(count) => ticks = count,
            }
            rig.post();
            for _ in 0..ticks {
                rig.tick();
                let after = rig.state();
                if before != after {
                    let row = TRANSITIONS.iter().find(|row| row.from == before && row.to == after);
                    prop_assert!(row.is_some(), "{:?} to {:?}", before, after);
                    if let Some(Trigger::Command(Command::EnableOperation)) = row.map(|row| row.trigger) {
                        prop_assert!(rig.commands.remote);
                    }
                }
                if rig.outputs.power_stage {
                    prop_assert!(after.may_have_power(), "power in {:?}", after);
                }
                if after == State::OperationEnabled {
                    prop_assert!(rig.outputs.power_stage);
                }
                prop_assert!(rig.exchange.lost_notices() == 0);
                prop_assert!(rig.actuals().error_code != crate::faults::POSITION_MISMATCH);
                rig.notices();
                before = after;
            }
        }
        // In the end it always comes to rest, without power.
        rig.fault = None;
        rig.supply = true;
        rig.commands.remote = false;
        rig.post();
        rig.until("safe", |rig| rig.exchange.is_safe());
        prop_assert_eq!(i64::from(rig.actuals().position_actual), rig.motor.position);
    }
}
