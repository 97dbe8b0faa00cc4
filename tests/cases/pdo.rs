//! Process data: the mapping procedure, transmission types, timers. RPDO 1 of the device maps 2003h and 2004h, TPDO 1 maps 2005h and 2006h.

use tests::Bench;

/// Disables RPDO 1 and clears its mapping, ready for new entries.
fn open_rpdo_1(bench: &mut Bench) {
    bench.write_u32(0x1400, 1, 0x8000_0204);
    bench.write_u8(0x1600, 0, 0);
}

/// Disables TPDO 1 and clears its mapping.
fn open_tpdo_1(bench: &mut Bench) {
    let cob_id = bench.read_u32(0x1800, 1);
    bench.write_u32(0x1800, 1, cob_id | 0x8000_0000);
    bench.write_u8(0x1A00, 0, 0);
}

/// Gives TPDO 1 a transmission type and inhibit time (100 µs) and event timer (ms), and switches TPDO 2 off.
fn tpdo_1(bench: &mut Bench, transmission_type: u8, inhibit: u16, event: u16) {
    bench.write_u32(0x1801, 1, 0xC000_0284);
    bench.write_u32(0x1800, 1, 0xC000_0184);
    bench.write_u8(0x1800, 2, transmission_type);
    bench.write_u16(0x1800, 3, inhibit);
    bench.write_u16(0x1800, 5, event);
    bench.write_u32(0x1800, 1, 0x4000_0184);
}

#[test]
fn p01_entries_are_locked_while_the_mapping_is_in_use() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1400, 1, 0x8000_0204);
    bench.refused("604: 23 00 16 01 20 00 03 20", 0x0601_0000);
}

#[test]
fn p02_the_mapping_is_locked_while_the_pdo_is_valid() {
    Bench::node(4).refused("604: 2F 00 16 00 00", 0x0601_0000);
}

#[test]
fn p03_the_standard_procedure_maps_anew() {
    let mut bench = Bench::node(4);
    open_rpdo_1(&mut bench);
    bench.write_u32(0x1600, 1, 0x2004_0020);
    bench.write_u32(0x1600, 2, 0x2003_0020);
    bench.write_u8(0x1600, 0, 2);
    bench.write_u32(0x1400, 1, 0x204);
    bench.start();
    bench.send("204: 01 02 03 04 05 06 07 08");
    assert_eq!(bench.read_u32(0x2004, 0), 0x0403_0201);
    assert_eq!(bench.read_u32(0x2003, 0), 0x0807_0605);
}

#[test]
fn p04_more_than_eight_entries_are_refused() {
    let mut bench = Bench::node(4);
    open_rpdo_1(&mut bench);
    bench.refused("604: 2F 00 16 00 09", 0x0604_0042);
}

#[test]
fn p05_more_than_64_bits_are_refused() {
    let mut bench = Bench::node(4);
    open_rpdo_1(&mut bench);
    for sub in 1..=3 {
        bench.write_u32(0x1600, sub, 0x2003_0020);
    }
    bench.refused("604: 2F 00 16 00 03", 0x0604_0042);
}

#[test]
fn p06_a_missing_object_is_not_mapped() {
    let mut bench = Bench::node(4);
    open_rpdo_1(&mut bench);
    bench.refused("604: 23 00 16 01 20 00 FF 5F", 0x0602_0000);
}

#[test]
fn p07_the_direction_must_fit() {
    let mut bench = Bench::node(4);
    open_rpdo_1(&mut bench);
    bench.refused("604: 23 00 16 01 08 00 01 10", 0x0604_0041);
    open_tpdo_1(&mut bench);
    bench.refused("604: 23 00 1A 01 10 00 09 20", 0x0604_0041);
}

#[test]
fn p08_an_object_that_is_not_mappable_is_not_mapped() {
    let mut bench = Bench::node(4);
    open_rpdo_1(&mut bench);
    bench.refused("604: 23 00 16 01 20 00 00 20", 0x0604_0041);
}

#[test]
fn p09_the_length_of_an_entry_must_be_that_of_the_object() {
    let mut bench = Bench::node(4);
    open_rpdo_1(&mut bench);
    bench.refused("604: 23 00 16 01 10 00 03 20", 0x0604_0041);
}

#[test]
fn p10_dummy_entries_skip_bytes() {
    let mut bench = Bench::node(4);
    open_rpdo_1(&mut bench);
    bench.write_u32(0x1600, 1, 0x0002_0008);
    bench.write_u32(0x1600, 2, 0x0005_0008);
    bench.write_u32(0x1600, 3, 0x2003_0020);
    bench.write_u8(0x1600, 0, 3);
    bench.write_u32(0x1400, 1, 0x204);
    bench.start();
    bench.send("204 [6] EE EE 01 02 03 04");
    assert_eq!(bench.read_u32(0x2003, 0), 0x0403_0201);
}

#[test]
fn p10_only_dummies_that_the_data_sheet_lists_are_taken() {
    let mut bench = Bench::node(4);
    open_rpdo_1(&mut bench);
    // REAL32, UNSIGNED64 and BOOLEAN are not in DummyUsage.
    for entry in ["20 00 08 00", "40 00 1B 00", "01 00 01 00"] {
        bench.refused(&format!("604: 23 00 16 01 {entry}"), 0x0604_0041);
    }
    bench.write_u32(0x1600, 1, 0x0007_0020);
}

#[test]
fn p11_a_tpdo_has_no_dummy_entries() {
    let mut bench = Bench::node(4);
    open_tpdo_1(&mut bench);
    bench.refused("604: 23 00 1A 01 08 00 05 00", 0x0604_0041);
}

#[test]
fn p13_the_identifier_of_a_valid_pdo_does_not_change() {
    let mut bench = Bench::node(4);
    bench.refused("604: 23 00 14 01 05 02 00 00", 0x0609_0030);
    let cob_id = bench.read_u32(0x1400, 1);
    bench.write_u32(0x1400, 1, cob_id);
}

#[test]
fn p14_masters_write_a_plain_identifier() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1800, 1, 0x8000_0184);
    bench.write_u32(0x1800, 1, 0x0000_0184);
    bench.send("000 [2] 01 04");
    bench.expect("184 ..");
}

#[test]
fn p15_a_29_bit_identifier_is_refused() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1400, 1, 0x8000_0204);
    bench.refused("604: 23 00 14 01 04 02 00 20", 0x0609_0030);
}

#[test]
fn p16_the_inhibit_time_of_a_valid_pdo_does_not_change() {
    let mut bench = Bench::node(4);
    bench.refused("604: 2B 00 18 03 64 00", 0x0609_0030);
    let present = bench.read_u16(0x1800, 3);
    bench.write_u16(0x1800, 3, present);
}

#[test]
fn p18_only_supported_transmission_types_are_taken() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1800, 1, 0x8000_0184);
    for kind in [0, 1, 240, 252, 253, 254, 255] {
        bench.write_u8(0x1800, 2, kind);
    }
    for kind in 241..=251_u8 {
        bench.refused(&format!("604: 2F 00 18 02 {kind:02X}"), 0x0609_0030);
    }
}

#[test]
fn p19_to_p22_a_short_pdo_changes_nothing_and_is_reported_once() {
    let mut bench = Bench::node(4);
    bench.start();
    bench.send("204 [2] 01 02");
    bench.expect("084: 10 82 11 ..");
    bench.send("204 [0]");
    bench.silence(100);
    assert_eq!(bench.read_u32(0x2003, 0), 0);
    assert_eq!(bench.read_u8(0x1001, 0), 0x11);
    bench.send("204: 01 02 03 04 05 06 07 08");
    bench.expect("084: 00 00 00 ..");
    assert_eq!(bench.read_u32(0x2003, 0), 0x0403_0201);
    assert_eq!(bench.read_u8(0x1001, 0), 0);
}

#[test]
fn p20_a_long_pdo_is_used_and_reported_once() {
    let mut bench = Bench::node(4);
    open_rpdo_1(&mut bench);
    bench.write_u32(0x1600, 1, 0x2003_0020);
    bench.write_u8(0x1600, 0, 1);
    bench.write_u32(0x1400, 1, 0x204);
    bench.start();
    bench.send("204: 01 02 03 04 05 06 07 08");
    bench.expect("084: 20 82 11 ..");
    bench.send("204: 02 02 03 04 05 06 07 08");
    bench.silence(100);
    assert_eq!(bench.read_u32(0x2003, 0), 0x0403_0202);
}

#[test]
fn p23_outside_operational_nothing_is_received() {
    let mut bench = Bench::node(4);
    bench.send("204: 01 02 03 04 05 06 07 08");
    bench.silence(100);
    assert_eq!(bench.read_u32(0x2003, 0), 0);
    bench.start();
    bench.write_u32(0x2003, 0, 7);
    bench.send("204 [8] rtr");
    bench.silence(100);
    assert_eq!(bench.read_u32(0x2003, 0), 7);
}

#[test]
fn p25_type_1_samples_at_each_sync() {
    let mut bench = Bench::node(4);
    tpdo_1(&mut bench, 1, 0, 0);
    bench.start();
    for value in 1..=3_u32 {
        bench.change(|dictionary| dictionary.set_sent_number_1(value));
        bench.silence(10);
        bench.send("080 [0]");
        bench.expect(&format!("184: {value:02X} 00 00 00"));
    }
    bench.silence(100);
}

#[test]
fn p26_type_3_counts_from_entering_operational() {
    let mut bench = Bench::node(4);
    tpdo_1(&mut bench, 3, 0, 0);
    bench.start();
    for _ in 0..2 {
        bench.send("080 [0]");
    }
    bench.send("000 [2] 80 04");
    bench.start();
    for _ in 0..2 {
        for _ in 0..2 {
            bench.send("080 [0]");
            bench.silence(5);
        }
        bench.send("080 [0]");
        bench.expect("184 ..");
    }
}

#[test]
fn p27_type_0_needs_an_event_and_a_sync() {
    let mut bench = Bench::node(4);
    tpdo_1(&mut bench, 0, 0, 0);
    bench.start();
    bench.send("080 [0]");
    bench.expect("184: 00");
    bench.send("080 [0]");
    bench.silence(10);
    bench.change(|dictionary| dictionary.set_sent_number_1(7));
    bench.silence(10);
    bench.send("080 [0]");
    bench.expect("184: 07");
    bench.send("080 [0]");
    bench.silence(10);
}

#[test]
fn p29_the_inhibit_time_sends_the_last_value() {
    let mut bench = Bench::node(4);
    tpdo_1(&mut bench, 255, 100, 0);
    bench.start();
    bench.drain(50);
    let began = bench.now();
    for value in 1..=5_u32 {
        bench.change(|dictionary| dictionary.set_sent_number_1(value));
        bench.run_micros(600);
    }
    bench.expect("184: 01");
    bench.expect("184: 05");
    let elapsed = bench.now() - began;
    assert!((10_000..11_000).contains(&elapsed.to_micros()), "{elapsed}");
    bench.silence(100);
}

#[test]
fn p30_an_event_restarts_the_event_timer() {
    let mut bench = Bench::node(4);
    tpdo_1(&mut bench, 255, 0, 100);
    bench.start();
    bench.silence(60);
    let event = bench.now();
    bench.change(|dictionary| dictionary.set_sent_number_1(1));
    bench.expect("184: 01");
    bench.expect("184: 01");
    let elapsed = (bench.now() - event).to_micros();
    assert!((100_000..101_000).contains(&elapsed), "{elapsed} µs");
}

#[test]
fn p31_the_inhibit_time_wins_over_the_event_timer() {
    let mut bench = Bench::node(4);
    tpdo_1(&mut bench, 255, 500, 10);
    bench.send("000 [2] 01 04");
    bench.expect("184 ..");
    let began = bench.now();
    bench.expect("184 ..");
    let elapsed = (bench.now() - began).to_micros();
    // Frames on the bus may differ by their stuff bits.
    assert!((49_900..51_000).contains(&elapsed), "{elapsed} µs");
}

#[test]
fn p32_nothing_changed_nothing_sent() {
    let mut bench = Bench::node(4);
    bench.start();
    bench.change(|dictionary| dictionary.set_sent_number_1(0));
    bench.silence(1_000);
}

#[test]
fn p33_a_synchronous_rpdo_waits_for_sync() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1400, 1, 0x8000_0204);
    bench.write_u8(0x1400, 2, 1);
    bench.write_u32(0x1400, 1, 0x204);
    bench.start();
    bench.send("204: 01 00 00 00");
    bench.send("204: 02 00 00 00");
    bench.run_millis(10);
    assert_eq!(bench.read_u32(0x2003, 0), 0);
    bench.send("080 [0]");
    assert_eq!(bench.read_u32(0x2003, 0), 2);
}

#[test]
fn p34_an_rpdo_after_the_sync_waits_for_the_next() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1400, 1, 0x8000_0204);
    bench.write_u8(0x1400, 2, 1);
    bench.write_u32(0x1400, 1, 0x204);
    bench.start();
    bench.queue("080 [0]");
    bench.queue("204: 09 00 00 00");
    bench.run_millis(10);
    assert_eq!(bench.read_u32(0x2003, 0), 0);
    bench.send("080 [0]");
    assert_eq!(bench.read_u32(0x2003, 0), 9);
}

#[test]
fn p38_two_rpdos_with_one_identifier_are_both_executed() {
    let mut bench = Bench::node(4);
    open_rpdo_1(&mut bench);
    bench.write_u32(0x1600, 1, 0x2003_0020);
    bench.write_u8(0x1600, 0, 1);
    bench.write_u32(0x1400, 1, 0x204);
    bench.write_u32(0x1401, 1, 0x8000_0204);
    bench.write_u8(0x1601, 0, 0);
    bench.write_u32(0x1601, 1, 0x2004_0020);
    bench.write_u8(0x1601, 0, 1);
    bench.write_u32(0x1401, 1, 0x204);
    bench.start();
    bench.send("204 [4] 01 02 03 04");
    assert_eq!(bench.read_u32(0x2003, 0), 0x0403_0201);
    assert_eq!(bench.read_u32(0x2004, 0), 0x0403_0201);
}

#[test]
fn p40_a_new_mapping_holds_from_the_next_frame() {
    let mut bench = Bench::node(4);
    bench.start();
    bench.change(|dictionary| {
        dictionary.set_sent_number_1(0x1111_1111);
        dictionary.set_sent_number_2(0x2222_2222);
    });
    bench.expect("184: 11 11 11 11 22 22 22 22");
    open_tpdo_1(&mut bench);
    bench.write_u32(0x1A00, 1, 0x2006_0020);
    bench.write_u8(0x1A00, 0, 1);
    bench.write_u32(0x1800, 1, 0x184);
    bench.change(|dictionary| dictionary.set_sent_number_2(0x3333_3333));
    bench.drain_until("184 [4] 33 33 33 33", 50);
}

#[test]
fn p22_a_short_pdo_shows_in_the_error_register_of_the_emergency() {
    let mut bench = Bench::node(4);
    bench.start();
    bench.send("204 [2] 01 02");
    let emergency = bench.expect("084: 10 82 ..");
    assert_eq!(emergency.payload()[2], 0x11, "communication and generic");
    assert_eq!(bench.read_u8(0x1001, 0), 0x11);
}
