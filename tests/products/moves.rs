//! Each product moves a motor with what its data sheet gives it: no limit of 0, no end velocity that is a start speed, no acceleration of 0.

use sim::products::Product;

use crate::bench::Bench;

const NODE: u8 = 4;

/// How long a move may take.
const MOVE: u32 = 60_000;

fn position(bench: &mut Bench) -> i32 {
    bench.read(NODE, 0x6064, 0) as i32
}

/// Where the motor stands, once it does.
fn rest(bench: &mut Bench) -> i32 {
    let mut last = position(bench);
    loop {
        bench.run(100);
        let now = position(bench);
        if now == last {
            return now;
        }
        last = now;
    }
}

fn set_point(bench: &mut Bench, target: i32) {
    bench.write(NODE, 0x607A, 0, &target.to_le_bytes());
    bench.write(NODE, 0x6040, 0, &[0x1F, 0]);
    bench.wait_for_status(NODE, 0x1000, 0x1000, 100);
    bench.write(NODE, 0x6040, 0, &[0x0F, 0]);
    bench.wait_for_status(NODE, 0x1400, 0x0400, MOVE);
}

/// A product whose motor is on, in this mode.
fn enabled(name: &str, mode: u8) -> Bench {
    let mut bench = Bench::node(name, NODE);
    bench.write(NODE, 0x6060, 0, &[mode]);
    bench.enable(NODE);
    bench.wait_for_status(NODE, 0x6F, 0x27, 100);
    assert_eq!(bench.read(NODE, 0x6061, 0) as u8, mode);
    bench
}

/// There and back by the profile that the data sheet has, and the pulses are as many.
fn moves_to_positions(name: &str) {
    let mut bench = enabled(name, 1);
    // The default of the S200 is ten counts a second.
    if bench.read(NODE, 0x6081, 0) < 1_000 {
        bench.write(NODE, 0x6081, 0, &20_000_u32.to_le_bytes());
    }
    for target in [20_000, -5_000, 0] {
        set_point(&mut bench, target);
        assert_eq!(rest(&mut bench), target, "{name}");
        assert_eq!(bench.drive.plant_mut().position(), i64::from(target));
    }
}

fn moves_at_a_velocity(name: &str) {
    let mut bench = enabled(name, 3);
    bench.write(NODE, 0x60FF, 0, &4_000_i32.to_le_bytes());
    bench.run(3_000);
    let (first, _) = (position(&mut bench), bench.run(1_000));
    let travelled = position(&mut bench) - first;
    assert!((3_900..=4_100).contains(&travelled), "{name}: {travelled}");
    bench.write(NODE, 0x60FF, 0, &0_i32.to_le_bytes());
    bench.run(3_000);
    let stood = position(&mut bench);
    assert_eq!(rest(&mut bench), stood);
}

/// Method 35: where the motor stands is home.
fn homes_on_the_spot(name: &str) {
    let mut bench = enabled(name, 1);
    if bench.read(NODE, 0x6081, 0) < 1_000 {
        bench.write(NODE, 0x6081, 0, &20_000_u32.to_le_bytes());
    }
    set_point(&mut bench, 3_000);
    assert_eq!(rest(&mut bench), 3_000);
    bench.write(NODE, 0x6098, 0, &[35]);
    bench.write(NODE, 0x6060, 0, &[6]);
    bench.run(20);
    bench.write(NODE, 0x6040, 0, &[0x1F, 0]);
    bench.wait_for_status(NODE, 0x3400, 0x1400, 5_000);
    assert_eq!(position(&mut bench), 0, "{name}");
}

#[test]
fn every_product_is_moved_here() {
    let names: Vec<_> = Product::names().collect();
    assert_eq!(names, ["lmd", "nanotec", "s200", "tc1"]);
}

macro_rules! moves {
    ($($product:ident: $($what:ident)*;)*) => {$(
        mod $product {
            $(#[test]
            fn $what() {
                super::$what(stringify!($product));
            })*
        }
    )*};
}

moves! {
    lmd: moves_to_positions moves_at_a_velocity homes_on_the_spot;
    nanotec: moves_to_positions homes_on_the_spot;
    s200: moves_to_positions moves_at_a_velocity homes_on_the_spot;
    tc1: moves_to_positions moves_at_a_velocity homes_on_the_spot;
}
