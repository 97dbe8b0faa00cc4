//! Each fault of communication as candump shows it: how it comes about, its emergency message, its end.

use canopen::Duration;
use canopen::can_controller::ControllerState;
use canopen::cia301::parameters::ParameterSet;
use tests::Bench;

fn operational() -> Bench {
    let mut bench = Bench::node(4);
    bench.start();
    bench
}

/// A device that expects node 5 every 100 ms.
fn watching() -> Bench {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1016, 1, 0x0005_0064);
    bench.start();
    bench
}

#[test]
fn a_heartbeat_that_stays_away() {
    let mut bench = watching();
    for _ in 0..2 {
        bench.send("705 [1] 05");
        bench.run_millis(80);
    }
    bench.run_millis(50);
    bench.send("705 [1] 05");
    bench.run_millis(10);
    insta::assert_snapshot!(bench.candump());
}

#[test]
fn a_watched_node_that_restarts() {
    let mut bench = watching();
    bench.send("705 [1] 05");
    bench.run_millis(50);
    bench.send("705 [1] 00");
    bench.run_millis(20);
    bench.send("705 [1] 7F");
    bench.run_millis(10);
    insta::assert_snapshot!(bench.candump());
}

#[test]
fn a_guarding_master_that_stays_away() {
    let mut bench = Bench::node(4);
    bench.write_u16(0x100C, 0, 20);
    bench.write_u8(0x100D, 0, 3);
    bench.start();
    for _ in 0..3 {
        bench.send("704 [1] rtr");
        bench.run_millis(20);
    }
    bench.run_millis(60);
    bench.send("704 [1] rtr");
    bench.run_millis(10);
    insta::assert_snapshot!(bench.candump());
}

#[test]
fn an_rpdo_that_is_too_short_and_one_that_is_too_long() {
    let mut bench = operational();
    for frame in ["204 [7] 01", "204: 01", "404 [2] 01 02", "404 [1] 01"] {
        bench.send(frame);
        bench.run_millis(2);
    }
    insta::assert_snapshot!(bench.candump());
}

#[test]
fn an_rpdo_that_misses_its_deadline() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1400, 1, 0x8000_0204);
    bench.write_u16(0x1400, 5, 10);
    bench.write_u32(0x1400, 1, 0x204);
    bench.start();
    bench.send("204: 01");
    bench.run_millis(15);
    bench.send("204: 02");
    bench.run_millis(5);
    insta::assert_snapshot!(bench.candump());
}

#[test]
fn a_sync_of_a_wrong_length() {
    let mut bench = operational();
    for frame in ["080 [1] 01", "080 [0]"] {
        bench.send(frame);
        bench.run_millis(2);
    }
    insta::assert_snapshot!(bench.candump());
}

#[test]
fn a_sync_that_stays_away() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1006, 0, 20_000);
    for _ in 0..3 {
        bench.send("080 [0]");
        bench.run_millis(20);
    }
    bench.run_millis(40);
    bench.send("080 [0]");
    bench.run_millis(2);
    insta::assert_snapshot!(bench.candump());
}

#[test]
fn bus_off() {
    let mut bench = operational();
    bench.write_u16(0x1017, 0, 20);
    bench.run_millis(5);
    let now = bench.now();
    bench.device().go_bus_off(now);
    for _ in 0..10 {
        bench.send("204: 01");
        bench.run_millis(15);
    }
    insta::assert_snapshot!(bench.candump());
}

#[test]
fn error_passive() {
    let mut bench = operational();
    for state in [ControllerState::ErrorPassive, ControllerState::ErrorActive] {
        let now = bench.now();
        bench.device().node().controller_changed(state, now);
        bench.run_millis(5);
    }
    insta::assert_snapshot!(bench.candump());
}

#[test]
fn received_frames_that_are_lost() {
    let mut bench = operational();
    let now = bench.now();
    bench.device().node().frames_lost(3, now);
    bench.run_millis(1_010);
    insta::assert_snapshot!(bench.candump());
}

#[test]
fn another_node_with_our_identifier() {
    let mut bench = operational();
    bench.send("704 [1] 05");
    bench.run_millis(2);
    bench.send("000 [2] 82 04");
    bench.run_millis(2);
    insta::assert_snapshot!(bench.candump());
}

#[test]
fn parameters_that_are_lost() {
    let mut bench = Bench::node(4);
    bench.write(0x1010, 1, b"save");
    bench.device().store.damaged = Some(ParameterSet::Application);
    bench.send("000 [2] 81 04");
    bench.run_millis(2);
    bench.device().store.damaged = None;
    bench.write(0x1010, 1, b"save");
    bench.run_millis(2);
    insta::assert_snapshot!(bench.candump());
}

#[test]
fn emergencies_with_an_inhibit_time() {
    let mut bench = Bench::node(4);
    bench.write_u16(0x1015, 0, 100);
    bench.start();
    bench.send("204 [1] 01");
    bench.send("080 [1] 01");
    bench.send("204: 01");
    bench.send("080 [0]");
    bench.run_millis(50);
    insta::assert_snapshot!(bench.candump());
}

#[test]
fn a_blocked_bus() {
    let mut bench = operational();
    bench.write_u16(0x1017, 0, 10);
    bench.run_millis(5);
    bench.jam(Duration::millis(30));
    for value in 1..=10 {
        bench.change(|objects| objects.set_sent_number_1(value));
        bench.run_millis(2);
    }
    bench.run_millis(20);
    insta::assert_snapshot!(bench.candump());
}
