use proptest::prelude::*;

use crate::Command;
use crate::state_machine::{State, TRANSITIONS, Trigger};
use crate::testing::{Rig, quick_stop};

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
