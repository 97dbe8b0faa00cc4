//! Software limits and limit switches while a torque is held.

use sim::plant::{Axis, ServoAxisData, Switch};
use tests::drive::{INTERNAL_LIMIT, OPERATION_ENABLED, ServoBench, TARGET_REACHED};

use super::cyclic::{bytes, period};
use super::{enable, enabled, torque};

/// How far beyond a limit the rotor may swing before it rests there, in counts. Before the ramp it goes up to 500 in a
/// tick.
const SWING: i64 = 4;

fn set_limits(drive: &mut ServoBench, (low, high): (i32, i32)) {
    drive.write_i32(0x607D, 1, low);
    drive.write_i32(0x607D, 2, high);
}

/// A torque, at once.
fn push(drive: &mut ServoBench, target: i16) {
    drive.write_u32(0x6087, 0, 1_000_000);
    drive.write_i16(0x6071, 0, target);
}

/// Runs for so many milliseconds; gives how far the rotor was in the direction of `sign` at most, and its greatest speed in counts/ms.
fn watch(drive: &mut ServoBench, millis: u64, sign: i64) -> (i64, i64) {
    let (mut farthest, mut fastest) = (i64::MIN, 0);
    for _ in 0..millis {
        let before = drive.position();
        drive.run_millis(1);
        farthest = farthest.max(drive.position() * sign);
        fastest = fastest.max((drive.position() - before).abs());
    }
    (farthest * sign, fastest)
}

/// The rotor comes to rest at a limit, and is at most `swing` counts beyond it before. Gives its greatest speed in counts/ms.
#[track_caller]
fn ends_at(drive: &mut ServoBench, limit: i32, millis: u64, swing: i64) -> i64 {
    let limit = i64::from(limit);
    let sign = (limit - drive.position()).signum();
    let (farthest, fastest) = watch(drive, millis, sign);
    let beyond = (farthest - limit) * sign;
    assert!(beyond <= swing, "{beyond} beyond {limit}");
    let away = drive.position() - limit;
    assert!(away.abs() <= 1.max(swing / 4), "{away} from {limit}");
    drive.reaches(OPERATION_ENABLED, 1);
    fastest
}

/// Until a limit is in the way.
fn until_limited(drive: &mut ServoBench) {
    drive.run_millis(4);
    while drive.statusword() & INTERNAL_LIMIT == 0 {
        drive.run_millis(1);
    }
}

#[test]
fn m45_a_held_torque_ends_on_a_software_limit_whatever_the_speed() {
    for (name, way, most) in [("servo_100w", 100_000, 490), ("nema17", 25_000, 80)] {
        let mut fastest = 0;
        for (target, way) in [(100, way / 10), (150, way), (400, way), (1_000, 2 * way)] {
            let mut drive = enabled(name, 4);
            set_limits(&mut drive, (-way, way));
            for sign in [1, -1] {
                push(&mut drive, target * sign);
                let limit = way * i32::from(sign);
                fastest = fastest.max(ends_at(&mut drive, limit, 2_000, SWING));
                assert_ne!(drive.statusword() & INTERNAL_LIMIT, 0);
            }
        }
        assert!(fastest > most, "{name}: {fastest} counts/ms");
    }
}

#[test]
fn m45_a_torque_in_each_period_ends_on_a_software_limit() {
    for (name, target) in [("servo_100w", 200_i16), ("nema17", 300)] {
        let mut drive = ServoBench::on_axis(name);
        drive.map_pdo(0x1401, &[0x6071_0010], 1);
        drive.write_u8(0x60C2, 1, 4);
        let mut drive = enable(drive, 10);
        set_limits(&mut drive, (-20_000, 10_000));
        for (sign, limit) in [(1, 10_000), (-1, -20_000)] {
            let set_point = bytes(&(target * sign).to_le_bytes());
            let mut farthest = i64::MIN;
            for _ in 0..250 {
                period(&mut drive, Some(&set_point));
                farthest = farthest.max((drive.position() - limit) * i64::from(sign));
            }
            assert!(farthest <= SWING, "{name}: {farthest} beyond {limit}");
            assert!((drive.position() - limit).abs() <= 1, "{name}");
            assert_ne!(drive.statusword() & INTERNAL_LIMIT, 0);
        }
    }
}

#[test]
fn m45_a_torque_that_comes_at_once_just_before_a_software_limit_ends_on_it() {
    for (name, target, way) in [("servo_100w", 3_000, 3_000), ("nema17", 1_400, 400)] {
        for sign in [1, -1] {
            let mut drive = enabled(name, 4);
            set_limits(&mut drive, (-way, way));
            push(&mut drive, target * sign);
            // The hardest ramp is that of the limits of the torque.
            ends_at(&mut drive, way * i32::from(sign), 500, 3 * SWING);
        }
    }
}

#[test]
fn m45_a_stepper_in_closed_loop_ends_on_a_software_limit() {
    const FIELD: i64 = 5;
    for stepper in [1, 2, 3] {
        let mut drive = ServoBench::on_axis("nema17");
        drive.write_u8(0x20C4, 1, stepper);
        let mut drive = enable(drive, 4);
        set_limits(&mut drive, (-8_000, 8_000));
        for (target, limit) in [(300, 8_000_i64), (-150, -8_000)] {
            push(&mut drive, target);
            let (farthest, _) = watch(&mut drive, 1_500, limit.signum());
            let beyond = farthest.abs() - limit.abs();
            assert!(beyond <= FIELD, "{stepper}: {beyond} beyond {limit}");
            // Who only supervises leaves what friction takes of the lead.
            let away = drive.position() - limit;
            assert!(away.abs() <= FIELD, "{stepper}: {away} from {limit}");
        }
    }
}

#[test]
fn m45_what_coasts_or_is_driven_towards_a_software_limit_ends_on_it() {
    // None, and one the other way that brakes too little.
    for (target, load) in [(0, 0.0), (-5, 0.0), (-20, -0.02), (0, -0.03)] {
        let mut drive = enabled("servo_100w", 4);
        set_limits(&mut drive, (-100_000, 60_000));
        push(&mut drive, 150);
        watch(&mut drive, 80, 1);
        assert!(drive.position() < 30_000);
        push(&mut drive, target);
        drive.plant().load_torque = load;
        ends_at(&mut drive, 60_000, 2_000, SWING);
    }
}

#[test]
fn m45_a_torque_against_a_software_limit_does_not_creep_and_the_other_way_is_free() {
    for name in ["servo_100w", "nema17"] {
        let mut drive = enabled(name, 4);
        set_limits(&mut drive, (-50_000, 5_000));
        push(&mut drive, 300);
        ends_at(&mut drive, 5_000, 800, SWING);
        let share = f64::from(drive.read_u32(0x6076, 0)) * 1e-3;
        for load in [0.0, -0.3, 0.3, 0.0] {
            drive.plant().load_torque = load * share;
            drive.run_millis(100);
            for target in [1_000, 1, 0, 500] {
                drive.write_i16(0x6071, 0, target);
                let (farthest, _) = watch(&mut drive, 200, 1);
                assert!((farthest - 5_000).abs() <= 1, "{name}: {farthest}");
                assert!((drive.position() - 5_000).abs() <= 1, "{name}");
            }
        }
        drive.write_i16(0x6071, 0, -200);
        drive.run_millis(20);
        assert_eq!(drive.statusword() & INTERNAL_LIMIT, 0);
        assert!((torque(&mut drive) + 200).abs() <= 2);
        assert!(drive.position() < 4_990, "{name}: {}", drive.position());
    }
}

#[test]
fn m45_a_torque_the_other_way_takes_the_place_of_the_ramp_before_a_software_limit() {
    let mut drive = enabled("servo_100w", 4);
    set_limits(&mut drive, (-1_000_000, 60_000));
    push(&mut drive, 150);
    until_limited(&mut drive);
    drive.run_millis(10);
    assert!(drive.read_i32(0x606C, 0) > 200_000);
    drive.write_i16(0x6071, 0, -500);
    drive.run_millis(20);
    assert!((torque(&mut drive) + 500).abs() <= 5);
    assert_eq!(drive.statusword() & INTERNAL_LIMIT, 0);
    let (farthest, _) = watch(&mut drive, 100, 1);
    assert!(farthest < 60_000);
    assert!(drive.read_i32(0x606C, 0) < 0);
}

#[test]
fn m45_a_software_limit_that_is_written_in_motion_counts_at_once() {
    let mut drive = enabled("servo_100w", 4);
    set_limits(&mut drive, (-1_000_000, 100_000));
    push(&mut drive, 150);
    drive.run_millis(40);
    assert!(drive.position() < 20_000);
    // Nearer.
    drive.write_i32(0x607D, 2, 70_000);
    ends_at(&mut drive, 70_000, 1_500, SWING);
    // Further, while it stands, and on the ramp.
    drive.write_i32(0x607D, 2, 130_000);
    until_limited(&mut drive);
    assert!(drive.read_i32(0x606C, 0) > 400_000);
    drive.write_i32(0x607D, 2, 145_000);
    drive.run_millis(3);
    assert_eq!(drive.statusword() & INTERNAL_LIMIT, 0);
    until_limited(&mut drive);
    // Nearer than the quick stop ramp ends.
    let limit = drive.position() as i32 + 40_000;
    drive.write_i32(0x607D, 2, limit);
    ends_at(&mut drive, limit, 2_000, SWING);
    // Behind the rotor: it stops where it can.
    drive.write_i32(0x607D, 2, 600_000);
    drive.run_millis(100);
    let behind = drive.position() as i32 - 100;
    drive.write_i32(0x607D, 2, behind);
    drive.run_millis(1_000);
    let stands = drive.position();
    assert_ne!(drive.statusword() & INTERNAL_LIMIT, 0);
    drive.run_millis(300);
    assert!((drive.position() - stands).abs() <= 1);
}

#[test]
fn m45_limits_of_the_torque_that_brake_less_make_the_ramp_begin_earlier() {
    for (name, limit, index) in [
        ("servo_100w", 30_u16, 0x60E1),
        ("servo_100w", 30, 0x6072),
        ("nema17", 40, 0x6073),
    ] {
        let mut drive = enabled(name, 4);
        set_limits(&mut drive, (-100_000, 100_000));
        push(&mut drive, 150);
        drive.run_millis(60);
        drive.write_u16(index, 0, limit);
        ends_at(&mut drive, 100_000, 4_000, 3 * SWING);
    }
}

#[test]
fn m45_a_halt_before_a_software_limit_ends_with_the_torque_of_before() {
    let mut drive = enabled("servo_100w", 4);
    set_limits(&mut drive, (-50_000, 50_000));
    push(&mut drive, 150);
    until_limited(&mut drive);
    // Harder than the quick stop.
    drive.write_u32(0x6084, 0, 20_000_000);
    drive.command(0x10F);
    drive.run_millis(300);
    assert_ne!(drive.statusword() & TARGET_REACHED, 0);
    assert!(drive.position() < 49_000);
    drive.command(0x0F);
    ends_at(&mut drive, 50_000, 1_000, SWING);
}

#[test]
fn m45_a_limit_switch_stops_whatever_takes_the_motor_into_it() {
    for target in [150, 0, -5] {
        let mut axis = Axis::servo(&ServoAxisData::named("servo_100w").unwrap());
        axis.track.positive_limit = Some(Switch::from(60_000));
        let mut drive = enable(ServoBench::on(axis), 4);
        push(&mut drive, 150);
        watch(&mut drive, 90, 1);
        assert!(drive.position() < 50_000, "{}", drive.position());
        push(&mut drive, target);
        let (farthest, fastest) = watch(&mut drive, 1_500, 1);
        assert!(fastest > 200, "{fastest} counts/ms");
        // 6085h is 2 counts/ms².
        let ramp = fastest * fastest / 4 + 4 * fastest;
        assert!(farthest > 60_000 && farthest < 60_000 + ramp, "{farthest}");
        let stands = drive.position();
        watch(&mut drive, 200, 1);
        assert!(target < 0 || (drive.position() - stands).abs() <= 1);
        drive.write_i16(0x6071, 0, -150);
        drive.run_millis(100);
        assert!(drive.position() < stands - 1_000);
    }
}
