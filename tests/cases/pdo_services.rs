//! Remote requests, bit-granular mappings and deadlines of PDOs.

use canopen::Duration;
use tests::Bench;

/// TPDO 1 with this transmission type; it may be asked for by remote frames.
fn remote(transmission_type: u8) -> Bench {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1801, 1, 0xC000_0284);
    bench.write_u32(0x1800, 1, 0x8000_0184);
    bench.write_u8(0x1800, 2, transmission_type);
    bench.write_u32(0x1800, 1, 0x184);
    bench.start();
    bench.drain(5);
    bench
}

#[test]
fn type_253_sends_the_fresh_value_on_request() {
    let mut bench = remote(253);
    bench.change(|objects| objects.set_sent_number_1(1));
    bench.send("080 [0]");
    bench.silence(100);
    bench.change(|objects| objects.set_sent_number_1(2));
    bench.send("184 [8] rtr");
    bench.expect("184: 02");
    bench.send("184 [8] rtr");
    bench.expect("184: 02");
    bench.silence(100);
}

#[test]
fn type_252_sends_the_value_of_the_last_sync_on_request() {
    let mut bench = remote(252);
    bench.change(|objects| objects.set_sent_number_1(1));
    bench.run_millis(1);
    bench.send("080 [0]");
    bench.silence(100);
    bench.change(|objects| objects.set_sent_number_1(2));
    bench.run_millis(1);
    bench.send("184 [8] rtr");
    bench.expect("184: 01");
    bench.send("080 [0]");
    bench.silence(100);
    bench.send("184 [8] rtr");
    bench.expect("184: 02");
}

#[test]
fn a_remote_request_of_an_event_driven_pdo_is_answered_where_it_is_allowed() {
    let mut bench = remote(255);
    bench.change(|objects| objects.set_sent_number_1(7));
    bench.expect("184: 07");
    bench.send("184 [8] rtr");
    bench.expect("184: 07");
    bench.write_u32(0x1800, 1, 0xC000_0184);
    bench.write_u32(0x1800, 1, 0x4000_0184);
    bench.drain(10);
    bench.send("184 [8] rtr");
    bench.silence(100);
}

#[test]
fn no_remote_request_is_answered_outside_operational() {
    for command in ["000 [2] 80 04", "000 [2] 02 04"] {
        let mut bench = remote(253);
        bench.send(command);
        bench.send("184 [8] rtr");
        bench.silence(100);
        bench.start();
        bench.drain(5);
        bench.send("184 [8] rtr");
        bench.expect("184: 00");
    }
}

#[test]
fn bits_are_packed_without_gaps() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1800, 1, 0xC000_0184);
    bench.write_u8(0x1A00, 0, 0);
    for flag in 1..=8 {
        bench.write_u32(0x1A00, flag, 0x2014_0001 | u32::from(flag) << 8);
    }
    bench.write_u8(0x1A00, 0, 8);
    bench.write_u32(0x1800, 1, 0x4000_0184);
    for flag in [1, 3, 8] {
        bench.write_u8(0x2014, flag, 1);
    }
    bench.send("000 [2] 01 04");
    bench.expect("184 [1] 85");
    bench.send("604: 2F 14 20 03 00");
    bench.drain_until("184 [1] 81", 10);
}

#[test]
fn a_mapping_of_17_bits_takes_three_bytes() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1800, 1, 0xC000_0184);
    bench.write_u8(0x1A00, 0, 0);
    bench.write_u32(0x1A00, 1, 0x2014_0101);
    bench.write_u32(0x1A00, 2, 0x2015_0010);
    bench.write_u8(0x1A00, 0, 2);
    bench.write_u32(0x1800, 1, 0x4000_0184);
    bench.write_u8(0x2014, 1, 1);
    bench.write_u16(0x2015, 0, 0x8001);
    bench.send("000 [2] 01 04");
    bench.expect("184 [3] 03 00 01");
    // Switched off and on again the length is still in bits.
    bench.write_u32(0x1800, 1, 0xC000_0184);
    bench.send("604: 23 00 18 01 84 01 00 40");
    bench.drain_until("184 [3] 03 00 01", 10);
}

#[test]
fn received_bits_reach_their_objects() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1400, 1, 0x8000_0204);
    bench.write_u8(0x1600, 0, 0);
    bench.write_u32(0x1600, 1, 0x2014_0101);
    bench.write_u32(0x1600, 2, 0x2014_0201);
    bench.write_u32(0x1600, 3, 0x2015_0010);
    bench.write_u8(0x1600, 0, 3);
    bench.write_u32(0x1400, 1, 0x204);
    bench.start();
    bench.send("204 [3] 06 00 02");
    assert_eq!(bench.read_u8(0x2014, 1), 0);
    assert_eq!(bench.read_u8(0x2014, 2), 1);
    assert_eq!(bench.read_u16(0x2015, 0), 0x8001);
    bench.send("204 [2] 06 00");
    bench.drain_until("084: 10 82 11 ..", 10);
}

#[test]
fn a_missed_deadline_is_reported_for_each_pdo() {
    let mut bench = Bench::node(4);
    for (index, deadline) in [(0x1400, 50), (0x1401, 100)] {
        let cob_id = bench.read_u32(index, 1);
        bench.write_u32(index, 1, cob_id | 0x8000_0000);
        bench.write_u16(index, 5, deadline);
        bench.write_u32(index, 1, cob_id);
    }
    bench.start();
    bench.silence(1_000);
    bench.send("204: 01");
    bench.send("304: 01");
    bench.silence(40);
    bench.send("204: 02");
    bench.silence(48);
    bench.expect_within("084: 50 82 11 ..", 3);
    bench.send("204: 03");
    bench.expect_within("084: 00 00 00 ..", 3);
    bench.send("304: 02");
    bench.silence(45);
    bench.expect("084: 50 82 11 ..");
    bench.run_millis(30);
    bench.send("204: 04");
    bench.send("304: 03");
    bench.drain_until("084: 00 00 00 ..", 10);
    bench.send("000 [2] 80 04");
    bench.drain(5);
    bench.silence(1_000);
}

#[test]
fn all_pdos_of_a_sync_leave_by_identifier_on_a_busy_bus() {
    let mut bench = Bench::node(4);
    for (number, identifier) in [(0_u16, 0x184_u32), (1, 0x284), (2, 0x384), (3, 0x484)] {
        let index = 0x1800 + number;
        let mapping = 0x1A00 + number;
        bench.write_u32(index, 1, 0xC000_0000 | identifier);
        bench.write_u8(index, 2, 1);
        bench.write_u8(mapping, 0, 0);
        bench.write_u32(mapping, 1, 0x2005_0020);
        bench.write_u8(mapping, 0, 1);
        bench.write_u32(index, 1, 0x4000_0000 | identifier);
    }
    bench.start();
    for _ in 0..5 {
        bench.send("080 [0]");
        bench.jam(Duration::millis(3));
        for identifier in ["184", "284", "384", "484"] {
            bench.expect(&format!("{identifier} [4] 00 00 00 00"));
        }
        bench.silence(10);
    }
}
