//! A field that is weakened: beyond the speed of the bus, within the limits of current and torque, and back.

use sim::plant::ServoAxisData;
use tests::drive::{FAULT, INTERNAL_LIMIT, OPERATION_ENABLED, ServoBench};

use super::{enable, torque};

/// A bus of 26 V takes `servo_100w` to about 2,500 turns a minute.
fn low(data: &mut ServoAxisData) {
    data.plant.supply.voltage = 26.0;
}

/// 3,000 turns a minute, in counts/s and rad/s.
const FAST: (i32, f64) = (500_000, 314.2);

/// In profile velocity, with a current that may weaken the field, in mA.
fn weakened(change: impl FnOnce(&mut ServoAxisData), milliamperes: u32) -> ServoBench {
    let mut drive = ServoBench::on_changed("servo_100w", change);
    drive.write_u32(0x20C2, 7, milliamperes);
    drive.write_u32(0x6065, 0, u32::MAX);
    enable(drive, 3)
}

/// So many milliseconds. Gives the greatest current in A.
fn most(drive: &mut ServoBench, milliseconds: u32) -> f64 {
    let mut most = 0.0_f64;
    for _ in 0..4 * milliseconds {
        drive.run_micros(250);
        let [d, q] = drive.plant().current();
        most = most.max(d.hypot(q));
    }
    most
}

#[test]
fn m45_a_weakened_field_takes_the_motor_beyond_the_speed_of_its_bus_and_back() {
    let mut reached = [0.0; 2];
    for (reached, milliamperes) in reached.iter_mut().zip([0, 5_000]) {
        let mut drive = weakened(low, milliamperes);
        // Where it does not reach what is wanted it has a way to make up.
        for sign in if milliamperes > 0 { &[1, -1][..] } else { &[1] } {
            drive.write_i32(0x60FF, 0, sign * FAST.0);
            let peak = most(&mut drive, 2_500);
            *reached = drive.plant().velocity() * f64::from(*sign);
            assert!(peak < 12.6, "{peak} A");
            // What is told is what there is.
            let [d, q] = drive.plant().current();
            let told = f64::from(torque(&mut drive));
            assert!((told - q * 250.0).abs() < 50.0, "{told} with {q} A");
            let told = f64::from(drive.read_i16(0x6078, 0)).abs();
            let size = d.hypot(q) * 250.0;
            assert!((told - size).abs() < 50.0, "{told} with {d}, {q} A");
        }
        drive.reaches(OPERATION_ENABLED, 1);
        // A quick stop from there.
        drive.command(0x0B);
        let peak = most(&mut drive, 1_000);
        assert!(peak < 12.6, "{peak} A");
        assert!(drive.plant().velocity().abs() < 1.0);
        assert!(!FAULT.is_shown_by(drive.statusword()));
    }
    let [without, with] = reached;
    assert!(without < 0.9 * FAST.1, "{without} rad/s");
    assert!((with / FAST.1 - 1.0).abs() < 0.01, "{with} rad/s");
}

#[test]
fn m45_20c2h_7_is_taken_over_while_the_power_is_off() {
    let mut drive = weakened(low, 0);
    drive.write_u32(0x20C2, 7, 5_000);
    drive.write_i32(0x60FF, 0, FAST.0);
    most(&mut drive, 1_500);
    assert!(drive.plant().current()[0].abs() < 0.5);
    assert!(drive.plant().velocity() < 0.9 * FAST.1);
    drive.command(0x0B);
    most(&mut drive, 1_000);
    drive.enable();
    most(&mut drive, 1_500);
    assert!(drive.plant().velocity() > 0.99 * FAST.1);
}

/// With inductances that are 30 % off it is no voltage that the model does not know.
#[test]
fn m45_a_weakened_field_bears_data_that_are_off() {
    for nanohenries in [560_000, 1_040_000] {
        let mut drive = ServoBench::on_changed("servo_100w", low);
        drive.write_u32(0x20C2, 2, nanohenries);
        drive.write_u32(0x20C2, 3, nanohenries);
        drive.write_u32(0x20C2, 7, 8_000);
        drive.write_u32(0x6065, 0, u32::MAX);
        let mut drive = enable(drive, 3);
        drive.write_i32(0x60FF, 0, FAST.0);
        let peak = most(&mut drive, 1_500);
        let velocity = drive.plant().velocity();
        assert!((velocity / FAST.1 - 1.0).abs() < 0.01, "{velocity} rad/s");
        assert!(peak < 12.6, "{peak} A");
        drive.reaches(OPERATION_ENABLED, 1);
    }
}

/// 6073h and I²t are limits of the whole current, and leave a torque beside the field that is weakened.
#[test]
fn m45_limits_of_the_current_hold_with_a_weakened_field() {
    let mut drive = weakened(low, 12_000);
    drive.write_u16(0x6073, 0, 500);
    drive.plant().load_torque = 0.04;
    drive.write_i32(0x60FF, 0, FAST.0);
    let peak = most(&mut drive, 1_500);
    let [d, q] = drive.plant().current();
    assert!(peak < 2.1 && d < -1.5 && q > 0.45, "{peak}, {d}, {q} A");
    // More than the bus has the voltage for takes all that there is, until it is what motor and stage bear for ever.
    let mut drive = weakened(low, 12_000);
    drive.plant().load_torque = 0.25;
    drive.write_i32(0x60FF, 0, 2 * FAST.0);
    for _ in 0..8 {
        let peak = most(&mut drive, 1_000);
        assert!(peak < 12.6, "{peak} A");
    }
    let [d, q] = drive.plant().current();
    assert!(d.hypot(q) < 4.2 && q > 2.9, "{d}, {q} A");
    assert_ne!(drive.statusword() & INTERNAL_LIMIT, 0);
}

/// The gates go off before the magnet drives the bus beyond its bound: √3 · 13.33 mV·s · 4 · 650 rad/s is 60 V.
#[test]
fn m45_a_weakened_field_ends_at_the_speed_whose_magnet_drives_the_bus_to_its_bound() {
    let mut drive = weakened(|data| data.speed = 7_000, 8_000);
    drive.write_i32(0x60FF, 0, 1_200_000);
    let (mut fastest, mut volts) = (0.0_f64, 0.0_f64);
    for _ in 0..16_000 {
        drive.run_micros(250);
        fastest = fastest.max(drive.plant().velocity());
        volts = volts.max(drive.plant().bus_voltage());
    }
    assert!((640.0..660.0).contains(&fastest), "{fastest} rad/s");
    assert_eq!(drive.read_u16(0x603F, 0), 0x7310);
    assert!(volts < 60.0, "{volts} V");
}

/// A fault at speed: the motor coasts, and its magnet feeds the bus.
#[test]
fn m45_a_fault_beyond_the_speed_of_the_bus_keeps_it_within_its_bound() {
    let mut drive = weakened(low, 8_000);
    drive.write_i32(0x60FF, 0, FAST.0);
    most(&mut drive, 1_500);
    drive.plant().sensor_faults.encoder_is_cut = true;
    let mut volts = 0.0_f64;
    for _ in 0..4_000 {
        drive.run_micros(250);
        volts = volts.max(drive.plant().bus_voltage());
    }
    drive.reaches(FAULT, 1);
    assert!(volts < 32.5, "{volts} V");
}

/// A salient motor has more torque of an ampere in a weakened field. 6072h and 6077h are that of the motor.
#[test]
fn m45_a_limit_of_the_torque_holds_in_the_weakened_field_of_a_salient_motor() {
    let mut drive = ServoBench::on_changed("servo_400w", |data| data.plant.supply.voltage = 20.0);
    drive.write_u32(0x20C2, 7, 30_000);
    drive.write_u32(0x6065, 0, u32::MAX);
    drive.write_u16(0x6072, 0, 300);
    drive.write_u32(0x6080, 0, 2_600);
    let mut drive = enable(drive, 4);
    drive.plant().load_torque = 0.2;
    drive.write_i16(0x6071, 0, 1_000);
    let (mut greatest, mut told, mut along) = (0.0_f64, 0, 0.0_f64);
    for _ in 0..400 {
        drive.run_millis(1);
        let [d, q] = drive.plant().current();
        greatest = greatest.max(6.0 * (12.5e-3 - 0.04e-3 * d) * q / 1.275);
        along = along.min(d);
        told = told.max(torque(&mut drive));
    }
    assert!(along < -10.0, "{along} A");
    assert!(
        (0.29..0.306).contains(&greatest),
        "{greatest} of the rated torque"
    );
    assert!((295..=303).contains(&told), "{told}");
}

/// A field that leads the rotor stays as it is.
#[test]
fn m45_a_stepper_whose_field_leads_its_rotor_is_not_weakened() {
    let [without, with] = [0, 1_000].map(|milliamperes| {
        let mut drive = ServoBench::on_axis("nema17");
        drive.write_u32(0x20C2, 7, milliamperes);
        drive.write_u8(0x20C4, 1, 2);
        let mut drive = enable(drive, 3);
        drive.write_i32(0x60FF, 0, 60_000);
        drive.run_millis(600);
        let [d, q] = drive.plant().current();
        (drive.plant().angle(), d, q)
    });
    assert_eq!(without, with);
}
