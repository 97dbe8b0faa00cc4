//! What tells where the magnet is: Hall sensors, or an absolute encoder. Nothing is looked for, and what they cannot say is fault 7305h.

use servo_plant::SensorFaults;
use sim::plant::{Axis, Magnet, ServoAxisData, eccentricity_table};
use std::f64::consts::TAU;
use tests::drive::{OPERATION_ENABLED, ServoBench};

use super::faults::{fails, turning};
use super::{enable, enabled, torque};

/// A table that takes out nothing.
const NO_ERROR: [i32; 64] = [0; 64];

const HALL: &str = "servo_100w_hall";
const ABSOLUTE: &str = "servo_100w_absolute";

/// How far the rotor has gone from where it was, in rad.
fn moved(drive: &mut ServoBench, from: f64) -> f64 {
    drive.plant().angle() - from
}

/// Enabled in profile torque where the rotor stands at first: nothing moves. Then a torque to each side turns it that way at once.
#[track_caller]
fn turns_without_a_search(change: impl Fn(&mut ServoAxisData) + Copy, name: &str, start: f64) {
    for target in [300_i16, -300] {
        let mut drive = ServoBench::on_changed(name, |data| {
            data.start = start;
            change(data);
        });
        drive.write_u8(0x6060, 0, 4);
        drive.write_u32(0x6087, 0, 1_000_000);
        drive.enable();
        drive.run_millis(100);
        assert!(OPERATION_ENABLED.is_shown_by(drive.statusword()));
        assert!(moved(&mut drive, start).abs() < 1e-3, "still at {start}");
        drive.write_i16(0x6071, 0, target);
        let (mut most, mut back) = (0.0_f64, 0.0_f64);
        for _ in 0..100 {
            drive.run_micros(250);
            let way = moved(&mut drive, start) * f64::from(target.signum());
            (most, back) = (most.max(way), back.min(way));
        }
        assert!(most > 0.02 && back > -1e-3, "{most}, {back} from {start}");
        drive.stays_in(OPERATION_ENABLED, 30);
    }
}

#[test]
fn m45_with_hall_sensors_nothing_moves_before_the_torque_and_that_has_its_direction() {
    for sixth in 0..12 {
        turns_without_a_search(|_| {}, HALL, 0.07 + f64::from(sixth) * TAU / 48.0);
    }
}

#[test]
fn m45_with_an_absolute_angle_nothing_moves_before_the_torque() {
    for (bits, zero, start) in [(12, 0.0, 0.3), (14, 2.2, -1.0), (20, -0.4, 5.0)] {
        let change = |data: &mut ServoAxisData| {
            data.plant.sensors.bits = bits;
            data.plant.sensors.zero = zero;
        };
        turns_without_a_search(change, ABSOLUTE, start);
    }
}

#[test]
fn m45_an_encoder_alone_looks_for_the_magnet() {
    let mut drive = ServoBench::on_changed("servo_100w", |data| {
        (data.magnet, data.start) = (Magnet::Searched, 0.4);
    });
    drive.write_u8(0x6060, 0, 4);
    drive.enable();
    let mut most = 0.0_f64;
    for _ in 0..2_000 {
        drive.run_millis(1);
        most = most.max(moved(&mut drive, 0.4).abs());
    }
    assert!((0.05..TAU / 4.0).contains(&most), "{most} rad");
    assert!(OPERATION_ENABLED.is_shown_by(drive.statusword()));
}

/// How far the rotor moves while it is enabled in profile torque, in rad, on the axis of a file that stands at 500 of 10,000 counts.
fn moves_when_enabled(feedback: &str) -> (i32, f64) {
    let text = format!("start = 500\n[servo]\naxis = \"servo_100w\"\nfeedback = {feedback}\n");
    let mut drive = ServoBench::on(Axis::from_toml(&text).unwrap());
    let begun = drive.read_i32(0x6064, 0);
    let from = drive.plant().angle();
    assert!((from - 0.05 * TAU).abs() < 1e-9);
    drive.write_u8(0x6060, 0, 4);
    drive.enable();
    let mut most = 0.0_f64;
    for _ in 0..2_000 {
        drive.run_millis(1);
        most = most.max(moved(&mut drive, from).abs());
    }
    drive.stays_in(OPERATION_ENABLED, 30);
    (begun, most)
}

#[test]
fn m45_the_file_of_an_axis_says_what_tells_where_the_magnet_is() {
    let (begun, most) = moves_when_enabled("\"incremental\"");
    assert!(begun == 0 && most > 0.05, "{begun}, {most}");
    let (begun, most) = moves_when_enabled("\"hall\"");
    assert!(begun == 0 && most < 1e-3, "{begun}, {most}");
    let (begun, most) =
        moves_when_enabled("\"absolute\"\nbits = 14\neccentricity_mrad = 30\ntable = true");
    assert!(
        (498..=502).contains(&begun) && most < 1e-3,
        "{begun}, {most}"
    );
    // Without the table it shows 30 mrad times the sine of 18 degrees too much: 15 counts.
    let (begun, _) = moves_when_enabled("\"absolute\"\neccentricity_mrad = 30");
    assert!((513..=517).contains(&begun), "{begun}");
}

#[test]
fn m45_from_the_first_edge_of_a_hall_sensor_on_the_torque_is_whole() {
    let mut drive = turning(HALL);
    drive.write_i32(0x60FF, 0, 0);
    drive.run_millis(300);
    drive.write_u8(0x6060, 0, 4);
    super::hold(&mut drive);
    drive.write_i16(0x6071, 0, 500);
    drive.run_millis(700);
    assert!((torque(&mut drive) - 500).abs() <= 5);
    let given = drive.plant().torque() / 0.32;
    assert!((0.49..0.51).contains(&given), "{given}");
}

#[test]
fn m45_a_magnet_that_is_not_found_is_a_fault() {
    let mut drive = ServoBench::on_changed("servo_100w", |data| data.magnet = Magnet::Searched);
    drive.write_u8(0x6060, 0, 4);
    drive.plant().sensor_faults.encoder_is_cut = true;
    for word in [0x06, 0x07, 0x0F] {
        drive.command(word);
        drive.run_millis(10);
    }
    fails(&mut drive, 5_000, &[0x7305]);
}

#[test]
fn m45_a_table_takes_out_what_a_magnet_off_its_centre_shows() {
    // 0.02 rad are 32 counts of 10,000.
    for (table, least, most) in [
        (&NO_ERROR, 28.0, 36.0),
        (eccentricity_table(0.02), 0.0, 4.5),
    ] {
        let drive = ServoBench::on_changed(ABSOLUTE, |data| {
            data.magnet = Magnet::Absolute(table);
            data.plant.sensors.eccentricity = 0.02;
            data.plant.sensors.bits = 16;
        });
        let mut drive = enable(drive, 3);
        let counts = drive.read_u32(0x608F, 1) as i32;
        drive.write_i32(0x60FF, 0, counts / 4);
        let mut worst = 0.0_f64;
        for _ in 0..150 {
            drive.run_millis(30);
            let shown = f64::from(drive.read_i32(0x6064, 0));
            let turned = drive.plant().angle() / TAU * f64::from(counts);
            worst = worst.max((shown - turned).abs());
        }
        // A reading is up to a millisecond old.
        assert!((least..most).contains(&worst), "{worst} counts");
    }
}

/// A fault of the sensors while the motor turns is 7305h, and stays while it lasts; what is mended holds again.
#[track_caller]
fn is_a_fault_until_mended(name: &str, break_it: impl Fn(&mut SensorFaults), stays: bool) {
    let mut drive = turning(name);
    break_it(&mut drive.plant().sensor_faults);
    fails(&mut drive, 1_500, &[0x7305]);
    drive.command(0x80);
    drive.run_millis(20);
    if stays {
        drive.command(0x06);
        drive.command(0x07);
        drive.command(0x0F);
        fails(&mut drive, 1_500, &[0x7305]);
        drive.command(0x80);
        drive.run_millis(20);
    }
    drive.plant().sensor_faults = SensorFaults::default();
    drive.run_millis(500);
    drive.enable();
    drive.stays_in(OPERATION_ENABLED, 300);
    let counts = drive.read_u32(0x608F, 1) as i32;
    assert!(drive.read_i32(0x606C, 0) > 8 * counts);
}

#[test]
fn m45_hall_sensors_that_all_say_the_same_are_a_fault() {
    is_a_fault_until_mended(HALL, |faults| faults.cut_hall = 0b111, true);
    is_a_fault_until_mended(HALL, |faults| faults.high_hall = 0b111, true);
}

#[test]
fn m45_a_hall_sensor_or_an_encoder_that_is_cut_is_a_fault_in_motion() {
    is_a_fault_until_mended(HALL, |faults| faults.cut_hall = 0b010, false);
    is_a_fault_until_mended(HALL, |faults| faults.high_hall = 0b001, false);
    // The sensors go on where the encoder stands.
    let mut drive = turning(HALL);
    drive.plant().sensor_faults.encoder_is_cut = true;
    fails(&mut drive, 1_500, &[0x7305]);
}

#[test]
fn m45_an_absolute_angle_that_jumps_is_a_fault() {
    for slipped in [0.2, -0.2, 3.0] {
        is_a_fault_until_mended(ABSOLUTE, |faults| faults.slipped_magnet = slipped, false);
    }
}

#[test]
fn m45_an_absolute_encoder_that_does_not_answer_or_stands_still_is_a_fault() {
    is_a_fault_until_mended(ABSOLUTE, |faults| faults.line_is_broken = true, true);
    // A word that stays the same is seen by what the motor does, as an encoder that is cut.
    let mut drive = turning(ABSOLUTE);
    drive.plant().sensor_faults.encoder_is_cut = true;
    fails(&mut drive, 1_500, &[0x7305, 0x7121, 0x8611]);
}

#[test]
fn m45_a_drive_that_is_off_bears_what_its_sensors_say() {
    for name in [HALL, ABSOLUTE] {
        let mut drive = ServoBench::on_axis(name);
        drive.plant().sensor_faults.cut_hall = 0b111;
        drive.plant().sensor_faults.line_is_broken = true;
        drive.run_millis(100);
        assert_eq!(drive.read_u16(0x603F, 0), 0);
        drive.plant().sensor_faults = SensorFaults::default();
        drive.run_millis(10);
        drive.enable();
        drive.stays_in(OPERATION_ENABLED, 100);
    }
    // Nothing to go by as the power comes.
    for name in [HALL, ABSOLUTE] {
        let mut drive = enabled(name, 1);
        drive.command(0x00);
        drive.run_millis(50);
        drive.plant().sensor_faults.cut_hall = 0b111;
        drive.plant().sensor_faults.line_is_broken = true;
        drive.run_millis(10);
        for word in [0x06, 0x07, 0x0F] {
            drive.command(word);
        }
        fails(&mut drive, 1_500, &[0x7305]);
    }
}

/// What the sensors of the currents say without one is learnt as the power comes, before the gates are on.
#[test]
fn m45_offsets_of_the_current_sensors_are_learnt() {
    let offsets = |magnet: Magnet| {
        move |data: &mut ServoAxisData| {
            data.magnet = magnet;
            data.plant.sensors.current_offset = [0.08, -0.06, 0.05];
        }
    };
    let mut away = [0.0; 2];
    for (away, magnet) in away
        .iter_mut()
        .zip([Magnet::Known, Magnet::Absolute(&NO_ERROR)])
    {
        let mut drive = enable(ServoBench::on_changed("servo_100w", offsets(magnet)), 4);
        drive.write_i16(0x6071, 0, 100);
        drive.run_millis(100);
        super::hold(&mut drive);
        drive.run_millis(400);
        assert_eq!(torque(&mut drive), 100);
        let [d, q] = drive.plant().current();
        *away = d.hypot(q - 0.4);
    }
    assert!(away[0] > 0.03 && away[1] < 2e-3, "{away:?} A");
    // One that is too far off is broken.
    let mut drive = ServoBench::on_changed(ABSOLUTE, |data| {
        data.plant.sensors.current_offset = [0.0, 0.15, 0.0];
    });
    for word in [0x06, 0x07, 0x0F] {
        drive.command(word);
        drive.run_millis(10);
    }
    fails(&mut drive, 100, &[0x7300]);
}
