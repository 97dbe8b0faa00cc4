//! What ends operation of a drive whose motor is moved by its current, and the error codes.

use servo_plant::{SensorFaults, Short};
use sim::plant::ServoAxisData;
use tests::drive::{FAULT, INTERNAL_LIMIT, OPERATION_ENABLED, ServoBench};

use super::{enable, enabled, hold, torque};

/// The drive is in fault within so many milliseconds, with one of these codes, and the motor has no current.
#[track_caller]
pub fn fails(drive: &mut ServoBench, milliseconds: u64, codes: &[u16]) {
    drive.reaches(FAULT, milliseconds);
    let code = drive.read_u16(0x603F, 0);
    assert!(codes.contains(&code), "{code:04X}h");
    drive.run_millis(50);
    let current = drive.plant().phase_currents();
    let speed = drive.plant().velocity();
    assert!(
        current.iter().all(|current| current.abs() < 0.05),
        "{current:?} A at {speed} rad/s"
    );
}

/// Turning in profile velocity.
pub fn turning(name: &str) -> ServoBench {
    let mut drive = enabled(name, 3);
    let counts = drive.read_u32(0x608F, 1) as i32;
    drive.write_i32(0x60FF, 0, 10 * counts);
    drive.run_millis(300);
    assert!(drive.read_i32(0x606C, 0) > 8 * counts);
    drive
}

#[test]
fn m45_a_rotor_that_is_held_is_a_fault() {
    for name in ["nema23", "servo_100w"] {
        let mut drive = turning(name);
        hold(&mut drive);
        drive.write_u32(0x6065, 0, u32::MAX);
        fails(&mut drive, 2_000, &[0x7121]);
        drive.plant().load_brake = 0.0;
        drive.command(0x80);
        drive.run_millis(20);
        drive.write_i32(0x60FF, 0, 0);
        drive.enable();
        drive.reaches(OPERATION_ENABLED, 5);
    }
}

#[test]
fn m45_an_encoder_that_is_cut_is_a_fault() {
    for name in ["nema17", "servo_100w", "servo_400w"] {
        let mut drive = turning(name);
        drive.plant().sensor_faults.encoder_is_cut = true;
        fails(&mut drive, 1_500, &[0x7305, 0x7121, 0x8611]);
    }
}

#[test]
fn m45_counts_that_are_lost_are_a_fault_at_the_next_index() {
    for (name, lost, slipped) in [
        ("nema17", 5_i64, 0_i64),
        ("servo_100w", -5, 0),
        ("servo_400w", 0, 40),
    ] {
        let mut drive = turning(name);
        // Two are the edges of an index.
        drive.plant().sensor_faults.lost_counts = 2 * lost.signum();
        drive.stays_in(OPERATION_ENABLED, 300);
        drive.plant().sensor_faults.lost_counts = lost;
        drive.plant().sensor_faults.slipped_index = slipped;
        fails(&mut drive, 150, &[0x7305]);
        // It comes back with each index: the magnet is not where the counts say.
        drive.command(0x80);
        drive.run_millis(20);
        drive.enable();
        fails(&mut drive, 500, &[0x7305]);
        // What is mended holds again.
        drive.plant().sensor_faults = SensorFaults::default();
        drive.command(0x80);
        drive.run_millis(20);
        drive.enable();
        drive.stays_in(OPERATION_ENABLED, 500);
    }
}

#[test]
fn m45_a_phase_that_is_cut_is_a_fault() {
    for name in ["nema17", "servo_400w"] {
        let mut drive = turning(name);
        drive.plant().load_brake = 0.05;
        drive.plant().cut_phase = Some(1);
        fails(&mut drive, 1_500, &[0x7122, 0x7305, 0x7121, 0x8611]);
    }
}

#[test]
fn m45_a_wire_that_touches_the_bus_is_a_fault() {
    // Of two windings that do not know of each other nobody can tell that a current flows beside them.
    for (name, code) in [
        ("servo_100w", 0x2320),
        ("servo_400w", 0x2320),
        ("nema17", 0x2310),
    ] {
        let mut drive = turning(name);
        drive.plant().short = Some(Short::new(0, 0.05, 2e-6));
        fails(&mut drive, 5, &[code]);
        let beside = drive.plant().short.map(|short| short.current());
        assert!(beside.unwrap() < 0.01, "{beside:?} A");
        // It is there at once when the fault is left while the wire still touches.
        drive.command(0x80);
        drive.run_millis(20);
        drive.write_i32(0x60FF, 0, 0);
        drive.command(0x06);
        drive.command(0x07);
        drive.command(0x0F);
        fails(&mut drive, 50, &[code]);
        drive.plant().short = None;
        drive.command(0x80);
        drive.run_millis(20);
        drive.enable();
        drive.reaches(OPERATION_ENABLED, 50);
    }
}

#[test]
fn m45_a_current_sensor_that_says_what_cannot_be_is_a_fault() {
    for (says, target) in [(0.0, 500), (3.0, 0)] {
        let mut drive = enabled("servo_100w", 4);
        hold(&mut drive);
        drive.write_i16(0x6071, 0, target);
        drive.run_millis(600);
        assert!((torque(&mut drive) - target).abs() <= 5);
        drive.plant().sensor_faults.stuck_current = Some((1, says));
        fails(&mut drive, 50, &[0x7300]);
    }
}

#[test]
fn m45_a_supply_that_goes_is_a_fault() {
    let mut drive = turning("servo_400w");
    drive.set_supply(false);
    fails(&mut drive, 100, &[0x3220]);
}

#[test]
fn m45_a_following_error_is_a_fault() {
    let mut drive = turning("servo_100w");
    drive.write_u32(0x6065, 0, 500);
    drive.write_u16(0x6066, 0, 10);
    hold(&mut drive);
    fails(&mut drive, 1_500, &[0x8611]);
}

#[test]
fn m45_heat_of_the_stage_is_a_fault() {
    let mut drive = turning("servo_100w");
    drive.axis().plant_mut().temperature = 1_050;
    fails(&mut drive, 500, &[0x4310, 0x4210]);
}

#[test]
fn m45_a_bus_that_rises_beyond_its_bound_is_a_fault() {
    let mut drive = turning("servo_100w");
    drive.plant().charge_bus(1.4 * 48.0);
    fails(&mut drive, 50, &[0x3210]);
}

#[test]
fn m45_a_motor_that_is_driven_too_fast_is_a_fault() {
    let mut drive = enabled("servo_100w", 4);
    // 1.2 times the 3,000 1/min of the axis.
    drive.write_u16(0x6072, 0, 100);
    drive.plant().load_torque = -0.05;
    drive.reaches(FAULT, 1_000);
    assert_eq!(drive.read_u16(0x603F, 0), 0x7310);
    drive.plant().load_torque = 0.0;
    drive.plant().load_brake = 0.2;
    drive.run_millis(500);
    let currents = drive.plant().phase_currents();
    assert!(currents.iter().all(|current| current.abs() < 0.01));
    assert_eq!(drive.plant().velocity(), 0.0);
}

#[test]
fn m45_braking_stays_below_the_bound_of_the_bus() {
    let mut drive = enabled("servo_400w", 3);
    let counts = drive.read_u32(0x608F, 1) as i32;
    for acceleration in [0x6083, 0x6084] {
        drive.write_u32(acceleration, 0, counts as u32 * 2_000);
    }
    drive.write_i32(0x60FF, 0, 45 * counts);
    drive.run_millis(300);
    drive.write_i32(0x60FF, 0, 0);
    let (mut most, mut chops) = (0_f64, false);
    for _ in 0..200 {
        drive.run_millis(1);
        most = most.max(drive.plant().bus_voltage());
        chops |= drive.plant().chopper;
    }
    assert!(chops, "the chopper was on");
    assert!((48.0 * 1.03..48.0 * 1.2).contains(&most), "{most} V");
    assert!(OPERATION_ENABLED.is_shown_by(drive.statusword()));
    assert_eq!(drive.read_i32(0x606C, 0), 0);
}

/// Without a chopper nothing takes back what the motor gives: it brakes no harder than the bus bears, and comes to rest by the friction of its machine.
#[test]
fn m45_braking_without_a_chopper_stays_below_the_bound_of_the_bus() {
    let mut drive = ServoBench::on_changed("servo_400w", |data| {
        data.plant.load.inertia = 5e-4;
        data.plant.load.coulomb_friction = 0.1;
        data.plant.supply.chopper = 1e9;
    });
    drive.write_u32(0x6065, 0, u32::MAX);
    let mut drive = enable(drive, 3);
    let counts = drive.read_u32(0x608F, 1) as i32;
    for acceleration in [0x6083, 0x6084] {
        drive.write_u32(acceleration, 0, counts as u32 * 500);
    }
    drive.write_i32(0x60FF, 0, 40 * counts);
    drive.run_millis(600);
    drive.write_i32(0x60FF, 0, 0);
    let (mut most, mut is_limited) = (0_f64, false);
    let mut waited = 0;
    while drive.read_i32(0x606C, 0).abs() > counts / 10 {
        drive.run_millis(1);
        most = most.max(drive.plant().bus_voltage());
        is_limited |= drive.statusword() & INTERNAL_LIMIT != 0;
        waited += 1;
        assert!(waited < 5_000, "it does not come to rest");
    }
    // The ramp alone takes 80 ms. At 1.25 times its voltage the bus is fault 3210h.
    assert!((48.0 * 1.1..48.0 * 1.24).contains(&most), "{most} V");
    assert!(is_limited && waited > 200, "{waited} ms");
    assert!(OPERATION_ENABLED.is_shown_by(drive.statusword()));
}

#[test]
fn m45_a_hot_stage_gives_less_torque() {
    let mut drive = enabled("servo_100w", 4);
    hold(&mut drive);
    drive.write_u32(0x6087, 0, 100_000);
    // What the board warns of and what it ends by its temperature is elsewhere.
    drive.write_i16(0x2074, 2, 1_200);
    drive.write_i16(0x2074, 3, 1_200);
    drive.write_i16(0x6071, 0, 1_000);
    drive.run_millis(50);
    assert!((torque(&mut drive) - 1_000).abs() <= 5);
    assert_eq!(drive.statusword() & INTERNAL_LIMIT, 0);
    // From 80 °C on it falls to nothing at 100 °C: at 97 °C 15 % of the peak of three times the rated one is left.
    drive.axis().plant_mut().temperature = 970;
    drive.run_millis(50);
    let left = torque(&mut drive);
    assert!((440..=460).contains(&left), "{left}");
    assert_eq!(drive.statusword() & INTERNAL_LIMIT, INTERNAL_LIMIT);
}

#[test]
fn m45_heat_of_the_motor_is_warned_of_before_a_held_rotor_is_blocked() {
    let mut drive = enabled("servo_100w", 4);
    hold(&mut drive);
    drive.write_u32(0x6087, 0, 100_000);
    drive.write_i16(0x6071, 0, 2_500);
    drive.run_millis(50);
    assert!((torque(&mut drive) - 2_500).abs() <= 10);
    // What the peak of three times may add in two seconds, 2.5 times add in three.
    drive.run_millis(2_500);
    assert_eq!(drive.statusword() & 0x80, 0);
    let mut waited = 0;
    while drive.statusword() & 0x80 == 0 {
        drive.run_millis(10);
        waited += 10;
        assert!(waited < 500, "2350h is a warning");
    }
    // Then the heat takes back what was asked for, and the rotor that is held is blocked at a limit.
    fails(&mut drive, 500, &[0x7121]);
}

#[test]
fn m45_the_stage_has_a_heat_of_its_own() {
    // It bears 6 A for ever, where the motor bears 4 A, and its peak of 12 A for half a second, where the motor bears that for two.
    let mut drive = ServoBench::on_changed("servo_100w", |data| data.stage = (6.0, 0.5));
    drive.write_u32(0x6087, 0, 100_000);
    let mut drive = enable(drive, 4);
    hold(&mut drive);
    // 8 A: 54 A²s are there for 28 A² above what the stage bears. The motor has 256 A²s for 48 A².
    drive.write_i16(0x6071, 0, 2_000);
    drive.run_millis(1_600);
    assert!((torque(&mut drive) - 2_000).abs() <= 10);
    assert_eq!(drive.statusword() & (INTERNAL_LIMIT | 0x80), 0);
    let mut waited = 1_600;
    while drive.statusword() & 0x80 == 0 {
        drive.run_millis(10);
        waited += 10;
        assert!(waited < 1_900, "2350h is a warning");
    }
    assert!((torque(&mut drive) - 2_000).abs() <= 10);
    // Then the stage takes back what was asked for, and the rotor that is held is blocked at a limit.
    fails(&mut drive, 300, &[0x7121]);
}

#[test]
fn m45_a_current_of_two_phases_that_stands_still_is_a_fault_before_much_flows() {
    for (name, peak) in [("nema17", 2.4), ("nema23", 6.0)] {
        for (mode, target) in [(4, 0_i32), (4, 300), (3, 4_096), (3, 40_000)] {
            for says in [0.0, 0.4, 1.5] {
                let mut drive = enabled(name, mode);
                if mode == 4 {
                    hold(&mut drive);
                    drive.write_i16(0x6071, 0, target as i16);
                } else {
                    drive.write_i32(0x60FF, 0, target);
                }
                drive.run_millis(500);
                drive.plant().sensor_faults.stuck_current = Some((1, says));
                let mut most = 0.0_f64;
                for _ in 0..400 {
                    drive.run_micros(250);
                    most = most.max(drive.plant().phase_currents()[1].abs());
                }
                let what = format!("{name}, {target} in mode {mode}, says {says}");
                // More than that the bus does not drive until it is seen.
                assert!(most < 3.3 * peak, "{what}: {most} A");
                let code = drive.read_u16(0x603F, 0);
                // A sensor that says nothing is a phase that carries nothing, as soon as it is to carry something.
                let expected = match (says == 0.0, target) {
                    (true, 0) => 0,
                    (true, _) => 0x7122,
                    _ => 0x7300,
                };
                assert_eq!(code, expected, "{what}: {code:04X}h");
            }
        }
    }
}

#[test]
fn m45_data_of_another_motor_are_a_fault_where_the_model_ends() {
    for (name, share) in [("nema17", 5.0), ("servo_100w", 5.0), ("servo_400w", 10.0)] {
        let mut drive = ServoBench::on_axis(name);
        let data = ServoAxisData::named(name).expect("ready").motor();
        for (sub, own) in [(2, data.inductance_d), (3, data.inductance_q)] {
            drive.write_u32(0x20C2, sub, (f64::from(own) * 1e9 * share) as u32);
        }
        drive.run_millis(10);
        drive.write_u8(0x6060, 0, 3);
        let counts = drive.read_u32(0x608F, 1) as i32;
        drive.write_i32(0x60FF, 0, 10 * counts);
        for word in [0x06, 0x07, 0x0F] {
            drive.command(word);
            drive.run_millis(10);
        }
        fails(&mut drive, 200, &[0x7305, 0x7122]);
        // With its own it goes on.
        drive.write_u32(0x20C2, 2, 0);
        drive.write_u32(0x20C2, 3, 0);
        drive.command(0x80);
        drive.run_millis(20);
        drive.enable();
        drive.stays_in(OPERATION_ENABLED, 300);
    }
}

/// Where a rotor is blocked: below the speed of 20C5h:2, at a limit of the torque, for the time of 20C5h:1.
#[test]
fn m45_a_rotor_is_blocked_below_a_speed_and_for_a_time() {
    // At its rated torque the motor turns at 100 turns a minute, and no faster.
    let fan = |data: &mut ServoAxisData| {
        let rated = f64::from(data.motor().rated_torque());
        data.plant.load.viscous_friction = rated / (100.0 / 60.0 * std::f64::consts::TAU);
    };
    for (speed, time, is_blocked) in [
        (50_u16, 200_u16, false),
        (200, 0, false),
        (200, 150, true),
        (200, 600, true),
    ] {
        let mut drive = ServoBench::on_changed("servo_100w", fan);
        drive.write_u16(0x20C5, 1, time);
        drive.write_u16(0x20C5, 2, speed);
        drive.write_u16(0x6072, 0, 1_000);
        drive.write_u32(0x6065, 0, u32::MAX);
        let mut drive = enable(drive, 3);
        drive.write_u32(0x6083, 0, 10_000_000);
        drive.write_i32(0x60FF, 0, 200_000);
        if is_blocked {
            drive.stays_in(OPERATION_ENABLED, u64::from(time) - 20);
            drive.run_millis(60);
            assert_eq!(drive.read_u16(0x603F, 0), 0x7121);
        } else {
            drive.stays_in(OPERATION_ENABLED, 1_000);
            let turning = drive.read_i32(0x606C, 0);
            assert!((15_000..18_000).contains(&turning), "{turning}");
        }
    }
}

/// With 605Eh = 2: a fault of the loops takes the current at once, and the motor coasts; one of the position or of the board brakes it on the quick stop ramp first.
#[test]
fn m45_each_fault_has_the_reaction_of_its_class() {
    type Event = fn(&mut ServoBench);
    let events: [(u16, bool, Event); 9] = [
        (0x2320, false, |drive| {
            drive.plant().short = Some(Short::new(0, 0.05, 2e-6));
        }),
        (0x3210, false, |drive| drive.plant().charge_bus(1.4 * 48.0)),
        (0x3220, false, |drive| drive.set_supply(false)),
        (0x4310, false, |drive| {
            drive.write_i16(0x2074, 3, 1_200);
            drive.axis().plant_mut().temperature = 1_010;
        }),
        (0x7300, false, |drive| {
            drive.plant().sensor_faults.stuck_current = Some((1, 3.0));
        }),
        (0x7305, false, |drive| {
            drive.plant().sensor_faults.lost_counts = 7;
        }),
        (0x7310, false, |drive| {
            drive.write_u16(0x6072, 0, 100);
            drive.plant().load_torque = -0.3;
        }),
        (0x4210, true, |drive| {
            // Below 80 °C, from where on it gives less torque.
            drive.write_i16(0x2074, 3, 700);
            drive.axis().plant_mut().temperature = 750;
        }),
        (0x8611, true, |drive| {
            drive.write_u16(0x6066, 0, 0);
            drive.write_u32(0x6065, 0, 20);
            drive.plant().load_torque = 0.3;
        }),
    ];
    for (code, brakes, event) in events {
        let mut drive = turning("servo_100w");
        drive.write_i16(0x605E, 0, 2);
        drive.write_u32(0x6085, 0, 2_000_000);
        event(&mut drive);
        let mut waited = 0;
        while drive.read_u16(0x603F, 0) != code {
            drive.run_millis(1);
            waited += 1;
            assert!(waited < 300, "{code:04X}h");
        }
        drive.plant().load_torque = 0.0;
        drive.run_millis(5);
        let begin = drive.plant().velocity();
        drive.run_millis(20);
        let slower = (begin - drive.plant().velocity()) / 0.02;
        if brakes {
            // 1,257 rad/s², and at 8611h what is left of the load; friction alone is 312.
            assert!(
                (1_150.0..1_700.0).contains(&slower),
                "{code:04X}h: {slower}"
            );
        } else {
            assert_eq!(drive.plant().current(), [0.0; 2], "{code:04X}h");
        }
        drive.reaches(FAULT, 3_000);
        drive.run_millis(50);
        assert_eq!(drive.plant().current(), [0.0; 2], "{code:04X}h");
    }
}

/// What I²t has spent stays spent when the data of the motor are written.
#[test]
fn m45_heat_is_not_forgotten_with_other_data_of_the_motor() {
    let mut drive = enabled("servo_100w", 4);
    drive.write_u32(0x6087, 0, 100_000);
    hold(&mut drive);
    drive.write_i16(0x6071, 0, 2_500);
    // Of three seconds.
    drive.run_millis(2_500);
    assert_eq!(drive.statusword() & 0x80, 0);
    drive.command(0x06);
    drive.run_millis(20);
    drive.write_u32(0x20C2, 1, 610_000);
    drive.run_millis(20);
    drive.enable();
    drive.run_millis(600);
    assert_ne!(drive.statusword() & 0x80, 0, "2350h");
}
