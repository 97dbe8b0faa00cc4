//! What the TC1 does in its own way.

use sim::plant::{Switch, Track};

use crate::steer::{NODE, begin, enabled_on, position};

/// Bit 16 of 1002h of the TC1 is the level of its external enable, input 1.
#[test]
fn the_tc1_shows_its_external_enable() {
    for edge in [100, 1_000_000] {
        let track = Track {
            negative_limit: Some(Switch::from(edge)),
            ..Track::default()
        };
        let mut bench = enabled_on("tc1", 1, track);
        for target in [50, 200, 50] {
            begin(&mut bench, target, 20_000, 1_000_000);
            bench.run(500);
            assert_eq!(position(&mut bench), target);
            let shown = bench.read(NODE, 0x1002, 0) >> 16 & 1 == 1;
            assert_eq!(shown, i64::from(target) > edge);
        }
    }
}
