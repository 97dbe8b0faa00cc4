//! What the manuals promise of inputs, outputs, brake, currents, supply and temperature.

use canopen::{Duration, Frame};
use sim::plant::{Index, Switch, Track};

use crate::bench::Bench;
use crate::steer::{NODE, begin, number, on, position};

/// Bits of 60FDh.
fn inputs(bench: &mut Bench) -> u32 {
    bench.run(50);
    bench.read(NODE, 0x60FD, 0)
}

/// The first emergency message that tells of an error.
fn told(bench: &mut Bench, within: u32) -> [u8; 8] {
    let frame = bench.next(0x084, within).expect("an emergency message");
    *frame.full_payload().unwrap()
}

/// Limit switches stop the motor at the inputs that are said to be theirs, and show in 60FDh.
fn stops_at_its_limit_switches(name: &str) {
    for (velocity, edge, bit) in [(20_000_i32, 3_000, 1), (-20_000, -2_000, 0)] {
        let mut bench = on(
            name,
            Track {
                positive_limit: Some(Switch::from(3_000)),
                negative_limit: Some(Switch::up_to(-2_000)),
                ..Track::default()
            },
        );
        match name {
            "lmd" => {
                bench.write(NODE, 0x2002, 2, &[0b10]);
                bench.write(NODE, 0x2002, 3, &[0b01]);
            }
            _ => {
                // IN1MODE is NSTOP, IN2MODE is PSTOP.
                number(&mut bench, 0x3562, 1, 3);
                number(&mut bench, 0x3565, 1, 2);
            }
        }
        assert_eq!(inputs(&mut bench) & 0b111, 0, "{name}");
        number(&mut bench, 0x6085, 0, 200_000);
        bench.write(NODE, 0x6060, 0, &[3]);
        bench.enable(NODE);
        bench.write(NODE, 0x60FF, 0, &velocity.to_le_bytes());
        bench.run(3_000);
        let stood = position(&mut bench);
        // 20,000² / 400,000 is 1000.
        assert!(stood.abs_diff(edge) <= 1_300, "{name}: {stood}");
        assert_eq!(
            (stood - edge).signum(),
            velocity.signum(),
            "{name}: {stood}"
        );
        bench.run(200);
        assert_eq!(position(&mut bench), stood, "{name}");
        assert_eq!(inputs(&mut bench) & 0b111, 1 << bit, "{name}");
        if name == "lmd" {
            assert_eq!(bench.read(NODE, 0x2020, 1), 1 << bit, "limit reached");
        }
    }
}

/// An input that has no function stops nothing.
#[test]
fn an_input_without_a_function_stops_nothing() {
    for name in ["lmd", "s200"] {
        let mut bench = on(
            name,
            Track {
                positive_limit: Some(Switch::from(3_000)),
                ..Track::default()
            },
        );
        bench.write(NODE, 0x6060, 0, &[3]);
        bench.enable(NODE);
        number(&mut bench, 0x60FF, 0, 20_000);
        bench.run(1_000);
        assert!(position(&mut bench) > 8_000, "{name}");
    }
}

/// Its inputs are bits 16 and up of 60FDh, whatever function they have.
fn shows_its_inputs(name: &str, count: usize) {
    let always = || Some(Switch::from(-1_000));
    let tracks = [
        Track {
            negative_limit: always(),
            ..Track::default()
        },
        Track {
            positive_limit: always(),
            ..Track::default()
        },
        Track {
            home: always(),
            ..Track::default()
        },
        Track {
            index: Some(Index {
                first: -100,
                distance: 1_000,
                width: 500,
            }),
            ..Track::default()
        },
        Track {
            probes: [always(), None],
            ..Track::default()
        },
        Track {
            probes: [None, always()],
            ..Track::default()
        },
    ];
    for (input, track) in tracks.into_iter().take(count).enumerate() {
        let mut bench = on(name, track);
        assert_eq!(
            inputs(&mut bench) >> 16,
            1 << input,
            "{name}: {}",
            input + 1
        );
        if name == "s200" {
            // IN1 to IN4.
            let levels = [0x3561, 0x3564, 0x3567, 0x356A].map(|index| bench.read(NODE, index, 1));
            let own = levels.iter().position(|level| *level == 1);
            assert_eq!((levels.iter().sum::<u32>(), own), (1, Some(input)));
        }
    }
}

/// Input 6 of a Nanotec is its home switch, bit 2 of 60FDh.
#[test]
fn the_home_switch_of_a_nanotec_is_input_6() {
    let home = Track {
        probes: [None, Some(Switch::from(-10))],
        ..Track::default()
    };
    let mut bench = on("nanotec", home);
    assert_eq!(inputs(&mut bench), 1 << 21 | 1 << 2);
    let other = Track {
        home: Some(Switch::from(-10)),
        ..Track::default()
    };
    let mut bench = on("nanotec", other);
    assert_eq!(inputs(&mut bench), 1 << 18);
}

/// 2008h:1 are the outputs that follow the brake, 2008h:2 those that follow bit 10 of the statusword; the others are 60FEh's.
#[test]
fn outputs_of_the_lmd_follow_brake_and_target() {
    let mut bench = Bench::node("lmd", NODE);
    bench.write(NODE, 0x2008, 1, &[0b001]);
    bench.write(NODE, 0x2008, 2, &[0b010]);
    bench.write(NODE, 0x60FE, 1, &0x0004_0000_u32.to_le_bytes());
    bench.run(20);
    let outputs = |bench: &mut Bench| bench.drive.plant_mut().outputs() & 0b111;
    assert_eq!(outputs(&mut bench), 0b100);
    bench.write(NODE, 0x6060, 0, &[1]);
    number(&mut bench, 0x6067, 0, 0xFFFF_FFFF);
    bench.enable(NODE);
    bench.run(50);
    assert_eq!(outputs(&mut bench) & 0b001, 1, "the brake is open");
    number(&mut bench, 0x6081, 0, 10_000);
    number(&mut bench, 0x607A, 0, 5_000);
    bench.write(NODE, 0x6040, 0, &[0x1F, 0]);
    bench.run(100);
    assert_eq!(outputs(&mut bench), 0b101, "under way");
    bench.run(1_500);
    assert_eq!(outputs(&mut bench), 0b111, "in position");
    bench.write(NODE, 0x6040, 0, &[0x06, 0]);
    bench.run(50);
    assert_eq!(outputs(&mut bench) & 0b001, 0, "the brake has closed");
}

/// O1MODE and O2MODE of the S200: in position, and an error.
#[test]
fn outputs_of_the_s200_have_their_functions() {
    let mut bench = Bench::node("s200", NODE);
    number(&mut bench, 0x35AF, 1, 7);
    number(&mut bench, 0x35B2, 1, 18);
    bench.write(NODE, 0x6060, 0, &[1]);
    bench.enable(NODE);
    let outputs = |bench: &mut Bench| bench.drive.plant_mut().outputs() & 0b11;
    number(&mut bench, 0x6081, 0, 10_000);
    number(&mut bench, 0x607A, 0, 20_000);
    bench.write(NODE, 0x6040, 0, &[0x1F, 0]);
    bench.run(100);
    assert_eq!(outputs(&mut bench), 0);
    bench.run(3_000);
    assert_eq!(outputs(&mut bench), 0b01);
    bench.drive.plant_mut().fault = Some(0x4210);
    bench.run(50);
    assert_eq!(outputs(&mut bench) & 0b10, 0b10);
    let answer = bench.sdo(NODE, [0x23, 0xAF, 0x35, 1, 99, 0, 0, 0]);
    assert_eq!(answer[0], 0x80, "no such function");
}

/// The brake opens with power, the motor waits for it, and power stays until it has closed.
fn waits_for_its_brake(name: &str) {
    let mut bench = Bench::node(name, NODE);
    match name {
        "nanotec" => {
            bench.write(NODE, 0x2007, 2, &300_u16.to_le_bytes());
            bench.write(NODE, 0x2007, 3, &200_u16.to_le_bytes());
        }
        // TBRAKE0, TBRAKE.
        _ => {
            number(&mut bench, 0x366F, 1, 300);
            number(&mut bench, 0x366E, 1, 200);
        }
    }
    bench.write(NODE, 0x6060, 0, &[1]);
    assert!(!bench.drive.plant_mut().is_brake_open(), "{name}");
    bench.enable(NODE);
    bench.run(20);
    assert!(bench.drive.plant_mut().is_brake_open(), "{name}");
    number(&mut bench, 0x6081, 0, 20_000);
    number(&mut bench, 0x607A, 0, 5_000);
    bench.write(NODE, 0x6040, 0, &[0x1F, 0]);
    bench.run(150);
    assert_eq!(position(&mut bench), 0, "{name}: the brake may hold");
    bench.run(4_000);
    assert_eq!(position(&mut bench), 5_000, "{name}");
    // A Nanotec keeps its power while it is switched on.
    let down = if name == "nanotec" { 0x06 } else { 0x07 };
    bench.write(NODE, 0x6040, 0, &[down, 0]);
    bench.run(100);
    let plant = bench.drive.plant_mut();
    assert!(!plant.is_brake_open(), "{name}");
    assert!(plant.is_energised(), "{name}: it closes");
    bench.run(200);
    assert!(!bench.drive.plant_mut().is_energised(), "{name}");
}

/// Currents of the S200's motor, as a stepper has them: while it holds and moves, and while it accelerates.
#[test]
fn the_currents_of_the_s200_are_those_of_its_motor() {
    let mut bench = Bench::node("s200", NODE);
    number(&mut bench, 0x358E, 1, 2_000);
    number(&mut bench, 0x358F, 1, 3_000);
    bench.write(NODE, 0x6060, 0, &[3]);
    number(&mut bench, 0x6083, 0, 10_000);
    bench.enable(NODE);
    number(&mut bench, 0x60FF, 0, 10_000);
    bench.run(500);
    assert_eq!(bench.drive.plant_mut().current(), 3_000, "it accelerates");
    bench.run(1_500);
    assert_eq!(bench.drive.plant_mut().current(), 2_000);
}

/// MSPEED of the S200 is its 6080h: one turn a minute is 65536 counts in 60 seconds.
#[test]
fn the_s200_keeps_below_mspeed() {
    let mut bench = Bench::node("s200", NODE);
    number(&mut bench, 0x35A3, 1, 1);
    assert_eq!(bench.read(NODE, 0x6080, 0), 1);
    bench.write(NODE, 0x6060, 0, &[3]);
    bench.enable(NODE);
    number(&mut bench, 0x60FF, 0, 5_000);
    bench.run(1_000);
    let from = position(&mut bench);
    bench.run(1_000);
    let way = position(&mut bench) - from;
    assert!((1_070..=1_110).contains(&way), "{way}");
}

/// VBUS and HSTemp show supply and temperature; below VBUSMIN is F05, above MAXTEMPH is F01.
#[test]
fn the_s200_watches_its_bus_and_its_heat_sink() {
    let mut bench = Bench::node("s200", NODE);
    bench.run(200);
    for (index, shown) in [(0x361A, 24), (0x3B78, 24), (0x3B6A, 25)] {
        assert_eq!(bench.read(NODE, index, 1), shown, "{index:04X}h");
    }
    number(&mut bench, 0x361D, 1, 20);
    bench.write(NODE, 0x6060, 0, &[1]);
    bench.enable(NODE);
    bench.sent.clear();
    bench.drive.plant_mut().supply_voltage = 18_000;
    assert_eq!(told(&mut bench, 1_000)[..4], [0x20, 0x31, 0x05, 1]);
    let mut bench = Bench::node("s200", NODE);
    number(&mut bench, 0x3585, 1, 60);
    bench.run(200);
    bench.sent.clear();
    bench.drive.plant_mut().temperature = 650;
    assert_eq!(told(&mut bench, 2_000)[..4], [0x10, 0x42, 0x09, 1]);
    assert_eq!(bench.read(NODE, 0x3B6A, 1), 65);
    // 0 is no threshold.
    let mut bench = Bench::node("s200", NODE);
    bench.sent.clear();
    bench.drive.plant_mut().temperature = 650;
    bench.run(1_000);
    assert!(bench.next(0x084, 10).is_none());
}

/// PE of the S200 is how far the motor is from where it should be, and SWE1 and SWE2 are where it may go.
#[test]
fn the_s200_shows_its_following_error_and_keeps_its_software_limits() {
    let mut bench = Bench::node("s200", NODE);
    bench.drive.plant_mut().encoder = true;
    // PEMAX.
    number(&mut bench, 0x35C7, 1, 5_000);
    bench.write(NODE, 0x6060, 0, &[1]);
    bench.enable(NODE);
    number(&mut bench, 0x6081, 0, 2_000);
    number(&mut bench, 0x607A, 0, 20_000);
    bench.write(NODE, 0x6040, 0, &[0x1F, 0]);
    bench.run(500);
    bench.drive.plant_mut().displace(-1_000);
    bench.run(50);
    let shown = bench.read(NODE, 0x35C5, 1) as i32;
    assert!(shown.abs().abs_diff(1_000) <= 10, "{shown}");
    let mut bench = Bench::node("s200", NODE);
    bench.write(NODE, 0x3604, 1, &(-2_000_i32).to_le_bytes());
    number(&mut bench, 0x3606, 1, 2_000);
    // As its manual has it they count once they are stored and the drive has started anew.
    bench.write(NODE, 0x1010, 1, b"save");
    bench.send(&Frame::data_frame(0, &[129, NODE]));
    bench.run(200);
    bench.write(NODE, 0x6060, 0, &[1]);
    number(&mut bench, 0x6081, 0, 20_000);
    bench.enable(NODE);
    number(&mut bench, 0x607A, 0, 9_000);
    bench.write(NODE, 0x6040, 0, &[0x1F, 0]);
    bench.run(2_000);
    assert_eq!(position(&mut bench), 2_000);
}

/// The converter of a Nanotec has 10 bits, and a PDO carries them; supply and temperature are beside it.
#[test]
fn the_nanotec_reads_its_analogue_input() {
    let mut bench = Bench::node("nanotec", NODE);
    number(&mut bench, 0x1803, 1, 0xC000_0484);
    bench.write(NODE, 0x1A03, 0, &[0]);
    number(&mut bench, 0x1A03, 1, 0x6401_0110);
    bench.write(NODE, 0x1A03, 0, &[1]);
    bench.write(NODE, 0x1803, 2, &[1]);
    number(&mut bench, 0x1803, 1, 0x4000_0484);
    bench.send(&Frame::data_frame(0, &[1, NODE]));
    for (level, shown) in [(4_092_u16, 1_023_u16), (2_048, 512), (0, 0)] {
        bench.drive.plant_mut().analogue = level;
        bench.run(50);
        assert_eq!(bench.read(NODE, 0x6401, 1) as u16, shown);
        assert_eq!(bench.read(NODE, 0x2003, 3) as u16, shown);
        bench.sent.clear();
        bench.send(&Frame::data_frame(0x080, &[]));
        let frame = bench.next(0x484, 20).expect("TPDO 4");
        assert_eq!(frame.payload(), shown.to_le_bytes());
    }
    assert_eq!(bench.read(NODE, 0x2003, 1), 250, "tenths of a degree");
    assert_eq!(bench.read(NODE, 0x2003, 2), 240, "tenths of a volt");
    bench.drive.plant_mut().auxiliary_voltage = 5_100;
    bench.run(50);
    assert_eq!(bench.read(NODE, 0x2003, 4), 51, "that of the electronics");
}

/// A home switch that bounces for 10 ms is one edge if 2008h is longer, and more without; another input that bounces meanwhile changes
/// nothing of that, and is debounced too.
#[test]
fn the_nanotec_debounces_its_home_switch() {
    for (time, bounces) in [(20_u8, false), (0, true)] {
        let bouncing = |edge| Some(Switch::from(edge).bouncing(Duration::from_ticks(10_000)));
        let mut bench = on(
            "nanotec",
            Track {
                probes: [bouncing(505), bouncing(500)],
                ..Track::default()
            },
        );
        bench.write(NODE, 0x2008, 0, &[time]);
        bench.write(NODE, 0x6060, 0, &[1]);
        bench.enable(NODE);
        begin(&mut bench, 1_000, 1_000, 10_000);
        let (mut edges, mut before) = ([0, 0], [0, 0]);
        for _ in 0..1_500 {
            bench.run(1);
            let word = bench.drive.object(0x60FD, 0).unwrap();
            let now = [word[0] >> 2 & 1, word[2] >> 5 & 1];
            for (count, (now, before)) in edges.iter_mut().zip(now.iter().zip(before)) {
                *count += u32::from(*now != before);
            }
            before = now;
        }
        assert_eq!(before, [1, 1]);
        assert_eq!(edges.map(|count| count > 1), [bounces; 2], "{edges:?}");
    }
}

/// A bit of 60FEh:2 that has no output voids the whole mask.
#[test]
fn the_nanotec_discards_a_mask_with_bits_of_no_output() {
    let mut bench = Bench::node("nanotec", NODE);
    number(&mut bench, 0x60FE, 2, 0x0002_0000);
    for mask in [0x0001_0001_u32, 0x000F_0000, 0x8001_0000] {
        let [a, b, c, d] = mask.to_le_bytes();
        let answer = bench.sdo(NODE, [0x23, 0xFE, 0x60, 2, a, b, c, d]);
        assert_eq!(answer[0], 0x80, "{mask:08X}h");
        assert_eq!(bench.read(NODE, 0x60FE, 2), 0x0002_0000);
    }
}

/// Another mode is taken when the brake of a Nanotec has opened.
#[test]
fn the_nanotec_changes_no_mode_while_its_brake_opens() {
    let mut bench = Bench::node("nanotec", NODE);
    bench.write(NODE, 0x2007, 2, &300_u16.to_le_bytes());
    bench.write(NODE, 0x6060, 0, &[1]);
    bench.enable(NODE);
    bench.run(20);
    bench.write(NODE, 0x6060, 0, &[2]);
    bench.run(150);
    assert_eq!(bench.read(NODE, 0x6061, 0) as u8, 1);
    bench.run(200);
    assert_eq!(bench.read(NODE, 0x6061, 0) as u8, 2);
}

/// A set-point of a Nanotec is ready when the motor has stood for the swing-out time, 2004h:5.
#[test]
fn the_nanotec_is_ready_when_it_has_swung_out() {
    let times = [0_u16, 300].map(|time| {
        let mut bench = Bench::node("nanotec", NODE);
        bench.write(NODE, 0x2004, 5, &time.to_le_bytes());
        bench.write(NODE, 0x6060, 0, &[1]);
        bench.enable(NODE);
        begin(&mut bench, 1_000, 2_000, 100_000);
        bench.run(10);
        let mut passed = 0;
        while bench.read(NODE, 0x6041, 0) >> 10 & 1 == 0 {
            bench.run(5);
            passed += 5;
            assert!(passed < 5_000, "{time}");
        }
        assert_eq!(position(&mut bench), 1_000, "{time}");
        passed
    });
    assert!((280..=320).contains(&(times[1] - times[0])), "{times:?}");
}

/// 1010h stores nothing while the motor has power, and tells so.
#[test]
fn some_objects_of_the_tc1_wait_until_the_motor_is_off() {
    let mut bench = Bench::node("tc1", NODE);
    bench.write(NODE, 0x6060, 0, &[1]);
    let save = [0x23, 0x10, 0x10, 1, b's', b'a', b'v', b'e'];
    bench.enable(NODE);
    assert_eq!(
        bench.sdo(NODE, save),
        [0x80, 0x10, 0x10, 1, 0x22, 0, 0, 0x08]
    );
    bench.write(NODE, 0x6040, 0, &[0, 0]);
    bench.run(50);
    assert_eq!(bench.sdo(NODE, save)[0], 0x60);
}

mod each {
    promises! {
        stops_at_its_limit_switches: lmd s200;
        waits_for_its_brake: nanotec s200;
    }

    #[test]
    fn shows_its_inputs() {
        super::shows_its_inputs("nanotec", 6);
        super::shows_its_inputs("lmd", 4);
        super::shows_its_inputs("s200", 4);
    }
}
