//! Configuration by SDO, and PDO traffic.

use tests::Bench;

#[test]
fn a_pdo_is_mapped_anew() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1800, 1, 0xC000_0184);
    bench.write_u8(0x1A00, 0, 0);
    bench.write_u32(0x1A00, 1, 0x2006_0020);
    bench.write_u32(0x1A00, 2, 0x1001_0008);
    bench.write_u8(0x1A00, 0, 2);
    bench.write_u8(0x1800, 2, 1);
    bench.write_u32(0x1800, 1, 0x4000_0184);
    bench.send("000 [2] 01 04");
    bench.change(|objects| objects.set_sent_number_2(0x0102_0304));
    bench.run_millis(1);
    bench.send("080 [0]");
    bench.run_millis(1);
    insta::assert_snapshot!(bench.candump());
}

#[test]
fn events_with_inhibit_time_and_event_timer() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1800, 1, 0xC000_0184);
    bench.write_u16(0x1800, 3, 100);
    bench.write_u16(0x1800, 5, 25);
    bench.write_u32(0x1800, 1, 0x4000_0184);
    bench.start();
    for value in 1..=5 {
        bench.change(|objects| objects.set_sent_number_1(value));
        bench.run_millis(1);
    }
    bench.run_millis(60);
    insta::assert_snapshot!(bench.candump());
}

#[test]
fn synchronous_pdos_both_ways() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1400, 1, 0x8000_0204);
    bench.write_u8(0x1400, 2, 1);
    bench.write_u8(0x1600, 0, 0);
    bench.write_u32(0x1600, 1, 0x2007_0040);
    bench.write_u8(0x1600, 0, 1);
    bench.write_u32(0x1400, 1, 0x204);
    bench.start();
    // What is received acts at the next SYNC, and shows in the TPDO of the one after it.
    for value in 1..=3 {
        bench.send(&format!("204: {value:02X}"));
        bench.run_millis(1);
        bench.send("080 [0]");
        bench.run_millis(4);
    }
    insta::assert_snapshot!(bench.candump());
}

#[test]
fn a_pdo_on_remote_request() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1801, 1, 0xC000_0284);
    bench.write_u32(0x1800, 1, 0x8000_0184);
    bench.write_u8(0x1800, 2, 253);
    bench.write_u32(0x1800, 1, 0x184);
    bench.start();
    for value in 1..=3 {
        bench.change(|objects| objects.set_sent_number_1(value));
        bench.send("184 [8] rtr");
        bench.run_millis(2);
    }
    insta::assert_snapshot!(bench.candump());
}
