//! Faults of the bus as the device sees them: bus-off, error passive, lost frames, another node with its identifiers.

use tests::Bench;

#[test]
fn c04_an_identifier_of_ours_from_another_node_is_reported_once() {
    for (frame, low, high) in [
        ("584: 43 00 10 00", "84", "05"),
        ("704 [1] 05", "04", "07"),
        ("184: 00", "84", "01"),
    ] {
        let mut bench = Bench::node(4);
        bench.start();
        bench.send(frame);
        bench.expect(&format!("084: 50 81 11 {low} {high}"));
        bench.send(frame);
        bench.silence(100);
        assert_eq!(bench.read_u8(0x1001, 0), 0x11);
        assert_eq!(bench.read_u32(0x1003, 1) & 0xFFFF, 0x8150);
    }
}

#[test]
fn c04_each_identifier_is_reported() {
    let mut bench = Bench::node(4);
    bench.start();
    bench.send("704 [1] 05");
    bench.expect("084: 50 81 11 04 07");
    bench.send("584: 43 00 10 00");
    bench.expect("084: 50 81 11 84 05");
    bench.send("000 [2] 82 04");
    bench.drain_until("704 [1] 00", 20);
    assert_eq!(bench.read_u8(0x1001, 0), 0, "a reset forgets it");
}

#[test]
fn c04_identifiers_that_others_may_send_are_not_reported() {
    let mut bench = Bench::node(4);
    bench.start();
    for frame in ["081 [0]", "204: 00", "604: 40 00 10 00", "705 [1] 05"] {
        bench.send(frame);
    }
    bench.expect("584: 43 00 10 00 ..");
    bench.silence(100);
}
