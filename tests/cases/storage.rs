//! Store and restore parameters (1010h, 1011h, 1020h) on the virtual drive, whose sectors outlive its power.

use sim::drive::Setup;
use sim::flash::Flash;
use tests::DriveBench;

const SAVE_ALL: &str = "604: 23 10 10 01 73 61 76 65";
const SAVED_ALL: &str = "584: 60 10 10 01 00 00 00 00";
const LOAD_ALL: &str = "604: 23 11 10 01 6C 6F 61 64";
const LOADED_ALL: &str = "584: 60 11 10 01 00 00 00 00";

/// Takes the power away and gives it back.
fn restart(bench: &mut DriveBench) {
    bench.axis().power_cycle();
    bench.drain_until("704 [1] 00", 100);
}

/// Sends an order and waits for its answer.
fn order(bench: &mut DriveBench, order: &str, answer: &str) {
    bench.queue(order);
    bench.expect(answer);
}

#[test]
fn saved_parameters_outlive_the_power() {
    let mut bench = DriveBench::booted(4);
    bench.write_u32(0x6081, 0, 4_321);
    bench.write_u32(0x6083, 0, 70_000);
    bench.write_u16(0x1015, 0, 7);
    order(&mut bench, SAVE_ALL, SAVED_ALL);
    restart(&mut bench);
    assert_eq!(bench.read_u32(0x6081, 0), 4_321);
    assert_eq!(bench.read_u32(0x6083, 0), 70_000);
    assert_eq!(bench.try_read(0x1015, 0), Ok(vec![7, 0]));
    // Commands and targets are not parameters.
    assert_eq!(bench.read_u32(0x607A, 0), 0);
}

#[test]
fn the_drive_moves_with_what_was_saved() {
    let mut bench = DriveBench::booted(4);
    bench.write_u32(0x6081, 0, 1_000);
    order(&mut bench, SAVE_ALL, SAVED_ALL);
    restart(&mut bench);
    bench.start();
    bench.reaches(tests::drive::SWITCH_ON_DISABLED, 20);
    bench.enable();
    bench.begin_move(2_000);
    bench.run_millis(1_000);
    let position = bench.position();
    assert!(
        (900..1_100).contains(&position),
        "{position} steps in a second"
    );
}

#[test]
fn flash_that_fails_is_told_and_the_parameters_stay() {
    let mut flash = Flash::in_memory();
    flash.break_down();
    let setup = Setup {
        store: flash.into_store(),
        ..Setup::with_node_id(1, 4)
    };
    let mut bench = DriveBench::with(setup, 4);
    bench.refused(SAVE_ALL, 0x0606_0000);
    assert_eq!(bench.read_u32(0x6081, 0), 10_000);
}

#[test]
fn defaults_come_with_the_reset_and_not_before() {
    let mut bench = DriveBench::booted(4);
    bench.write_u32(0x6081, 0, 4_321);
    order(&mut bench, SAVE_ALL, SAVED_ALL);
    order(&mut bench, LOAD_ALL, LOADED_ALL);
    assert_eq!(bench.read_u32(0x6081, 0), 4_321);
    bench.send("000 [2] 81 04");
    bench.drain_until("704 [1] 00", 100);
    assert_eq!(bench.read_u32(0x6081, 0), 10_000);
}

#[test]
fn a_group_is_restored_without_the_others() {
    let mut bench = DriveBench::booted(4);
    bench.write_u32(0x6081, 0, 4_321);
    bench.write_u16(0x1015, 0, 7);
    order(&mut bench, SAVE_ALL, SAVED_ALL);
    order(
        &mut bench,
        "604: 23 11 10 03 6C 6F 61 64",
        "584: 60 11 10 03 00 00 00 00",
    );
    restart(&mut bench);
    assert_eq!(bench.read_u32(0x6081, 0), 10_000);
    assert_eq!(bench.try_read(0x1015, 0), Ok(vec![7, 0]));
}

#[test]
fn r07_nothing_is_stored_while_the_motor_has_power() {
    let mut bench = DriveBench::enabled(4);
    bench.write_u32(0x6081, 0, 4_321);
    bench.begin_move(100_000);
    bench.drain(150);
    // The event timer of TPDO 1 would speak in between.
    bench.write_u16(0x1800, 5, 0);
    bench.drain(20);
    let before = bench.position();
    bench.queue(SAVE_ALL);
    bench.drain_until("584: 80 10 10 01 22 00 00 08", 100);
    assert!(bench.position() > before, "the motor turns on");
    // Switched off it is stored.
    bench.command(0x00);
    bench.reaches(tests::drive::SWITCH_ON_DISABLED, 2_000);
    bench.queue(SAVE_ALL);
    bench.drain_until(SAVED_ALL, 100);
    restart(&mut bench);
    assert_eq!(bench.read_u32(0x6081, 0), 4_321);
}

#[test]
fn a_damaged_set_is_told_and_the_drive_starts_with_defaults() {
    let mut bench = DriveBench::booted(4);
    bench.write_u32(0x6081, 0, 0x000A_5A5A);
    order(&mut bench, SAVE_ALL, SAVED_ALL);
    let stored = 0x000A_5A5A_u32.to_le_bytes();
    bench.axis().with_flash(|flash| flash.wear_out(&stored));
    bench.axis().power_cycle();
    bench.drain_until("704 [1] 00", 100);
    bench.expect("084: 10 63 01 03 00 00 00 00");
    assert_eq!(bench.read_u32(0x6081, 0), 10_000);
    // A save makes it whole again.
    bench.queue(SAVE_ALL);
    bench.drain_until(SAVED_ALL, 100);
    restart(&mut bench);
    bench.silence(50);
}

#[test]
fn a_changed_parameter_undates_the_configuration() {
    let mut bench = DriveBench::booted(4);
    bench.write_u32(0x6081, 0, 4_321);
    bench.write_u32(0x1020, 1, 15_579);
    bench.write_u32(0x1020, 2, 41_400_000);
    order(&mut bench, SAVE_ALL, SAVED_ALL);
    restart(&mut bench);
    assert_eq!(bench.read_u32(0x1020, 1), 15_579);
    assert_eq!(bench.read_u32(0x1020, 2), 41_400_000);
    bench.write_u32(0x6084, 0, 70_000);
    assert_eq!(bench.read_u32(0x1020, 1), 0);
    assert_eq!(bench.read_u32(0x1020, 2), 0);
}

#[test]
fn pdos_start_as_they_were_saved() {
    let mut bench = DriveBench::booted(4);
    // TPDO 2: statusword and mode display on an identifier of its own, at every SYNC.
    bench.write_u32(0x1801, 1, 0xC000_0284);
    bench.write_u8(0x1A01, 0, 0);
    bench.write_u32(0x1A01, 1, 0x6041_0010);
    bench.write_u32(0x1A01, 2, 0x6061_0008);
    bench.write_u8(0x1A01, 0, 2);
    bench.write_u8(0x1801, 2, 1);
    bench.write_u32(0x1801, 1, 0x4000_0299);
    order(&mut bench, SAVE_ALL, SAVED_ALL);
    restart(&mut bench);
    bench.start();
    bench.drain(20);
    bench.queue("080 [0]");
    bench.drain_until("299 [3] 50 02 01", 20);
}
