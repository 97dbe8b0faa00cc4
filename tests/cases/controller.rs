//! Faults of the bus as the device sees them: bus-off, error passive, lost frames, another node with its identifiers.

use canopen::can_controller::ControllerState;
use canopen::{Duration, Event};
use tests::{Bench, DriveBench};

/// Tells the device how its controller is.
fn controller(bench: &mut Bench, state: ControllerState) {
    let now = bench.now();
    bench.device().node().controller_changed(state, now);
}

#[test]
fn c01_after_bus_off_the_device_returns_by_itself() {
    let mut bench = Bench::node(4);
    bench.start();
    bench.write_u8(0x1029, 1, 1);
    let now = bench.now();
    bench.device().go_bus_off(now);
    bench.silence(99);
    let frame = bench.expect_within("084: 40 81 11 ..", 3);
    assert_eq!(frame.payload()[2], 0x11);
    bench.expect("084: 00 00 00 ..");
    // No boot-up message, and the state is what it was.
    assert_eq!(bench.state_in_heartbeat(), 0x05);
    let counters = bench.device().node().counters();
    assert_eq!((counters.bus_off, counters.restarts), (1, 1));
    assert_eq!(bench.read_u32(0x1003, 1) & 0xFFFF, 0x8140);
}

#[test]
fn c01_a_controller_that_does_not_return_is_tried_again_and_again() {
    let mut bench = Bench::node(4);
    bench.device().failing_restarts = 3;
    let now = bench.now();
    bench.device().go_bus_off(now);
    bench.silence(3_000);
    bench.drain(500);
    let restarts = bench
        .device()
        .told
        .iter()
        .filter(|event| **event == Event::RestartController)
        .count();
    assert_eq!(restarts, 4);
    bench.send("604: 40 00 10 00");
    bench.expect("584: 43 00 10 00 ..");
}

#[test]
fn c01_the_delay_is_configurable() {
    let mut bench = Bench::node(4);
    bench
        .device()
        .node()
        .set_restart_delay(Some(Duration::millis(500)));
    let now = bench.now();
    bench.device().go_bus_off(now);
    bench.silence(499);
    bench.expect_within("084: 40 81 11 ..", 3);

    let mut bench = Bench::node(4);
    bench.device().node().set_restart_delay(None);
    let now = bench.now();
    bench.device().go_bus_off(now);
    bench.silence(60_000);
}

#[test]
fn c01_and_c03_what_waited_during_bus_off_is_the_newest() {
    let mut bench = Bench::node(4);
    bench.write_u8(0x1029, 1, 1);
    bench.start();
    let now = bench.now();
    bench.device().go_bus_off(now);
    for value in 1..=20 {
        bench.change(|objects| objects.set_sent_number_1(value));
        bench.run_millis(2);
    }
    let mut values = Vec::new();
    while let Some(frame) = bench.next(Duration::millis(150)) {
        if frame.standard_id() == Some(0x184) {
            values.push(frame.payload()[0]);
        }
    }
    assert_eq!(values, [20]);
}

#[test]
fn c01_bus_off_is_a_communication_error_of_1029h() {
    for (behaviour, state) in [(0, 0x7F), (1, 0x05), (2, 0x04)] {
        let mut bench = Bench::node(4);
        bench.write_u8(0x1029, 1, behaviour);
        bench.write_u16(0x1017, 0, 1_000);
        bench.start();
        let now = bench.now();
        bench.device().go_bus_off(now);
        let beat = bench.drain_until("704 [1] xx", 1_100);
        assert_eq!(beat.payload(), [state], "1029h:1 is {behaviour}");
    }
}

#[test]
fn e09_error_passive_is_reported_until_it_is_over() {
    let mut bench = Bench::node(4);
    controller(&mut bench, ControllerState::ErrorPassive);
    bench.expect("084: 20 81 11 ..");
    controller(&mut bench, ControllerState::ErrorPassive);
    bench.silence(100);
    controller(&mut bench, ControllerState::ErrorActive);
    bench.expect("084: 00 00 00 ..");
}

#[test]
fn c02_and_e09_lost_frames_are_counted_and_reported_once() {
    let mut bench = Bench::node(4);
    let now = bench.now();
    bench.device().node().frames_lost(2, now);
    bench.expect("084: 10 81 11 ..");
    bench.run_millis(500);
    let now = bench.now();
    bench.device().node().frames_lost(3, now);
    bench.silence(990);
    bench.expect("084: 00 00 00 ..");
    assert_eq!(bench.device().node().counters().lost_frames, 5);
}

#[test]
fn c04_an_identifier_of_ours_from_another_node_is_reported_once() {
    for (frame, low, high) in [
        ("584: 43 00 10 00", "84", "05"),
        ("704 [1] 05", "04", "07"),
        ("184: 00", "84", "01"),
    ] {
        let mut bench = Bench::node(4);
        bench.start();
        bench.send(frame);
        bench.expect(&format!("084: 50 81 11 {low} {high}"));
        bench.send(frame);
        bench.silence(100);
        assert_eq!(bench.read_u8(0x1001, 0), 0x11);
        assert_eq!(bench.read_u32(0x1003, 1) & 0xFFFF, 0x8150);
    }
}

#[test]
fn c04_each_identifier_is_reported() {
    let mut bench = Bench::node(4);
    bench.start();
    bench.send("704 [1] 05");
    bench.expect("084: 50 81 11 04 07");
    bench.send("584: 43 00 10 00");
    bench.expect("084: 50 81 11 84 05");
    bench.send("000 [2] 82 04");
    bench.drain_until("704 [1] 00", 20);
    assert_eq!(bench.read_u8(0x1001, 0), 0, "a reset forgets it");
}

#[test]
fn c04_identifiers_that_others_may_send_are_not_reported() {
    let mut bench = Bench::node(4);
    bench.start();
    for frame in ["081 [0]", "204: 00", "604: 40 00 10 00", "705 [1] 05"] {
        bench.send(frame);
    }
    bench.expect("584: 43 00 10 00 ..");
    bench.silence(100);
}

#[test]
fn c01_a_drive_stops_when_its_controller_leaves_the_bus() {
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
fn c01_what_the_drive_has_counted_can_be_read() {
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
fn c01_the_drive_stores_its_restart_delay() {
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
fn c01_on_the_bus_a_drive_is_silent_until_its_controller_is_back() {
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
fn c02_frames_that_the_drive_lost_are_told_once() {
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
fn c02_frames_that_are_lost_stop_a_drive_with_power() {
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
fn c02_frames_that_are_lost_are_no_fault_of_a_drive_without_power() {
    let mut bench = DriveBench::started(4);
    bench.lose_frames(1);
    bench.queue("604: 40 00 10 00");
    bench.drain_until("084: 10 81 ..", 20);
    bench.stays_in(tests::drive::SWITCH_ON_DISABLED, 100);
    bench.enable();
}

#[test]
fn s26_the_drive_waits_for_a_client_as_long_as_it_is_told() {
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
fn b26_a_client_of_a_block_download_is_reminded_after_half_of_the_time() {
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
