//! Heartbeat, produced and consumed, and what the device does when the network is lost.

use canopen::Duration;
use tests::Bench;

/// A device in Operational that has heard node 5 and expects it every second.
fn watching() -> Bench {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1016, 1, 0x0005_03E8);
    bench.start();
    bench.send("705 [1] 05");
    bench
}

#[test]
fn h01_the_first_heartbeat_comes_at_once() {
    let mut bench = Bench::node(4);
    bench.write_u16(0x1017, 0, 100);
    bench.expect("704 [1] 7F");
    let first = bench.now();
    for beat in 1..=5 {
        bench.expect("704 [1] 7F");
        // The first one had to wait for the answer to the SDO.
        let off = (bench.now() - first).to_micros().abs_diff(beat * 100_000);
        assert!(off < 1_000, "beat {beat} is {off} µs off");
    }
}

#[test]
fn h02_a_new_state_shows_in_the_next_heartbeat() {
    let mut bench = Bench::node(4);
    bench.write_u16(0x1017, 0, 100);
    bench.expect("704 [1] 7F");
    bench.start();
    bench.expect("704 [1] 05");
}

#[test]
fn h03_a_node_is_watched_once() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1016, 1, 0x0005_03E8);
    bench.refused("604: 23 16 10 02 E8 03 05 00", 0x0604_0043);
    bench.refused("604: 23 16 10 02 10 27 05 00", 0x0604_0043);
    // The same entry anew, and another node beside it.
    bench.write_u32(0x1016, 1, 0x0005_07D0);
    bench.write_u32(0x1016, 2, 0x0006_03E8);
    bench.write_u32(0x1016, 1, 0);
    bench.write_u32(0x1016, 3, 0x0005_03E8);
}

#[test]
fn h04_only_a_heartbeat_begins_the_watch() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1016, 1, 0x0005_03E8);
    bench.start();
    bench.silence(3_000);
    bench.send("705 [1] 00");
    bench.silence(3_000);
    bench.send("705 [1] 7F");
    bench.silence(990);
    bench.expect("084: 30 81 11 ..");
}

#[test]
fn h05_a_lost_heartbeat_is_reported_once() {
    let mut bench = watching();
    for _ in 0..3 {
        bench.silence(900);
        bench.send("705 [1] 05");
    }
    let last = bench.now();
    bench.silence(990);
    bench.expect("084: 30 81 11 ..");
    let after = (bench.now() - last).to_micros();
    assert!((999_000..1_002_000).contains(&after), "{after} µs");
    bench.silence(5_000);
}

#[test]
fn h05_a_heartbeat_of_another_node_or_a_wrong_length_does_not_count() {
    let mut bench = watching();
    bench.silence(900);
    bench.send("706 [1] 05");
    bench.send("705 [2] 05 05");
    bench.send("705 [1] rtr");
    bench.silence(90);
    bench.expect("084: 30 81 11 ..");
}

#[test]
fn h06_the_heartbeat_that_returns_ends_the_error() {
    let mut bench = watching();
    bench.drain_until("084: 30 81 11 ..", 1_100);
    bench.send("705 [1] 05");
    bench.expect("084: 00 00 00 ..");
    bench.silence(990);
    bench.expect("084: 30 81 11 ..");
}

#[test]
fn h07_the_boot_up_of_a_node_that_was_active_is_reported() {
    let mut bench = watching();
    bench.silence(500);
    bench.send("705 [1] 00");
    bench.expect("084: 30 81 11 ..");
    bench.send("705 [1] 7F");
    bench.expect("084: 00 00 00 ..");
}

#[test]
fn h08_time_0_or_what_is_no_node_watches_nothing() {
    let mut bench = Bench::node(4);
    bench.start();
    bench.refused("604: 23 16 10 01 E8 03 05 01", 0x0609_0030);
    for entry in [0x0005_0000, 0x0000_03E8, 0x0080_03E8, 0x00FF_03E8] {
        bench.write_u32(0x1016, 1, entry);
        bench.write_u32(0x1016, 2, entry);
        bench.send("705 [1] 05");
        bench.silence(2_000);
        bench.write_u32(0x1016, 1, 0);
        bench.write_u32(0x1016, 2, 0);
    }
}

#[test]
fn h09_a_new_time_begins_the_watch_anew() {
    let mut bench = watching();
    bench.silence(800);
    bench.write_u32(0x1016, 1, 0x0005_07D0);
    bench.silence(1_000);
    bench.send("705 [1] 05");
    bench.silence(1_990);
    bench.expect("084: 30 81 11 ..");
    // A watch that ends takes its error along.
    bench.send("604: 23 16 10 01");
    bench.expect("084: 00 00 00 ..");
    bench.expect("584: 60 16 10 01");
    bench.silence(5_000);
}

#[test]
fn two_nodes_are_watched_each_by_its_own_time() {
    let mut bench = watching();
    bench.write_u32(0x1016, 2, 0x0006_0064);
    bench.send("706 [1] 05");
    bench.silence(95);
    bench.expect("084: 30 81 11 ..");
    bench.silence(500);
    // The second loss is another cause of an error that stands already, or is told beside it; both must end.
    bench.drain(500);
    bench.send("706 [1] 05");
    bench.send("705 [1] 05");
    bench.drain_until("084: 00 00 00 ..", 10);
    assert_eq!(bench.read_u8(0x1001, 0), 0);
}

/// The state after the loss of the heartbeat in Operational, and in Pre-operational.
fn states_after_loss(behaviour: u8) -> (u8, u8) {
    let lost_in = |is_operational: bool| {
        let mut bench = Bench::node(4);
        bench.write_u8(0x1029, 1, behaviour);
        bench.write_u32(0x1016, 1, 0x0005_0064);
        bench.write_u16(0x1017, 0, 500);
        if is_operational {
            bench.start();
        }
        bench.send("705 [1] 05");
        bench.drain(200);
        bench
            .drain_until("704 [1] xx", Duration::millis(600).to_millis())
            .payload()[0]
    };
    (lost_in(true), lost_in(false))
}

#[test]
fn n17_error_behaviour_0_leaves_operational_only() {
    assert_eq!(states_after_loss(0), (0x7F, 0x7F));
}

#[test]
fn n17_error_behaviour_1_changes_nothing() {
    assert_eq!(states_after_loss(1), (0x05, 0x7F));
}

#[test]
fn n17_error_behaviour_2_stops() {
    assert_eq!(states_after_loss(2), (0x04, 0x04));
}

#[test]
fn n17_other_error_behaviours_are_refused() {
    let mut bench = Bench::node(4);
    bench.refused("604: 2F 29 10 01 03", 0x0609_0030);
    assert_eq!(bench.read_u8(0x1029, 1), 0);
}
