//! What the manuals promise of stored parameters: their groups, and identifiers under another node-ID.

use canopen::Frame;

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

/// Identifiers that a Nanotec has stored stay under another node-ID until its defaults are restored; those of a TC1 follow it.
#[test]
fn the_identifiers_of_the_nanotec_stay_until_defaults_are_restored() {
    for (name, stored) in [("nanotec", [0x204, 0x184]), ("tc1", [0x209, 0x189])] {
        let mut bench = booted(name);
        bench.write(NODE, 0x1010, 1, b"save");
        if name == "nanotec" {
            bench.write(NODE, 0x2009, 0, &[9]);
        } else {
            for request in [[0x04, 1, 0], [0x11, 9, 0], [0x17, 0, 0]] {
                let [a, b, c] = request;
                bench.send(&Frame::full(0x7E5, [a, b, c, 0, 0, 0, 0, 0]));
                bench.run(50);
            }
        }
        bench.drive.power_cycle();
        bench.run(100);
        let identifiers =
            |bench: &mut Bench| [0x1400, 0x1800].map(|index| bench.read(9, index, 1) & 0x7FF);
        assert_eq!(identifiers(&mut bench), stored, "{name}");
        bench.write(9, 0x1011, 1, b"load");
        bench.drive.power_cycle();
        bench.run(100);
        assert_eq!(bench.drive.node_id().get(), 9, "{name}");
        assert_eq!(identifiers(&mut bench), [0x209, 0x189], "{name}");
    }
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
