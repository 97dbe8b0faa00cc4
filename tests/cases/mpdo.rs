//! Multiplexed PDOs (CiA 301, 7.2.2.4 to 7.2.2.7): the frame itself says which object its four bytes are.

use canopen::cia301::pdo::NotSent;
use tests::bare_node::MultiplexedBench as Bench;

/// Sub-index 0 of a mapping in source address mode.
const SOURCE: u8 = 254;
/// Sub-index 0 of a mapping in destination address mode.
const DESTINATION: u8 = 255;

/// The first PDO each way becomes a multiplexed one, by the procedure of CiA 301 for mapping.
#[track_caller]
fn multiplex(bench: &mut Bench, count: u8) {
    for (communication, mapping, cob_id) in [(0x1400, 0x1600, 0x204), (0x1800, 0x1A00, 0x4000_0184)]
    {
        bench.write_u32(communication, 1, 0x8000_0000 | cob_id);
        bench.write_u8(mapping, 0, count);
        bench.write_u32(communication, 1, cob_id);
        assert_eq!(bench.read_u8(mapping, 0), count);
    }
}

/// Node 4 in Operational, both its PDOs in this mode, its lists empty.
fn operational(count: u8) -> Bench {
    let mut bench = Bench::bare(4);
    multiplex(&mut bench, count);
    bench.start();
    bench
}

/// A value for 2003h, which no PDO may carry, 2001h, which is read-only, and objects that are not there.
const NOWHERE: [&str; 4] = [
    "204: 84 FF 5F 00 01 00 00 00",
    "204: 84 04 20 05 01 00 00 00",
    "204: 84 01 20 00 01 00 00 00",
    "204: 84 03 20 00 01 00 00 00",
];

#[test]
fn a_value_goes_to_the_object_that_the_frame_names() {
    let mut bench = operational(DESTINATION);
    bench.send("204: 84 00 20 00 78 56 34 12");
    bench.send("204: 84 04 20 03 09 EE EE EE");
    assert_eq!(bench.read_u32(0x2000, 0), 0x1234_5678);
    assert_eq!(bench.read_u8(0x2004, 3), 9, "as many bytes as it has");
    assert_eq!(bench.read_u8(0x2004, 4), 0, "none behind it");
    bench.send("204: 80 00 20 00 01 00 00 00");
    assert_eq!(bench.read_u32(0x2000, 0), 1, "node-ID 0 is everybody");
    bench.silence(100);
}

#[test]
fn a_frame_for_another_node_or_in_the_other_mode_changes_nothing() {
    let mut bench = operational(DESTINATION);
    bench.write_u32(0x2000, 0, 7);
    bench.send("204: 85 00 20 00 01 00 00 00");
    bench.send("204: FF 00 20 00 01 00 00 00");
    bench.send("204: 04 00 20 00 01 00 00 00");
    bench.send("204: 85 FF 5F 00 01 00 00 00");
    bench.silence(100);
    assert_eq!(bench.read_u32(0x2000, 0), 7);
    bench.send("204: 84 00 20 00 01 00 00 00");
    bench.silence(100);
    assert_eq!(bench.read_u32(0x2000, 0), 1, "for this one");
}

#[test]
fn outside_operational_no_value_is_taken() {
    let mut bench = Bench::bare(4);
    multiplex(&mut bench, DESTINATION);
    bench.send("204: 84 00 20 00 01 00 00 00");
    bench.send("204: 84 FF 5F 00 01 00 00 00");
    bench.silence(100);
    assert_eq!(bench.read_u32(0x2000, 0), 0);
    bench.start();
    bench.send("204: 84 00 20 00 01 00 00 00");
    bench.silence(100);
    assert_eq!(bench.read_u32(0x2000, 0), 1);
}

#[test]
fn an_object_that_cannot_be_written_is_told_once() {
    for frame in NOWHERE {
        let mut bench = operational(DESTINATION);
        bench.send(frame);
        bench.expect("084: 30 82 11 ..");
        bench.send(frame);
        bench.silence(100);
        assert_eq!(bench.read_u32(0x1003, 1) & 0xFFFF, 0x8230, "{frame}");
        // A frame for somebody else is no better one.
        bench.send("204: 85 00 20 00 01 00 00 00");
        bench.silence(100);
        bench.send("204: 84 00 20 00 01 00 00 00");
        bench.expect("084: 00 00 00 ..");
        assert_eq!(bench.read_u32(0x2000, 0), 1);
        assert_eq!(bench.read_u8(0x1001, 0), 0);
        // The next time it is news again.
        bench.send(frame);
        bench.expect("084: 30 82 11 ..");
    }
}

#[test]
fn a_value_beyond_its_limits_is_left_out() {
    let mut bench = operational(DESTINATION);
    bench.send("204: 84 02 20 00 F6 00 00 00");
    assert_eq!(bench.read_i8(0x2002, 0), -10);
    bench.send("204: 84 02 20 00 F5 00 00 00");
    bench.silence(100);
    assert_eq!(bench.read_i8(0x2002, 0), -10);
}

#[test]
fn a_frame_that_is_too_short_is_told_and_not_taken() {
    let mut bench = operational(DESTINATION);
    bench.send("204 [7] 84 00 20 00 01 00 00");
    bench.expect("084: 10 82 11 ..");
    assert_eq!(bench.read_u32(0x2000, 0), 0);
    bench.send("204: 84 00 20 00 01 00 00 00");
    bench.expect("084: 00 00 00 ..");
    assert_eq!(bench.read_u32(0x2000, 0), 1);
}

#[test]
fn a_value_is_sent_to_another_node_when_the_application_wants_it() {
    let mut bench = Bench::bare(4);
    multiplex(&mut bench, DESTINATION);
    assert_eq!(
        bench.send_to(9, 0x6000, 1, [1, 2, 3, 4]),
        Err(NotSent::NoPdo),
        "Pre-operational"
    );
    bench.start();
    bench.silence(100);
    assert_eq!(bench.send_to(9, 0x6000, 1, [1, 2, 3, 4]), Ok(()));
    bench.expect("184: 89 00 60 01 01 02 03 04");
    assert_eq!(bench.send_to(127, 0x6000, 1, [1, 2, 3, 4]), Ok(()));
    bench.expect("184: FF 00 60 01 01 02 03 04");
    assert_eq!(bench.send_to(0, 0x6000, 2, [5, 0, 0, 0]), Ok(()));
    bench.expect("184: 80 00 60 02 05 00 00 00");
    bench.silence(100);
}

#[test]
fn the_dispatcher_list_says_which_object_stands_for_whose() {
    let mut bench = operational(SOURCE);
    // 2004h:2 and :3 stand for 6000h:1 and :2 of node 5, 2000h for 6200h of node 6.
    bench.write_u64(0x1FD0, 1, 0x0220_0402_6000_0105);
    bench.write_u64(0x1FD0, 2, 0x0120_0000_6200_0006);
    for frame in [
        "204: 05 00 60 01 0A EE EE EE",
        "204: 05 00 60 02 14 00 00 00",
        "204: 06 00 62 00 78 56 34 12",
    ] {
        bench.send(frame);
    }
    // In front of the block and behind it, another node, an object that nothing stands for, and the other mode.
    for frame in [
        "204: 05 00 60 00 FF 00 00 00",
        "204: 05 00 60 03 FF 00 00 00",
        "204: 06 00 60 01 FF 00 00 00",
        "204: 04 04 20 01 FF 00 00 00",
        "204: 06 FF 5F 00 FF 00 00 00",
        "204: 85 00 60 01 FF 00 00 00",
    ] {
        bench.send(frame);
    }
    bench.silence(100);
    let bytes: Vec<u8> = (1..=4).map(|sub| bench.read_u8(0x2004, sub)).collect();
    assert_eq!(bytes, [0, 10, 20, 0]);
    assert_eq!(bench.read_u32(0x2000, 0), 0x1234_5678);
}

#[test]
fn the_scanner_list_is_sent_when_operational_is_entered() {
    let mut bench = Bench::bare(4);
    multiplex(&mut bench, SOURCE);
    // 2004h:2 to :4, and 2000h.
    bench.write_u32(0x1FA0, 1, 0x0320_0402);
    bench.write_u32(0x1FA0, 2, 0x0120_0000);
    for sub in 1..=4 {
        bench.write_u8(0x2004, sub, 16 + sub);
    }
    bench.write_u32(0x2000, 0, 0x1234_5678);
    bench.silence(100);
    bench.send("000 [2] 01 04");
    bench.expect("184: 04 04 20 02 12 00 00 00");
    bench.expect("184: 04 04 20 03 13 00 00 00");
    bench.expect("184: 04 04 20 04 14 00 00 00");
    bench.expect("184: 04 00 20 00 78 56 34 12");
    bench.silence(1_000);
}

#[test]
fn the_event_timer_sends_the_scanner_list_again() {
    let mut bench = Bench::bare(4);
    bench.write_u16(0x1800, 5, 50);
    multiplex(&mut bench, SOURCE);
    bench.write_u32(0x1FA0, 1, 0x0220_0401);
    bench.send("000 [2] 01 04");
    for (before, value) in [("00", "11"), ("11", "22"), ("22", "33")] {
        bench.expect(&format!("184: 04 04 20 01 {before} 00 00 00"));
        bench.expect_within("184: 04 04 20 02 00 00 00 00", 5);
        bench.send(&format!("604: 2F 04 20 01 {value} 00 00 00"));
        bench.expect("584: 60 04 20 01 ..");
        bench.silence(40);
    }
    bench.expect_within("184: 04 04 20 01 33 00 00 00", 10);
}

#[test]
fn the_application_announces_an_object_of_the_scanner_list() {
    let mut bench = operational(SOURCE);
    bench.write_u32(0x1FA0, 2, 0x0120_0402);
    bench.change(|objects| objects.set_bytes_byte_2(5));
    bench.silence(100);
    assert_eq!(bench.announce(0x2004, 2), Ok(()));
    bench.expect("184: 04 04 20 02 05 00 00 00");
    assert_eq!(bench.announce(0x2004, 1), Err(NotSent::NotListed));
    bench.silence(100);
}

#[test]
fn the_lists_take_objects_of_pdos_alone() {
    let mut bench = Bench::bare(4);
    // 2003h is for no PDO, 2004h:5 is not there, 2001h is read-only: it may be sent.
    bench.refused("604: 23 A0 1F 01 00 03 20 01", 0x0604_0041);
    bench.refused("604: 23 A0 1F 01 01 04 20 05", 0x0604_0041);
    bench.send("604: 23 A0 1F 01 00 01 20 01");
    bench.expect("584: 60 A0 1F 01 ..");
    let write = |bench: &mut Bench, number: u64| bench.try_write(0x1FD0, 1, &number.to_le_bytes());
    assert_eq!(write(&mut bench, 0x0120_0100_6000_0105), Err(0x0604_0041));
    assert_eq!(write(&mut bench, 0x0220_0404_6000_0105), Err(0x0604_0041));
    assert_eq!(write(&mut bench, 0x0120_0000_6000_0180), Err(0x0609_0030));
    assert_eq!(bench.read_u64(0x1FD0, 1), 0);
}

#[test]
fn a_multiplexed_pdo_of_a_synchronous_type_is_not_made_valid() {
    let mut bench = Bench::bare(4);
    for (communication, mapping, valid) in
        [(0x14, 0x1600, "04 02 00 00"), (0x18, 0x1A00, "84 01 00 40")]
    {
        bench.write_u8(communication << 8, 2, 1);
        bench.write_u8(mapping, 0, DESTINATION);
        bench.refused(
            &format!("604: 23 00 {communication:02X} 01 {valid}"),
            0x0609_0030,
        );
        bench.write_u8(communication << 8, 2, 254);
        bench.send(&format!("604: 23 00 {communication:02X} 01 {valid}"));
        bench.expect(&format!("584: 60 00 {communication:02X} 01 .."));
    }
}
