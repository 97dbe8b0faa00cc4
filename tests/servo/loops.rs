//! What a master sets of the loops: filters behind that of the velocity, and how fast that of the current is.

use servo_plant::data::Coupling;
use tests::drive::{OPERATION_ENABLED, ServoBench};

use super::{enable, enabled, hold, torque};

/// The greatest 6074h while a sine of so many Hz and half the rated torque is added.
fn amplitude(drive: &mut ServoBench, hertz: u16) -> i16 {
    drive.write_u16(0x20C0, 6, 10 * hertz);
    drive.write_u16(0x20C0, 7, 10 * hertz);
    drive.write_u16(0x20C0, 8, 400);
    drive.write_u8(0x20C0, 1, 2);
    drive.run_millis(100);
    let mut most = 0;
    for _ in 0..200 {
        drive.run_millis(1);
        most = most.max(drive.read_i16(0x6074, 0).abs());
    }
    drive.run_millis(200);
    assert_eq!(drive.read_u8(0x20C1, 1), 6, "done");
    most
}

#[test]
fn m45_filters_of_the_velocity_loop_take_out_what_they_are_set_to() {
    let mut drive = enabled("servo_100w", 1);
    // So soft that a low-pass does not make them swing.
    for (index, sub, gain) in [(0x60F9, 1, 200), (0x60F9, 2, 70), (0x60FB, 1, 70)] {
        drive.write_u16(index, sub, gain);
    }
    // Frequencies that do not keep step with the reading.
    let (slow, fast) = (37, 173);
    let open = [slow, fast].map(|hertz| amplitude(&mut drive, hertz));
    assert!(
        open.iter().all(|most| (440..600).contains(most)),
        "{open:?}"
    );
    drive.write_u16(0x20C3, 3, fast);
    let notch = [slow, fast].map(|hertz| amplitude(&mut drive, hertz));
    assert!(notch[1] < 60, "{notch:?}");
    assert!((notch[0] - open[0]).abs() < 40, "{open:?}, {notch:?}");
    drive.write_u16(0x20C3, 3, 0);
    // At its frequency 0.707 with either order; at 173 Hz a fourth, or the square of that.
    for (quality, left) in [(0, 0.25), (707, 0.0625)] {
        drive.write_u16(0x20C3, 2, quality);
        drive.write_u16(0x20C3, 1, 45);
        let most = f64::from(amplitude(&mut drive, fast)) / f64::from(open[1]);
        assert!((most - left).abs() < 0.05, "quality {quality}: {most}");
        drive.write_u16(0x20C3, 1, 0);
    }
    let again = amplitude(&mut drive, fast);
    assert!((again - open[1]).abs() < 20, "{open:?}, {again}");
    for (sub, value, code) in [
        (1, 1_501_u16, 0x0609_0031),
        (2, 2_001, 0x0609_0031),
        (3, 1_501, 0x0609_0031),
        (4, 99, 0x0609_0032),
    ] {
        assert_eq!(
            drive.try_write(0x20C3, sub, &value.to_le_bytes()),
            Err(code)
        );
    }
}

#[test]
fn m45_filters_are_taken_over_without_a_bump() {
    let mut drive = enabled("servo_100w", 1);
    drive.plant().load_torque = 0.1;
    drive.run_millis(300);
    let (before, stood) = (torque(&mut drive), drive.position());
    assert!(before.abs() > 200, "{before}");
    for (low_pass, notch) in [(600, 0), (600, 400), (900, 250), (0, 250), (0, 0)] {
        drive.write_u16(0x20C3, 1, low_pass);
        drive.write_u16(0x20C3, 3, notch);
        for _ in 0..10 {
            drive.run_millis(1);
            let after = torque(&mut drive);
            assert!((after - before).abs() < 20, "{before} and {after}");
        }
        assert!((drive.position() - stood).abs() <= 1);
    }
}

#[test]
fn m45_the_share_of_the_current_loop_is_how_fast_a_torque_comes() {
    // 20 thousandths of an error in each 50 µs: 2.5 ms until a third of it is left; with 1 it is 50 ms.
    let mut gone = [0.0; 3];
    for (gone, share) in gone.iter_mut().zip([0, 20, 1]) {
        let mut drive = enabled("servo_100w", 4);
        hold(&mut drive);
        drive.write_u32(0x6087, 0, u32::MAX);
        drive.write_u16(0x60F6, 1, share);
        drive.run_millis(5);
        drive.write_i16(0x6071, 0, 500);
        drive.run_millis(3);
        *gone = drive.plant().current()[1];
        drive.run_millis(300);
        let held = torque(&mut drive);
        assert!((held - 500).abs() <= 5, "{held} with {share}, {gone} A");
        // Taken over at once.
        drive.write_u16(0x60F6, 1, 0);
        drive.write_i16(0x6071, 0, 0);
        drive.run_millis(3);
        assert!(drive.plant().current()[1].abs() < 0.1);
    }
    // Of 2 A.
    assert!(gone[0] > 1.9, "{gone:?} A");
    assert!(
        (0.5..1.6).contains(&gone[1]) && (0.01..0.3).contains(&gone[2]),
        "{gone:?} A"
    );
}

/// How far the rotor still swings a tenth of a second behind a load that came at once, in counts.
fn swings(drive: &mut ServoBench) -> f64 {
    drive.plant().load_torque = 0.1;
    drive.run_millis(100);
    let mut ends = (f64::INFINITY, f64::NEG_INFINITY);
    for _ in 0..400 {
        drive.run_micros(250);
        let at = drive.plant().angle() / std::f64::consts::TAU * 10_000.0;
        ends = (ends.0.min(at), ends.1.max(at));
    }
    drive.plant().load_torque = 0.0;
    drive.run_millis(300);
    ends.1 - ends.0
}

/// A load of the inertia of the rotor, on a coupling that swings with 325 Hz. Softer loops do not need the notch.
#[test]
fn m45_a_notch_takes_out_the_swinging_of_an_elastic_coupling() {
    for backlash in [0.0, 0.002] {
        let mut drive = ServoBench::on_changed("servo_100w", |data| {
            data.plant.coupling = Some(Coupling {
                stiffness: 10.0,
                damping: 2e-4,
                backlash,
            });
        });
        drive.write_u32(0x6065, 0, u32::MAX);
        let mut drive = enable(drive, 1);
        let open = swings(&mut drive);
        drive.write_u16(0x20C3, 3, 325);
        drive.write_u16(0x20C3, 4, 1_000);
        let notched = swings(&mut drive);
        drive.write_u16(0x20C3, 3, 0);
        for (index, sub, gain) in [(0x60F9, 1, 200), (0x60F9, 2, 70), (0x60FB, 1, 70)] {
            drive.write_u16(index, sub, gain);
        }
        let soft = swings(&mut drive);
        assert!(open > 200.0, "{open}");
        assert!(
            notched < 0.15 * open && soft < 0.15 * open,
            "{open}, {notched}, {soft}"
        );
        drive.reaches(OPERATION_ENABLED, 1);
    }
}
