//! Node guarding and life guarding.

use tests::Bench;

/// A device in Operational with a life time of 300 ms.
fn guarded() -> Bench {
    let mut bench = Bench::node(4);
    bench.write_u16(0x100C, 0, 100);
    bench.write_u8(0x100D, 0, 3);
    bench.start();
    bench
}

#[test]
fn g01_the_answers_to_the_master_toggle() {
    let mut bench = Bench::node(4);
    for answer in ["7F", "FF", "7F"] {
        bench.send("704 [1] rtr");
        bench.expect(&format!("704 [1] {answer}"));
    }
    bench.silence(1_000);
}

#[test]
fn g02_the_answers_show_the_state() {
    let mut bench = Bench::node(4);
    bench.start();
    for answer in ["05", "85"] {
        bench.send("704 [1] rtr");
        bench.expect(&format!("704 [1] {answer}"));
    }
    bench.send("000 [2] 02 04");
    for answer in ["04", "84", "04"] {
        bench.send("704 [1] rtr");
        bench.expect(&format!("704 [1] {answer}"));
    }
}

#[test]
fn g03_reset_communication_begins_with_toggle_0() {
    let mut bench = Bench::node(4);
    bench.send("704 [1] rtr");
    bench.expect("704 [1] 7F");
    bench.send("000 [2] 82 04");
    bench.expect("704 [1] 00");
    bench.send("704 [1] rtr");
    bench.expect("704 [1] 7F");
}

#[test]
fn g04_a_heartbeat_producer_is_not_guarded() {
    let mut bench = Bench::node(4);
    bench.write_u16(0x1017, 0, 1_000);
    bench.expect("704 [1] 7F");
    for _ in 0..3 {
        bench.send("704 [1] rtr");
        bench.silence(100);
    }
    bench.expect_within("704 [1] 7F", 800);
}

#[test]
fn g05_life_guarding_begins_with_the_first_request_and_misses_the_next() {
    let mut bench = guarded();
    bench.silence(2_000);
    bench.send("704 [1] rtr");
    bench.expect("704 [1] 05");
    for answer in ["85", "05", "85"] {
        bench.silence(280);
        bench.send("704 [1] rtr");
        bench.expect(&format!("704 [1] {answer}"));
    }
    bench.silence(295);
    bench.expect("084: 30 81 11 ..");
    bench.silence(2_000);
    // 1029h:1 is 0: Pre-operational. The toggle runs on.
    bench.send("704 [1] rtr");
    let answer = bench.drain_until("704 [1] xx", 10);
    assert_eq!(answer.payload(), [0x7F]);
}

#[test]
fn g06_the_next_request_ends_the_error() {
    let mut bench = guarded();
    bench.send("704 [1] rtr");
    bench.expect("704 [1] 05");
    bench.drain_until("084: 30 81 11 ..", 310);
    bench.send("704 [1] rtr");
    bench.drain_until("084: 00 00 00 ..", 10);
    assert_eq!(bench.read_u8(0x1001, 0), 0);
    bench.drain_until("084: 30 81 11 ..", 310);
}

#[test]
fn g07_the_heartbeat_takes_over_from_guarding() {
    let mut bench = guarded();
    bench.send("704 [1] rtr");
    bench.expect("704 [1] 05");
    bench.silence(100);
    bench.write_u16(0x1017, 0, 1_000);
    bench.expect("704 [1] 05");
    bench.silence(990);
    bench.expect("704 [1] 05");
}

#[test]
fn guarding_of_another_node_is_not_answered() {
    let mut bench = Bench::node(4);
    bench.send("705 [1] rtr");
    bench.send("00000704 [1] rtr");
    bench.silence(100);
}

#[test]
fn a_life_time_factor_of_0_watches_nothing() {
    let mut bench = guarded();
    bench.write_u8(0x100D, 0, 0);
    bench.send("704 [1] rtr");
    bench.expect("704 [1] 05");
    bench.silence(2_000);
}
