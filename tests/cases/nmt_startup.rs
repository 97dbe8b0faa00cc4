//! NMT start-up.

use tests::Bench;

/// The power fails and returns.
fn cycle_power(bench: &mut Bench) {
    bench.device().cycle_power();
    bench.drain_until("704 [1] 00", 20);
}

#[test]
fn n16_bit_2_of_1f80h_chooses_between_self_start_and_waiting() {
    for (startup, state) in [(0, 0x05), (4, 0x7F)] {
        let mut bench = Bench::node(4);
        bench.write_u32(0x1F80, 0, startup);
        bench.write_u16(0x1017, 0, 100);
        bench.write(0x1010, 2, b"save");
        cycle_power(&mut bench);
        let beat = bench.drain_until("704 [1] xx", 250);
        assert_eq!(beat.payload(), [state], "1F80h is {startup}");
        // A master's word counts after that.
        bench.send("000 [2] 80 04");
        bench.drain(5);
        let beat = bench.drain_until("704 [1] xx", 250);
        assert_eq!(beat.payload(), [0x7F]);
    }
}
