//! What the manuals promise of the groups that parameters are stored in.

use crate::bench::Bench;
use crate::promises::{booted, nmt};
use crate::steer::{NODE, number};

/// Whether the heartbeat and the window of the following error are as they were set.
fn kept(bench: &mut Bench) -> (bool, bool) {
    nmt(bench, 129);
    bench.run(200);
    (
        bench.read(NODE, 0x1017, 0) == 5_000,
        bench.read(NODE, 0x6065, 0) == 1_234,
    )
}

/// Each group of the TC1 is stored and restored without the others. Its last three are those of the manufacturer, who has nothing in them.
#[test]
fn the_tc1_stores_each_of_its_groups() {
    for group in 1..=6 {
        let mut bench = booted("tc1");
        for index in [0x1010, 0x1011] {
            assert_eq!(bench.read(NODE, index, group), 1, "{index:04X}h:{group}");
        }
        bench.write(NODE, 0x1017, 0, &5_000_u16.to_le_bytes());
        number(&mut bench, 0x6065, 0, 1_234);
        bench.write(NODE, 0x1010, group, b"save");
        let expected = (matches!(group, 1 | 2), matches!(group, 1 | 3));
        assert_eq!(kept(&mut bench), expected, "{group}");
        bench.write(NODE, 0x1011, group, b"load");
        assert_eq!(kept(&mut bench), (false, false), "{group}");
    }
}
