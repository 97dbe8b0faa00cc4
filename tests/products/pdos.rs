//! What the manuals promise of PDOs: identifiers, transmission types, times, mappings.

use canopen::Frame;

use crate::bench::Bench;
use crate::promises::{booted, count, nmt, write_byte};
use crate::steer::NODE;

/// Four PDOs each way with the identifiers of the pre-defined connection set.
fn has_its_pdos(name: &str) {
    let mut bench = booted(name);
    for (number, first) in [(0_u16, 0x180_u32), (1, 0x280), (2, 0x380), (3, 0x480)] {
        let identifier =
            |bench: &mut Bench, index: u16| bench.read(NODE, index + number, 1) & 0x7FF;
        assert_eq!(identifier(&mut bench, 0x1800), first + 4, "{name}");
        assert_eq!(identifier(&mut bench, 0x1400), first + 0x80 + 4, "{name}");
    }
    // The controlword is that of RPDO 1, and counts in operational only; the statusword that of TPDO 1, on each change.
    bench.send(&Frame::data_frame(0x204, &[6, 0]));
    bench.run(20);
    assert_eq!(bench.read(NODE, 0x6040, 0) as u16, 0);
    bench.sent.clear();
    nmt(&mut bench, 1);
    assert!(bench.next(0x184, 200).is_some(), "on start");
    bench.run(300);
    bench.sent.clear();
    bench.send(&Frame::data_frame(0x204, &[6, 0]));
    let word = loop {
        let frame = bench.next(0x184, 300).expect("a statusword");
        if frame.payload()[0] & 0x6F == 0x21 {
            break frame;
        }
    };
    assert_eq!(word.length(), 2, "{name}");
    nmt(&mut bench, 128);
    assert_eq!(
        count(&mut bench, 0x184, 300),
        0,
        "no PDO in pre-operational"
    );
}

/// The types of CiA 301, and no others.
fn has_transmission_types(name: &str) {
    let mut bench = booted(name);
    for kind in [0, 1, 240, 254, 255] {
        assert_eq!(write_byte(&mut bench, 0x1800, 2, kind), 0, "{name}: {kind}");
        assert_eq!(bench.read(NODE, 0x1800, 2) as u8, kind);
        assert_eq!(write_byte(&mut bench, 0x1400, 2, kind), 0, "{name}: {kind}");
    }
    for kind in [241, 251] {
        assert_eq!(write_byte(&mut bench, 0x1800, 2, kind), 0x0609_0030);
        assert_eq!(write_byte(&mut bench, 0x1400, 2, kind), 0x0609_0030);
    }
}

/// TPDO 1 with this transmission type and no inhibit time.
pub fn with_type(name: &str, kind: u8) -> Bench {
    let mut bench = booted(name);
    bench.write(NODE, 0x1800, 1, &0xC000_0184_u32.to_le_bytes());
    bench.write(NODE, 0x1800, 2, &[kind]);
    bench.write(NODE, 0x1800, 3, &[0, 0]);
    bench.write(NODE, 0x1800, 5, &[0, 0]);
    bench.write(NODE, 0x1800, 1, &0x4000_0184_u32.to_le_bytes());
    nmt(&mut bench, 1);
    bench
}

/// A PDO at every second SYNC; the identifier of SYNC can be another one.
fn sends_with_sync(name: &str) {
    let mut bench = with_type(name, 2);
    bench.write(NODE, 0x1005, 0, &0x0000_0081_u32.to_le_bytes());
    bench.sent.clear();
    for _ in 0..6 {
        bench.send(&Frame::data_frame(0x080, &[]));
        bench.send(&Frame::data_frame(0x081, &[]));
        bench.run(5);
    }
    let own = |frame: &&Frame| frame.standard_id() == Some(0x184);
    assert_eq!(bench.sent.iter().filter(own).count(), 3, "{name}");
}

/// A synchronous receive PDO counts at the SYNC, an event-driven one at once.
fn receives_with_sync(name: &str) {
    let mut bench = booted(name);
    bench.write(NODE, 0x1400, 2, &[1]);
    nmt(&mut bench, 1);
    bench.send(&Frame::data_frame(0x204, &[6, 0]));
    bench.run(20);
    assert_eq!(bench.read(NODE, 0x6040, 0) as u16, 0, "{name}");
    bench.send(&Frame::data_frame(0x080, &[]));
    bench.run(20);
    assert_eq!(bench.read(NODE, 0x6040, 0) as u16, 6, "{name}");
}

/// The event timer, in milliseconds and with an S200 in 100 µs, is the longest pause; the inhibit time, in 100 µs, the shortest.
fn keeps_its_times(name: &str) {
    let mut bench = with_type(name, 255);
    let timer: u16 = if name == "s200" { 200 } else { 20 };
    bench.write(NODE, 0x1800, 5, &timer.to_le_bytes());
    bench.run(50);
    let came = count(&mut bench, 0x184, 1_000);
    assert!((49..=51).contains(&came), "{name}: {came}");
    bench.write(NODE, 0x1800, 5, &[0, 0]);
    bench.write(NODE, 0x1800, 1, &0xC000_0184_u32.to_le_bytes());
    bench.write(NODE, 0x1800, 3, &1_000_u16.to_le_bytes());
    bench.write(NODE, 0x1800, 1, &0x4000_0184_u32.to_le_bytes());
    bench.run(150);
    bench.sent.clear();
    for controlword in [6, 0, 6, 0, 6, 0] {
        bench.send(&Frame::data_frame(0x204, &[controlword, 0]));
        bench.run(15);
    }
    let own = |frame: &&Frame| frame.standard_id() == Some(0x184);
    assert_eq!(bench.sent.iter().filter(own).count(), 1, "{name}");
}

/// TPDO 4 is mapped anew, in pre-operational and in operational, and carries what is mapped.
fn is_mapped_anew(name: &str) {
    for command in [128, 1] {
        let mut bench = booted(name);
        nmt(&mut bench, command);
        bench.write(NODE, 0x1803, 1, &0xC000_0484_u32.to_le_bytes());
        bench.write(NODE, 0x1A03, 0, &[0]);
        bench.write(NODE, 0x1A03, 1, &0x6041_0010_u32.to_le_bytes());
        bench.write(NODE, 0x1A03, 2, &0x6061_0008_u32.to_le_bytes());
        bench.write(NODE, 0x1A03, 0, &[2]);
        bench.write(NODE, 0x1803, 2, &[1]);
        bench.write(NODE, 0x1803, 1, &0x4000_0484_u32.to_le_bytes());
        nmt(&mut bench, 1);
        bench.sent.clear();
        bench.send(&Frame::data_frame(0x080, &[]));
        let frame = bench.next(0x484, 100).expect("TPDO 4");
        assert_eq!(frame.length(), 3, "{name}");
        // Switched off it is silent.
        bench.write(NODE, 0x1803, 1, &0xC000_0484_u32.to_le_bytes());
        bench.sent.clear();
        bench.send(&Frame::data_frame(0x080, &[]));
        assert!(bench.next(0x484, 50).is_none());
    }
}

mod each {
    promises! {
        has_its_pdos: lmd nanotec s200 tc1;
        has_transmission_types: lmd nanotec s200 tc1;
        sends_with_sync: lmd nanotec s200 tc1;
        receives_with_sync: lmd nanotec s200 tc1;
        keeps_its_times: lmd nanotec s200 tc1;
        is_mapped_anew: lmd nanotec s200 tc1;
    }
}
