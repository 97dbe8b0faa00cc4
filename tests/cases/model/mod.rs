//! D33: random controlwords, modes, option codes, set-points, faults and network commands against the transition table, written down a
//! second time ([`table`]). The state is compared in every millisecond: a transition is there within ten, unless the motor has
//! to stop first; then the state before it stands for as long as the motor moves.

mod table;

use canopen::Duration;
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;
use tests::DriveBench;

use table::{Network, State, Table};

/// Within so many milliseconds a transition is seen.
const SEEN: u64 = 10;

/// Without a step for so many milliseconds the motor stands. The last steps of a ramp of 100,000 steps/s² take less.
const STILL: u64 = 6;

/// What a master or the world does.
#[derive(Clone, Copy, Debug)]
enum Action {
    Controlword(u16),
    /// 6007h, 605Ah, 605Bh, 605Ch, 605Dh or 605Eh.
    Option(u16, i16),
    Mode(i8),
    /// 607Ah, and the next data record of interpolated position.
    Target(i32),
    /// 60FFh and 6042h.
    Velocity(i16),
    /// 6098h.
    HomingMethod(i8),
    FaultAppears,
    FaultGoes,
    /// SYNC in each millisecond, or none.
    Sync(bool),
    NmtStart,
    NmtStop,
    NmtPreOperational,
    ResetNode,
    ResetCommunication,
}

/// The modes of the drive.
fn is_there(mode: i8) -> bool {
    matches!(mode, 0..=3 | 6..=9)
}

fn any_action() -> impl Strategy<Value = Action> {
    const COMMANDS: &[u16] = &[
        0x06, 0x07, 0x0F, 0x0F, 0x1F, 0x1F, 0x3F, 0x7F, 0x02, 0x00, 0x80, 0x87, 0x8F, 0x10F, 0x106,
    ];
    let option = prop_oneof![
        (0_i16..=3).prop_map(|code| Action::Option(0x6007, code)),
        (0_i16..=8).prop_map(|code| Action::Option(0x605A, code)),
        (0_i16..=1).prop_map(|code| Action::Option(0x605B, code)),
        (0_i16..=1).prop_map(|code| Action::Option(0x605C, code)),
        (1_i16..=4).prop_map(|code| Action::Option(0x605D, code)),
        (0_i16..=4).prop_map(|code| Action::Option(0x605E, code)),
    ];
    let modes = vec![0_i8, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, -1];
    prop_oneof![
        // Commands as masters send them, some with bits of others, some just noise.
        16 => prop::sample::select(COMMANDS).prop_map(Action::Controlword),
        3 => any::<u16>().prop_map(Action::Controlword),
        5 => option,
        4 => prop::sample::select(modes).prop_map(Action::Mode),
        2 => (-20_000..=20_000).prop_map(Action::Target),
        2 => (-10_000_i16..=10_000).prop_map(Action::Velocity),
        1 => prop::sample::select(vec![0_i8, 17, 35, 37]).prop_map(Action::HomingMethod),
        2 => any::<bool>().prop_map(Action::Sync),
        1 => Just(Action::FaultAppears),
        2 => Just(Action::FaultGoes),
        1 => Just(Action::NmtStop),
        3 => Just(Action::NmtStart),
        1 => Just(Action::NmtPreOperational),
        1 => Just(Action::ResetNode),
        1 => Just(Action::ResetCommunication),
    ]
}

/// A drive, the table beside it, and what has been seen of the motor.
struct Comparison {
    drive: DriveBench,
    table: Table,
    has_sync: bool,
    /// In milliseconds.
    now: u64,
    /// The states of the table with the time at which each was entered, the last one first.
    passed: Vec<(u64, State)>,
    /// Where the motor was in each millisecond.
    positions: Vec<i64>,
    /// When it made its last step.
    moved: u64,
    /// When the last thing was done.
    acted: u64,
    /// When 6060h was last written.
    mode_written: u64,
    /// Quick stop active and fault reaction active that a PDO has not shown yet.
    unseen: Vec<State>,
    has_booted: bool,
}

impl Comparison {
    fn new() -> Self {
        let mut drive = DriveBench::enabled(4);
        // What 2051h:2 = 1 makes of a set-point that is missing is for other cases.
        drive.write_u8(0x2051, 2, 2);
        drive.drain(20);
        let position = drive.position();
        Self {
            drive,
            table: Table::new(),
            has_sync: false,
            now: 0,
            passed: vec![(0, State::OperationEnabled)],
            positions: vec![position],
            moved: 0,
            acted: 0,
            mode_written: 0,
            unseen: Vec::new(),
            has_booted: false,
        }
    }

    /// Does it, to the drive and to the table.
    fn act(&mut self, action: Action) -> Result<(), TestCaseError> {
        self.acted = self.now;
        let Self { drive, table, .. } = self;
        match action {
            Action::Controlword(controlword) => {
                if table.has_pdos() {
                    drive.command(controlword);
                    table.command(controlword);
                } else if table.has_sdo() {
                    // No PDO is taken, but SDO is.
                    drive.command(!controlword);
                    drive.write_u16(0x6040, 0, controlword);
                    table.command(controlword);
                } else {
                    drive.command(controlword);
                }
            }
            Action::Option(index, code) if table.has_sdo() => {
                drive.write_i16(index, 0, code);
                let options = &mut table.options;
                match index {
                    0x6007 => options.abort_connection = code,
                    0x605A => options.quick_stop = code,
                    0x605B => options.shutdown = code,
                    0x605C => options.disable_operation = code,
                    0x605E => options.fault_reaction = code,
                    _ => {}
                }
            }
            Action::Mode(mode) if table.has_sdo() => {
                let result = drive.try_write(0x6060, 0, &mode.to_le_bytes());
                prop_assert_eq!(result.is_ok(), is_there(mode), "mode {}", mode);
                if result.is_ok() {
                    table.mode = mode;
                    self.mode_written = self.now;
                }
            }
            Action::Target(target) if table.has_sdo() => {
                drive.write_i32(0x607A, 0, target);
                drive.write_i32(0x60C1, 1, target);
            }
            Action::Velocity(velocity) if table.has_sdo() => {
                drive.write_i32(0x60FF, 0, velocity.into());
                drive.write_i16(0x6042, 0, velocity);
            }
            Action::HomingMethod(method) if table.has_sdo() => {
                drive.write_u8(0x6098, 0, method.cast_unsigned());
            }
            // A stopped node has no SDO.
            Action::Option(..)
            | Action::Mode(_)
            | Action::Target(_)
            | Action::Velocity(_)
            | Action::HomingMethod(_) => {}
            Action::Sync(has_sync) => self.has_sync = has_sync,
            Action::FaultAppears => {
                drive.set_fault(Some(0x4310));
                table.cause = true;
            }
            Action::FaultGoes => {
                drive.set_fault(None);
                table.cause = false;
            }
            Action::NmtStart => {
                drive.send("000 [2] 01 04");
                table.go(Network::Operational);
            }
            Action::NmtStop => {
                drive.send("000 [2] 02 04");
                table.go(Network::Stopped);
            }
            Action::NmtPreOperational => {
                drive.send("000 [2] 80 04");
                table.go(Network::PreOperational);
            }
            Action::ResetNode | Action::ResetCommunication => {
                let is_node = matches!(action, Action::ResetNode);
                drive.send(if is_node {
                    "000 [2] 81 04"
                } else {
                    "000 [2] 82 04"
                });
                table.go(Network::Resetting { is_node });
                self.unseen.clear();
                self.has_booted = false;
                self.settle();
                return self.boots();
            }
        }
        if !self.table.has_pdos() {
            self.unseen.clear();
        }
        self.settle();
        Ok(())
    }

    /// The boot-up message comes when the motor has no power any more.
    fn boots(&mut self) -> Result<(), TestCaseError> {
        let begin = self.now;
        let mut idle = 0;
        while !self.has_booted {
            self.millisecond()?;
            idle = if self.table.state.may_have_power() {
                0
            } else {
                idle + 1
            };
            prop_assert!(idle <= SEEN + STILL, "no boot-up message: {:?}", self.table);
            prop_assert!(self.now < begin + 1_000, "it never stops: {:?}", self.table);
        }
        prop_assert!(!self.table.has_power(), "reset in motion: {:?}", self.table);
        self.table.booted();
        self.mode_written = self.now;
        self.enter(self.table.state);
        // The data sheet's value may be back.
        self.drive.write_u8(0x2051, 2, 2);
        self.settle();
        Ok(())
    }

    /// The motor made a step just now, or a moment ago.
    fn moves(&self) -> bool {
        self.now < self.moved + STILL
    }

    fn enter(&mut self, state: State) {
        self.passed.insert(0, (self.now, state));
        let is_transient = matches!(state, State::QuickStopActive | State::FaultReactionActive);
        if is_transient && self.table.has_pdos() {
            self.unseen.push(state);
        }
    }

    /// Lets the table go as far as it leads.
    fn settle(&mut self) {
        // A fault reset has led somewhere already.
        if self.passed[0].1 != self.table.state {
            self.enter(self.table.state);
        }
        let mut entered = Vec::new();
        let moves = self.moves();
        self.table.settle(moves, |state| entered.push(state));
        for state in entered {
            self.enter(state);
        }
    }

    /// The motor is slow enough for the end of a ramp.
    fn is_slow(&self) -> bool {
        let last = self.positions.len() - 1;
        let before = last.saturating_sub(1);
        self.positions[last].abs_diff(self.positions[before]) <= 3
    }

    /// A millisecond passes, and what is shown has to be what the table says.
    fn millisecond(&mut self) -> Result<(), TestCaseError> {
        if self.has_sync {
            self.drive.queue("080 [0]");
        }
        let end = self.drive.now() + Duration::millis(1);
        while let Some(left) = end.checked_duration_since(self.drive.now()) {
            let Some(frame) = self.drive.next(left) else {
                break;
            };
            match (frame.standard_id(), frame.payload()) {
                (Some(0x184), [low, high, ..]) => {
                    let statusword = u16::from_le_bytes([*low, *high]);
                    self.unseen.retain(|state| !state.is_shown_by(statusword));
                }
                (Some(0x704), [0]) => self.has_booted = true,
                _ => {}
            }
        }
        self.now += 1;
        let position = self.drive.position();
        if self.positions.last() != Some(&position) {
            self.moved = self.now;
        }
        let distance = position - self.positions.last().copied().unwrap_or(position);
        self.positions.push(position);
        self.settle();
        let actuals = self.drive.axis().actuals();
        let shown = actuals.statusword;
        // The drive knows best when the motor stands: one that goes on before it does is caught at its speed.
        if self.moves() && self.is_slow() && !self.table.state.is_shown_by(shown) {
            let mut entered = Vec::new();
            if self.table.waits(true) {
                self.table.settle(false, |state| entered.push(state));
            }
            for state in entered {
                self.enter(state);
            }
        }
        let since = self.now.saturating_sub(SEEN);
        let recent = self.passed.iter().position(|(at, _)| *at < since);
        let recent = &self.passed[..recent.map_or(self.passed.len(), |old| old + 1)];
        // Transition 0, and what follows it by itself, comes before the boot-up message.
        if self.table.begins_anew(shown) {
            return Ok(());
        }
        let of = recent.iter().find(|(_, state)| state.is_shown_by(shown));
        prop_assert!(
            of.is_some(),
            "statusword {shown:04X}h, {recent:?} at {}, {:?}",
            self.now,
            self.table
        );
        let state = of.map_or(self.table.state, |(_, state)| *state);
        let has_power = self.drive.axis().plant().is_energised();
        prop_assert!(state.may_have_power() || !has_power, "power in {state:?}");
        prop_assert!(state != State::OperationEnabled || has_power, "no power");
        prop_assert!(
            has_power
                || distance.abs() <= 1
                || self.moved < self.now
                || self.passed[0].0 + 2 >= self.now,
            "it moves without power: {distance}"
        );
        if matches!(self.table.network, Network::Resetting { .. }) {
            return Ok(());
        }
        if self.passed[0].0.max(self.acted) + SEEN < self.now {
            let is_remote = shown & 1 << 9 != 0;
            prop_assert_eq!(
                is_remote,
                self.table.is_remote(),
                "bit 9 in {:?}",
                &self.table
            );
        }
        // At rest a mode is there within 10 ms.
        let still = self.moved.max(self.mode_written) + SEEN + STILL < self.now;
        if still {
            prop_assert_eq!(
                actuals.mode_display,
                self.table.mode,
                "6061h, {:?}",
                &self.table
            );
        }
        Ok(())
    }
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig { cases: 96, ..ProptestConfig::default() }))]

    #[test]
    fn d33_the_drive_follows_the_transition_table(
        actions in prop::collection::vec((any_action(), prop::sample::select(vec![3_u64, 11, 40, 120])), 1..60),
        move_first: bool,
    ) {
        let mut comparison = Comparison::new();
        if move_first {
            comparison.drive.begin_move(1_000_000);
            comparison.table.command(0x0F);
        }
        for (action, wait) in actions {
            comparison.act(action)?;
            for _ in 0..wait {
                comparison.millisecond().map_err(|error| {
                    TestCaseError::fail(format!("after {action:?}: {error}"))
                })?;
            }
            if wait > SEEN {
                let unseen = &comparison.unseen;
                prop_assert!(unseen.is_empty(), "no PDO has shown {unseen:?} after {action:?}");
            }
        }
    }
}
