use proptest::prelude::*;

use super::*;
use crate::controlword::Command;

/// The machine in a state, reached by its own transitions.
fn machine_in(state: State, quick_stop: QuickStopOption) -> StateMachine {
    StateMachine {
        state,
        quick_stop,
        ..StateMachine::new()
    }
}

/// The time says only when a state began.
const NOW: Instant = Instant::from_ticks(0);

const CALM: Conditions = Conditions {
    command: None,
    remote: true,
    quick_stop: QuickStopOption::QuickStopRamp,
    at_once: false,
    standstill: true,
    fault: false,
    fault_reset: false,
};

fn command(command: Command) -> Conditions {
    Conditions {
        command: Some(command),
        ..CALM
    }
}

#[test]
fn every_number_of_the_standard_is_in_the_table() {
    for number in 1..=16 {
        assert!(
            TRANSITIONS.iter().any(|row| row.number == number),
            "transition {number}"
        );
    }
}

#[test]
fn every_state_has_a_statusword_of_its_own() {
    for state in State::ALL {
        for others in [0, 0xFF90] {
            assert_eq!(
                State::from_statusword(state.statusword() | others),
                Some(state)
            );
        }
    }
    // Bit 5 is free in some states.
    assert_eq!(State::from_statusword(0x60), Some(State::SwitchOnDisabled));
    assert_eq!(State::from_statusword(0x28), Some(State::Fault));
}

#[test]
fn the_option_counts_when_the_quick_stop_begins() {
    let mut machine = machine_in(State::OperationEnabled, QuickStopOption::QuickStopRamp);
    let begin = Conditions {
        quick_stop: QuickStopOption::QuickStopRampAndStay,
        ..command(Command::QuickStop)
    };
    assert_eq!(machine.step(NOW, &begin).map(|t| t.number), Some(11));
    assert_eq!(machine.step(NOW, &command(Command::QuickStop)), None);
}

#[test]
fn m15_without_remote_every_state_leads_to_switch_on_disabled() {
    for option in [
        QuickStopOption::QuickStopRamp,
        QuickStopOption::QuickStopRampAndStay,
    ] {
        for from in State::ALL {
            let mut machine = machine_in(from, option);
            let alone = Conditions {
                remote: false,
                quick_stop: option,
                ..command(Command::EnableOperation)
            };
            for _ in 0..3 {
                machine.step(NOW, &alone);
            }
            let end = match from {
                State::Fault | State::FaultReactionActive => State::Fault,
                _ => State::SwitchOnDisabled,
            };
            assert_eq!(machine.state(), end, "{from:?} {option:?}");
        }
    }
}

/// A second statement of the standard, by state instead of by row: what a state does under given conditions.
fn model(state: State, stays: bool, seen: &Conditions) -> State {
    use Command as C;
    use State as S;
    if seen.fault && !matches!(state, S::Fault | S::FaultReactionActive) {
        return S::FaultReactionActive;
    }
    let command = match seen.command {
        given if seen.remote || given == Some(C::DisableVoltage) => given,
        _ => Some(C::QuickStop),
    };
    match state {
        S::NotReadyToSwitchOn => S::SwitchOnDisabled,
        S::SwitchOnDisabled if command == Some(C::Shutdown) => S::ReadyToSwitchOn,
        S::ReadyToSwitchOn => match command {
            Some(C::SwitchOn | C::EnableOperation) => S::SwitchedOn,
            Some(C::QuickStop | C::DisableVoltage) => S::SwitchOnDisabled,
            Some(C::Shutdown) | None => state,
        },
        S::SwitchedOn => match command {
            Some(C::EnableOperation) => S::OperationEnabled,
            Some(C::Shutdown) => S::ReadyToSwitchOn,
            Some(C::QuickStop | C::DisableVoltage) => S::SwitchOnDisabled,
            Some(C::SwitchOn) | None => state,
        },
        S::OperationEnabled => match command {
            Some(C::SwitchOn) if seen.standstill || seen.at_once => S::SwitchedOn,
            Some(C::Shutdown) if seen.standstill || seen.at_once => S::ReadyToSwitchOn,
            Some(C::DisableVoltage) => S::SwitchOnDisabled,
            Some(C::QuickStop) => S::QuickStopActive,
            _ => state,
        },
        S::QuickStopActive => match command {
            Some(C::DisableVoltage) => S::SwitchOnDisabled,
            _ if seen.standstill && !(stays && seen.remote) => S::SwitchOnDisabled,
            Some(C::EnableOperation) if seen.standstill => S::OperationEnabled,
            _ => state,
        },
        S::FaultReactionActive if seen.standstill => S::Fault,
        S::Fault if seen.fault_reset => S::SwitchOnDisabled,
        _ => state,
    }
}

fn any_conditions() -> impl Strategy<Value = Conditions> {
    (
        prop::sample::select(std::vec![
            Some(Command::Shutdown),
            Some(Command::SwitchOn),
            Some(Command::EnableOperation),
            Some(Command::EnableOperation),
            Some(Command::QuickStop),
            Some(Command::DisableVoltage),
            None,
        ]),
        prop::bool::weighted(0.9),
        prop::sample::select(QuickStopOption::ALL.to_vec()),
        any::<bool>(),
        any::<bool>(),
        prop::bool::weighted(0.05),
        any::<bool>(),
    )
        .prop_map(
            |(command, remote, quick_stop, at_once, standstill, fault, fault_reset)| Conditions {
                command,
                remote,
                quick_stop,
                at_once,
                standstill,
                fault,
                fault_reset,
            },
        )
}

proptest! {
    #[test]
    fn d33_the_machine_and_the_model_agree(sequence in prop::collection::vec(any_conditions(), 1..200)) {
        let mut machine = StateMachine::new();
        let mut stays = false;
        for seen in sequence {
            let before = machine.state();
            let expected = model(before, stays, &seen);
            let transition = machine.step(NOW, &seen);
            prop_assert_eq!(machine.state(), expected);
            prop_assert_eq!(transition.is_some(), before != expected);
            if let Some(t) = transition {
                prop_assert_eq!((t.from, t.to), (before, expected));
            }
            if before != expected && expected == State::QuickStopActive {
                stays = seen.remote && seen.quick_stop.stays();
            }
            if !seen.remote {
                stays = false;
            }
        }
    }
}

/// What the triggers say, in words.
fn is_there(trigger: Trigger, seen: &Conditions, stays: bool) -> bool {
    match trigger {
        Trigger::Automatic => true,
        Trigger::Command(command) => seen.command == Some(command),
        Trigger::AtStandstill(command) => {
            (seen.standstill || seen.at_once) && seen.command == Some(command)
        }
        Trigger::QuickStopCompleted => seen.standstill && !stays,
        Trigger::Resume => {
            seen.standstill && stays && seen.command == Some(Command::EnableOperation)
        }
        Trigger::Fault => seen.fault,
        Trigger::ReactionCompleted => seen.standstill,
        Trigger::FaultReset => seen.fault_reset,
    }
}

#[test]
fn the_first_row_whose_trigger_is_there_is_taken_and_no_other() {
    let commands = [
        None,
        Some(Command::Shutdown),
        Some(Command::SwitchOn),
        Some(Command::EnableOperation),
        Some(Command::QuickStop),
        Some(Command::DisableVoltage),
    ];
    let options = [
        QuickStopOption::QuickStopRamp,
        QuickStopOption::QuickStopRampAndStay,
    ];
    for state in State::ALL {
        for (command, bits) in commands
            .into_iter()
            .flat_map(|c| (0..16_u8).map(move |b| (c, b)))
        {
            for quick_stop in options {
                let has = |bit: u8| bits & 1 << bit != 0;
                let conditions = Conditions {
                    command,
                    at_once: has(0),
                    standstill: has(1),
                    fault: has(2),
                    fault_reset: has(3),
                    ..CALM
                };
                let expected = TRANSITIONS.iter().find(|row| {
                    row.from == state && is_there(row.trigger, &conditions, quick_stop.stays())
                });
                let mut machine = machine_in(state, quick_stop);
                let taken = machine.step(NOW, &conditions);
                assert_eq!(taken.as_ref(), expected, "{state:?}, {conditions:?}");
                assert_eq!(machine.state(), expected.map_or(state, |row| row.to));
            }
        }
    }
}
