//! Faults of the bus as a drive sees them: bus-off, lost frames, clients that fall silent.

use canopen::can_controller::ControllerState;
use tests::DriveBench;

#[test]
fn a_drive_stops_when_its_controller_leaves_the_bus() {
    let mut bench = DriveBench::enabled(4);
    bench.begin_move(1_000_000);
    bench.run_millis(100);
    bench.set_controller(ControllerState::BusOff);
    bench.run_millis(60);
    let stopped = bench.position();
    bench.run_millis(500);
    assert_eq!(bench.position(), stopped);
    assert!(tests::drive::SWITCH_ON_DISABLED.is_shown_by(bench.statusword()));
}

#[test]
fn what_the_drive_has_counted_can_be_read() {
    let mut bench = DriveBench::booted(4);
    bench.set_controller(ControllerState::ErrorPassive);
    bench.drain(20);
    bench.set_controller(ControllerState::BusOff);
    bench.drain(300);
    bench.lose_frames(2);
    for _ in 0..2 {
        bench.send("123 [0]");
    }
    bench.drain(20);
    assert_eq!(bench.read_u32(0x2010, 1), 1, "error passive");
    assert_eq!(bench.read_u32(0x2010, 2), 1, "bus-off");
    assert_eq!(bench.read_u32(0x2010, 3), 1, "restarts");
    assert_eq!(bench.read_u32(0x2010, 4), 2, "lost frames");
    assert_eq!(bench.read_u32(0x2010, 5), 0, "overflows");
}

#[test]
fn the_drive_stores_its_restart_delay() {
    let mut bench = DriveBench::booted(4);
    bench.write_u16(0x2011, 0, 300);
    bench.queue("604: 23 10 10 01 73 61 76 65");
    bench.expect("584: 60 10 10 01");
    bench.axis().power_cycle();
    bench.drain_until("704 [1] 00", 100);
    bench.set_controller(ControllerState::BusOff);
    bench.silence(300);
    bench.expect("084: 40 81 11");
    bench.drain(10);
    // FFFFh: the controller stays off the bus.
    bench.write_u16(0x2011, 0, 0xFFFF);
    bench.set_controller(ControllerState::BusOff);
    bench.silence(3_000);
}

#[test]
fn on_the_bus_a_drive_is_silent_until_its_controller_is_back() {
    let mut bench = DriveBench::booted(4);
    bench.set_controller(ControllerState::BusOff);
    // The delay of 100 ms, and 128 times 11 bits.
    bench.silence(100);
    bench.expect("084: 40 81 11");
    bench.expect("084: 00 00 00");
    bench.silence(200);
    // No second boot-up message, and no reset: a value that was written is there.
    assert_eq!(bench.state_in_heartbeat(), 0x7F);
}

#[test]
fn frames_that_the_drive_lost_are_told_once() {
    let mut bench = DriveBench::booted(4);
    bench.lose_frames(3);
    for _ in 0..3 {
        bench.queue("604: 40 00 10 00");
    }
    bench.expect("084: 10 81 11");
    bench.silence(900);
    bench.drain_until("084: 00 00 00", 200);
    bench.send("604: 40 00 10 00");
    bench.expect("584: 43 00 10 00 ..");
}

#[test]
fn frames_that_are_lost_stop_a_drive_with_power() {
    let mut bench = DriveBench::enabled(4);
    bench.begin_move(1_000_000);
    bench.drain(20);
    bench.lose_frames(1);
    // A command may have been among them.
    bench.queue("604: 40 00 10 00");
    bench.drain_until("084: 10 81 ..", 20);
    bench.reaches(tests::drive::FAULT, 1_000);
    assert_eq!(bench.read_u16(0x603F, 0), 0x8110);
    let stopped = bench.position();
    bench.run_millis(500);
    assert_eq!(bench.position(), stopped);
    bench.command(0x80);
    bench.reaches(tests::drive::SWITCH_ON_DISABLED, 20);
}

#[test]
fn frames_that_are_lost_are_no_fault_of_a_drive_without_power() {
    let mut bench = DriveBench::started(4);
    bench.lose_frames(1);
    bench.queue("604: 40 00 10 00");
    bench.drain_until("084: 10 81 ..", 20);
    bench.stays_in(tests::drive::SWITCH_ON_DISABLED, 100);
    bench.enable();
}

#[test]
fn the_drive_waits_for_a_client_as_long_as_it_is_told() {
    let mut bench = DriveBench::booted(4);
    bench.write_u16(0x5FF3, 0, 4_000);
    bench.send("604: 21 17 10 00 02");
    bench.expect("584: 60 17 10 00");
    bench.silence(3_990);
    bench.expect("584: 80 17 10 00 00 00 04 05");
    // Too short to be of use.
    assert_eq!(
        bench.try_write(0x5FF3, 0, &9_u16.to_le_bytes()),
        Err(0x0609_0032)
    );
    bench.write_u16(0x5FF3, 0, 10);
    bench.send("604: 21 17 10 00 02");
    bench.expect("584: 60 17 10 00");
    bench.silence(9);
    bench.expect("584: 80 17 10 00 00 00 04 05");
}

#[test]
fn a_client_of_a_block_download_is_reminded_after_half_of_the_time() {
    let mut bench = DriveBench::booted(4);
    bench.write_u16(0x5FF3, 0, 4_000);
    bench.send("604: C2 20 20 00 15 00 00 00");
    bench.expect("584: A4 20 20 00 7F");
    bench.send("604: 01 41 42 43 44 45 46 47");
    bench.silence(1_990);
    bench.expect("584: A2 01 7F");
    bench.silence(1_990);
    bench.expect("584: 80 20 20 00 00 00 04 05");
}
