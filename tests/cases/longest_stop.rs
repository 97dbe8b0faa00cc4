//! A stop that the drive makes on its own has an end, whatever its ramp (20A1h): a motor that turns can always be stopped.

use canopen::{ControllerState, Frame};
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;
use tests::DriveBench;
use tests::drive::{FAULT, FAULT_REACTION_ACTIVE, QUICK_STOP_ACTIVE, SWITCH_ON_DISABLED};

/// 20A1h as it comes, in milliseconds.
const LONGEST: u64 = 2_000;

/// What is around it: control ticks, the boot.
const SLACK: u64 = 10;

/// A drive that turns at 5,000 steps/s and sends a heartbeat every 100 ms. Under power its quick stop ramp has been made one of 5,000 s.
fn turning() -> DriveBench {
    let mut drive = DriveBench::started(4);
    drive.write_u8(0x6060, 0, 3);
    drive.write_u32(0x6083, 0, 50_000);
    drive.write_i32(0x60FF, 0, 5_000);
    drive.write_u16(0x1017, 0, 100);
    drive.enable();
    drive.run_millis(150);
    drive.send("604: 23 85 60 00 01 00 00 00");
    drive.drain_until("584: 60 85 60 00", 10);
    drive.drain(1);
    drive
}

/// The same, braking already, because of `cause`.
fn braking(cause: Cause) -> DriveBench {
    let mut drive = turning();
    cause.prepare(&mut drive);
    cause.occur(&mut drive);
    drive.drain(300);
    assert!(turns(&mut drive), "{cause:?}: it brakes on its ramp");
    drive
}

/// Why the drive stops on its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Cause {
    ResetNode,
    ResetCommunication,
    Stopped,
    /// A lost heartbeat, with this in 6007h.
    Lost(i16),
    BusOff,
    Fault,
}

impl Cause {
    const ALL: [Self; 7] = [
        Self::ResetNode,
        Self::ResetCommunication,
        Self::Stopped,
        Self::Lost(1),
        Self::Lost(3),
        Self::BusOff,
        Self::Fault,
    ];

    fn prepare(self, drive: &mut DriveBench) {
        if let Self::Lost(option) = self {
            drive.write_i16(0x6007, 0, option);
            drive.write_u32(0x1016, 1, 0x007F_0064);
            drive.send("77F [1] 05");
        }
    }

    fn occur(self, drive: &mut DriveBench) {
        match self {
            Self::ResetNode => drive.send("000 [2] 81 04"),
            Self::ResetCommunication => drive.send("000 [2] 82 04"),
            Self::Stopped => drive.send("000 [2] 02 04"),
            Self::Lost(_) => drive.run_millis(100),
            Self::BusOff => drive.set_controller(ControllerState::BusOff),
            Self::Fault => drive.set_fault(Some(0x4210)),
        }
    }

    /// Whether the drive boots behind its stop.
    fn boots(self) -> bool {
        matches!(self, Self::ResetNode | Self::ResetCommunication)
    }
}

/// Whether the motor moves within two milliseconds.
fn turns(drive: &mut DriveBench) -> bool {
    let before = drive.position();
    drive.run_millis(2);
    drive.position() != before
}

/// No pulse leaves any more, and there is no current.
#[track_caller]
fn is_off(drive: &mut DriveBench) {
    assert!(!drive.axis().plant().is_energised());
    let before = drive.position();
    drive.run_millis(1_000);
    assert_eq!(drive.position(), before);
}

#[test]
fn a_stop_of_the_drive_ends_when_20a1h_says() {
    for cause in Cause::ALL {
        for longest in [None, Some(300)] {
            let mut drive = turning();
            if let Some(longest) = longest {
                drive.write_u16(0x20A1, 0, longest);
            }
            let longest = longest.map_or(LONGEST, u64::from);
            cause.prepare(&mut drive);
            cause.occur(&mut drive);
            drive.run_millis(longest - SLACK);
            assert!(turns(&mut drive), "{cause:?}: the ramp goes first");
            assert!(drive.axis().plant().is_energised());
            drive.run_millis(2 * SLACK);
            is_off(&mut drive);
            let end = match cause {
                Cause::Fault | Cause::Lost(1) => FAULT,
                _ => SWITCH_ON_DISABLED,
            };
            assert!(end.is_shown_by(drive.statusword()), "{cause:?}");
        }
    }
}

#[test]
fn n18_a_drive_that_brakes_for_a_reset_is_heard_and_boots_in_time() {
    for command in ["000 [2] 81 04", "000 [2] 82 04"] {
        let mut drive = turning();
        drive.drain_until("704 [1] 05", 110);
        drive.send(command);
        let begin = drive.now();
        for beat in 0..LONGEST / 100 - 1 {
            drive.drain_until("704 [1] 05", 101);
            if beat == 5 {
                drive.set_fault(Some(0x4210));
                drive.drain_until("084: 10 42 09", 5);
                drive.set_fault(None);
            }
        }
        drive.drain_until("704 [1] 00", 200);
        let after = (drive.now() - begin).to_millis();
        // The fault has a reaction of its own, which is the same stop.
        assert!((LONGEST..LONGEST + SLACK).contains(&after), "{after} ms");
        is_off(&mut drive);
    }
}

#[test]
fn disable_voltage_ends_every_stop_at_once() {
    for cause in Cause::ALL {
        if matches!(cause, Cause::Stopped | Cause::BusOff) {
            continue;
        }
        for frame in ["204 [2] 00 00", "604: 2B 40 60 00 00 00"] {
            let mut drive = braking(cause);
            if matches!(cause, Cause::Lost(_)) {
                // It is Pre-operational, where no PDO is taken.
                drive.send("000 [2] 01 04");
                drive.drain(2);
            }
            drive.send(frame);
            if cause.boots() {
                drive.drain_until("704 [1] 00", SLACK);
            } else {
                drive.run_millis(3);
            }
            is_off(&mut drive);
        }
    }
}

#[test]
fn disable_voltage_ends_a_stop_in_a_network_that_has_come_back() {
    let mut drive = braking(Cause::Stopped);
    drive.send("000 [2] 01 04");
    drive.drain(20);
    assert!(QUICK_STOP_ACTIVE.is_shown_by(drive.statusword()));
    drive.command(0x00);
    drive.run_millis(3);
    is_off(&mut drive);
}

#[test]
fn n18_a_second_reset_waits_for_no_ramp() {
    for cause in [Cause::ResetNode, Cause::ResetCommunication] {
        for command in ["000 [2] 81 04", "000 [2] 82 04"] {
            let mut drive = braking(cause);
            drive.send(command);
            drive.drain_until("704 [1] 00", SLACK);
            is_off(&mut drive);
            let position = drive.read_u32(0x6085, 0);
            let is_kept = cause == Cause::ResetCommunication && command == "000 [2] 82 04";
            assert_eq!(position == 1, is_kept, "the wider of the two is done");
        }
    }
}

#[test]
fn a_reset_during_a_reaction_and_a_stop_during_a_reset_end_in_time() {
    for (first, second) in [
        (Cause::Fault, Cause::ResetNode),
        (Cause::Lost(1), Cause::ResetNode),
        (Cause::ResetNode, Cause::Stopped),
        (Cause::ResetNode, Cause::Fault),
        (Cause::Stopped, Cause::ResetCommunication),
    ] {
        let mut drive = braking(first);
        second.occur(&mut drive);
        // What has begun to stop is not given another two seconds.
        drive.drain_until("704 [1] 00", LONGEST - 300 + SLACK);
        drive.set_fault(None);
        is_off(&mut drive);
    }
}

#[test]
fn what_takes_the_power_away_does_so_in_every_stop() {
    for cause in Cause::ALL {
        for is_cut in [false, true] {
            let mut drive = braking(cause);
            if is_cut {
                drive.set_fault(Some(0x9000));
            } else {
                drive.set_supply(false);
            }
            drive.run_millis(3);
            is_off(&mut drive);
        }
    }
}

#[test]
fn a_slow_limit_60c6h_holds_no_stop_up_either() {
    let mut drive = turning();
    drive.write_u32(0x6085, 0, 1_000_000);
    drive.write_u32(0x60C6, 0, 1);
    drive.send("000 [2] 81 04");
    drive.drain_until("704 [1] 00", LONGEST + SLACK);
    is_off(&mut drive);
}

#[test]
fn the_brake_closes_before_the_power_goes() {
    let mut drive = turning();
    drive.write_u16(0x2040, 2, 40);
    drive.send("000 [2] 81 04");
    drive.run_millis(LONGEST - SLACK);
    assert!(drive.axis().plant().is_brake_open());
    drive.run_millis(2 * SLACK);
    assert!(!drive.axis().plant().is_brake_open());
    assert!(drive.axis().plant().is_energised(), "until it holds");
    drive.drain_until("704 [1] 00", 40);
    is_off(&mut drive);
}

#[test]
fn a_fault_reaction_is_shown_until_it_ends() {
    let mut drive = turning();
    drive.write_u16(0x20A1, 0, 500);
    drive.set_fault(Some(0x4210));
    drive.run_millis(490);
    assert!(FAULT_REACTION_ACTIVE.is_shown_by(drive.statusword()));
    drive.reaches(FAULT, 20);
    is_off(&mut drive);
}

/// Something that a master, or the world, does to a drive.
#[derive(Clone, Debug)]
enum Step {
    Command(u16),
    Write32(u16, u32),
    Write16(u16, u16),
    Mode(u8),
    Nmt(u8),
    Fault(Option<u16>),
    Wait(u64),
}

impl Step {
    fn take(&self, drive: &mut DriveBench) {
        let sdo = |command: u8, index: u16, value: u32| {
            let ([low, high], [a, b, c, d]) = (index.to_le_bytes(), value.to_le_bytes());
            Frame::data_frame(0x604, &[command, low, high, 0, a, b, c, d])
        };
        match *self {
            Self::Command(word) => drive.command(word),
            Self::Write32(index, value) => drive.send_frame(sdo(0x23, index, value)),
            Self::Write16(index, value) => drive.send_frame(sdo(0x2B, index, value.into())),
            Self::Mode(mode) => drive.send_frame(sdo(0x2F, 0x6060, mode.into())),
            Self::Nmt(command) => drive.send_frame(Frame::data_frame(0, &[command, 4])),
            Self::Fault(code) => drive.set_fault(code),
            Self::Wait(milliseconds) => drive.run_millis(milliseconds),
        }
    }
}

fn step() -> impl Strategy<Value = Step> {
    let words = vec![0x00, 0x02, 0x06, 0x07, 0x0F, 0x1F, 0x3F, 0x10F, 0x80, 0x8F];
    let ramps = vec![0x6083, 0x6084, 0x6085, 0x60C5, 0x60C6];
    let goals = vec![0x607A, 0x6081, 0x60FF];
    let options = vec![0x605A, 0x605B, 0x605C, 0x605D, 0x605E, 0x6007];
    prop_oneof![
        6 => prop::sample::select(words).prop_map(Step::Command),
        2 => (prop::sample::select(ramps), prop::sample::select(vec![1, 50_000, 1_000_000]))
            .prop_map(|(index, value)| Step::Write32(index, value)),
        3 => (prop::sample::select(goals), prop::sample::select(vec![0, 5_000, 20_000, 200_000]))
            .prop_map(|(index, value)| Step::Write32(index, value)),
        1 => (prop::sample::select(options), 0..=8_u16).prop_map(|(index, value)| Step::Write16(index, value)),
        1 => Just(Step::Write16(0x6086, 2)),
        1 => prop::sample::select(vec![1, 2, 3, 6, 7, 8, 9]).prop_map(Step::Mode),
        1 => prop::sample::select(vec![0x01, 0x02, 0x80]).prop_map(Step::Nmt),
        1 => prop::option::of(prop::sample::select(vec![0x4210, 0x2310])).prop_map(Step::Fault),
        6 => (0..120_u64).prop_map(Step::Wait),
    ]
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig::with_cases(60)))]

    #[test]
    fn after_disable_voltage_and_a_reset_there_is_no_pulse_and_the_drive_boots(steps in prop::collection::vec(step(), 1..40), is_running in prop::bool::ANY) {
        let mut drive = if is_running { turning() } else { DriveBench::started(4) };
        for step in &steps {
            step.take(&mut drive);
        }
        drive.send("000 [2] 01 04");
        drive.command(0x00);
        drive.send("000 [2] 81 04");
        drive.drain_until("704 [1] 00", SLACK);
        let before = drive.position();
        drive.drain(500);
        prop_assert_eq!(drive.position(), before);
    }

    #[test]
    fn after_a_reset_alone_the_drive_boots_within_its_longest_stop(steps in prop::collection::vec(step(), 1..40)) {
        let mut drive = turning();
        for step in &steps {
            step.take(&mut drive);
        }
        drive.send("000 [2] 81 04");
        drive.drain_until("704 [1] 00", LONGEST + SLACK);
        let before = drive.position();
        drive.drain(500);
        prop_assert_eq!(drive.position(), before);
    }
}
