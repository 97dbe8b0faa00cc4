use canopen::Duration;

use super::*;
use crate::plant::{AXES, Heat, Index, Load, Magnet, SupplyChange, Switch, eccentricity_table};
use master::data_sheet::Address;

fn refused(text: &str) -> (Option<usize>, String) {
    Axis::from_toml(text).unwrap_err()
}

#[test]
fn an_empty_file_is_an_axis_with_nothing_along_it() {
    assert_eq!(Axis::from_toml(""), Ok(Axis::default()));
}

#[test]
fn every_key_is_understood() {
    let axis = Axis::from_toml(
        "start = -5\nseed = 7\nencoder = true\nturn = 100\n\
         [stops]\nlow = -10\nhigh = 20\n\
         [negative_limit]\nat = -8\nhysteresis = 2\nbounce_us = 300\nnormally_closed = true\n\
         [positive_limit]\nat = 18\n\
         [home]\nfrom = 3\nto = 6\nhysteresis = 1\n\
         [index]\nfirst = 4\ndistance = 50\n\
         [probe_1]\nfrom = 7\nto = 8\n\
         [probe_2]\nto = 9\n",
    );
    let expected = Axis {
        servo: None,
        start: -5,
        seed: 7,
        encoder: true,
        track: Track {
            negative_limit: Some(
                Switch::up_to(-8)
                    .with_hysteresis(2)
                    .bouncing(Duration::from_ticks(300))
                    .normally_closed(),
            ),
            positive_limit: Some(Switch::from(18)),
            home: Some(Switch::within(3..=6).with_hysteresis(1)),
            index: Some(Index::new(4, 50)),
            probes: [Some(Switch::within(7..=8)), Some(Switch::up_to(9))],
            stops: Some(-10..=20),
            turn: Some(100),
        },
        motor: None,
        supply: None,
        settings: Settings::default(),
    };
    assert_eq!(axis, Ok(expected));
}

#[test]
fn settings_are_objects_by_number_or_name() {
    let settings = Axis::from_toml(
        "[settings]\n\"2040h:2\" = 30\n\"Brake release time\" = 60\n\"2032h\" = 0b11\n",
    )
    .unwrap()
    .settings;
    assert_eq!(
        settings.values(),
        [
            (Address::new(0x2032, 0), vec![3]),
            (Address::new(0x2040, 1), vec![60, 0]),
            (Address::new(0x2040, 2), vec![30, 0]),
        ]
    );
}

#[test]
fn what_is_no_setting_is_refused_with_its_line() {
    for (setting, what) in [
        ("\"4444h\" = 1", "no object"),
        ("\"Brake relish time\" = 1", "no object"),
        ("\"6041h\" = 1", "no setting"),
        ("\"1017h\" = 100", "no setting"),
        ("\"2040h:1\" = 10001", "beyond its limits"),
        ("\"2032h\" = -1", "2032h"),
        ("\"2032h\" = \"x\"", "invalid type"),
        ("\"2040h:1\" = 1\n\"Brake release time\" = 2", "twice"),
    ] {
        let (line, why) = refused(&format!("[settings]\n{setting}\n"));
        assert!(
            line >= Some(2) && why.contains(what),
            "{setting}: {line:?} {why}"
        );
    }
}

#[test]
fn a_home_switch_may_reach_to_an_end_of_the_axis() {
    let home = |text: &str| Axis::from_toml(text).unwrap().track.home.unwrap().range;
    assert_eq!(home("[home]\nfrom = 3"), Switch::from(3).range);
    assert_eq!(home("[home]\nto = 3"), Switch::up_to(3).range);
}

#[test]
fn every_key_of_a_motor_is_understood() {
    let axis = Axis::from_toml(
        "encoder = true\n\
         [stops]\nlow = -10\nhigh = 20\ncompliance = 5\n\
         [index]\nfirst = 4\ndistance = 50\nwidth = 3\n\
         [motor]\nfull_steps = 400\nmicrosteps = 8\nrated_current_ma = 1500\nholding_torque_mnm = 400\n\
         detent_torque_mnm = 15\nrotor_inertia_gcm2 = 54\nresistance_mohm = 1600\ninductance_uh = 2800\n\
         damping_percent = 20\nstall_sense = true\nencoder_counts = 4000\n\
         [load]\ninertia_gcm2 = 120\nfriction_mnm = 20\ndrag_mnm = 10\ntorque_mnm = -30\nbrake_mnm = 900\nbrake_release_ms = 40\nbrake_engage_ms = 25\n\
         [heat]\nambient_c = -5\nrise_k = 70\ntime_constant_s = 600\n\
         [supply]\nvoltage_mv = 36000\nresistance_mohm = 200\n\
         [[supply.change]]\nat_ms = 5000\nfor_ms = 250\nvoltage_mv = 9000\n",
    )
    .unwrap();
    let motor = MotorData {
        full_steps: 400,
        microsteps: 8,
        rated_current: 1_500,
        holding_torque: 400,
        detent_torque: 15,
        rotor_inertia: 54,
        resistance: 1_600,
        inductance: 2_800,
        damping: 20,
        senses_stall: true,
        encoder_counts: Some(4_000),
        load: Load {
            inertia: 120,
            friction: 20,
            drag: 10,
            torque: -30,
            brake: 900,
            brake_release: Duration::from_ticks(40_000),
            brake_engage: Duration::from_ticks(25_000),
            compliance: 5,
        },
        heat: Heat {
            ambient: -5,
            rise: 70,
            time_constant: Duration::from_ticks(600_000_000),
        },
    };
    let supply = SupplyData {
        voltage: 36_000,
        resistance: 200,
        changes: vec![SupplyChange {
            at: Duration::from_ticks(5_000_000),
            duration: Duration::from_ticks(250_000),
            voltage: 9_000,
        }],
    };
    assert_eq!(axis.motor, Some(motor));
    assert_eq!(axis.supply, Some(supply));
    assert_eq!(axis.track.index.map(|index| index.width), Some(3));
}

#[test]
fn a_motor_needs_no_key() {
    let motor = Axis::from_toml("[motor]\n").unwrap().motor.unwrap();
    let load = Load {
        compliance: 8,
        ..Load::default()
    };
    assert_eq!(
        motor,
        MotorData {
            load,
            ..MotorData::default()
        }
    );
}

#[test]
fn mistakes_are_told_with_their_line() {
    for (text, line, part) in [
        ("start = 1\nspeed = 5\n", 2, "speed"),
        ("\n[home]\nfrom = \"three\"\n", 3, "three"),
        ("[index]\nfirst = 1\n", 1, "distance"),
        ("start = 5000000000\n", 1, "5000000000"),
        ("[home\n", 1, ""),
        ("start = 5\n[stops]\nlow = 6\nhigh = 9\n", 2, "start = 5"),
        ("\n[home]\nfrom = 6\nto = 5\n", 2, "from = 6"),
        ("[index]\nfirst = 6\ndistance = 0\n", 3, "nonzero"),
        ("turn = 0\n", 1, "nonzero"),
        (
            "[negative_limit]\nhysteresis = 2\n",
            1,
            "missing field `at`",
        ),
        ("[negative_limit]\nat = 1\nto = 2\n", 1, "not `from`"),
        ("[home]\nat = 1\n", 1, "not `at`"),
        ("[home]\nfrom = 1\nbouncing = 2\n", 3, "bouncing"),
        ("[motor]\ntorque = 5\n", 2, "torque"),
        (
            "seed = 1\n[motor]\nrated_current_ma = 0\n",
            2,
            "rated_current_ma = 0",
        ),
        ("[motor]\nencoder_counts = 400\n", 1, "encoder = true"),
        (
            "[motor]\nholding_torque_mnm = 90000\nrotor_inertia_gcm2 = 1\n",
            1,
            "inertia",
        ),
        (
            "[motor]\n\n[heat]\ntime_constant_s = 0\n",
            1,
            "time_constant_s = 0",
        ),
        (
            "encoder = true\n[motor]\nencoder_counts = 20000000\n",
            2,
            "at most 16777216",
        ),
        (
            "seed = 1\n[load]\nfriction_mnm = 5\n",
            2,
            "[load] needs a [motor]",
        ),
        ("[heat]\nrise_k = 5\n", 1, "[heat] needs a [motor]"),
        (
            "[stops]\nlow = 0\nhigh = 9\ncompliance = 3\n",
            1,
            "needs a [motor]",
        ),
        ("[supply]\n\n[[supply.change]]\nat_ms = 5\n", 3, "for_ms"),
        (
            "\n[servo]\nfeedback = \"hall\"\n",
            2,
            "missing field `axis`",
        ),
        (
            "[servo]\naxis = \"servo_1kw\"\n",
            2,
            "`servo_1kw` is no ready axis: `nema17`, ",
        ),
        (
            "[servo]\naxis = \"nema17\"\nfeedback = \"halls\"\n",
            3,
            "expected one of `incremental`, `hall`, `absolute`",
        ),
        (
            "[servo]\naxis = \"nema17\"\nfeedback = \"absolute\"\nbits = 11\n",
            4,
            "bits = 11 is not 12 to 20",
        ),
        (
            "[servo]\naxis = \"servo_100w\"\nfeedback = \"hall\"\nbits = 14\n",
            4,
            "bits needs feedback = \"absolute\"",
        ),
        (
            "[servo]\ntable = true\naxis = \"servo_100w\"\n",
            2,
            "table needs feedback = \"absolute\"",
        ),
        (
            "[servo]\naxis = \"servo_100w_hall\"\neccentricity_mrad = 3\n",
            3,
            "eccentricity_mrad needs",
        ),
        (
            "[servo]\naxis = \"nema17\"\nfeedback = \"absolute\"\neccentricity_mrad = 501\n",
            4,
            "at most 500",
        ),
        (
            "[servo]\naxis = \"nema17\"\n[motor]\n",
            3,
            "[motor] does not go with a [servo]",
        ),
        (
            "[supply]\n[servo]\naxis = \"nema17\"\n",
            1,
            "[supply] does not go",
        ),
        (
            "[servo]\naxis = \"nema17\"\n[stops]\nlow = 0\nhigh = 9\n",
            3,
            "[stops] does not go",
        ),
        (
            "[servo]\naxis = \"nema17\"\n[settings]\n\"2070h:1\" = 5\n",
            4,
            "no object",
        ),
    ] {
        let (found, what) = refused(text);
        assert_eq!(found, Some(line), "{text}: {what}");
        assert!(what.contains(part), "{text}: {what}");
        assert!(!what.contains('\n'), "{text}: {what}");
    }
}

/// The ready axis of this name as a file has it, with these keys.
fn servo(name: &str, keys: &str) -> Axis {
    Axis::from_toml(&format!("[servo]\naxis = \"{name}\"\n{keys}")).unwrap()
}

fn magnet(axis: &Axis) -> Magnet {
    axis.servo.unwrap().magnet
}

#[test]
fn a_servo_is_a_ready_axis_with_the_machine_behind_it() {
    for ready in AXES {
        assert_eq!(servo(ready.name, ""), Axis::servo(&ready.at_work()));
    }
}

#[test]
fn the_feedback_makes_the_ready_axes_with_other_sensors() {
    for (feedback, name) in [
        ("hall", "servo_100w_hall"),
        ("absolute", "servo_100w_absolute"),
    ] {
        let made = servo("servo_100w", &format!("feedback = \"{feedback}\"\n"));
        let ready = ServoAxisData {
            name: "servo_100w",
            ..ServoAxisData::named(name).unwrap()
        };
        assert_eq!(made, Axis::servo(&ready.at_work()));
    }
    let made = servo("nema17", "feedback = \"incremental\"\n");
    assert_eq!(magnet(&made), Magnet::Searched);
}

#[test]
fn an_absolute_encoder_has_bits_and_a_magnet_off_its_centre() {
    let keys = "feedback = \"absolute\"\nbits = 14\neccentricity_mrad = 20\n";
    let made = servo("nema23", keys);
    let sensors = made.servo.unwrap().plant.sensors;
    assert_eq!((sensors.bits, sensors.eccentricity), (14, 0.02));
    assert_eq!(magnet(&made), Magnet::Absolute(&[0; 64]));
    let corrected = servo("nema23", &format!("{keys}table = true\n"));
    let table = eccentricity_table(0.02);
    assert_eq!(magnet(&corrected), Magnet::Absolute(table));
    assert_ne!(magnet(&corrected), magnet(&made));
}

#[test]
fn what_a_file_sets_stays_where_a_servo_sets_up_its_drive() {
    let of = |axis: &Axis, index| {
        let values = axis.settings.values().iter();
        let mut found = values.filter(|(address, _)| *address == Address::new(index, 0));
        (found.next().map(|(_, value)| value.clone()), found.count())
    };
    let axis = servo("servo_100w", "[settings]\n\"6072h\" = 1500\n");
    assert_eq!(of(&axis, 0x6072), (Some(vec![0xDC, 0x05]), 0));
    let ready = Axis::servo(&ServoAxisData::named("servo_100w").unwrap());
    assert_eq!(of(&axis, 0x6073), of(&ready, 0x6073));
    assert!(of(&ready, 0x6073).0.is_some());
}

/// The axes in a folder below `sim/plants`.
fn ready(folder: &str) -> Vec<Axis> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let paths = std::fs::read_dir(folder)
        .unwrap()
        .map(|file| file.unwrap().path());
    paths
        .filter(|path| path.is_file())
        .map(|path| Axis::read(&path).unwrap())
        .collect()
}

#[test]
fn the_ready_axes_can_be_read() {
    let exact = ready("plants");
    assert!(exact.len() >= 3 && exact.iter().all(|axis| axis.motor.is_none()));
    let moved = ready("plants/with_motor");
    assert!(moved.len() >= 3 && moved.iter().all(|axis| axis.motor.is_some()));
}

#[test]
fn every_key_is_in_the_manual() {
    let manual = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/plant.md");
    let manual = std::fs::read_to_string(manual).unwrap();
    let sections = [
        "",
        "[stops]",
        "[home]",
        "[index]",
        "[motor]",
        "[load]",
        "[heat]",
        "[servo]",
        "[supply]",
        "[[supply.change]]",
    ];
    for section in sections {
        // The answer to a key that is not known names all that are.
        let (_, what) = refused(&format!("{section}\nnonsense = 1\n"));
        let keys: Vec<&str> = what.split('`').skip(3).step_by(2).collect();
        assert!(keys.len() >= 2, "{what}");
        for key in keys {
            assert!(manual.contains(key), "{section} {key}");
        }
    }
}
