//! A second SDO server: 1201h gives its identifiers, and it works beside the first.

use tests::Bench;

/// A device whose second server listens at 680h and answers at 681h.
fn with_second_server() -> Bench {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1201, 1, 0x680);
    bench.write_u32(0x1201, 2, 0x681);
    bench
}

#[test]
fn s38_restricted_identifiers_are_no_server() {
    let mut bench = Bench::node(4);
    for sub in 1..=2 {
        for id in [
            0x000_u32,
            0x001,
            0x07F,
            0x101,
            0x180,
            0x581,
            0x5FF,
            0x601,
            0x605,
            0x67F,
            0x6E0,
            0x6FF,
            0x701,
            0x77F,
            0x7E4,
            0x7FF,
            0x2000_0680,
        ] {
            let [a, b, c, d] = id.to_le_bytes();
            bench.refused(
                &format!("604: 23 01 12 {sub:02X} {a:02X} {b:02X} {c:02X} {d:02X}"),
                0x0609_0030,
            );
        }
    }
    assert_eq!(bench.read_u32(0x1201, 1), 0x8000_0000);
}

#[test]
fn s39_the_identifiers_of_a_valid_server_do_not_change() {
    let mut bench = with_second_server();
    bench.refused("604: 23 01 12 01 82 06", 0x0609_0030);
    bench.refused("604: 23 01 12 02 83 06", 0x0609_0030);
    bench.write_u32(0x1201, 1, 0x680);
    bench.write_u32(0x1201, 1, 0x8000_0680);
    bench.write_u32(0x1201, 2, 0x8000_0681);
    bench.write_u32(0x1201, 1, 0x682);
    bench.write_u32(0x1201, 2, 0x683);
    bench.send("682: 40 00 10 00");
    bench.expect("683: 43 00 10 00 ..");
    bench.send("680: 40 00 10 00");
    bench.silence(100);
}

#[test]
fn s40_two_servers_serve_two_clients_at_the_same_time() {
    let mut bench = with_second_server();
    bench.send("604: 40 10 20 00");
    bench.expect("584: 41 10 20 00 0E");
    bench.send("680: 21 01 20 00 09");
    bench.expect("681: 60 01 20 00");
    bench.send("604: 60");
    bench.expect("584: 00 41 42 43 44 45 46 47");
    bench.send("680: 00 61 62 63 64 65 66 67");
    bench.expect("681: 20");
    bench.send("604: 70");
    bench.expect("584: 11 48 49 4A 4B 4C 4D 4E");
    bench.send("680: 1B 68 69");
    bench.expect("681: 30");
    assert_eq!(bench.read(0x2001, 0), b"abcdefghi");
}

#[test]
fn s40_requests_at_once_are_answered_by_their_own_servers() {
    let mut bench = with_second_server();
    bench.queue("604: 40 0D 20 00");
    bench.queue("680: 40 0C 20 00");
    bench.expect("584: 41 0D 20 00 07");
    bench.expect("681: 41 0C 20 00 06");
    bench.send("680: 60");
    bench.expect("681: 03 41 42 43 44 45 46");
    bench.send("604: 60");
    bench.expect("584: 01 41 42 43 44 45 46 47");
}

#[test]
fn s40_a_time_out_of_one_server_leaves_the_other_alone() {
    let mut bench = with_second_server();
    bench.send("680: 40 01 20 00");
    bench.expect("681: 41 01 20 00 40");
    bench.silence(600);
    bench.send("604: 40 01 20 00");
    bench.expect("584: 41 01 20 00 40");
    bench.silence(390);
    bench.expect("681: 80 01 20 00 00 00 04 05");
    bench.send("604: 60");
    bench.expect("584: 00 41 42 43 44 45 46 47");
}

#[test]
fn s40_a_server_that_is_not_valid_is_silent() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1201, 1, 0x680);
    bench.send("680: 40 00 10 00");
    bench.silence(100);
    bench.write_u32(0x1201, 2, 0x681);
    bench.send("680: 40 00 10 00");
    bench.expect("681: 43 00 10 00 ..");
    bench.send("000 [2] 82 04");
    bench.expect("704 [1] 00");
    bench.send("680: 40 00 10 00");
    bench.silence(100);
}

/// Identifier 4FEh is lower than 584h: the abort gets on the bus between the segments.
#[test]
fn b24_an_abort_while_segments_are_sent_stops_them() {
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
