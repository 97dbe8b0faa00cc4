//! What the Nanotec does by its module: where its home switch is, its current for a block, three delays of its brake, its inputs and outputs.

use canopen::Frame;
use sim::plant::{Switch, Track};

use crate::bench::Bench;
use crate::steer::{NODE, begin, command, enabled, enabled_on, number, position, statusword};

/// An edge of an input shows at once, and the next one of it not before 2008h is over; other inputs do not wait for that.
#[test]
fn the_nanotec_debounces_each_input_by_itself() {
    let mut bench = enabled_on(
        "nanotec",
        1,
        Track {
            home: Some(Switch::from(520)),
            probes: [Some(Switch::within(500..=540)), None],
            ..Track::default()
        },
    );
    bench.write(NODE, 0x2008, 0, &[200]);
    begin(&mut bench, 2_000, 1_000, 100_000);
    let mut edges = [vec![], vec![]];
    let mut before = [false; 2];
    for time in 0..2_000_u32 {
        bench.run(1);
        let word = bench.drive.object(0x60FD, 0).unwrap()[2];
        let now = [word & 1 << 4 != 0, word & 1 << 2 != 0];
        for (edges, (now, before)) in edges.iter_mut().zip(now.iter().zip(before)) {
            if *now != before {
                edges.push(time);
            }
        }
        before = now;
    }
    let [of_probe, of_home] = edges;
    assert_eq!((of_probe.len(), of_home.len()), (2, 1));
    let first = of_probe[0];
    // 20 and 40 steps further at 1000 a second.
    assert!((15..=25).contains(&(of_home[0] - first)), "{of_home:?}");
    assert!((200..=203).contains(&(of_probe[1] - first)), "{of_probe:?}");
}

/// TPDO 4 carries the analogue input, and is sent by events.
fn with_analogue_pdo() -> Bench {
    let mut bench = Bench::node("nanotec", NODE);
    number(&mut bench, 0x1803, 1, 0xC000_0484);
    bench.write(NODE, 0x1A03, 0, &[0]);
    number(&mut bench, 0x1A03, 1, 0x6401_0110);
    bench.write(NODE, 0x1A03, 0, &[1]);
    bench.write(NODE, 0x1803, 2, &[255]);
    bench.write(NODE, 0x1803, 3, &[0, 0]);
    number(&mut bench, 0x1803, 1, 0x4000_0484);
    bench.send(&Frame::data_frame(0, &[1, NODE]));
    bench.run(50);
    bench
}

/// The input comes to this; whether the PDO tells of it. Whoever reads it sees it in any case.
fn tells(bench: &mut Bench, level: u16) -> bool {
    bench.sent.clear();
    bench.drive.plant_mut().analogue = level * 4;
    let frame = bench.next(0x484, 30);
    if let Some(frame) = &frame {
        assert_eq!(frame.payload(), level.to_le_bytes());
    }
    assert_eq!(bench.read(NODE, 0x6401, 1) as u16, level);
    assert_eq!(bench.next(0x484, 30), None, "{level}");
    frame.is_some()
}

/// 6423h lets a change of the analogue input send its PDO.
#[test]
fn the_analogue_input_of_the_nanotec_sends_when_it_may() {
    let mut bench = with_analogue_pdo();
    assert!(!tells(&mut bench, 100));
    bench.write(NODE, 0x6423, 0, &[1]);
    bench.run(30);
    for level in [200, 201, 0, 1_023] {
        assert!(tells(&mut bench, level), "{level}");
    }
    bench.write(NODE, 0x6423, 0, &[0]);
    assert!(!tells(&mut bench, 500));
}

/// 6424h and 6425h: outside of both, or between them where the upper one is below.
#[test]
fn the_analogue_input_of_the_nanotec_has_limits() {
    for (upper, lower, told) in [
        (800_u32, 200_u32, [false, true, false, true, true]),
        (200, 800, [true, false, true, false, false]),
    ] {
        let mut bench = with_analogue_pdo();
        number(&mut bench, 0x6424, 1, upper);
        number(&mut bench, 0x6425, 1, lower);
        bench.write(NODE, 0x6423, 0, &[1]);
        bench.run(30);
        for (level, told) in [500, 900, 300, 100, 1_000].into_iter().zip(told) {
            assert_eq!(tells(&mut bench, level), told, "{upper}: {level}");
        }
    }
}

/// 6426h to 6428h: how far it has to be from what was told last, downwards, upwards; smaller ones of a direction count for nothing.
#[test]
fn the_analogue_input_of_the_nanotec_has_deltas() {
    for (deltas, told) in [
        ([0, 0, 0], [true, true, true, true]),
        ([20, 0, 0], [false, true, false, true]),
        ([20, 120, 10], [false, true, false, false]),
        ([20, 10, 60], [false, false, false, true]),
    ] {
        let mut bench = with_analogue_pdo();
        bench.write(NODE, 0x6423, 0, &[1]);
        bench.run(30);
        assert!(tells(&mut bench, 500));
        for (index, delta) in (0x6426..).zip(deltas) {
            number(&mut bench, index, 1, delta);
        }
        let levels = [520, 530, 515, 430];
        for (level, told) in levels.into_iter().zip(told) {
            assert_eq!(tells(&mut bench, level), told, "{deltas:?}: {level}");
        }
    }
}

/// A block run has the current of 2004h:4, if there is one; other moves that of 2004h:1.
#[test]
fn the_nanotec_looks_for_a_block_with_its_own_current() {
    for (own, expected) in [(10_u8, 750), (0, 3_000)] {
        let track = Track {
            stops: Some(-1_500..=2_000),
            ..Track::default()
        };
        let mut bench = enabled_on("nanotec", 1, track);
        bench.drive.plant_mut().encoder = true;
        bench.write(NODE, 0x2004, 1, &[40]);
        bench.write(NODE, 0x2004, 4, &[own]);
        begin(&mut bench, 100, 2_000, 100_000);
        bench.run(20);
        assert_eq!(bench.drive.plant_mut().current(), 3_000, "a move");
        bench.run(500);
        bench.write(NODE, 0x6060, 0, &[6]);
        number(&mut bench, 0x6099, 1, 2_000);
        number(&mut bench, 0x6099, 2, 500);
        bench.write(NODE, 0x6098, 0, &[0xFE]);
        bench.run(20);
        command(&mut bench, 0x1F);
        bench.run(300);
        assert_eq!(bench.drive.plant_mut().current(), expected, "{own}");
        bench.wait_for_status(NODE, 0x3400, 0x1400, 8_000);
        let stands = bench.drive.plant_mut().rotor();
        assert!(stands.abs_diff(2_000) <= 20, "{stands}");
        bench.write(NODE, 0x6060, 0, &[1]);
        command(&mut bench, 0x0F);
        bench.run(2);
        begin(&mut bench, -1_000, 2_000, 100_000);
        bench.run(50);
        assert_eq!(bench.drive.plant_mut().current(), 3_000, "a move again");
    }
}

/// Methods -4 to -7 look for a switch at another node, whose inputs a PDO brings to 2010h:2: -4 and -6 for one that opens.
#[test]
fn the_nanotec_homes_to_a_switch_of_another_node() {
    for (method, edge) in [(-4_i8, 1_000), (-5, 1_000), (-6, -800), (-7, -800)] {
        let mut bench = enabled("nanotec", 6);
        number(&mut bench, 0x1401, 1, 0x8000_0304);
        bench.write(NODE, 0x1601, 0, &[0]);
        number(&mut bench, 0x1601, 1, 0x2010_0208);
        bench.write(NODE, 0x1601, 0, &[1]);
        number(&mut bench, 0x1401, 1, 0x304);
        bench.write(NODE, 0x2010, 1, &[3]);
        bench.send(&Frame::data_frame(0, &[1, NODE]));
        number(&mut bench, 0x6099, 1, 2_000);
        number(&mut bench, 0x6099, 2, 200);
        bench.write(NODE, 0x2008, 0, &[0]);
        bench.write(NODE, 0x6098, 0, &method.to_le_bytes());
        let tell = |bench: &mut Bench| {
            let stands = bench.drive.plant_mut().position();
            let is_operated = if edge > 0 {
                stands >= edge
            } else {
                stands <= edge
            };
            let opens = matches!(method, -4 | -6);
            // Other inputs of the node say the contrary.
            let inputs = if is_operated != opens { 0x08 } else { 0xF7 };
            bench.send(&Frame::data_frame(0x304, &[inputs]));
        };
        tell(&mut bench);
        bench.run(20);
        command(&mut bench, 0x1F);
        let mut time = 0;
        while statusword(&mut bench) & 0x3400 != 0x1400 {
            tell(&mut bench);
            bench.run(1);
            time += 1;
            assert!(time < 10_000, "{method}");
        }
        let home = bench.drive.plant_mut().position();
        assert!(home.abs_diff(edge) <= 10, "{method}: {home}");
        assert!(position(&mut bench).abs() <= 10, "{method}");
    }
}

/// 2007h: from power to the release of the brake, from there to the first motion, from its fall to the end of power.
#[test]
fn the_brake_of_the_nanotec_has_three_delays() {
    let mut bench = Bench::node("nanotec", NODE);
    for (sub, time) in [(1, 200_u16), (2, 300), (3, 150)] {
        bench.write(NODE, 0x2007, sub, &time.to_le_bytes());
    }
    bench.write(NODE, 0x6060, 0, &[2]);
    bench.write(NODE, 0x6042, 0, &[100, 0]);
    command(&mut bench, 0x06);
    command(&mut bench, 0x0F);
    let mut times = [None; 3];
    for time in 0..800 {
        let plant = bench.drive.plant_mut();
        let now = [
            plant.is_energised(),
            plant.is_brake_open(),
            plant.position() != 0,
        ];
        for (first, is_so) in times.iter_mut().zip(now) {
            if is_so {
                first.get_or_insert(time);
            }
        }
        bench.run(1);
    }
    let [power, open, moves] = times.map(|time| time.expect("it has come"));
    assert!((199..=202).contains(&(open - power)), "{times:?}");
    assert!((299..=345).contains(&(moves - open)), "{times:?}");
    command(&mut bench, 0x10F);
    bench.run(2_000);
    command(&mut bench, 0x06);
    let (mut closed, mut time) = (None, 0);
    while bench.drive.plant_mut().is_energised() {
        if !bench.drive.plant_mut().is_brake_open() {
            closed.get_or_insert(time);
        }
        bench.run(1);
        time += 1;
        assert!(time < 2_000);
    }
    let lasted = time - closed.expect("it closes before");
    assert!((149..=152).contains(&lasted), "{lasted}");
}

/// Its outputs show what the drive does, until 60FEh:2 gives them to the master.
#[test]
fn outputs_of_the_nanotec_tell_of_the_drive() {
    let mut bench = enabled("nanotec", 1);
    let outputs = |bench: &mut Bench| bench.drive.plant_mut().outputs() & 0b111;
    begin(&mut bench, 2_000, 2_000, 100_000);
    bench.run(200);
    assert_eq!(outputs(&mut bench), 0b001, "it moves");
    bench.run(2_000);
    assert_eq!(outputs(&mut bench), 0b010, "it is there");
    // Output 2 is the master's.
    number(&mut bench, 0x60FE, 2, 0x0005_0000);
    bench.run(20);
    assert_eq!(outputs(&mut bench), 0);
    bench.drive.plant_mut().fault = Some(0x4210);
    bench.run(50);
    assert_eq!(outputs(&mut bench), 0b100, "an error");
    number(&mut bench, 0x60FE, 1, 0x0002_0000);
    bench.run(20);
    assert_eq!(outputs(&mut bench), 0b110);
}

/// Bit 4 is 1 while there is current in the motor: from switched on on, where the brake opens, until it has closed again.
#[test]
fn the_nanotec_has_current_from_switched_on_on() {
    let mut bench = Bench::node("nanotec", NODE);
    bench.write(NODE, 0x2007, 3, &150_u16.to_le_bytes());
    bench.write(NODE, 0x6060, 0, &[1]);
    let seen = |bench: &mut Bench| {
        bench.run(30);
        let shown = statusword(bench) >> 4 & 1 == 1;
        let plant = bench.drive.plant_mut();
        [
            shown,
            plant.current() != 0,
            plant.is_energised(),
            plant.is_brake_open(),
        ]
    };
    for (controlword, has_current) in [
        (0x00, false),
        (0x06, false),
        (0x07, true),
        (0x0F, true),
        (0x07, true),
    ] {
        command(&mut bench, controlword);
        assert_eq!(seen(&mut bench), [has_current; 4], "{controlword:02X}h");
    }
    command(&mut bench, 0x06);
    assert_eq!(seen(&mut bench), [true, true, true, false]);
    assert_eq!(statusword(&mut bench) & 0x6F, 0x23);
    bench.run(150);
    assert_eq!(seen(&mut bench), [false; 4]);
    assert_eq!(statusword(&mut bench) & 0x6F, 0x21);
    // What is to be quick does not wait for the brake.
    for command_now in [0x00, 0x02] {
        for controlword in [0x06, 0x07, command_now] {
            command(&mut bench, controlword);
            bench.run(30);
        }
        assert_eq!(seen(&mut bench), [false; 4]);
        assert_eq!(statusword(&mut bench) & 0x4F, 0x40);
    }
    // Nor does a reset, and neither leaves current behind it.
    for reset in [0x82, 0x81] {
        for controlword in [0x06, 0x07] {
            command(&mut bench, controlword);
            bench.run(30);
        }
        assert_eq!(seen(&mut bench), [true; 4]);
        bench.sent.clear();
        bench.send(&Frame::data_frame(0, &[reset, NODE]));
        assert!(bench.next(0x704, 500).is_some(), "it has booted");
        assert_eq!(seen(&mut bench), [false; 4]);
    }
    // A fault takes it away too.
    for controlword in [0x06, 0x07] {
        command(&mut bench, controlword);
        bench.run(30);
    }
    bench.drive.plant_mut().fault = Some(0x2310);
    assert!(!seen(&mut bench)[2]);
}
