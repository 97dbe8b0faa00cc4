//! `axis402 tune` against the virtual drive with a servo.

use canopen::Duration;
use master::axis402::{Node, Problem, Tuning, tune};
use master::bus::simulated::Handle;
use sim::ServoDrive;
use sim::drive::Setup;
use sim::plant::{Axis, ServoAxisData};

use master::tuning::{self, Host, Stage, Wanted};
use master::{Master, Simulated};

use crate::bench::{Bench, refusal};

/// A drive on a ready axis, with the friction of a machine.
fn on_axis(name: &str) -> (Bench, Handle<ServoDrive>) {
    let data = ServoAxisData::named(name).unwrap().at_work();
    let mut setup = Setup::with_node_id(1, 4);
    setup.axis = Some(Axis::servo(&data));
    let mut bench = Bench::new();
    let drive = bench.attach(ServoDrive::new(setup));
    bench.master.run_for(Duration::from_ticks(10_000));
    (bench, drive)
}

/// What it must leave as it was: mode, controlword, orders of the measurement, scope, motor data and gains.
const KEPT: [(u16, u8); 17] = [
    (0x6060, 0),
    (0x6081, 0),
    (0x6083, 0),
    (0x607A, 0),
    (0x20C0, 1),
    (0x20C0, 2),
    (0x20C0, 4),
    (0x20D0, 4),
    (0x20D0, 5),
    (0x20D0, 6),
    (0x20D1, 1),
    (0x20D1, 2),
    (0x20D1, 3),
    (0x20C2, 1),
    (0x20C2, 5),
    (0x60F9, 1),
    (0x60FB, 1),
];

fn kept(bench: &mut Bench) -> Vec<Vec<u8>> {
    let read = |(index, sub)| bench.master.read(4, index, sub).unwrap();
    KEPT.into_iter().map(read).collect()
}

/// A number of the one object that `--json` prints.
fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn a_motor_is_measured_and_nothing_is_written() {
    let (mut bench, _) = on_axis("servo_100w");
    let node = bench.meet(4);
    assert_eq!(node.sheet.title(), "servo.eds", "it needs no file");
    let before = kept(&mut bench);
    let folder = tempfile::tempdir().unwrap();
    let (plot, step) = (
        folder.path().join("plot.svg"),
        folder.path().join("step.svg"),
    );
    let wanted = Tuning {
        current: Some(700),
        bandwidth: Some(500),
        json: true,
        plot: Some(plot.clone()),
        step: Some(step.clone()),
        ..Tuning::default()
    };
    let told = bench.told(|master, console| tune(master, &node, &wanted, console));
    assert_eq!(kept(&mut bench), before);
    assert!(bench.progress.contains("nothing is written") || bench.progress.contains("moves"));
    let statusword: u16 = bench.master.read(4, 0x6041, 0).unwrap();
    assert_eq!(statusword & 0x6F, 0x21, "the power stage is off");

    let found = json(&told);
    let number = |name: &str| found[name].as_f64().unwrap();
    assert!((number("resistance") / 0.6 - 1.0).abs() < 0.03);
    assert!((number("flux") / 13.33e-3 - 1.0).abs() < 0.04);
    assert_eq!(number("pole_pairs"), 4.0);
    assert_eq!(found["gains"][0], 500);
    assert_eq!(found["is_written"], false);
    for (picture, word) in [(plot, "frequency in Hz"), (step, "position demand")] {
        let drawn = std::fs::read_to_string(picture).unwrap();
        assert!(drawn.contains("<svg") && drawn.contains(word));
    }
    let step = found["step"].as_array().unwrap();
    let last = step.last().unwrap();
    assert_eq!(last[1], 100);
    // The friction of the machine is nothing that the drive goes by.
    assert!((last[2].as_i64().unwrap() - 100).abs() <= 15, "{last}");
    // The response is that of an inertia.
    let points = found["response"].as_array().unwrap();
    assert_eq!(points.len(), 40);
    let middle = points
        .iter()
        .filter(|point| (20.0..150.0).contains(&point["frequency"].as_f64().unwrap()));
    let mut count = 0;
    for point in middle {
        let value = |name: &str| point[name].as_f64().unwrap();
        let omega = std::f64::consts::TAU * value("frequency");
        let inertia = 1.0 / (omega * value("amplitude"));
        let known = f64::from(ServoAxisData::named("servo_100w").unwrap().motor().inertia);
        // Dry friction takes its share of the torque, in step with the speed.
        let share = inertia / known;
        assert!((0.95..1.35).contains(&share), "{point}: {share}");
        assert!((-95.0..-50.0).contains(&value("phase")), "{point}");
        count += 1;
    }
    assert!(count > 20);
}

#[test]
fn what_was_found_is_written_when_that_is_asked_for() {
    let (mut bench, _) = on_axis("nema17");
    let node = bench.meet(4);
    // The drive goes by a motor that is not the one it has.
    bench.master.write(4, 0x20C2, 5, 40_000_u32).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let wanted = Tuning {
        is_short: true,
        writes: true,
        step: Some(folder.path().join("step.svg")),
        ..Tuning::default()
    };
    let told = bench.told(|master, console| tune(master, &node, &wanted, console));
    assert!(told.contains("pole pairs         50"), "{told}");
    assert!(
        bench.progress.contains("axis402 save 4"),
        "{}",
        bench.progress
    );
    let inertia: u32 = bench.master.read(4, 0x20C2, 5).unwrap();
    let known = ServoAxisData::named("nema17").unwrap().motor().inertia * 1e9;
    assert!(
        (f64::from(inertia) / f64::from(known) - 1.0).abs() < 0.2,
        "{inertia}"
    );
    let resistance: u32 = bench.master.read(4, 0x20C2, 1).unwrap();
    assert!((1_600_000..1_700_000).contains(&resistance), "{resistance}");
    let gain: u16 = bench.master.read(4, 0x60F9, 1).unwrap();
    assert_eq!(gain, 600);
}

#[test]
fn what_cannot_be_measured_is_told_and_the_motor_has_no_power_then() {
    let (mut bench, drive) = on_axis("servo_100w");
    let node = bench.meet(4);
    let before = kept(&mut bench);
    let servo = bench
        .master
        .bus_mut()
        .station_mut(drive)
        .plant_mut()
        .servo_mut()
        .unwrap();
    servo.plant_mut().sensor_faults.encoder_is_cut = true;
    let wanted = Tuning::default();
    let result = bench.run(|master, console| tune(master, &node, &wanted, console));
    let (line, code) = refusal(result);
    assert!(line.contains("the encoder does not see"), "{line}");
    assert_eq!(code, 1);
    assert_eq!(kept(&mut bench), before);
    let statusword: u16 = bench.master.read(4, 0x6041, 0).unwrap();
    assert_eq!(statusword & 0x6F, 0x21);

    // A drive that somebody moves is left alone.
    for controlword in [0x06_u16, 0x07, 0x0F] {
        bench.master.write(4, 0x6040, 0, controlword).unwrap();
        bench.master.run_for(Duration::from_ticks(20_000));
    }
    let result = bench.run(|master, console| tune(master, &node, &wanted, console));
    assert!(refusal(result).0.contains("power stage is on"));

    // One without a servo has nothing to measure.
    let (mut bench, _) = Bench::with_drives(&[7]);
    let node = bench.meet(7);
    let result = bench.run(|master, console| tune(master, &node, &wanted, console));
    assert!(refusal(result).0.contains("20C1h is missing"));
}

/// The plant of the axis.
fn plant(bench: &mut Bench, drive: Handle<ServoDrive>) -> &mut sim::plant::Plant {
    bench.master.bus_mut().station_mut(drive).plant_mut()
}

#[test]
fn every_ready_axis_is_measured() {
    for data in sim::plant::AXES {
        let (mut bench, _) = on_axis(data.name);
        let node = bench.meet(4);
        let wanted = Tuning {
            is_short: true,
            json: true,
            ..Tuning::default()
        };
        let found = json(&bench.told(|master, console| tune(master, &node, &wanted, console)));
        let plant = data.at_work().plant;
        let (motor, load) = (plant.motor, plant.load);
        let inertia = motor.inertia + load.inertia;
        let friction = motor.coulomb_friction + load.coulomb_friction;
        for (name, known, bound) in [
            ("resistance", motor.resistance, 0.01),
            ("inductance_along", motor.inductance_d, 0.01),
            ("inductance_across", motor.inductance_q, 0.01),
            ("flux", motor.flux, 0.03),
            ("pole_pairs", f64::from(motor.pole_pairs), 0.0),
            ("inertia", inertia, 0.15),
            ("friction", friction, 0.2),
        ] {
            let away = found[name].as_f64().unwrap() / known - 1.0;
            assert!(away.abs() <= bound, "{}: {name} {away:.3}", data.name);
        }
        let angle = found["angle"].as_f64().unwrap();
        assert!((angle + 180.0).rem_euclid(360.0) - 180.0 < 5.0, "{angle}");
    }
}

#[test]
fn a_fault_is_told_by_its_name() {
    let (mut bench, drive) = on_axis("servo_100w");
    let node = bench.meet(4);
    plant(&mut bench, drive).supply = false;
    let begin = bench.master.now();
    let wanted = Tuning::default();
    let result = bench.run(|master, console| tune(master, &node, &wanted, console));
    let (line, code) = refusal(result);
    assert!(
        line.contains("fault 3220h, DC link voltage too low"),
        "{line}"
    );
    assert_eq!(code, 1);
    assert!(bench.master.now() - begin < Duration::from_ticks(2_000_000));

    // It is there before, and nobody waits for it to go.
    let begin = bench.master.now();
    let result = bench.run(|master, console| tune(master, &node, &wanted, console));
    assert!(refusal(result).0.contains("fault 3220h"));
    assert!(bench.master.now() - begin < Duration::from_ticks(1_000_000));
}

/// Does something at the first pause of a stage.
struct Disturbs<'a> {
    bench: &'a mut Bench,
    stage: Stage,
    is_at: bool,
    happens: &'a mut dyn FnMut(&mut Bench) -> Result<(), Problem>,
}

impl Host for Disturbs<'_> {
    type Line = Simulated;

    fn master(&mut self) -> &mut Master<Simulated> {
        &mut self.bench.master
    }

    fn pause(&mut self, span: Duration) -> Result<(), Problem> {
        if std::mem::take(&mut self.is_at) {
            (self.happens)(self.bench)?;
        }
        Ok(self.bench.master.wait(span)?)
    }

    fn at(&mut self, stage: Stage) {
        self.is_at = stage == self.stage;
    }
}

fn disturbed(
    bench: &mut Bench,
    node: &Node,
    stage: Stage,
    happens: &mut dyn FnMut(&mut Bench) -> Result<(), Problem>,
) -> Result<tuning::Found, Problem> {
    let mut host = Disturbs {
        bench,
        stage,
        is_at: false,
        happens,
    };
    let wanted = Wanted {
        motor: true,
        ..Wanted::default()
    };
    tuning::tune(&mut host, node, &wanted)
}

#[test]
fn what_happens_while_it_measures_ends_it_without_power() {
    for (stage, what, words) in [
        (
            Stage::Winding,
            "bus",
            "fault 3220h, DC link voltage too low",
        ),
        (
            Stage::Strokes,
            "bus",
            "fault 3220h, DC link voltage too low",
        ),
        (Stage::Field, "encoder", "the encoder does not see"),
        (
            Stage::Strokes,
            "brake",
            "the current does not move the rotor",
        ),
        (Stage::Field, "brake", "the encoder does not see"),
    ] {
        let (mut bench, drive) = on_axis("servo_100w");
        let node = bench.meet(4);
        let before = kept(&mut bench);
        let mut happens = |bench: &mut Bench| {
            let plant = plant(bench, drive);
            match what {
                "bus" => plant.supply = false,
                "brake" => plant.servo_mut().unwrap().plant_mut().load_brake = 20.0,
                _ => {
                    let motor = plant.servo_mut().unwrap().plant_mut();
                    motor.sensor_faults.encoder_is_cut = true;
                }
            }
            Ok(())
        };
        let (line, _) = refusal(disturbed(&mut bench, &node, stage, &mut happens));
        assert!(line.contains(words), "{stage:?} {what}: {line}");
        assert_eq!(kept(&mut bench), before);
        bench.master.run_for(Duration::from_ticks(100_000));
        let servo = plant(&mut bench, drive).servo_mut().unwrap();
        let current = servo.plant().phase_currents();
        assert!(current.iter().all(|ampere| *ampere == 0.0), "{current:?}");
    }
}

#[test]
fn whoever_stops_it_is_told_if_the_motor_may_have_power_still() {
    let (mut bench, _) = on_axis("nema17");
    let node = bench.meet(4);
    let result = disturbed(&mut bench, &node, Stage::Strokes, &mut |_| {
        Err(Problem::Stopped)
    });
    assert_eq!(refusal(result).1, 130);
    let statusword: u16 = bench.master.read(4, 0x6041, 0).unwrap();
    assert_eq!(statusword & 0x6F, 0x21, "the power stage is off");

    // A node that is stopped does not answer.
    let result = disturbed(&mut bench, &node, Stage::Strokes, &mut |bench| {
        bench.master.nmt(master::NmtCommand::Stop, 4);
        Err(Problem::Stopped)
    });
    let (line, code) = refusal(result);
    assert_eq!(
        line,
        "node 4 does not answer: its motor may still have power"
    );
    assert_eq!(code, 1);
}
