//! Found, numbered and switched to each bit rate by LSS, or not.

use super::*;

/// LSS finds the device by its four numbers, and by no others.
pub fn is_selected_by_lss(name: &str) {
    let mut bench = Bench::new(name, sim::drive::Setup::unconfigured(0x1454_523E));
    let node = bench.drive.node_id().get();
    let identity: Vec<u32> = match node {
        255 => vec![0x3F5, 1, 1, 0x1454_523E],
        _ => (1..=4).map(|sub| bench.read(node, 0x1018, sub)).collect(),
    };
    assert_eq!(identity[3], 0x1454_523E);
    for off in [1, 0] {
        bench.sent.clear();
        for (command, word) in (0x40..).zip(&identity) {
            let [a, b, c, d] = (word + if command == 0x43 { off } else { 0 }).to_le_bytes();
            bench.send(&Frame::full(0x7E5, [command, a, b, c, d, 0, 0, 0]));
        }
        let answer = bench.next(0x7E4, 20);
        assert_eq!(
            answer.map(|frame| frame.payload()[0]),
            (off == 0).then_some(0x44)
        );
    }
    bench.send(&Frame::full(0x7E5, [0x11, 9, 0, 0, 0, 0, 0, 0]));
    let answer = bench.next(0x7E4, 20).expect("an answer");
    assert_eq!(answer.payload()[..2], [0x11, 0]);
}

/// Nobody answers LSS.
pub fn has_no_lss(name: &str) {
    let mut bench = booted(name);
    bench.send(&Frame::full(0x7E5, [0x04, 1, 0, 0, 0, 0, 0, 0]));
    bench.send(&Frame::full(0x7E5, [0x5E, 0, 0, 0, 0, 0, 0, 0]));
    assert_eq!(count(&mut bench, 0x7E4, 100), 0, "{name}");
}

/// Each bit rate of CiA 305 is taken by LSS, and is in force once it is activated; an index that is none is refused.
pub fn runs_at_each_bit_rate(name: &str) {
    for (index, kbit) in [
        (0, 1_000),
        (1, 800),
        (2, 500),
        (3, 250),
        (4, 125),
        (6, 50),
        (7, 20),
        (8, 10),
    ] {
        let mut bench = booted(name);
        bench.send(&Frame::full(0x7E5, [0x04, 1, 0, 0, 0, 0, 0, 0]));
        bench.send(&Frame::full(0x7E5, [0x13, 0, index, 0, 0, 0, 0, 0]));
        let answer = bench.next(0x7E4, 20).expect("an answer");
        assert_eq!(answer.payload()[..2], [0x13, 0], "{name}: {kbit}");
        bench.send(&Frame::full(0x7E5, [0x15, 1, 0, 0, 0, 0, 0, 0]));
        bench.run(50);
        let rate = bench
            .drive
            .bit_rate()
            .map(canopen::BitRate::kbit_per_second);
        assert_eq!(rate, Some(kbit), "{name}");
    }
    let mut bench = booted(name);
    bench.send(&Frame::full(0x7E5, [0x04, 1, 0, 0, 0, 0, 0, 0]));
    bench.send(&Frame::full(0x7E5, [0x13, 0, 20, 0, 0, 0, 0, 0]));
    let answer = bench.next(0x7E4, 20).expect("an answer");
    assert_eq!(answer.payload()[..2], [0x13, 1]);
}
