//! What a master does with a drive again and again.

use sim::drive::Setup;
use sim::plant::{Axis, ServoAxisData, Track};

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

/// A product whose motor is moved by its current, on a ready axis, with a node-ID and in switch on disabled.
pub fn on_servo(name: &str, axis: &str) -> Bench {
    servo_node(name, axis, NODE)
}

/// The same with another node-ID.
pub fn servo_node(name: &str, axis: &str, node: u8) -> Bench {
    let data = ServoAxisData::named(axis).expect("a ready axis");
    let setup = Setup {
        axis: Some(Axis::bare_servo(&data)),
        ..Setup::with_node_id(1, node)
    };
    let mut bench = Bench::new(name, setup);
    bench.run(20);
    bench
}

/// The motor and what is around it, to load it and to see what it does.
pub fn plant(bench: &mut Bench) -> &mut servo_plant::Plant {
    let servo = bench.drive.plant_mut().servo_mut();
    servo.expect("a motor moved by its current").plant_mut()
}

/// The peak of the current in the motor, in A, with the sign of its torque.
pub fn current(bench: &mut Bench) -> f64 {
    let [d, q] = plant(bench).current();
    d.hypot(q).copysign(q)
}

/// The rotor is held by something outside.
pub fn hold(bench: &mut Bench) {
    plant(bench).load_brake = 20.0;
}
