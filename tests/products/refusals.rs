//! What the manuals say that a product has not, and how it leaves the factory.

use crate::bench::Bench;
use crate::promises;

/// What the manual says that it has not is refused as an object that is not there.
fn has_none_of(name: &str, objects: &[u16]) {
    let mut bench = promises::booted(name);
    for index in objects {
        assert_eq!(
            promises::refusal(&mut bench, *index, 0),
            Some(0x0602_0000),
            "{name}: {index:04X}h"
        );
    }
}

#[test]
fn has_nothing_that_its_manual_says_it_has_not() {
    let tc1 = [
        0x1007, 0x100C, 0x100D, 0x1012, 0x1020, 0x1023, 0x1024, 0x1025, 0x1026, 0x1027, 0x1028,
        0x1029, 0x1280, 0x1FA0, 0x1FD0, 0x1404, 0x1804,
    ];
    has_none_of("tc1", &tc1);
    has_none_of(
        "nanotec",
        &[
            0x1006, 0x1012, 0x1016, 0x1019, 0x1029, 0x60A4, 0x6087, 0x6077, 0x60B1, 0x60B2, 0x60B8,
        ],
    );
    has_none_of("s200", &[0x1012, 0x1019, 0x1007, 0x1015, 0x1200]);
    has_none_of("lmd", &[0x1200, 0x60B8, 0x60C5, 0x607D, 0x6091]);
}

#[test]
fn leaves_the_factory_with_its_node_id_and_bit_rate() {
    for (name, node, kbit) in [("lmd", 65, 1_000), ("nanotec", 1, 1_000), ("s200", 1, 500)] {
        let bench = Bench::new(name, sim::drive::Setup::unconfigured(1));
        assert_eq!(bench.drive.node_id().get(), node);
        let rate = bench
            .drive
            .bit_rate()
            .map(canopen::BitRate::kbit_per_second);
        assert_eq!(rate, Some(kbit), "{name}");
    }
}

/// Profile velocity and the cyclic modes are none of the Nanotec's.
#[test]
fn refuses_modes_that_it_does_not_have() {
    let mut bench = promises::booted("nanotec");
    // Nor has it any of its maker for the direction of a clock, an analogue speed or a joystick.
    for mode in [3, 8, 9, 10, 0xFA, 0xFB, 0xFC, 0xFD] {
        assert_ne!(
            promises::write_byte(&mut bench, 0x6060, 0, mode),
            0,
            "{mode}"
        );
    }
}

/// A remote frame asks the TC1 for nothing: no PDO, no state.
#[test]
fn answers_no_remote_frame() {
    let mut bench = promises::operational("tc1");
    bench.run(300);
    for identifier in [0x704, 0x184, 0x284] {
        let before = promises::count(&mut bench, identifier, 90);
        bench.sent.clear();
        bench.send(&canopen::Frame::remote_frame(identifier, 0));
        let own = |frame: &&canopen::Frame| frame.standard_id() == Some(identifier);
        assert_eq!(bench.sent.iter().filter(own).count(), 0, "{before}");
    }
}
