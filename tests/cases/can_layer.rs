//! The CAN layer below the services: foreign frames, a bus that is blocked, random traffic.

use canopen::{Duration, Frame};
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;
use tests::{Bench, DriveBench};

#[test]
fn twenty_frames_back_to_back_are_all_served() {
    let mut bench = Bench::node(4);
    bench.start();
    for number in 0..20_u8 {
        bench.queue_frame(Frame::data_frame(
            0x204,
            &[number, 0, 0, 0, number, 0, 0, 0],
        ));
    }
    bench.queue("604: 40 03 20 00");
    bench.expect("584: 43 03 20 00 13 00 00 00");
    assert_eq!(bench.read_u32(0x2004, 0), 19);
}

#[test]
fn a_blocked_bus_leaves_the_newest_process_data_and_one_heartbeat() {
    let mut bench = Bench::node(4);
    bench.start();
    bench.write_u16(0x1017, 0, 10);
    bench.drain(25);
    bench.jam(Duration::millis(100));
    for value in 1..=50_u32 {
        bench.change(|dictionary| dictionary.set_sent_number_1(value));
        bench.run_millis(2);
    }
    let mut values = Vec::new();
    let mut beats = 0;
    while let Some(frame) = bench.next(Duration::millis(5)) {
        match frame.standard_id() {
            Some(0x184) => values.push(frame.payload()[0]),
            Some(0x704) => beats += 1,
            other => panic!("{other:?}"),
        }
    }
    // What the controller's mailboxes held when the bus was blocked is older; the rest was replaced in its slot.
    assert_eq!(values.last(), Some(&50));
    assert!(values.len() <= 4, "{values:?}");
    assert!(beats <= 4, "{beats}");
}

#[test]
fn what_has_not_left_within_the_window_is_dropped() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1801, 1, 0xC000_0284);
    bench.write_u32(0x1800, 1, 0xC000_0184);
    bench.write_u8(0x1800, 2, 1);
    bench.write_u32(0x1800, 1, 0x4000_0184);
    bench.write_u32(0x1007, 0, 1_000);
    bench.start();
    bench.send("080 [0]");
    bench.expect("184 ..");
    bench.send("080 [0]");
    bench.jam(Duration::millis(3));
    bench.silence(50);
    bench.send("080 [0]");
    bench.expect("184 ..");
}

/// Identifier 4FEh is lower than 584h: the abort gets on the bus between the segments.
#[test]
fn an_abort_while_segments_are_sent_stops_them() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1201, 1, 0x4FE);
    bench.write_u32(0x1201, 2, 0x681);
    bench.send("4FE: A4 01 20 00 7F");
    bench.expect("681: C6 01 20 00 40");
    bench.send("4FE: A3");
    bench.expect("681: 01 41 42 43 44 45 46 47");
    bench.send("4FE: 80 01 20 00 00 00 00 08");
    bench.run_millis(10);
    let sent = bench
        .cob_ids_of_the_device()
        .iter()
        .filter(|id| **id == 0x681)
        .count();
    // The answer, and of ten segments those that were in mailboxes.
    assert!(sent <= 6, "{sent} frames");
    bench.drain(2_000);
    bench.send("4FE: 40 00 10 00");
    bench.expect("681: 43 00 10 00 ..");
}

#[test]
fn o02_every_index_and_sub_index_has_an_answer() {
    let mut bench = Bench::node(4);
    // Every index near an object, and a stride over the rest; every sub-index of those that exist.
    let mut indices: Vec<u16> = (0x1000..0x1400).chain((0..=0xFFFF).step_by(251)).collect();
    indices.extend([
        0x0000, 0x0FFF, 0x1400, 0x15FF, 0x1600, 0x1800, 0x1A00, 0x1FFF, 0x2000, 0x2011, 0x2012,
        0xFFFF,
    ]);
    for index in indices {
        match bench.try_read(index, 0) {
            Err(0x0602_0000) => assert_eq!(bench.try_read(index, 1), Err(0x0602_0000)),
            Ok(_) | Err(0x0601_0001) => {
                for sub in 1..=255_u8 {
                    match bench.try_read(index, sub) {
                        Ok(_) | Err(0x0609_0011 | 0x0601_0001 | 0x0800_0024) => {}
                        Err(code) => panic!("{index:04X}h:{sub:02X}: {code:08X}"),
                    }
                }
            }
            Err(code) => panic!("{index:04X}h:00: {code:08X}"),
        }
    }
}

#[test]
fn two_drives_on_one_bus_do_not_hear_each_other() {
    let mut first = Bench::node(4);
    first.attach_another(5);
    first.expect("705 [1] 00");
    first.send("604: 23 00 20 00 11 11 11 11");
    first.expect("584: 60 00 20 00");
    first.send("605: 40 00 20 00");
    first.expect("585: 43 00 20 00 00 00 00 00");
    first.send("000 [2] 01 05");
    first.expect("185 ..");
    first.drain(10);
    assert_eq!(first.state_in_heartbeat(), 0x7F);
}

/// A frame as noise on the bus has it: mostly for the device, sometimes for nobody.
fn any_frame() -> impl Strategy<Value = Frame> {
    let id = prop_oneof![
        8 => prop::sample::select(vec![0x000_u16, 0x080, 0x204, 0x304, 0x404, 0x504, 0x604, 0x7E5]),
        1 => 0_u16..0x800,
    ];
    (
        id,
        prop::collection::vec(any::<u8>(), 0..=8),
        prop::bool::weighted(0.7),
    )
        .prop_map(|(id, mut data, whole)| {
            if whole && matches!(id, 0x604 | 0x7E5) {
                data.resize(8, 0);
            }
            if whole && id == 0 {
                // Commands for this node, but none that resets it: a reset is its own case.
                data = vec![[0x01, 0x02, 0x80][data.len() % 3], 4];
            }
            Frame::data_frame(id, &data)
        })
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig { cases: 48, ..ProptestConfig::default() }))]

    #[test]
    fn c06_random_frames_never_break_the_drive(traffic in prop::collection::vec((any_frame(), 0_u64..3_000), 1..150)) {
        let mut drive = DriveBench::booted(4);
        let mut requests = 0;
        for (frame, pause) in traffic {
            requests += usize::from(frame.standard_id() == Some(0x604));
            drive.send_frame(frame);
            drive.run_micros(pause);
        }
        drive.run_millis(1_100);
        let sent = drive.cob_ids_of_the_device();
        let answers = sent.iter().filter(|id| **id == 0x584).count();
        prop_assert_eq!(sent[0], 0x704);
        // One answer for a request, and one more where a transfer that was left open is timed out.
        prop_assert!(answers <= 2 * requests, "{} answers to {} requests", answers, requests);
        // Whatever happened, the node can be brought back.
        drive.send("000 [2] 81 04");
        drive.drain_until("704 [1] 00", 12_000);
    }
}
