//! What the manuals promise of set-points that come with SYNC: interpolated position, and cyclic synchronous position.

use canopen::Frame;

use crate::bench::Bench;
use crate::steer::{NODE, begin, command, number, position, statusword};

/// A set-point of interpolated position, and the SYNC that takes it.
fn cycle(bench: &mut Bench, target: i32) {
    bench.write(NODE, 0x60C1, 1, &target.to_le_bytes());
    bench.send(&Frame::data_frame(0x080, &[]));
    bench.run(10);
}

/// Set-points of interpolated position come with SYNC; the motor is where they are, once bit 4 is set, and bit 12 tells so.
fn follows_a_set_point_of_each_sync(name: &str) {
    let mut bench = Bench::node(name, NODE);
    bench.write(NODE, 0x60C2, 1, &[10]);
    let millis = (-3_i16).to_le_bytes();
    let size = if name == "s200" { 2 } else { 1 };
    bench.write(NODE, 0x60C2, 2, &millis[..size]);
    bench.send(&Frame::data_frame(0, &[1, NODE]));
    bench.write(NODE, 0x6060, 0, &[7]);
    bench.enable(NODE);
    for _ in 0..50 {
        cycle(&mut bench, 0);
    }
    assert_eq!(statusword(&mut bench) >> 12 & 1, 0, "{name}: not yet");
    command(&mut bench, 0x1F);
    for _ in 0..10 {
        cycle(&mut bench, 0);
    }
    assert_eq!(statusword(&mut bench) >> 12 & 1, 1, "{name}");
    for target in 1..=100 {
        cycle(&mut bench, target * 10);
        if target == 80 {
            let away = position(&mut bench) - 800;
            assert!((-40..=10).contains(&away), "{name}: {away}");
        }
    }
    for _ in 0..10 {
        cycle(&mut bench, 1_000);
    }
    assert_eq!(position(&mut bench), 1_000, "{name}");
}

/// A quick stop in interpolated position is abrupt, whatever 6085h says.
#[test]
fn the_nanotec_stops_abruptly_in_interpolated_position() {
    let mut bench = Bench::node("nanotec", NODE);
    number(&mut bench, 0x6085, 0, 1_000);
    bench.write(NODE, 0x60C2, 1, &[10]);
    bench.write(NODE, 0x60C2, 2, &[0xFD]);
    bench.send(&Frame::data_frame(0, &[1, NODE]));
    bench.write(NODE, 0x6060, 0, &[7]);
    bench.enable(NODE);
    for _ in 0..50 {
        cycle(&mut bench, 0);
    }
    command(&mut bench, 0x1F);
    for target in 1..=100 {
        cycle(&mut bench, target * 20);
    }
    let from = position(&mut bench);
    command(&mut bench, 0x0B);
    bench.run(1_000);
    // 2000 a second: a ramp of 6085h would take two seconds, and 2000.
    let way = position(&mut bench) - from;
    assert!((0..=30).contains(&way), "{way}");
}

/// Bit 8 of a Nanotec tells that its clock is locked to SYNC.
#[test]
fn the_nanotec_tells_that_it_is_locked_to_sync() {
    let mut bench = Bench::node("nanotec", NODE);
    // It listens from operational on.
    for (command, is_locked) in [(128, 0), (1, 1)] {
        bench.send(&Frame::data_frame(0, &[command, NODE]));
        bench.run(20);
        for _ in 0..400 {
            bench.send(&Frame::data_frame(0x080, &[]));
            bench.run(5);
        }
        let word = bench.drive.object(0x6041, 0).unwrap();
        assert_eq!(word[1] & 1, is_locked, "{command}");
    }
    bench.run(500);
    assert_eq!(statusword(&mut bench) >> 8 & 1, 0, "SYNC has ended");
}

/// Bit 12 of cyclic synchronous position tells that the target is followed, bit 13 of a following error.
#[test]
fn the_lmd_tells_how_it_follows_cyclic_targets() {
    let mut bench = Bench::node("lmd", NODE);
    bench.write(NODE, 0x60C2, 1, &[10]);
    bench.write(NODE, 0x60C2, 2, &(-3_i8).to_le_bytes());
    number(&mut bench, 0x6065, 0, 500);
    bench.send(&Frame::data_frame(0, &[1, NODE]));
    bench.write(NODE, 0x6060, 0, &[8]);
    bench.enable(NODE);
    let cycle = |bench: &mut Bench, target: i32| {
        bench.write(NODE, 0x607A, 0, &target.to_le_bytes());
        bench.send(&Frame::data_frame(0x080, &[]));
        bench.run(10);
        statusword(bench) >> 12 & 3
    };
    for target in 0..100 {
        cycle(&mut bench, target * 20);
    }
    assert_eq!(cycle(&mut bench, 2_000), 0b01, "it follows");
    bench.drive.plant_mut().encoder = true;
    cycle(&mut bench, 2_020);
    bench.drive.plant_mut().displace(-2_000);
    for target in 102..110 {
        cycle(&mut bench, target * 20);
    }
    assert_eq!(cycle(&mut bench, 2_200) >> 1, 1, "it is too far away");
    // Without targets nothing is followed.
    let mut bench = Bench::node("lmd", NODE);
    bench.write(NODE, 0x6060, 0, &[8]);
    bench.enable(NODE);
    bench.write(NODE, 0x6040, 0, &[0x0F, 1]);
    bench.run(200);
    assert_eq!(statusword(&mut bench) >> 12 & 1, 0, "halt");
}

/// A master that begins with the position that it reads moves nothing; its set-points come by a PDO with SYNC.
#[test]
fn the_nanotec_is_led_by_pdos_from_where_it_stands() {
    let mut bench = Bench::node("nanotec", NODE);
    // RPDO 2 carries controlword and set-point, TPDO 2 statusword and position.
    for (index, cob_id, mapping) in [
        (0x1401, 0x0000_0304_u32, [0x6040_0010_u32, 0x60C1_0120]),
        (0x1801, 0x4000_0284, [0x6041_0010, 0x6064_0020]),
    ] {
        number(&mut bench, index, 1, cob_id | 0x8000_0000);
        bench.write(NODE, index + 0x200, 0, &[0]);
        for (sub, entry) in (1..).zip(mapping) {
            number(&mut bench, index + 0x200, sub, entry);
        }
        bench.write(NODE, index + 0x200, 0, &[2]);
        bench.write(NODE, index, 2, &[1]);
        number(&mut bench, index, 1, cob_id);
    }
    // The period is that of SYNC, whatever this is.
    bench.write(NODE, 0x60C2, 1, &[77]);
    bench.write(NODE, 0x6060, 0, &[1]);
    bench.enable(NODE);
    begin(&mut bench, 700, 2_000, 50_000);
    bench.run(1_000);
    bench.write(NODE, 0x6060, 0, &[7]);
    bench.send(&Frame::data_frame(0, &[1, NODE]));
    bench.run(20);
    let cycle = |bench: &mut Bench, controlword: u16, target: i32| {
        let mut data = controlword.to_le_bytes().to_vec();
        data.extend(target.to_le_bytes());
        bench.send(&Frame::data_frame(0x304, &data));
        bench.sent.clear();
        bench.send(&Frame::data_frame(0x080, &[]));
        bench.run(10);
        let own = |frame: &&Frame| frame.standard_id() == Some(0x284);
        let frame = *bench.sent.iter().find(own).expect("TPDO 2");
        let [_, _, a, b, c, d] = frame.payload() else {
            panic!("{frame:?}")
        };
        i32::from_le_bytes([*a, *b, *c, *d])
    };
    let here = cycle(&mut bench, 0x0F, 0);
    assert_eq!(here, 700);
    for _ in 0..50 {
        assert_eq!(cycle(&mut bench, 0x1F, here), 700, "it stays");
    }
    let mut last = here;
    for step in 1..=60 {
        let shown = cycle(&mut bench, 0x1F, here + step.min(50) * 10);
        // No faster than the set-points are apart, and a step more or less.
        assert!((0..=12).contains(&(shown - last)), "{shown} behind {last}");
        last = shown;
    }
    assert_eq!(last, 1_200);
}

mod each {
    promises! {
        follows_a_set_point_of_each_sync: nanotec s200;
    }
}
