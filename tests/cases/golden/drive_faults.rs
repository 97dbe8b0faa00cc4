//! Each kind of fault of the drive as candump shows it, from operation enabled on: its emergency message, the statusword, its reset.

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
