//! Store and restore parameters over the bus: 1010h, 1011h, 1020h, and what a power cut leaves.

use canopen::cia301::parameters::ParameterSet;
use tests::Bench;

const SAVE: &[u8; 4] = b"save";
const LOAD: &[u8; 4] = b"load";

/// The power fails and returns.
fn cycle_power(bench: &mut Bench) {
    bench.device().cycle_power();
    bench.drain_until("704 [1] 00", 20);
}

#[test]
fn r01_the_answer_comes_when_the_data_is_safe() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x2000, 0, 0x0102_0304);
    bench.send("604: 23 10 10 01 73 61 76 65");
    // Each step of the store takes a millisecond; there is more than one.
    bench.silence(2);
    bench.expect("584: 60 10 10 01");
    cycle_power(&mut bench);
    assert_eq!(bench.read_u32(0x2000, 0), 0x0102_0304);
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
fn r01_a_medium_that_fails_is_told() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x2000, 0, 1);
    bench.write(0x1010, 1, SAVE);
    bench.write_u32(0x2000, 0, 2);
    bench.device().store.is_broken = true;
    bench.refused("604: 23 10 10 01 73 61 76 65", 0x0606_0000);
    cycle_power(&mut bench);
    assert_eq!(bench.read_u32(0x2000, 0), 1);
}

#[test]
fn r01_a_set_is_stored_without_the_others() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x2000, 0, 7);
    bench.write_u16(0x1015, 0, 100);
    bench.write(0x1010, 2, SAVE);
    cycle_power(&mut bench);
    assert_eq!(bench.read_u16(0x1015, 0), 100);
    assert_eq!(bench.read_u32(0x2000, 0), 0);
    bench.write_u32(0x2000, 0, 7);
    bench.write_u16(0x1015, 0, 200);
    bench.write(0x1010, 4, SAVE);
    cycle_power(&mut bench);
    assert_eq!(bench.read_u16(0x1015, 0), 100);
    assert_eq!(bench.read_u32(0x2000, 0), 7);
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
fn r02_a_wrong_signature_stores_nothing() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x2000, 0, 1);
    bench.refused("604: 23 10 10 01 65 76 61 73", 0x0800_0020);
    bench.refused("604: 23 10 10 01 6C 6F 61 64", 0x0800_0020);
    bench.refused("604: 23 10 10 02 00 00 00 00", 0x0800_0020);
    cycle_power(&mut bench);
    assert_eq!(bench.read_u32(0x2000, 0), 0);
}

#[test]
fn r03_defaults_come_back_at_the_next_reset_and_not_before() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x2000, 0, 1);
    bench.write(0x1010, 1, SAVE);
    bench.write(0x1011, 1, LOAD);
    assert_eq!(bench.read_u32(0x2000, 0), 1);
    bench.send("000 [2] 81 04");
    bench.expect("704 [1] 00");
    assert_eq!(bench.read_u32(0x2000, 0), 0);
    cycle_power(&mut bench);
    assert_eq!(bench.read_u32(0x2000, 0), 0);
}

#[test]
fn r04_a_wrong_signature_restores_nothing() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x2000, 0, 1);
    bench.write(0x1010, 1, SAVE);
    bench.refused("604: 23 11 10 01 73 61 76 65", 0x0800_0020);
    bench.refused("604: 23 11 10 04 00 00 00 00", 0x0800_0020);
    cycle_power(&mut bench);
    assert_eq!(bench.read_u32(0x2000, 0), 1);
}

#[test]
fn r05_every_set_tells_that_it_is_stored_on_command() {
    let mut bench = Bench::node(4);
    for index in [0x1010, 0x1011] {
        for sub in 1..=4 {
            assert_eq!(bench.read_u32(index, sub), 1, "{index:04X}h:{sub}");
        }
    }
}

#[test]
fn r03_reset_communication_restores_the_communication_only() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x2000, 0, 1);
    bench.write_u16(0x1015, 0, 100);
    bench.write(0x1010, 1, SAVE);
    bench.write_u32(0x2000, 0, 2);
    bench.write_u16(0x1015, 0, 200);
    bench.send("000 [2] 82 04");
    bench.expect("704 [1] 00");
    assert_eq!(bench.read_u32(0x2000, 0), 2);
    assert_eq!(bench.read_u16(0x1015, 0), 100, "the stored one");
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

#[test]
fn r08_what_cannot_be_read_is_reported_and_the_rest_is_loaded() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x2000, 0, 7);
    bench.write_u16(0x1015, 0, 100);
    bench.write(0x1010, 1, SAVE);
    bench.device().store.damaged = Some(ParameterSet::Communication);
    bench.device().cycle_power();
    bench.expect("704 [1] 00");
    bench.expect("084: 10 63 xx ..");
    assert_eq!(bench.read_u16(0x1015, 0), 0);
    assert_eq!(bench.read_u32(0x2000, 0), 7);
}

#[test]
fn r09_the_date_of_the_configuration_holds_until_a_parameter_changes() {
    let mut bench = Bench::node(4);
    let date = |bench: &mut Bench| (bench.read_u32(0x1020, 1), bench.read_u32(0x1020, 2));
    bench.write_u16(0x1015, 0, 100);
    bench.write_u32(0x1020, 1, 15_000);
    bench.write_u32(0x1020, 2, 36_000_000);
    bench.write(0x1010, 1, SAVE);
    assert_eq!(date(&mut bench), (15_000, 36_000_000));
    cycle_power(&mut bench);
    assert_eq!(date(&mut bench), (15_000, 36_000_000));
    bench.write_u16(0x1015, 0, 200);
    assert_eq!(date(&mut bench), (0, 0));
    cycle_power(&mut bench);
    assert_eq!(
        date(&mut bench),
        (15_000, 36_000_000),
        "what is stored holds"
    );
    bench.write(0x1011, 1, LOAD);
    cycle_power(&mut bench);
    assert_eq!(date(&mut bench), (0, 0));
}
