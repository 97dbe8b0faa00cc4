//! The figures of the issue on the bus, on motors without cogging and friction: torque, set-points in each period, a load at once. `--nocapture` tells them.

use std::f64::consts::TAU;

use sim::plant::{AXES, ServoAxisData};
use tests::drive::ServoBench;

use super::cyclic::bytes;
use super::{enable, torque};

/// Counts of a turn of `servo_100w`.
const COUNTS: f64 = 10_000.0;

/// Without cogging and dry friction.
fn ideal(data: &mut ServoAxisData) {
    data.plant.motor.detent = 0.0;
    data.plant.motor.coulomb_friction = 0.0;
}

/// Beside that a load on which the rated torque comes to 0.3 of the greatest speed.
fn on_a_fan(data: &mut ServoAxisData) {
    let speed = 0.3 * f64::from(data.speed) / 60.0 * TAU;
    data.plant.load.viscous_friction = f64::from(data.motor().rated_torque()) / speed;
}

/// SYNC, and behind it the set-point for the next, in a period of so many microseconds.
fn period(drive: &mut ServoBench, micros: u64, set_point: &str) {
    let begin = drive.now();
    let length = set_point.split(' ').count();
    drive.send(&format!("304 [{length}] {set_point}"));
    drive.send("080 [0]");
    let passed = drive.now().ticks() - begin.ticks();
    drive.run_micros(micros - passed);
}

/// Mean of the torque of the motor and its greatest deviation from that, in N·m, over a fifth of a second.
fn given(drive: &mut ServoBench) -> (f64, f64) {
    let mut seen = Vec::new();
    for _ in 0..800 {
        drive.run_micros(250);
        seen.push(drive.plant().torque());
    }
    let mean = seen.iter().sum::<f64>() / seen.len() as f64;
    let ripple = seen
        .iter()
        .fold(0.0_f64, |most, one| most.max((one - mean).abs()));
    (mean, ripple)
}

#[test]
fn m45_a_torque_is_within_a_hundredth_of_its_target_and_its_ripple_is_told() {
    for axis in &AXES[..4] {
        let rated = f64::from(axis.motor().rated_torque());
        for (what, is_ideal) in [("ideal", true), ("with cogging and friction", false)] {
            let mut worst = (0.0_f64, 0.0_f64);
            for mode in [4, 10] {
                let mut drive = ServoBench::on_changed(axis.name, |data| {
                    if is_ideal {
                        ideal(data);
                    }
                    on_a_fan(data);
                });
                drive.map_pdo(0x1401, &[0x6071_0010], 1);
                drive.write_u8(0x60C2, 1, 4);
                drive.write_u32(0x6087, 0, 100_000);
                let mut drive = enable(drive, mode);
                for target in [100_i16, 500, 1_000, -700] {
                    for _ in 0..40 {
                        period(&mut drive, 4_000, &bytes(&target.to_le_bytes()));
                    }
                    if mode == 10 {
                        // The last one holds while the torque is looked at.
                        drive.write_u8(0x2051, 2, 2);
                    }
                    assert_eq!(torque(&mut drive).signum(), target.signum());
                    let (mean, ripple) = given(&mut drive);
                    let wanted = f64::from(target) * 1e-3 * rated;
                    worst.0 = worst.0.max((mean / wanted - 1.0).abs());
                    worst.1 = worst.1.max(ripple / rated);
                }
            }
            // With ideal sensors; what the detents do is beside the torque of the current.
            let detent = if is_ideal {
                0.0
            } else {
                axis.plant.motor.detent / rated
            };
            assert!(is_ideal || worst.1 > detent, "{}: {}", axis.name, worst.1);
            assert!(worst.1 < detent + 0.012, "{}: {}", axis.name, worst.1);
            assert!(worst.0 < 0.01 + 2.0 * detent, "{}: {}", axis.name, worst.0);
            println!(
                "{}, {what}: at most {:.2} % from 6071h, ripple {:.2} % of the rated torque",
                axis.name,
                100.0 * worst.0,
                100.0 * worst.1
            );
        }
    }
}

/// A tenth of a turn, beginning at rest.
fn sine(time: f64) -> f64 {
    0.1 * (1.0 - (TAU * 10.0 * time).cos())
}

/// A turn in 0.2 s, at rest at both ends.
fn quintic(time: f64) -> f64 {
    let t = (time / 0.2).min(1.0);
    t * t * t * (10.0 - 15.0 * t + 6.0 * t * t)
}

#[test]
fn m45_set_points_in_each_period_are_followed_within_two_counts() {
    for (name, motion) in [
        ("sine of 10 Hz", sine as fn(f64) -> f64),
        ("quintic", quintic),
    ] {
        for (cubic, millis) in [0, -1]
            .into_iter()
            .flat_map(|cubic| [(cubic, 1_u8), (cubic, 2), (cubic, 4)])
        {
            let mut drive = ServoBench::on_changed("servo_100w", ideal);
            drive.map_pdo(0x1401, &[0x607A_0020], 1);
            drive.write_u8(0x60C2, 1, millis);
            drive.write_i16(0x60C0, 0, cubic);
            for index in [0x6083, 0x6084, 0x6085, 0x60C5, 0x60C6] {
                drive.write_u32(index, 0, 100_000_000);
            }
            let mut drive = enable(drive, 8);
            let seconds = f64::from(millis) * 1e-3;
            let mut seen = Vec::new();
            // The clock of the drive comes to that of SYNC first.
            let settled = (0.3 / seconds) as i32;
            for step in 0..2 * settled {
                let time = f64::from(step - settled) * seconds;
                let target = (motion(time.max(0.0)) * COUNTS).round() as i32;
                period(
                    &mut drive,
                    u64::from(millis) * 1_000,
                    &bytes(&target.to_le_bytes()),
                );
                seen.push((time + seconds, drive.plant().angle() / TAU * COUNTS - 0.5));
            }
            let away = |delay: f64| {
                seen.iter().fold(0.0_f64, |most, (time, at)| {
                    most.max((at - motion((time - delay).max(0.0)) * COUNTS).abs())
                })
            };
            let (worst, delay) = (0..20_000_i32)
                .map(|micros| (away(f64::from(micros) * 1e-6), micros))
                .min_by(|one, other| one.0.total_cmp(&other.0))
                .unwrap();
            println!("{name}, 60C0h = {cubic}, each {millis} ms: {worst:.1} counts away");
            assert!(worst <= 2.0, "{worst}");
            let periods = (if millis == 1 { 3 } else { 2 }) - i32::from(cubic);
            let due = periods * i32::from(millis) * 1_000;
            assert!((delay - due).abs() < 25, "{delay} µs, not {due}");
        }
    }
}

#[test]
fn m45_half_of_the_peak_torque_at_once_is_taken_back_in_50_ms() {
    for name in ["servo_100w", "servo_400w"] {
        let mut drive = enable(ServoBench::on_changed(name, ideal), 1);
        drive.run_millis(50);
        let data = ServoAxisData::named(name).expect("a ready axis");
        let peak = f64::from(data.motor().torque_constant() * data.peak_current);
        drive.plant().load_torque = 0.5 * peak;
        let (mut most, mut late) = (0.0_f64, 0.0_f64);
        for micros in (0..150_000).step_by(250) {
            drive.run_micros(250);
            let away = (drive.plant().angle() / TAU * COUNTS - 0.5).abs();
            most = most.max(away);
            if micros >= 50_000 {
                late = late.max(away);
            }
        }
        println!("{name}: {most:.1} counts away, {late:.2} after 50 ms");
        assert!(late <= 2.0, "{name}: {late}");
    }
}
