//! What the manuals say that a product has not, and how it leaves the factory.

use crate::bench::Bench;
use crate::promises;
use crate::steer::NODE;

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

/// The abort codes of the TC1's table, each by what leads to it. For the rest of the thirty it has no reason: blocks, objects that can only be
/// written, memory that runs out, another dictionary.
#[test]
fn the_tc1_has_a_code_for_each_refusal() {
    let mut bench = promises::booted("tc1");
    // The history is empty until something happens.
    assert_eq!(promises::refusal(&mut bench, 0x1003, 1), Some(0x0800_0024));
    bench.write(NODE, 0x1016, 1, &0x0005_0064_u32.to_le_bytes());
    for (request, code) in [
        ([0xE0, 0x00, 0x10, 0, 0, 0, 0, 0], 0x0504_0001_u32),
        // Blocks, either way.
        ([0xA0, 0x08, 0x10, 0, 127, 0, 0, 0], 0x0504_0001),
        ([0xC2, 0x85, 0x60, 0, 4, 0, 0, 0], 0x0504_0001),
        ([0x2B, 0x41, 0x60, 0, 1, 0, 0, 0], 0x0601_0002),
        ([0x40, 0xFE, 0x5F, 0, 0, 0, 0, 0], 0x0602_0000),
        // What is not there, and what is no process data, into a mapping that is off.
        ([0x23, 0x00, 0x1A, 1, 0x08, 0, 0xFE, 0x5F], 0x0604_0041),
        ([0x23, 0x00, 0x1A, 1, 0x20, 0, 0x00, 0x10], 0x0604_0041),
        // The same node twice among the heartbeats.
        ([0x23, 0x16, 0x10, 2, 0x64, 0, 5, 0], 0x0604_0043),
        ([0x23, 0x17, 0x10, 0, 1, 0, 0, 0], 0x0607_0012),
        ([0x2F, 0x17, 0x10, 0, 1, 0, 0, 0], 0x0607_0013),
        ([0x40, 0x18, 0x10, 9, 0, 0, 0, 0], 0x0609_0011),
        ([0x40, 0x00, 0x18, 4, 0, 0, 0, 0], 0x0609_0011),
        ([0x2F, 0x00, 0x18, 2, 0xF1, 0, 0, 0], 0x0609_0030),
        ([0x2F, 0x03, 0x10, 0, 1, 0, 0, 0], 0x0609_0031),
        ([0x23, 0x83, 0x60, 0, 0, 0, 0, 0], 0x0609_0032),
        ([0x23, 0x10, 0x10, 1, b'S', b'A', b'V', b'E'], 0x0800_0022),
    ] {
        if request[1..3] == [0x00, 0x1A] {
            bench.write(NODE, 0x1800, 1, &0xC000_0184_u32.to_le_bytes());
            bench.write(NODE, 0x1A00, 0, &[0]);
        }
        let answer = bench.sdo(NODE, request);
        let [a, b, c, d] = code.to_le_bytes();
        let [_, low, high, sub, ..] = request;
        assert_eq!(answer, [0x80, low, high, sub, a, b, c, d], "{request:02X?}");
    }
    // In the middle of a transfer: a toggle bit, and a master that says no more.
    let name = [0x40, 0x08, 0x10, 0, 0, 0, 0, 0];
    assert_eq!(bench.sdo(NODE, name)[0], 0x41);
    let answer = bench.sdo(NODE, [0x70, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(answer, [0x80, 0x08, 0x10, 0, 0, 0, 3, 5]);
    assert_eq!(bench.sdo(NODE, name)[0], 0x41);
    let told = bench
        .next(0x580 + u16::from(NODE), 5_000)
        .expect("an abort");
    assert_eq!(told.payload(), [0x80, 0x08, 0x10, 0, 0, 0, 4, 5]);
    // Storing fails where the flash does.
    bench.drive.with_flash(&mut |flash| flash.break_down());
    bench.run(10);
    let answer = bench.sdo(NODE, [0x23, 0x10, 0x10, 1, b's', b'a', b'v', b'e']);
    assert_eq!(answer, [0x80, 0x10, 0x10, 1, 0, 0, 6, 6]);
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
