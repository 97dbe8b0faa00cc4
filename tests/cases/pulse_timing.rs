//! What the driver of the motor needs (20B0h): it limits the velocity, and changes only without power.

use tests::DriveBench;
use tests::drive::{INTERNAL_LIMIT, SWITCH_ON_DISABLED};

/// A drive that is enabled in profile velocity, with steep ramps, and asked for this velocity.
fn turning(bench: &mut DriveBench, velocity: i32) {
    bench.write_u8(0x6060, 0, 3);
    bench.write_u32(0x6083, 0, 50_000_000);
    bench.write_u32(0x6084, 0, 50_000_000);
    bench.enable();
    bench.write_i32(0x60FF, 0, velocity);
    bench.run_millis(100);
}

#[test]
fn a_driver_limits_the_velocity_and_bit_11_tells() {
    // 1 / (high + low), in ticks of the step clock of 84 MHz, rounded up.
    for (number, most) in [(1, 500_000), (2, 249_258), (5, 1_000_000), (6, 149_732)] {
        let mut bench = DriveBench::started(4);
        bench.write_u8(0x20B0, 1, number);
        turning(&mut bench, most);
        assert_eq!(bench.read_i32(0x606B, 0), most, "driver {number}");
        assert_eq!(bench.statusword() & INTERNAL_LIMIT, 0);
        bench.write_i32(0x60FF, 0, most + 1);
        bench.run_millis(20);
        assert_eq!(bench.read_i32(0x606B, 0), most, "driver {number}");
        assert_ne!(bench.statusword() & INTERNAL_LIMIT, 0);
    }
}

#[test]
fn times_of_ones_own_count_with_255() {
    let mut bench = DriveBench::started(4);
    for (sub, nanoseconds) in [(2, 10_000), (3, 40_000), (4, 1_000), (5, 1_000)] {
        bench.write_u32(0x20B0, sub, nanoseconds);
    }
    bench.write_u8(0x20B0, 1, 255);
    turning(&mut bench, 100_000);
    assert_eq!(bench.read_i32(0x606B, 0), 20_000);
    assert_ne!(bench.statusword() & INTERNAL_LIMIT, 0);
}

#[test]
fn pulse_timing_does_not_change_while_the_motor_has_power() {
    let mut bench = DriveBench::enabled(4);
    bench.write_u16(0x1800, 5, 0);
    bench.drain(20);
    bench.refused("604: 2F B0 20 01 03 00 00 00", 0x0800_0022);
    bench.refused("604: 23 B0 20 02 64 00 00 00", 0x0800_0022);
    bench.command(0x00);
    bench.reaches(SWITCH_ON_DISABLED, 2_000);
    bench.write_u8(0x20B0, 1, 3);
    assert_eq!(bench.read_u8(0x20B0, 1), 3);
}

#[test]
fn a_driver_that_nobody_knows_is_refused() {
    let mut bench = DriveBench::started(4);
    bench.write_u16(0x1800, 5, 0);
    bench.drain(20);
    bench.refused("604: 2F B0 20 01 07 00 00 00", 0x0609_0030);
    bench.refused("604: 23 B0 20 02 41 42 0F 00", 0x0609_0031);
}
