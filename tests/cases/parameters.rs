//! Parameters that are stored while the bus is busy, and what a power cut leaves.

use tests::Bench;

const SAVE: &[u8; 4] = b"save";

/// The power fails and returns.
fn cycle_power(bench: &mut Bench) {
    bench.device().cycle_power();
    bench.drain_until("704 [1] 00", 20);
}

#[test]
fn r01_a_cut_before_the_answer_leaves_the_old_set() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x2000, 0, 1);
    bench.write(0x1010, 1, SAVE);
    bench.write_u32(0x2000, 0, 2);
    bench.send("604: 23 10 10 01 73 61 76 65");
    bench.silence(2);
    cycle_power(&mut bench);
    assert_eq!(bench.read_u32(0x2000, 0), 1);
}

#[test]
fn r01_communication_works_while_parameters_are_stored() {
    let mut bench = Bench::node(4);
    bench.start();
    bench.send("604: 23 10 10 01 73 61 76 65");
    bench.send("204: 05 00 00 00 06");
    bench.change(|objects| objects.set_sent_number_1(9));
    bench.expect("184: 09");
    bench.expect("584: 60 10 10 01");
    assert_eq!(bench.read_u32(0x2003, 0), 5);
}

#[test]
fn r01_a_stored_mapping_works_after_power_on() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1800, 1, 0xC000_0184);
    bench.write_u8(0x1A00, 0, 0);
    bench.write_u32(0x1A00, 1, 0x2006_0020);
    bench.write_u8(0x1A00, 0, 1);
    bench.write_u32(0x1800, 1, 0x4000_01A4);
    bench.write(0x1010, 2, SAVE);
    cycle_power(&mut bench);
    bench.send("000 [2] 01 04");
    bench.expect("1A4 [4] 00 00 00 00");
}
