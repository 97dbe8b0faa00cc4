//! SYNC: producing it, its counter, its period and its window.

use tests::Bench;

/// A device whose TPDO 2, which is synchronous by default, is switched off.
fn without_tpdo_2() -> Bench {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1801, 1, 0xC000_0284);
    bench
}

/// The device produces SYNC every 10 ms.
fn produce(bench: &mut Bench) {
    bench.write_u32(0x1006, 0, 10_000);
    bench.write_u32(0x1005, 0, 0x4000_0080);
}

#[test]
fn y01_a_producer_sends_sync_every_period() {
    let mut bench = Bench::node(4);
    produce(&mut bench);
    bench.expect("080 [0]");
    let first = bench.now();
    for number in 1..=20 {
        bench.expect("080 [0]");
        let off = (bench.now() - first).to_micros().abs_diff(number * 10_000);
        assert!(off <= 250, "SYNC {number} is {off} µs off");
    }
}

#[test]
fn y01_the_end_of_production_ends_it_at_once() {
    let mut bench = Bench::node(4);
    produce(&mut bench);
    bench.expect("080 [0]");
    bench.write_u32(0x1005, 0, 0x80);
    bench.drain(1);
    bench.silence(100);
    bench.write_u32(0x1005, 0, 0x4000_0080);
    bench.expect("080 [0]");
    bench.write_u32(0x1006, 0, 0);
    bench.drain(1);
    bench.silence(100);
}

#[test]
fn y02_a_producer_counts() {
    let mut bench = Bench::node(4);
    bench.write_u8(0x1019, 0, 5);
    produce(&mut bench);
    for number in [1, 2, 3, 4, 5, 1, 2] {
        bench.expect(&format!("080 [1] {number:02X}"));
    }
}

#[test]
fn y03_the_counter_overflows_at_0_or_2_to_240() {
    let mut bench = Bench::node(4);
    for value in ["01", "F1", "FF"] {
        bench.refused(&format!("604: 2F 19 10 00 {value}"), 0x0609_0030);
    }
    for value in [2, 240, 0] {
        bench.write_u8(0x1019, 0, value);
        assert_eq!(bench.read_u8(0x1019, 0), value);
    }
}

#[test]
fn y04_and_s31_the_counter_does_not_change_while_a_period_is_set() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1006, 0, 10_000);
    bench.refused("604: 2F 19 10 00 05", 0x0800_0022);
    bench.write_u32(0x1006, 0, 0);
    bench.write_u8(0x1019, 0, 5);
}

#[test]
fn s31_a_write_that_needs_another_state_is_refused() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1006, 0, 10_000);
    bench.refused("604: 2F 19 10 00 F0", 0x0800_0022);
}

#[test]
fn y05_the_identifier_does_not_change_while_sync_is_produced() {
    let mut bench = Bench::node(4);
    produce(&mut bench);
    bench.drain(1);
    assert_eq!(
        bench.try_write(0x1005, 0, &0x4000_0090_u32.to_le_bytes()),
        Err(0x0609_0030)
    );
    bench.write_u32(0x1005, 0, 0x80);
    bench.write_u32(0x1005, 0, 0x90);
    bench.write_u32(0x1005, 0, 0x4000_0090);
    bench.drain_until("090 [0]", 20);
}

#[test]
fn y07_a_sync_without_the_counter_that_is_set_is_ignored_and_reported() {
    let mut bench = without_tpdo_2();
    bench.write_u8(0x1019, 0, 10);
    bench.write_u32(0x1800, 1, 0xC000_0184);
    bench.write_u8(0x1800, 2, 1);
    bench.write_u32(0x1800, 1, 0x4000_0184);
    bench.start();
    bench.send("080 [0]");
    bench.expect("084: 40 82 11 ..");
    bench.silence(50);
    bench.send("080 [2] 01 02");
    bench.silence(50);
    bench.send("080 [1] 01");
    bench.expect("084: 00 00 00 ..");
    bench.expect("184 ..");
}

#[test]
fn y08_a_sync_that_stays_away_is_reported_until_the_next() {
    let mut bench = without_tpdo_2();
    bench.write_u32(0x1006, 0, 1_000_000);
    bench.start();
    bench.send("080 [0]");
    bench.silence(1_000);
    bench.send("080 [0]");
    bench.silence(1_490);
    bench.expect("084: 00 81 11 ..");
    bench.silence(3_000);
    bench.send("080 [0]");
    bench.expect("084: 00 00 00 ..");
}

#[test]
fn y08_what_cannot_be_awaited_is_not() {
    // No SYNC has come yet; and one that was awaited no more after the period is 0.
    let mut bench = Bench::node(4);
    bench.write_u32(0x1006, 0, 100_000);
    bench.send("080 [0]");
    bench.write_u32(0x1006, 0, 0);
    bench.silence(2_000);
}

#[test]
fn y09_a_stopped_producer_is_silent() {
    let mut bench = Bench::node(4);
    produce(&mut bench);
    bench.expect("080 [0]");
    bench.send("000 [2] 02 04");
    bench.drain(1);
    bench.silence(200);
    bench.send("000 [2] 80 04");
    bench.expect("080 [0]");
}

#[test]
fn y09_reset_communication_ends_production() {
    let mut bench = Bench::node(4);
    produce(&mut bench);
    bench.expect("080 [0]");
    bench.send("000 [2] 82 04");
    bench.drain_until("704 [1] 00", 20);
    bench.silence(200);
}

#[test]
fn p28_a_sync_start_value_waits_for_the_counter() {
    let mut bench = without_tpdo_2();
    bench.write_u8(0x1019, 0, 10);
    bench.write_u32(0x1800, 1, 0xC000_0184);
    bench.write_u8(0x1800, 2, 2);
    bench.write_u8(0x1800, 6, 5);
    bench.write_u32(0x1800, 1, 0x4000_0184);
    bench.start();
    let mut sent_at = Vec::new();
    for counter in (1..=10).chain(1..=4) {
        bench.send(&format!("080 [1] {counter:02X}"));
        if bench.next(canopen::Duration::millis(2)).is_some() {
            sent_at.push(counter);
        }
    }
    assert_eq!(sent_at, [5, 7, 9, 1, 3]);
}

#[test]
fn p28_without_a_counter_the_start_value_is_ignored() {
    let mut bench = without_tpdo_2();
    bench.write_u32(0x1800, 1, 0xC000_0184);
    bench.write_u8(0x1800, 2, 1);
    bench.write_u8(0x1800, 6, 5);
    bench.write_u32(0x1800, 1, 0x4000_0184);
    bench.start();
    bench.send("080 [0]");
    bench.expect("184 ..");
}

#[test]
fn p36_what_has_not_left_within_the_window_is_dropped() {
    let mut bench = without_tpdo_2();
    bench.write_u32(0x1800, 1, 0xC000_0184);
    bench.write_u8(0x1800, 2, 1);
    bench.write_u32(0x1800, 1, 0x4000_0184);
    bench.write_u32(0x1007, 0, 1_000);
    bench.start();
    bench.send("080 [0]");
    bench.expect("184 ..");
    bench.send("080 [0]");
    bench.jam(canopen::Duration::millis(3));
    bench.silence(50);
    bench.send("080 [0]");
    bench.expect("184 ..");
}

#[test]
fn p36_a_synchronous_rpdo_after_the_window_is_discarded() {
    let mut bench = without_tpdo_2();
    bench.write_u32(0x1400, 1, 0x8000_0204);
    bench.write_u8(0x1400, 2, 1);
    bench.write_u32(0x1400, 1, 0x204);
    bench.write_u32(0x1007, 0, 5_000);
    bench.start();
    bench.send("080 [0]");
    bench.send("204: 01");
    bench.send("080 [0]");
    assert_eq!(bench.read_u32(0x2003, 0), 1);
    bench.run_millis(10);
    bench.send("204: 02");
    bench.send("080 [0]");
    assert_eq!(bench.read_u32(0x2003, 0), 1, "it came after the window");
    bench.send("204: 03");
    bench.send("080 [0]");
    assert_eq!(bench.read_u32(0x2003, 0), 3);
}
