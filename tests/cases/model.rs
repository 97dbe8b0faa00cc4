//! D33: random controlwords, modes, option codes, velocities, faults and network commands against the transition table, written
//! down here a second time.

use proptest::prelude::*;
use tests::DriveBench;
use tests::drive::{
    FAULT, OPERATION_ENABLED, QUICK_STOP_ACTIVE, READY_TO_SWITCH_ON, SWITCH_ON_DISABLED,
    SWITCHED_ON, State as Shown,
};

/// Where the drive can rest between two commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    SwitchOnDisabled,
    ReadyToSwitchOn,
    SwitchedOn,
    OperationEnabled,
    QuickStopActive,
    Fault,
}

/// What a master or the world does.
#[derive(Clone, Copy, Debug)]
enum Action {
    Controlword(u16),
    QuickStopOption(i16),
    /// 605Bh and 605Ch, which change how operation ends and not where.
    LeavingOptions(i16, i16),
    Mode(i8),
    Velocity(i16),
    FaultAppears,
    FaultGoes,
    NmtStop,
    NmtStart,
}

/// The transition table of CiA 402-2 as an executable model, with commands under their masks.
#[derive(Debug)]
struct Model {
    state: State,
    controlword: u16,
    option: i16,
    /// The option code of the quick stop under way: one that is written meanwhile counts for the next.
    running_option: i16,
    mode: i8,
    cause: bool,
    remote: bool,
}

impl Model {
    fn apply(&mut self, action: Action) {
        let mut reset = false;
        match action {
            Action::Controlword(controlword) if self.remote => {
                reset = controlword & !self.controlword & 0x80 != 0;
                self.controlword = controlword;
            }
            // A stopped node takes no PDO.
            Action::Controlword(_) => {}
            Action::QuickStopOption(option) if self.remote => self.option = option,
            Action::QuickStopOption(_) | Action::LeavingOptions(..) | Action::Velocity(_) => {}
            Action::Mode(mode) if self.remote && is_there(mode) => self.mode = mode,
            Action::Mode(_) => {}
            Action::FaultAppears => self.cause = true,
            Action::FaultGoes => self.cause = false,
            Action::NmtStop => self.remote = false,
            Action::NmtStart => self.remote = true,
        }
        if reset && self.state == State::Fault {
            self.state = State::SwitchOnDisabled; // 15
        }
        if self.cause {
            self.state = State::Fault; // 13 and 14
        }
        if !self.remote && self.state != State::Fault {
            self.state = State::SwitchOnDisabled; // as quick stop with option 2, then 12
        }
        // A command stands as long as the controlword does, so one can lead to the next.
        while let Some(next) = self.transition() {
            if next == State::QuickStopActive {
                self.running_option = self.option;
            }
            self.state = next;
        }
    }

    fn transition(&self) -> Option<State> {
        use State::{
            Fault, OperationEnabled, QuickStopActive, ReadyToSwitchOn, SwitchOnDisabled, SwitchedOn,
        };
        let bit = |number: u16| self.controlword >> number & 1 == 1;
        if bit(7) || !self.remote || self.state == Fault {
            return None;
        }
        let shutdown = bit(2) && bit(1) && !bit(0);
        let switch_on = bit(2) && bit(1) && bit(0) && !bit(3);
        let enable = bit(3) && bit(2) && bit(1) && bit(0);
        let quick_stop = !bit(2) && bit(1);
        let disable_voltage = !bit(1);
        match self.state {
            SwitchOnDisabled if shutdown => Some(ReadyToSwitchOn), // 2
            ReadyToSwitchOn if switch_on || enable => Some(SwitchedOn), // 3
            SwitchedOn if enable => Some(OperationEnabled),        // 4
            OperationEnabled if switch_on => Some(SwitchedOn),     // 5
            SwitchedOn if shutdown => Some(ReadyToSwitchOn),       // 6
            ReadyToSwitchOn if quick_stop || disable_voltage => Some(SwitchOnDisabled), // 7
            OperationEnabled if shutdown => Some(ReadyToSwitchOn), // 8
            OperationEnabled if disable_voltage => Some(SwitchOnDisabled), // 9
            SwitchedOn if quick_stop || disable_voltage => Some(SwitchOnDisabled), // 10
            OperationEnabled if quick_stop => Some(QuickStopActive), // 11
            QuickStopActive if disable_voltage || self.running_option <= 4 => {
                Some(SwitchOnDisabled)
            } // 12
            QuickStopActive if enable => Some(OperationEnabled),   // 16
            _ => None,
        }
    }

    fn shown(&self) -> Shown {
        match self.state {
            State::SwitchOnDisabled => SWITCH_ON_DISABLED,
            State::ReadyToSwitchOn => READY_TO_SWITCH_ON,
            State::SwitchedOn => SWITCHED_ON,
            State::OperationEnabled => OPERATION_ENABLED,
            State::QuickStopActive => QUICK_STOP_ACTIVE,
            State::Fault => FAULT,
        }
    }
}

/// The modes of the drive.
fn is_there(mode: i8) -> bool {
    matches!(mode, 0..=3 | 6)
}

fn any_action() -> impl Strategy<Value = Action> {
    prop_oneof![
        // Commands as masters send them, some with bits of others, some just noise.
        12 => prop::sample::select(vec![0x06_u16, 0x07, 0x0F, 0x02, 0x00, 0x80, 0x8F, 0x10F, 0x106]).prop_map(Action::Controlword),
        3 => any::<u16>().prop_map(|controlword| Action::Controlword(controlword & !0x10)),
        2 => prop::sample::select(vec![0_i16, 1, 2, 3, 4, 5, 6, 7, 8]).prop_map(Action::QuickStopOption),
        1 => (0_i16..=1, 0_i16..=1).prop_map(|(shutdown, disable)| Action::LeavingOptions(shutdown, disable)),
        3 => prop::sample::select(vec![0_i8, 1, 2, 3, 3, 4, 5, 6, -1]).prop_map(Action::Mode),
        2 => (-10_000_i16..=10_000).prop_map(Action::Velocity),
        1 => Just(Action::FaultAppears),
        2 => Just(Action::FaultGoes),
        1 => Just(Action::NmtStop),
        2 => Just(Action::NmtStart),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, ..ProptestConfig::default() })]

    #[test]
    fn d33_the_drive_follows_the_transition_table(actions in prop::collection::vec(any_action(), 1..60), move_first: bool) {
        let mut drive = DriveBench::enabled(4);
        if move_first {
            drive.begin_move(1_000_000);
        }
        let mut model = Model { state: State::OperationEnabled, controlword: 0x0F, option: 2, running_option: 2, mode: 1, cause: false, remote: true };
        for action in actions {
            match action {
                Action::Controlword(controlword) => drive.command(controlword),
                Action::QuickStopOption(option) if model.remote => drive.write_i16(0x605A, 0, option),
                Action::LeavingOptions(shutdown, disable) if model.remote => {
                    drive.write_i16(0x605B, 0, shutdown);
                    drive.write_i16(0x605C, 0, disable);
                }
                Action::Mode(mode) if model.remote => {
                    let result = drive.try_write(0x6060, 0, &mode.to_le_bytes());
                    prop_assert_eq!(result.is_ok(), is_there(mode), "mode {}", mode);
                }
                Action::Velocity(velocity) if model.remote => {
                    drive.write_i32(0x60FF, 0, velocity.into());
                    drive.write_i16(0x6042, 0, velocity);
                }
                // A stopped node has no SDO.
                Action::QuickStopOption(_) | Action::LeavingOptions(..) | Action::Mode(_) | Action::Velocity(_) => {}
                Action::FaultAppears => drive.set_fault(Some(0x4310)),
                Action::FaultGoes => drive.set_fault(None),
                Action::NmtStop => drive.send("000 [2] 02 04"),
                Action::NmtStart => drive.send("000 [2] 01 04"),
            }
            model.apply(action);
            // Long enough for the slowest ramp: 10,000 steps/s on 100,000 steps/s².
            drive.run_millis(120);
            let statusword = drive.statusword();
            prop_assert!(model.shown().is_shown_by(statusword), "after {action:?}: statusword {statusword:04X}h, model {model:?}");
            let shown = drive.axis().actuals().mode_display;
            prop_assert_eq!(shown, model.mode, "6061h after {:?} in {:?}", action, model);
            let powered = drive.axis().plant().is_energised();
            prop_assert_eq!(powered, matches!(model.state, State::OperationEnabled | State::QuickStopActive), "power after {:?}", action);
        }
    }
}
