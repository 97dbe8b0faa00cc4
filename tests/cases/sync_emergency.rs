//! SYNC as a consumer, emergency messages, error register and history.

use tests::Bench;

/// Provokes the error "RPDO 1 too short", and clears it.
const SHORT: &str = "204 [1] 00";
const GOOD: &str = "204: 00";

#[test]
fn y06_a_sync_with_a_counter_nobody_ordered_is_reported_and_ignored() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1800, 1, 0xC000_0184);
    bench.write_u8(0x1800, 2, 1);
    bench.write_u32(0x1800, 1, 0x4000_0184);
    bench.start();
    bench.send("080 [1] 01");
    bench.expect("084: 40 82 11 ..");
    bench.silence(50);
    bench.send("080 [0]");
    bench.expect("084: 00 00 00 ..");
    bench.expect("184 ..");
}

#[test]
fn y09_no_pdo_answers_a_sync_outside_operational() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1800, 1, 0xC000_0184);
    bench.write_u8(0x1800, 2, 1);
    bench.write_u32(0x1800, 1, 0x4000_0184);
    bench.send("080 [0]");
    bench.silence(100);
    bench.start();
    bench.send("000 [2] 02 04");
    bench.send("080 [0]");
    bench.silence(100);
}

#[test]
fn e01_without_an_identifier_only_the_history_grows() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1014, 0, 0x8000_0084);
    bench.start();
    bench.send(SHORT);
    bench.silence(100);
    assert_eq!(bench.read_u8(0x1003, 0), 1);
    assert_eq!(bench.read_u32(0x1003, 1) & 0xFFFF, 0x8210);
}

#[test]
fn e02_the_identifier_does_not_change_while_it_is_valid() {
    let mut bench = Bench::node(4);
    bench.refused("604: 23 14 10 00 85 00 00 00", 0x0609_0030);
    bench.write_u32(0x1014, 0, 0x8000_0084);
    bench.write_u32(0x1014, 0, 0x85);
    bench.start();
    bench.send(SHORT);
    bench.expect("085: 10 82 11 ..");
}

#[test]
fn e03_an_error_shows_in_frame_register_and_history() {
    let mut bench = Bench::node(4);
    bench.start();
    bench.send(SHORT);
    let frame = bench.expect("084: 10 82 11 ..");
    assert_eq!(bench.read_u8(0x1001, 0), 0x11);
    assert_eq!(bench.read_u8(0x1003, 0), 1);
    let info = u32::from(frame.payload()[3]) | u32::from(frame.payload()[4]) << 8;
    assert_eq!(bench.read_u32(0x1003, 1), 0x8210 | info << 16);
}

#[test]
fn e04_the_same_error_is_sent_once_and_its_end_too() {
    let mut bench = Bench::node(4);
    bench.start();
    bench.send(SHORT);
    bench.expect("084: 10 82 11 ..");
    bench.send(SHORT);
    bench.silence(50);
    bench.send(GOOD);
    bench.expect("084: 00 00 00 ..");
    bench.send(GOOD);
    bench.silence(50);
}

#[test]
fn e05_the_newest_error_is_first_and_the_oldest_is_dropped() {
    let mut bench = Bench::node(4);
    bench.start();
    // The oldest of nine is the only one of its kind.
    bench.send("080 [1] 01");
    bench.send("080 [0]");
    for _ in 0..8 {
        bench.send(SHORT);
        bench.send(GOOD);
        bench.drain(10);
    }
    assert_eq!(bench.read_u8(0x1003, 0), 8);
    for sub in 1..=8 {
        assert_eq!(
            bench.read_u32(0x1003, sub) & 0xFFFF,
            0x8210,
            "sub-index {sub}"
        );
    }
    bench.send("080 [1] 01");
    bench.drain(10);
    assert_eq!(bench.read_u8(0x1003, 0), 8);
    assert_eq!(bench.read_u32(0x1003, 1) & 0xFFFF, 0x8240);
    assert_eq!(bench.read_u32(0x1003, 2) & 0xFFFF, 0x8210);
}

#[test]
fn e06_the_history_is_cleared_with_zero() {
    let mut bench = Bench::node(4);
    bench.start();
    bench.send(SHORT);
    bench.drain(10);
    bench.refused("604: 2F 03 10 00 01", 0x0609_0030);
    bench.write_u8(0x1003, 0, 0);
    assert_eq!(bench.read_u8(0x1003, 0), 0);
    bench.refused("604: 40 03 10 01", 0x0800_0024);
}

#[test]
fn e07_the_inhibit_time_spaces_emergencies_and_loses_none() {
    let mut bench = Bench::node(4);
    bench.write_u16(0x1015, 0, 1_000);
    bench.start();
    bench.send(SHORT);
    bench.send("080 [1] 01");
    bench.send(GOOD);
    bench.expect("084: 10 82 11 ..");
    let first = bench.now();
    bench.silence(90);
    bench.expect("084: 40 82 11 ..");
    bench.silence(90);
    bench.expect("084: 00 00 11 ..");
    assert!((bench.now() - first).to_micros() >= 199_500);
}

#[test]
fn e08_the_generic_bit_stands_while_any_other_does() {
    let mut bench = Bench::node(4);
    bench.start();
    bench.send(SHORT);
    bench.send("080 [1] 01");
    bench.drain(10);
    assert_eq!(bench.read_u8(0x1001, 0), 0x11);
    bench.send(GOOD);
    bench.expect("084: 00 00 11 ..");
    assert_eq!(bench.read_u8(0x1001, 0), 0x11);
    bench.send("080 [0]");
    bench.expect("084: 00 00 00 ..");
    assert_eq!(bench.read_u8(0x1001, 0), 0);
}
