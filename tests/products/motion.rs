//! What the manuals promise of motion: profiles, limits, polarity, home offset; errors that end, and switches.

use canopen::settings::Switches;
use canopen::{BitRate, Frame};
use sim::drive::Setup;

use crate::bench::Bench;

const NODE: u8 = 4;

fn position(bench: &mut Bench) -> i32 {
    bench.read(NODE, 0x6064, 0) as i32
}

fn command(bench: &mut Bench, controlword: u16) {
    bench.write(NODE, 0x6040, 0, &controlword.to_le_bytes());
    bench.run(5);
}

/// A product in profile position, its motor on, with this profile.
fn ready(name: &str, velocity: u32, acceleration: u32) -> Bench {
    let mut bench = Bench::node(name, NODE);
    bench.write(NODE, 0x6060, 0, &[1]);
    bench.write(NODE, 0x6081, 0, &velocity.to_le_bytes());
    bench.write(NODE, 0x6083, 0, &acceleration.to_le_bytes());
    bench.write(NODE, 0x6084, 0, &acceleration.to_le_bytes());
    // A start speed of these, which would be all there is.
    if matches!(name, "lmd" | "nanotec") {
        bench.write(NODE, 0x6082, 0, &[0; 4]);
    }
    bench.enable(NODE);
    bench
}

fn begin(bench: &mut Bench, target: i32) {
    bench.write(NODE, 0x607A, 0, &target.to_le_bytes());
    command(bench, 0x1F);
    command(bench, 0x0F);
}

/// How far the motor goes in a second.
fn rate(bench: &mut Bench) -> i32 {
    let from = position(bench);
    bench.run(1_000);
    position(bench) - from
}

/// The velocity is that of 6081h, reached with 6083h and left with 6084h.
fn keeps_its_profile(name: &str) {
    let mut bench = ready(name, 2_000, 1_000);
    begin(&mut bench, 20_000);
    bench.run(1_000);
    // A second at 1000 per s² is 500 far, and two seconds are 2000.
    let way = position(&mut bench);
    assert!((480..=560).contains(&way), "{name}: {way}");
    bench.run(1_500);
    let rate = rate(&mut bench);
    assert!((1_980..=2_020).contains(&rate), "{name}: {rate}");
    bench.run(12_000);
    assert_eq!(position(&mut bench), 20_000, "{name}");
}

/// No faster than 607Fh, and bit 11 tells.
fn keeps_below_the_maximum(name: &str) {
    let mut bench = Bench::node(name, NODE);
    bench.write(NODE, 0x607F, 0, &1_000_u32.to_le_bytes());
    bench.write(NODE, 0x6060, 0, &[1]);
    bench.write(NODE, 0x6081, 0, &5_000_u32.to_le_bytes());
    bench.enable(NODE);
    begin(&mut bench, 20_000);
    bench.run(2_000);
    let rate = rate(&mut bench);
    assert!((980..=1_020).contains(&rate), "{name}: {rate}");
    assert_eq!(bench.read(NODE, 0x6041, 0) >> 11 & 1, 1, "{name}");
}

/// No faster than the motor may turn: one revolution in a minute is 65536 counts in 60 seconds.
#[test]
fn the_s200_keeps_below_the_speed_of_its_motor() {
    let mut bench = Bench::node("s200", NODE);
    bench.write(NODE, 0x6080, 0, &1_u32.to_le_bytes());
    bench.write(NODE, 0x6060, 0, &[1]);
    bench.write(NODE, 0x6081, 0, &5_000_u32.to_le_bytes());
    bench.enable(NODE);
    begin(&mut bench, 20_000);
    bench.run(2_000);
    let rate = rate(&mut bench);
    assert!((1_070..=1_110).contains(&rate), "{rate}");
}

/// Bit 7 of 607Eh turns positions around.
fn turns_around(name: &str) {
    let mut bench = Bench::node(name, NODE);
    bench.write(NODE, 0x607E, 0, &[0x80]);
    bench.write(NODE, 0x6060, 0, &[1]);
    bench.enable(NODE);
    begin(&mut bench, 1_000);
    bench.run(20_000);
    assert_eq!(position(&mut bench), 1_000, "{name}");
    assert_eq!(bench.drive.plant_mut().position(), -1_000, "{name}");
}

/// Where home is has the position 607Ch; with an LMD, whose 2098h is 1, the other sign.
fn homes_to_its_offset(name: &str) {
    let mut bench = Bench::node(name, NODE);
    bench.write(NODE, 0x607C, 0, &777_i32.to_le_bytes());
    bench.write(NODE, 0x6098, 0, &[35]);
    bench.write(NODE, 0x6060, 0, &[6]);
    bench.enable(NODE);
    command(&mut bench, 0x1F);
    bench.wait_for_status(NODE, 0x3400, 0x1400, 1_000);
    let home = if name == "lmd" { -777 } else { 777 };
    assert_eq!(position(&mut bench), home, "{name}");
}

/// A sin² ramp leads to the same place, and is half as steep in its first half.
fn has_sin_squared_ramps(name: &str) {
    let way = |kind: i16| {
        let mut bench = Bench::node(name, NODE);
        bench.write(NODE, 0x6086, 0, &kind.to_le_bytes());
        bench.write(NODE, 0x6060, 0, &[1]);
        bench.write(NODE, 0x6081, 0, &2_000_u32.to_le_bytes());
        bench.write(NODE, 0x6083, 0, &1_000_u32.to_le_bytes());
        bench.write(NODE, 0x6084, 0, &1_000_u32.to_le_bytes());
        bench.enable(NODE);
        begin(&mut bench, 10_000);
        bench.run(300);
        let early = position(&mut bench);
        bench.run(15_000);
        assert_eq!(position(&mut bench), 10_000, "{name}");
        early
    };
    let (linear, smooth) = (way(0), way(1));
    assert!(smooth * 2 < linear, "{name}: {smooth} and {linear}");
}

/// Only the trapezoid.
fn has_linear_ramps_only(name: &str) {
    let mut bench = Bench::node(name, NODE);
    bench.write(NODE, 0x6086, 0, &[0, 0]);
    let answer = bench.sdo(NODE, [0x2B, 0x86, 0x60, 0, 1, 0, 0, 0]);
    assert_eq!(answer[0], 0x80, "{name}");
}

/// Two errors stand; when one ends, a message with code 0 tells what is left.
fn tells_what_is_left(name: &str) {
    let mut bench = Bench::node(name, NODE);
    bench.write(NODE, 0x1016, 1, &0x0005_0032_u32.to_le_bytes());
    bench.send(&Frame::data_frame(0x705, &[5]));
    bench.run(100);
    bench.drive.plant_mut().fault = Some(0x4210);
    bench.run(50);
    bench.sent.clear();
    bench.send(&Frame::data_frame(0x705, &[5]));
    let left = bench.next(0x084, 50).expect("an emergency message");
    assert_eq!(left.payload()[..3], [0, 0, 0x09], "{name}");
}

/// The two rotary switches of a Nanotec: below 80h the position is the node-ID at 1 Mbit/s, from there on the bit rate is the stored one.
fn is_numbered_by_its_switches(name: &str) {
    for (position, node, kbit) in [
        (0x21, 33, 1_000),
        (0x7F, 127, 1_000),
        (0x81, 1, 500),
        (0x00, 7, 1_000),
        (0x80, 7, 500),
    ] {
        let mut setup = Setup::with_node_id(1, 7);
        setup.settings = setup.settings.map(|settings| canopen::Configuration {
            bit_timing: canopen::BitTiming::Fixed(BitRate::Kbit500),
            ..settings
        });
        setup.switches = Switches::ROTARY_REVERSED.wish(position);
        let bench = Bench::new(name, setup);
        assert_eq!(bench.drive.node_id().get(), node, "{position:02X}h");
        let rate = bench.drive.bit_rate().map(BitRate::kbit_per_second);
        assert_eq!(rate, Some(kbit), "{position:02X}h");
    }
}

mod each {
    promises! {
        keeps_its_profile: lmd nanotec s200 tc1;
        keeps_below_the_maximum: s200 tc1;
        turns_around: lmd nanotec;
        homes_to_its_offset: lmd nanotec s200 tc1;
        has_sin_squared_ramps: nanotec s200;
        has_linear_ramps_only: lmd tc1;
        tells_what_is_left: s200 tc1;
        is_numbered_by_its_switches: nanotec;
    }
}
