//! Steppers in closed loop by their load angle (20C4h): loads above the holding torque in each mode, and what is told of them.

use sim::plant::{Axis, ServoAxisData, Switch, Track};
use tests::drive::{
    FAULT, INTERNAL_LIMIT, OPERATION_ENABLED, SWITCHED_ON, ServoBench, TARGET_REACHED,
};

use super::cyclic::{bytes, period};
use super::{enable, hold, torque};

/// 20C4h:1.
const SUPERVISED: u8 = 1;
const AT_REST: u8 = 2;
const AT_ONCE: u8 = 3;

/// Counts of a full step.
const FULL_STEP: f64 = 4_096.0 / 200.0;

/// 20C4h:2 as it is by itself.
const BOUND: u16 = 150;

/// A drive whose positions are held in this way, in switch on disabled. Nobody looks for a blocked rotor or a following error.
fn held(name: &str, way: u8) -> ServoBench {
    set_up(ServoBench::on_axis(name), way)
}

fn set_up(mut drive: ServoBench, way: u8) -> ServoBench {
    drive.write_u8(0x20C4, 1, way);
    drive.write_u16(0x20C5, 1, 0);
    drive.write_u32(0x6065, 0, u32::MAX);
    drive
}

/// The torque of a full step of lead.
fn holding(name: &str) -> f64 {
    let data = ServoAxisData::named(name).expect("a ready axis");
    f64::from(data.motor().rated_torque())
}

/// A load of so many times the holding torque, in either direction.
fn load(drive: &mut ServoBench, name: &str, times: f64) {
    drive.plant().load_brake = times * holding(name);
}

/// Runs for so many milliseconds; the lead stays within its bound. Returns the bits of the statusword that were 1 all the time, and those that were at some.
fn watch(drive: &mut ServoBench, milliseconds: u64) -> (u16, u16) {
    let (mut all, mut any) = (u16::MAX, 0);
    for _ in 0..milliseconds {
        drive.run_millis(1);
        let word = drive.statusword();
        (all, any) = (all & word, any | word);
        let lead = drive
            .axis()
            .plant()
            .servo()
            .map(|servo| servo.loops().lead());
        assert!(lead <= Some(BOUND), "{lead:?}");
    }
    drive.reaches(OPERATION_ENABLED, 1);
    (all, any)
}

/// How far the rotor truly is from a position, in full steps.
fn away(drive: &mut ServoBench, position: i32) -> f64 {
    let at = drive.plant().angle() / std::f64::consts::TAU * 4_096.0;
    (at - f64::from(position)) / FULL_STEP
}

#[track_caller]
fn is_at(drive: &mut ServoBench, position: i32) {
    drive.run_millis(200);
    let away = away(drive, position);
    assert!(away.abs() < 0.1, "{away} full steps from {position}");
    let actual = drive.read_i32(0x6064, 0);
    assert!((actual - position).abs() <= 1, "6064h is {actual}");
}

#[test]
fn m45_a_stepper_moves_in_each_way_and_its_current_falls_at_rest() {
    for name in ["nema17", "nema23"] {
        for way in [0, SUPERVISED, AT_REST, AT_ONCE] {
            let mut drive = enable(held(name, way), 1);
            for target in [20_000, -3_000, 7] {
                drive.begin_move(target);
                drive.reaches_target(3_000);
                if way == SUPERVISED {
                    watch(&mut drive, 200);
                    let away = away(&mut drive, target);
                    assert!(away.abs() < 0.35, "{away} full steps");
                } else {
                    is_at(&mut drive, target);
                }
            }
            watch(&mut drive, 400);
            let rated = ServoAxisData::named(name).expect("ready").rated_current;
            let [d, q] = drive.plant().current();
            let share = d.hypot(q) / f64::from(rated);
            let most = if way == 0 { 0.2 } else { 0.6 };
            assert!(share < most, "{name}, way {way}: {share}");
        }
    }
}

#[test]
fn m45_a_load_above_the_holding_torque_costs_no_step_in_profile_position() {
    for (name, way) in [
        ("nema17", AT_REST),
        ("nema17", AT_ONCE),
        ("nema23", AT_REST),
        ("nema23", AT_ONCE),
    ] {
        let mut drive = enable(held(name, way), 1);
        drive.begin_move(16_000);
        watch(&mut drive, 150);
        load(&mut drive, name, 1.4);
        watch(&mut drive, 50);
        let (all, any) = watch(&mut drive, 700);
        assert_eq!(all & INTERNAL_LIMIT, INTERNAL_LIMIT, "held back");
        assert_eq!(any & TARGET_REACHED, 0);
        let behind = -away(&mut drive, 16_000);
        assert!(behind > 20.0, "{behind}");
        // The profile has ended, the motor has not.
        assert_eq!(drive.read_i32(0x6062, 0), 16_000);
        assert!((f64::from(drive.read_i32(0x60F4, 0)) - behind * FULL_STEP).abs() < 2.0);
        load(&mut drive, name, 0.0);
        drive.reaches_target(3_000);
        watch(&mut drive, 100);
        assert_eq!(drive.statusword() & INTERNAL_LIMIT, 0);
        is_at(&mut drive, 16_000);
    }
}

#[test]
fn m45_target_reached_waits_for_what_is_held_back_without_a_window_too() {
    let mut drive = enable(held("nema17", AT_REST), 1);
    drive.write_u32(0x6067, 0, u32::MAX);
    load(&mut drive, "nema17", 1.4);
    drive.begin_move(2_000);
    let (_, any) = watch(&mut drive, 500);
    assert_eq!(any & TARGET_REACHED, 0);
    load(&mut drive, "nema17", 0.0);
    drive.reaches_target(1_000);
    is_at(&mut drive, 2_000);
}

#[test]
fn m45_what_is_held_back_is_made_up_with_a_speed_of_its_own() {
    for (speed, way) in [
        (100_u16, AT_REST),
        (1_000, AT_REST),
        (1_000, AT_ONCE),
        (400, AT_REST),
        (100, AT_ONCE),
        (400, AT_ONCE),
    ] {
        let mut drive = held("nema17", way);
        drive.write_u16(0x20C4, 3, speed);
        let mut drive = enable(drive, 1);
        load(&mut drive, "nema17", 1.4);
        let target = (f64::from(speed.max(400)) * 0.5 * FULL_STEP) as i32;
        drive.begin_move(target);
        watch(&mut drive, 800);
        load(&mut drive, "nema17", 0.0);
        watch(&mut drive, 50);
        let begin = away(&mut drive, 0);
        watch(&mut drive, 200);
        let made_up = (away(&mut drive, 0) - begin) * 5.0;
        let off = made_up / f64::from(speed) - 1.0;
        assert!(off.abs() < 0.03, "way {way}: {made_up}, not {speed}");
        watch(&mut drive, 2_000);
        is_at(&mut drive, target);
    }
}

#[test]
fn m45_a_load_above_the_holding_torque_costs_no_step_in_profile_velocity() {
    for way in [AT_REST, AT_ONCE] {
        let mut drive = enable(held("nema17", way), 3);
        drive.write_i32(0x60FF, 0, 16_000);
        watch(&mut drive, 300);
        load(&mut drive, "nema17", 1.4);
        watch(&mut drive, 50);
        let (all, any) = watch(&mut drive, 250);
        assert_eq!(all & INTERNAL_LIMIT, INTERNAL_LIMIT);
        assert_eq!(any & TARGET_REACHED, 0);
        load(&mut drive, "nema17", 0.0);
        watch(&mut drive, 100);
        let before = drive.read_i32(0x60F4, 0);
        watch(&mut drive, 300);
        let after = drive.read_i32(0x60F4, 0);
        // What is made up at rest stays as long as the motor turns.
        let is_made_up = after < 20;
        assert_eq!(is_made_up, way == AT_ONCE, "{before}, then {after}");
        assert!(before > 1_000, "{before}");
        drive.write_i32(0x60FF, 0, 0);
        watch(&mut drive, 600);
        while drive.statusword() & INTERNAL_LIMIT != 0 {
            watch(&mut drive, 10);
        }
        watch(&mut drive, 100);
        let demand = drive.read_i32(0x6062, 0);
        is_at(&mut drive, demand);
    }
}

#[test]
fn m45_a_motion_back_comes_to_where_the_rotor_is_held() {
    for way in [AT_REST, AT_ONCE] {
        let mut drive = enable(held("nema17", way), 1);
        drive.begin_move(4_000);
        watch(&mut drive, 60);
        load(&mut drive, "nema17", 1.4);
        watch(&mut drive, 500);
        let stands = drive.position();
        assert!(stands < 3_000, "{stands}");
        load(&mut drive, "nema17", 0.6);
        drive.begin_move(0);
        let mut farthest = stands;
        for _ in 0..1_000 {
            watch(&mut drive, 1);
            farthest = farthest.max(drive.position());
        }
        let most = if way == AT_REST { stands + 60 } else { 4_010 };
        assert!(farthest < most, "{farthest} from {stands}");
        load(&mut drive, "nema17", 0.0);
        drive.reaches_target(1_000);
        is_at(&mut drive, 0);
    }
}

#[test]
fn m45_a_load_above_the_holding_torque_costs_no_step_in_cyclic_synchronous_position() {
    for way in [AT_REST, AT_ONCE] {
        let mut drive = held("nema17", way);
        drive.map_pdo(0x1401, &[0x607A_0020], 1);
        drive.write_u8(0x60C2, 1, 4);
        let mut drive = enable(drive, 8);
        let mut target = 0_i32;
        for step in 0..300 {
            if (40..90).contains(&step) {
                load(&mut drive, "nema17", 1.4);
            } else {
                load(&mut drive, "nema17", 0.0);
            }
            target += if step < 150 { 40 } else { 0 };
            period(&mut drive, Some(&bytes(&target.to_le_bytes())));
            if (50..90).contains(&step) {
                assert_ne!(drive.statusword() & INTERNAL_LIMIT, 0, "{step}");
            }
            let lead = drive.read_u16(0x20C4, 7);
            assert!(lead <= BOUND, "{lead}");
        }
        for _ in 0..100 {
            period(&mut drive, Some(&bytes(&target.to_le_bytes())));
        }
        assert_eq!(drive.statusword() & INTERNAL_LIMIT, 0);
        is_at(&mut drive, target);
    }
}

#[test]
fn m45_homing_on_a_switch_under_a_load_finds_the_same_home() {
    let mut homes = Vec::new();
    for times in [0.0, 1.3] {
        let data = ServoAxisData::named("nema17").expect("a ready axis");
        let axis = Axis {
            track: Track {
                home: Some(Switch::from(3_000)),
                ..Track::default()
            },
            ..Axis::servo(&data)
        };
        let mut drive = set_up(ServoBench::on(axis), AT_ONCE);
        drive.write_u8(0x2031, 1, 3);
        drive.write_u16(0x2030, 1, 1 << 3);
        drive.write_i8(0x6098, 0, 19);
        drive.write_u32(0x6099, 1, 8_000);
        drive.write_u32(0x6099, 2, 2_000);
        drive.write_u32(0x609A, 0, 200_000);
        let mut drive = enable(drive, 6);
        drive.command(0x1F);
        let mut loaded = 0;
        while drive.statusword() & 0x1400 != 0x1400 {
            // It comes again and again, also on the way back.
            loaded += 1;
            let is_loaded = loaded % 100 < 40;
            load(&mut drive, "nema17", if is_loaded { times } else { 0.0 });
            let (_, any) = watch(&mut drive, 1);
            if any & 0x1000 != 0 && any & INTERNAL_LIMIT != 0 {
                assert_eq!(any & TARGET_REACHED, 0);
            }
            assert_eq!(any & 0x2000, 0, "homing has failed");
            assert!(loaded < 6_000);
        }
        load(&mut drive, "nema17", 0.0);
        watch(&mut drive, 300);
        is_home(&mut drive);
        homes.push(drive.position());
    }
    assert!((homes[0] - homes[1]).abs() <= 2, "{homes:?}");
}

#[track_caller]
fn is_home(drive: &mut ServoBench) {
    let actual = drive.read_i32(0x6064, 0);
    assert!(actual.abs() <= 1, "6064h is {actual} at home");
}

#[test]
fn m45_supervised_lost_steps_are_told_and_are_a_fault_at_rest() {
    let mut drive = enable(held("nema17", SUPERVISED), 1);
    drive.begin_move(8_000);
    drive.run_millis(100);
    assert_eq!(drive.statusword() & INTERNAL_LIMIT, 0);
    load(&mut drive, "nema17", 1.6);
    drive.run_millis(40);
    assert_ne!(drive.statusword() & INTERNAL_LIMIT, 0);
    assert!(OPERATION_ENABLED.is_shown_by(drive.statusword()));
    drive.reaches(FAULT, 1_000);
    assert_eq!(drive.read_u16(0x603F, 0), 0x8611);
}

#[test]
fn m45_a_load_that_a_field_drags_along_is_a_following_error() {
    for way in [SUPERVISED, AT_REST, AT_ONCE] {
        let mut drive = held("nema17", way);
        drive.write_u32(0x6065, 0, 500);
        drive.write_u16(0x6066, 0, 10);
        let mut drive = enable(drive, 3);
        drive.write_i32(0x60FF, 0, 16_000);
        drive.run_millis(300);
        load(&mut drive, "nema17", 1.4);
        drive.reaches(FAULT, 500);
        assert_eq!(drive.read_u16(0x603F, 0), 0x8611, "way {way}");
    }
}

#[test]
fn m45_a_stepper_that_is_held_is_blocked_after_its_time() {
    for time in [200_u16, 800] {
        let mut drive = held("nema23", AT_ONCE);
        drive.write_u16(0x20C5, 1, time);
        let mut drive = enable(drive, 3);
        hold(&mut drive);
        drive.write_i32(0x60FF, 0, 8_000);
        watch(&mut drive, u64::from(time) - 50);
        drive.reaches(FAULT, 100);
        assert_eq!(drive.read_u16(0x603F, 0), 0x7121);
        drive.run_millis(50);
        assert!(drive.plant().phase_currents()[0].abs() < 0.05);
    }
}

#[test]
fn m45_an_encoder_that_is_cut_ends_a_stepper_in_each_way() {
    for way in [SUPERVISED, AT_REST, AT_ONCE] {
        let mut drive = held("nema17", way);
        drive.write_u16(0x20C5, 1, 500);
        let mut drive = enable(drive, 3);
        drive.write_i32(0x60FF, 0, 40_000);
        watch(&mut drive, 300);
        drive.plant().sensor_faults.encoder_is_cut = true;
        drive.reaches(FAULT, 1_500);
        let code = drive.read_u16(0x603F, 0);
        assert_eq!(code, 0x7305, "way {way}");
        drive.run_millis(100);
        assert!(drive.plant().phase_currents()[0].abs() < 0.05);
    }
}

#[test]
fn m45_modes_of_torque_are_there_and_change_in_flight() {
    let mut drive = enable(held("nema17", AT_ONCE), 3);
    drive.write_i32(0x60FF, 0, 16_000);
    watch(&mut drive, 300);
    let mut most = 0;
    for (mode, velocity) in [(4, 0), (3, 16_000), (4, 0), (3, 8_000)] {
        if mode == 3 {
            drive.write_i32(0x60FF, 0, velocity);
        }
        drive.write_u8(0x6060, 0, mode);
        for _ in 0..200 {
            drive.run_micros(250);
            let now = drive.axis().actuals().torque.actual;
            most = most.max(now.abs());
        }
        assert_eq!(drive.read_i8(0x6061, 0), mode as i8);
    }
    assert!(most < 700, "{most}");
    drive.write_u8(0x6060, 0, 4);
    hold(&mut drive);
    drive.write_i16(0x6071, 0, 100);
    drive.run_millis(1_000);
    assert_eq!(torque(&mut drive), 100);
    assert_eq!(drive.read_u16(0x20C4, 7), 0);
}

#[test]
fn m45_a_limit_of_the_torque_holds_for_a_stepper() {
    let mut drive = held("nema17", AT_ONCE);
    drive.write_u16(0x60E0, 0, 300);
    let mut drive = enable(drive, 1);
    load(&mut drive, "nema17", 0.5);
    drive.begin_move(2_000);
    let mut most = 0;
    for _ in 0..200 {
        watch(&mut drive, 1);
        most = most.max(torque(&mut drive));
    }
    assert!((250..=310).contains(&most), "{most}");
    assert_ne!(drive.statusword() & INTERNAL_LIMIT, 0);
    drive.write_u16(0x60E0, 0, 1_000);
    drive.reaches_target(1_000);
    load(&mut drive, "nema17", 0.0);
    watch(&mut drive, 200);
    is_at(&mut drive, 2_000);
}

#[test]
fn m45_the_way_of_a_stepper_is_taken_over_without_power_only() {
    let mut drive = enable(held("nema17", 0), 1);
    drive.write_u8(0x20C4, 1, AT_ONCE);
    drive.plant().load_torque = 0.3 * holding("nema17");
    drive.run_millis(300);
    assert_eq!(drive.read_u16(0x20C4, 7), 0, "the loops hold it");
    drive.command(0x07);
    drive.reaches(SWITCHED_ON, 500);
    drive.command(0x0F);
    drive.reaches(OPERATION_ENABLED, 20);
    drive.plant().load_torque = 0.3 * holding("nema17");
    drive.run_millis(300);
    assert!(drive.read_u16(0x20C4, 7) > 10);
    for (sub, value, code) in [
        (2, 109_u16, 0x0609_0032),
        (2, 171, 0x0609_0031),
        (3, 0, 0x0609_0032),
        (5, 1_001, 0x0609_0031),
    ] {
        assert_eq!(
            drive.try_write(0x20C4, sub, &value.to_le_bytes()),
            Err(code)
        );
    }
}

#[test]
fn m45_homing_on_a_hard_stop_finds_it_by_the_torque() {
    for (name, way) in [
        ("servo_100w", 0),
        ("nema17", 0),
        ("nema17", AT_REST),
        ("nema17", AT_ONCE),
    ] {
        let mut drive = held(name, way);
        drive.write_u16(0x60E0, 0, 500);
        drive.write_i8(0x6098, 0, -3);
        drive.write_u32(0x6099, 1, 4_000);
        drive.write_u32(0x6099, 2, 1_000);
        drive.write_u32(0x609A, 0, 100_000);
        let mut drive = enable(drive, 6);
        drive.command(0x1F);
        let mut passed = 0;
        while drive.statusword() & 0x1000 == 0 {
            drive.run_micros(250);
            if drive.position() >= 1_000 {
                hold(&mut drive);
            }
            passed += 1;
            assert_eq!(drive.statusword() & 0x2000, 0, "{name}, way {way}");
            assert!(passed < 16_000, "{name}, way {way}");
        }
        let stop = drive.position();
        assert!((1_000..1_010).contains(&stop), "{name}, way {way}: {stop}");
        drive.run_millis(20);
        drive.plant().load_brake = 0.0;
        drive.run_millis(300);
        assert_eq!(drive.statusword() & 0x3400, 0x1400, "{name}, way {way}");
        let (stands, actual) = (drive.position(), drive.read_i32(0x6064, 0));
        assert!((stands - stop).abs() <= 2, "{name}, way {way}: {stands}");
        assert!(actual.abs() <= 2, "{name}, way {way}: 6064h is {actual}");
    }
}
