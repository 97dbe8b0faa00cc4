//! Heartbeat.

use tests::Bench;

#[test]
fn h01_the_first_heartbeat_comes_at_once() {
    let mut bench = Bench::node(4);
    bench.write_u16(0x1017, 0, 100);
    bench.expect("704 [1] 7F");
    let first = bench.now();
    for beat in 1..=5 {
        bench.expect("704 [1] 7F");
        // The first one had to wait for the answer to the SDO.
        let off = (bench.now() - first).to_micros().abs_diff(beat * 100_000);
        assert!(off < 1_000, "beat {beat} is {off} µs off");
    }
}

#[test]
fn h02_a_new_state_shows_in_the_next_heartbeat() {
    let mut bench = Bench::node(4);
    bench.write_u16(0x1017, 0, 100);
    bench.expect("704 [1] 7F");
    bench.start();
    bench.expect("704 [1] 05");
}
