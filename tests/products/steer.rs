//! What a master does with a drive again and again.

use sim::plant::{Axis, Track};

use crate::bench::Bench;

pub const NODE: u8 = 4;

pub fn position(bench: &mut Bench) -> i32 {
    bench.read(NODE, 0x6064, 0) as i32
}

pub fn statusword(bench: &mut Bench) -> u16 {
    bench.read(NODE, 0x6041, 0) as u16
}

pub fn command(bench: &mut Bench, controlword: u16) {
    bench.write(NODE, 0x6040, 0, &controlword.to_le_bytes());
}

/// How far the motor goes in so many milliseconds.
pub fn way(bench: &mut Bench, milliseconds: u32) -> i32 {
    let from = position(bench);
    bench.run(milliseconds);
    position(bench) - from
}

pub fn number(bench: &mut Bench, index: u16, sub: u8, value: u32) {
    bench.write(NODE, index, sub, &value.to_le_bytes());
}

/// A product on this axis.
pub fn on(name: &str, track: Track) -> Bench {
    let mut bench = Bench::node(name, NODE);
    let axis = Axis {
        track,
        ..Axis::default()
    };
    bench.drive.plant_mut().mount(&axis);
    bench.run(20);
    bench
}

/// The same with its motor on, in this mode.
pub fn enabled_on(name: &str, mode: u8, track: Track) -> Bench {
    let mut bench = on(name, track);
    bench.write(NODE, 0x6060, 0, &[mode]);
    bench.enable(NODE);
    bench
}

pub fn enabled(name: &str, mode: u8) -> Bench {
    enabled_on(name, mode, Track::default())
}

/// Begins a move with this velocity and acceleration.
pub fn begin(bench: &mut Bench, target: i32, velocity: u32, acceleration: u32) {
    number(bench, 0x6081, 0, velocity);
    number(bench, 0x6083, 0, acceleration);
    number(bench, 0x6084, 0, acceleration);
    bench.write(NODE, 0x607A, 0, &target.to_le_bytes());
    command(bench, 0x1F);
    command(bench, 0x0F);
}
