//! Each kind of fault of the drive as candump shows it, from operation enabled on: its emergency message, the statusword, its reset.

use canopen::{Duration, Frame};
use sim::plant::{Axis, STEP_CLOCK_HZ, SupplyChange, SupplyData, Switch, Track};
use tests::drive::DriveBench;

/// The fault comes and goes, and a rising edge of controlword bit 7 resets it.
fn trace_of(mut come: impl FnMut(&mut DriveBench), mut go: impl FnMut(&mut DriveBench)) -> String {
    let mut drive = DriveBench::enabled(4);
    drive.run_millis(20);
    come(&mut drive);
    drive.run_millis(30);
    go(&mut drive);
    drive.run_millis(10);
    drive.command(0x80);
    drive.run_millis(30);
    drive.candump()
}

#[test]
fn overcurrent_of_the_power_stage() {
    insta::assert_snapshot!(trace_of(
        |drive| drive.set_fault(Some(0x2310)),
        |drive| drive.set_fault(None)
    ));
}

#[test]
fn a_power_stage_that_is_too_hot() {
    insta::assert_snapshot!(trace_of(
        |drive| drive.set_fault(Some(0x4210)),
        |drive| drive.set_fault(None)
    ));
}

#[test]
fn a_supply_that_is_lost() {
    insta::assert_snapshot!(trace_of(
        |drive| drive.set_supply(false),
        |drive| drive.set_supply(true)
    ));
}

#[test]
fn a_fault_whose_cause_stands_returns() {
    insta::assert_snapshot!(trace_of(|drive| drive.set_fault(Some(0x2310)), |_| {}));
}

/// The step clock runs on for 3 ms in which no tick comes: what was committed is played, and nothing is left.
#[test]
fn pulses_that_come_too_late() {
    insta::assert_snapshot!(trace_of(
        |drive| {
            drive.begin_move(10_000);
            let late = 3 * STEP_CLOCK_HZ / 1_000;
            let plant = drive.axis().plant_mut();
            plant.pulses_mut().play(late.into(), |_| {});
        },
        |_| {}
    ));
}

#[test]
fn a_motor_that_is_not_where_its_pulses_lead() {
    insta::assert_snapshot!(trace_of(
        |drive| drive.axis().plant_mut().displace(-1),
        |_| {}
    ));
}

#[test]
fn both_limit_switches_at_once() {
    let between = |negative, positive| Axis {
        track: Track {
            negative_limit: Some(Switch::up_to(negative)),
            positive_limit: Some(Switch::from(positive)),
            ..Track::default()
        },
        ..Axis::default()
    };
    insta::assert_snapshot!(trace_of(
        |drive| drive.axis().plant_mut().mount(&between(10, -10)),
        |drive| drive.axis().plant_mut().mount(&between(-1_000, 1_000))
    ));
}

/// Stop category 0 by the break input of the step timer: the power goes at once.
#[test]
fn pulses_that_are_cut_off_from_outside() {
    insta::assert_snapshot!(trace_of(
        |drive| {
            drive.begin_move(10_000);
            drive.set_fault(Some(0x9000));
        },
        |drive| drive.set_fault(None)
    ));
}

/// 24 V with 65 V in between, for 20 ms.
#[test]
fn a_supply_that_rises_too_high() {
    let axis = Axis {
        supply: Some(SupplyData {
            changes: vec![SupplyChange {
                at: Duration::millis(80),
                duration: Duration::millis(20),
                voltage: 65_000,
            }],
            ..SupplyData::default()
        }),
        ..Axis::default()
    };
    let mut drive = DriveBench::on(axis);
    drive.enable();
    drive.run_millis(100);
    drive.command(0x80);
    drive.run_millis(30);
    insta::assert_snapshot!(drive.candump());
}

/// SYNC goes on each 10 ms, and no set-points come with it any more: two are bridged.
#[test]
fn set_points_that_stay_away() {
    let mut drive = DriveBench::started(4);
    drive.write_u8(0x6060, 0, 8);
    drive.write_u8(0x60C2, 1, 10);
    drive.write_u8(0x1402, 2, 1);
    drive.enable();
    for target in [0_i32, 0, 0, 0, 50, 100, 150] {
        let [a, b, c, d] = target.to_le_bytes();
        drive.send_frame(Frame::data_frame(0x404, &[0x0F, 0, a, b, c, d]));
        drive.send("080 [0]");
        drive.run_millis(10);
    }
    for _ in 0..10 {
        drive.send("080 [0]");
        drive.run_millis(10);
    }
    drive.command(0x80);
    drive.run_millis(30);
    insta::assert_snapshot!(drive.candump());
}
