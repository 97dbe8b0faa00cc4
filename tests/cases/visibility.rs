//! When a master sees what it has commanded: every transition and every change of the mode, in a transmit PDO as it is by default and by SDO, within
//! 10 ms of virtual time.

use canopen::Duration;
use tests::DriveBench;
use tests::drive::{
    FAULT, FAULT_REACTION_ACTIVE, OPERATION_ENABLED, QUICK_STOP_ACTIVE, READY_TO_SWITCH_ON,
    SWITCH_ON_DISABLED, SWITCHED_ON, State,
};

/// What a master may rely on, in microseconds.
const WITHIN: u64 = 10_000;

/// Everything that tells an object, with the microseconds since the master has asked for something.
#[derive(Debug, Default)]
struct Sightings {
    by_pdo: Vec<(u64, u16)>,
    by_sdo: Vec<(u64, u16)>,
}

/// Where to look for a value of one or two bytes.
#[derive(Clone, Copy)]
struct Look {
    cob_id: u16,
    /// Behind so many bytes of the PDO.
    offset: usize,
    index: u16,
    length: usize,
}

/// 6041h is all there is in TPDO 1.
const STATUSWORD: Look = Look {
    cob_id: 0x184,
    offset: 0,
    index: 0x6041,
    length: 2,
};

/// 6061h is behind 6041h in TPDO 2.
const MODE_DISPLAY: Look = Look {
    cob_id: 0x284,
    offset: 2,
    index: 0x6061,
    length: 1,
};

impl Look {
    fn value(self, bytes: &[u8]) -> Option<u16> {
        match bytes.get(..self.length)? {
            [low, high] => Some(u16::from_le_bytes([*low, *high])),
            [only] => Some(u16::from(*only)),
            _ => None,
        }
    }

    /// Listens for so many microseconds from `since` on, and asks by SDO in each millisecond.
    fn at(self, drive: &mut DriveBench, since: u64, micros: u64) -> Sightings {
        let mut seen = Sightings::default();
        let [low, high] = self.index.to_le_bytes();
        for _ in 0..micros / 1_000 {
            drive.queue(&format!("604: 40 {low:02X} {high:02X} 00"));
            let end = drive.now() + Duration::millis(1);
            while let Some(left) = end.checked_duration_since(drive.now()) {
                let Some(frame) = drive.next(left) else {
                    break;
                };
                let passed = drive.now().ticks() - since;
                let data = frame.payload();
                if frame.standard_id() == Some(self.cob_id) {
                    let value = data.get(self.offset..).and_then(|data| self.value(data));
                    seen.by_pdo.extend(value.map(|value| (passed, value)));
                } else if frame.standard_id() == Some(0x584) && data[1..3] == [low, high] {
                    let value = self.value(&data[4..]);
                    seen.by_sdo.extend(value.map(|value| (passed, value)));
                }
            }
        }
        seen
    }
}

impl Sightings {
    fn append(&mut self, other: Self) {
        self.by_pdo.extend(other.by_pdo);
        self.by_sdo.extend(other.by_sdo);
    }

    /// From a later moment on. Before it there may be nothing but this.
    #[track_caller]
    fn since(self, later: u64, is_meant: impl Fn(u16) -> bool) -> Self {
        let keep = |sightings: Vec<(u64, u16)>| {
            let (before, behind): (Vec<_>, Vec<_>) =
                sightings.into_iter().partition(|(at, _)| *at < later);
            assert!(
                before.iter().all(|(_, word)| is_meant(*word)),
                "{before:X?}"
            );
            behind
                .into_iter()
                .map(|(at, word)| (at - later, word))
                .collect()
        };
        Self {
            by_pdo: keep(self.by_pdo),
            by_sdo: keep(self.by_sdo),
        }
    }

    #[track_caller]
    fn shows_by_pdo(&self, what: &str, is_it: impl Fn(u16) -> bool) {
        let first = self.by_pdo.iter().find(|(_, value)| is_it(*value));
        assert!(
            first.is_some_and(|(at, _)| *at <= WITHIN),
            "{what} by PDO: {self:X?}"
        );
    }

    #[track_caller]
    fn shows(&self, what: &str, is_it: impl Fn(u16) -> bool) {
        self.shows_by_pdo(what, &is_it);
        let first = self.by_sdo.iter().find(|(_, value)| is_it(*value));
        assert!(
            first.is_some_and(|(at, _)| *at <= WITHIN),
            "{what} by SDO: {self:X?}"
        );
    }
}

/// How a state is got to from switch on disabled.
fn path(state: State) -> &'static [(u16, State)] {
    const PATH: [(u16, State); 4] = [
        (0x06, READY_TO_SWITCH_ON),
        (0x07, SWITCHED_ON),
        (0x0F, OPERATION_ENABLED),
        (0x02, QUICK_STOP_ACTIVE),
    ];
    let end = PATH.iter().position(|(_, reached)| *reached == state);
    &PATH[..end.map_or(0, |end| end + 1)]
}

/// A drive that has been in a state for a while. Its quick stops stay (605Ah = 6).
fn drive_in(state: State) -> DriveBench {
    let mut drive = DriveBench::started(4);
    drive.write_i16(0x605A, 0, 6);
    for (controlword, reached) in path(state) {
        drive.command(*controlword);
        drive.reaches(*reached, 10);
    }
    if state == FAULT {
        drive.set_fault(Some(0x4310));
        drive.reaches(FAULT, 20);
        drive.set_fault(None);
    }
    drive.drain(33);
    drive
}

/// The same, at 10,000 steps/s; slowing down takes 100 ms.
fn moving() -> DriveBench {
    let mut drive = drive_in(OPERATION_ENABLED);
    drive.begin_move(1_000_000);
    drive.drain(300);
    drive
}

/// A controlword, and what is seen from then on.
fn command(drive: &mut DriveBench, controlword: u16, micros: u64) -> Sightings {
    drive.command(controlword);
    let sent = drive.now().ticks();
    STATUSWORD.at(drive, sent, micros)
}

#[track_caller]
fn shows(seen: &Sightings, what: &str, state: State) {
    seen.shows(what, |statusword| state.is_shown_by(statusword));
}

#[track_caller]
fn shows_by_pdo(seen: &Sightings, what: &str, state: State) {
    seen.shows_by_pdo(what, |statusword| state.is_shown_by(statusword));
}

#[test]
fn m01_and_m02_transitions_0_and_1_are_seen_within_10_ms_of_the_boot_up_message() {
    for by_power in [true, false] {
        let mut drive = drive_in(READY_TO_SWITCH_ON);
        if by_power {
            drive.axis().power_cycle();
        } else {
            drive.send("000 [2] 81 04");
        }
        drive.drain_until("704 [1] 00", 100);
        let booted = drive.now().ticks();
        let seen = STATUSWORD.at(&mut drive, booted, 5_000);
        assert!(seen.by_pdo.is_empty(), "it is Pre-operational");
        let first = seen
            .by_sdo
            .iter()
            .find(|(_, word)| SWITCH_ON_DISABLED.is_shown_by(*word));
        assert!(first.is_some(), "{seen:X?}");
        drive.send("000 [2] 01 04");
        let started = drive.now().ticks();
        let seen = STATUSWORD.at(&mut drive, started, WITHIN);
        shows(&seen, "0 and 1", SWITCH_ON_DISABLED);
    }
}

#[test]
fn m02_every_transition_by_a_command_is_seen_in_a_pdo_and_by_sdo_within_10_ms() {
    for (number, from, controlword, to) in [
        (2, SWITCH_ON_DISABLED, 0x06, READY_TO_SWITCH_ON),
        (3, READY_TO_SWITCH_ON, 0x07, SWITCHED_ON),
        (4, SWITCHED_ON, 0x0F, OPERATION_ENABLED),
        (5, OPERATION_ENABLED, 0x07, SWITCHED_ON),
        (6, SWITCHED_ON, 0x06, READY_TO_SWITCH_ON),
        (7, READY_TO_SWITCH_ON, 0x02, SWITCH_ON_DISABLED),
        (7, READY_TO_SWITCH_ON, 0x00, SWITCH_ON_DISABLED),
        (8, OPERATION_ENABLED, 0x06, READY_TO_SWITCH_ON),
        (9, OPERATION_ENABLED, 0x00, SWITCH_ON_DISABLED),
        (10, SWITCHED_ON, 0x02, SWITCH_ON_DISABLED),
        (10, SWITCHED_ON, 0x00, SWITCH_ON_DISABLED),
        (11, OPERATION_ENABLED, 0x02, QUICK_STOP_ACTIVE),
        (12, QUICK_STOP_ACTIVE, 0x00, SWITCH_ON_DISABLED),
        (15, FAULT, 0x80, SWITCH_ON_DISABLED),
        (16, QUICK_STOP_ACTIVE, 0x0F, OPERATION_ENABLED),
    ] {
        // The event timer of TPDO 1 (100 ms) and the control tick are wherever they are.
        for wait in [0, 377, 61_000] {
            let mut drive = drive_in(from);
            drive.run_micros(wait);
            drive.drain(0);
            let seen = command(&mut drive, controlword, WITHIN);
            shows(&seen, &format!("transition {number}"), to);
        }
    }
}

#[test]
fn m02_transitions_3_and_4_in_one_command_are_both_seen_in_a_pdo_within_10_ms() {
    let mut drive = drive_in(READY_TO_SWITCH_ON);
    let seen = command(&mut drive, 0x0F, WITHIN);
    shows_by_pdo(&seen, "transition 3", SWITCHED_ON);
    shows(&seen, "transition 4", OPERATION_ENABLED);
}

#[test]
fn m02_transitions_that_end_a_motion_are_seen_within_10_ms_of_where_they_are_due() {
    // Power off at once: 5, 8, 9.
    for (index, controlword, to) in [
        (0x605C, 0x07, SWITCHED_ON),
        (0x605B, 0x06, READY_TO_SWITCH_ON),
        (0x605B, 0x00, SWITCH_ON_DISABLED),
    ] {
        let mut drive = moving();
        drive.write_i16(index, 0, 0);
        drive.drain(33);
        let seen = command(&mut drive, controlword, WITHIN);
        shows(&seen, "at once", to);
    }
    // On a ramp: 5, 8 and 12 by itself.
    for (index, option, controlword, between, to) in [
        (0x605C, 1, 0x07, OPERATION_ENABLED, SWITCHED_ON),
        (0x605B, 1, 0x06, OPERATION_ENABLED, READY_TO_SWITCH_ON),
        (0x605A, 1, 0x02, QUICK_STOP_ACTIVE, SWITCH_ON_DISABLED),
    ] {
        let mut drive = moving();
        drive.write_i16(index, 0, option);
        drive.drain(33);
        let seen = command(&mut drive, controlword, WITHIN);
        if between == QUICK_STOP_ACTIVE {
            shows(&seen, "transition 11", between);
        }
        shows(&at_rest(&mut drive), "at rest", to);
    }
}

/// What is seen from the last millisecond on in which the motor has made a step. Until then nothing changes: the state stands on the ramp.
fn at_rest(drive: &mut DriveBench) -> Sightings {
    let begin = drive.now().ticks();
    let before = drive.statusword() & 0x6F;
    let mut stands = begin;
    let mut seen = Sightings::default();
    while drive.now().ticks() < begin + 300_000 {
        let now = drive.now().ticks();
        let position = drive.position();
        seen.append(STATUSWORD.at(drive, begin, 1_000));
        if drive.position() != position {
            stands = now;
        }
    }
    assert!(stands > begin + 50_000, "that was no ramp");
    seen.since(stands - begin, |word| word & 0x6F == before)
}

#[test]
fn m08_a_quick_stop_at_rest_and_what_follows_are_seen_within_10_ms() {
    for option in [0, 1, 2, 3, 4] {
        let mut drive = drive_in(OPERATION_ENABLED);
        drive.write_i16(0x605A, 0, option);
        drive.drain(33);
        let seen = command(&mut drive, 0x02, WITHIN);
        shows_by_pdo(&seen, "transition 11", QUICK_STOP_ACTIVE);
        shows(&seen, "transition 12", SWITCH_ON_DISABLED);
    }
}

#[test]
fn m10_a_fault_is_seen_in_every_state_within_10_ms() {
    for from in [
        SWITCH_ON_DISABLED,
        READY_TO_SWITCH_ON,
        SWITCHED_ON,
        OPERATION_ENABLED,
        QUICK_STOP_ACTIVE,
    ] {
        let mut drive = drive_in(from);
        drive.set_fault(Some(0x4310));
        let appeared = drive.now().ticks();
        let seen = STATUSWORD.at(&mut drive, appeared, WITHIN);
        shows_by_pdo(&seen, "transition 13", FAULT_REACTION_ACTIVE);
        shows(&seen, "transition 14", FAULT);
    }
    // Not ready to switch on: the fault is there when the device starts anew.
    let mut drive = drive_in(SWITCH_ON_DISABLED);
    drive.set_fault(Some(0x4310));
    drive.send("000 [2] 81 04");
    drive.drain_until("704 [1] 00", 100);
    let booted = drive.now().ticks();
    let seen = STATUSWORD.at(&mut drive, booted, WITHIN);
    let first = seen
        .by_sdo
        .iter()
        .find(|(_, word)| FAULT.is_shown_by(*word));
    assert!(first.is_some(), "{seen:X?}");
}

#[test]
fn m10_a_fault_reaction_on_a_ramp_is_seen_within_10_ms_and_so_is_its_end() {
    let mut drive = moving();
    drive.write_i16(0x605E, 0, 1);
    drive.drain(33);
    drive.set_fault(Some(0x4310));
    let appeared = drive.now().ticks();
    let seen = STATUSWORD.at(&mut drive, appeared, WITHIN);
    shows(&seen, "transition 13", FAULT_REACTION_ACTIVE);
    shows(&at_rest(&mut drive), "transition 14", FAULT);
}

/// TPDO 2 (6041h, 6061h) and RPDO 2 (6040h, 6060h), which are there but not valid by default.
fn with_modes_in_pdos(drive: &mut DriveBench) {
    drive.write_u32(0x1801, 1, 0x4000_0284);
    drive.write_u32(0x1401, 1, 0x304);
}

/// The controlword that keeps a drive in a state, once it has got there by [`path`].
fn last_command(state: State) -> u16 {
    path(state)
        .last()
        .map_or(0, |(controlword, _)| *controlword)
}

#[test]
fn m20_every_mode_change_at_rest_is_seen_in_a_pdo_and_by_sdo_within_10_ms() {
    const MODES: [i8; 8] = [1, 2, 3, 6, 7, 8, 9, 0];
    for state in [
        SWITCH_ON_DISABLED,
        READY_TO_SWITCH_ON,
        SWITCHED_ON,
        OPERATION_ENABLED,
        QUICK_STOP_ACTIVE,
        FAULT,
    ] {
        for halt in [0, 0x100] {
            let mut drive = drive_in(state);
            let controlword = if state == FAULT {
                0x0F
            } else {
                last_command(state)
            };
            with_modes_in_pdos(&mut drive);
            drive.command(controlword | halt);
            drive.drain(33);
            // From every mode to every other one, by SDO and by RPDO.
            for (step, pair) in every_pair(&MODES).windows(2).enumerate() {
                let [before, mode] = [pair[0], pair[1]];
                let code = mode.cast_unsigned();
                if step == 0 {
                    drive.write_u8(0x6060, 0, before.cast_unsigned());
                    drive.drain(33);
                }
                if step % 2 == 0 {
                    drive.send(&format!("604: 2F 60 60 00 {code:02X}"));
                } else {
                    let [low, high] = (controlword | halt).to_le_bytes();
                    drive.send(&format!("304 [3] {low:02X} {high:02X} {code:02X}"));
                }
                let sent = drive.now().ticks();
                let seen = MODE_DISPLAY.at(&mut drive, sent, WITHIN);
                let what = format!("{before} to {mode}, halt {halt:X}h");
                seen.shows(&what, |shown| shown == u16::from(code));
                let statusword = drive.statusword();
                assert!(state.is_shown_by(statusword), "{what}: {statusword:04X}h");
            }
            assert_eq!(drive.position(), 0);
        }
    }
}

/// A way through modes on which each follows each other one.
fn every_pair(modes: &[i8]) -> Vec<i8> {
    let mut way = Vec::new();
    for (number, first) in modes.iter().enumerate() {
        for second in &modes[number + 1..] {
            way.extend([*first, *second]);
        }
        way.push(*first);
    }
    way
}
