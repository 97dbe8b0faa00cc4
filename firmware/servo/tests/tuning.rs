//! What the measurement finds of motors that it knows nothing of, and that it keeps its bounds.

mod rig;

use rig::{HALF, PERIOD, modulation};
use servo::current_loop::Trip;
use servo::modulation::shares;
use servo::protection::Bus;
use servo::tuning::{Failure, Measured, Seen, Setup, Step, Tuning};
use servo::{Angle, Wiring};
use servo_plant::data::{
    LoadData, MotorData, Phases, PlantData, SensorData, StageData, SupplyData,
};
use servo_plant::{Gates, Plant, axes};

/// Numbers that look like chance, the same for the same seed.
struct Chance(u64);

impl Chance {
    fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    fn bits(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn between(&mut self, least: f64, max: f64) -> f64 {
        least + (max - least) * (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Evenly on a scale of factors.
    fn scaled(&mut self, least: f64, max: f64) -> f64 {
        least * (max / least).powf(self.between(0.0, 1.0))
    }

    fn one_of(&mut self, numbers: &[u16]) -> u16 {
        numbers[(self.bits() >> 32) as usize % numbers.len()]
    }
}

/// A motor as there could be one, with what it drives.
struct Sample {
    data: PlantData,
    rated: f64,
    is_reversed: bool,
    angle: f64,
}

fn random(seed: u64) -> Sample {
    let mut chance = Chance::new(seed);
    let is_stepper = chance.bits() & 1 << 40 != 0;
    let bus = chance.between(24.0, 56.0);
    let rated = chance.scaled(0.8, 20.0);
    let (phases, pole_pairs) = if is_stepper {
        (Phases::Two, chance.one_of(&[50, 50, 50, 100]))
    } else {
        (
            Phases::Three,
            chance.one_of(&[1, 2, 3, 4, 5, 7, 8, 10, 11, 14, 20, 21]),
        )
    };
    let max = match phases {
        Phases::Two => bus,
        Phases::Three => bus / 3_f64.sqrt(),
    };
    let resistance = max / rated * chance.scaled(0.03, 0.2);
    let inductance_d = resistance * chance.scaled(0.6e-3, 4e-3);
    let fastest = if is_stepper {
        chance.scaled(60.0, 200.0)
    } else {
        chance.scaled(150.0, 600.0)
    };
    let flux = max / (f64::from(pole_pairs) * fastest);
    let gear = phases.count() as f64 / 2.0 * f64::from(pole_pairs);
    let torque = gear * flux * rated;
    let inertia = torque / chance.scaled(2_000.0, 40_000.0);
    let share = chance.between(0.2, 1.0);
    let friction = torque * chance.between(0.01, 0.12);
    let (detent, detent_periods) = if is_stepper {
        (chance.between(0.0, 0.05), 4 * u32::from(pole_pairs))
    } else {
        (chance.between(0.0, 0.015), 6 * u32::from(pole_pairs))
    };
    let data = PlantData {
        motor: MotorData {
            phases,
            pole_pairs,
            resistance,
            inductance_d,
            // With more of it the rotor would not turn to a field of the rated current.
            inductance_q: inductance_d
                + (inductance_d * chance.between(0.0, 0.4)).min(0.3 * flux / rated),
            flux,
            detent: detent * torque,
            detent_periods,
            inertia: inertia * share,
            coulomb_friction: friction,
            viscous_friction: 0.02 * torque / fastest,
        },
        load: LoadData {
            inertia: inertia * (1.0 - share),
            coulomb_friction: 0.0,
            viscous_friction: 0.0,
        },
        coupling: None,
        stage: StageData {
            dead_time: chance.between(0.2e-6, 1e-6),
            period: 50e-6,
            ripple: 0.05 * rated,
        },
        supply: SupplyData {
            voltage: bus,
            resistance: 0.02,
            capacitance: 4e-3,
            chopper: 4.7,
        },
        sensors: SensorData {
            current_noise: 0.002 * rated,
            ..SensorData::ideal(u32::from(
                chance.one_of(&[4_000, 4_096, 8_192, 10_000, 16_384]),
            ))
        },
    };
    Sample {
        data,
        rated,
        is_reversed: chance.bits() & 1 << 33 != 0,
        angle: chance.between(-3.0, 3.0),
    }
}

fn setup(data: &PlantData, current: f64, rated: f64) -> Setup {
    let wiring = match data.motor.phases {
        Phases::Two => Wiring::TwoPhase,
        Phases::Three => Wiring::ThreePhase,
    };
    Setup {
        wiring,
        counts: data.sensors.counts,
        period: PERIOD,
        current: current as f32,
        trip: 2.0 * rated as f32,
        bus: (
            0.6 * data.supply.voltage as f32,
            1.25 * data.supply.voltage as f32,
        ),
        modulation: modulation(data, wiring),
        distance: 0.5,
        max_speed: 400.0,
    }
}

/// What was seen on the way.
#[derive(Debug, Default)]
struct Way {
    /// The greatest current of a phase, in A.
    current: f64,
    /// How far the rotor was from where it began, in turns.
    turns: f64,
    seconds: f64,
}

/// Lets the measurement run, `disturb` being told of the time and the plant in each period.
fn tune(
    plant: &mut Plant,
    setup: Setup,
    is_reversed: bool,
    mut disturb: impl FnMut(f64, &mut Plant),
) -> (Result<Measured, Failure>, Way) {
    let mut tuning = Tuning::new(setup).unwrap();
    let begin = plant.angle();
    let voltage = plant.data().supply.voltage as f32;
    let mut bus = Bus::new(1.03 * voltage, 1.05 * voltage, 1.2 * voltage).unwrap();
    let mut way = Way::default();
    loop {
        disturb(way.seconds, plant);
        let readings = plant.measure();
        plant.chopper = bus.run(readings.bus_voltage as f32);
        let count = readings.count as u16;
        let step = tuning.run(&Seen {
            currents: readings.currents.map(|current| current as f32),
            bus: readings.bus_voltage as f32,
            timer: if is_reversed {
                7_u16.wrapping_sub(count)
            } else {
                count
            },
        });
        let widths = match step {
            Step::Widths(widths) => widths,
            Step::Done(measured) => {
                plant.gates = Gates::Off;
                return (Ok(measured), way);
            }
            Step::Failed(failure) => {
                plant.gates = Gates::Off;
                return (Err(failure), way);
            }
        };
        plant.run(HALF);
        plant.gates = Gates::On(shares(setup.wiring, widths).map(f64::from));
        plant.run(HALF);
        for current in plant.phase_currents() {
            way.current = way.current.max(current.abs());
        }
        let turns = (plant.angle() - begin) / std::f64::consts::TAU;
        way.turns = way.turns.max(turns.abs());
        way.seconds += f64::from(PERIOD);
        assert!(way.seconds < 30.0, "it ends");
    }
}

fn ratio(found: f32, true_value: f64) -> f64 {
    f64::from(found) / true_value - 1.0
}

/// What is wrong with what was found, if anything.
fn mistakes(sample: &Sample, plant: &Plant, begin: i64, found: &Measured) -> Vec<String> {
    let motor = &sample.data.motor;
    let torque = motor.torque_constant() * sample.rated;
    let mut wrong = Vec::new();
    let mut within = |what: &str, away: f64, bound: f64| {
        if away.is_nan() || away.abs() > bound {
            wrong.push(format!("{what} {:.1} %", 100.0 * away));
        }
    };
    within("R", ratio(found.resistance, motor.resistance), 0.04);
    within("Ld", ratio(found.inductance_d, motor.inductance_d), 0.1);
    within("Lq", ratio(found.inductance_q, motor.inductance_q), 0.1);
    within("flux", ratio(found.flux, motor.flux), 0.04);
    let inertia = motor.inertia + sample.data.load.inertia;
    let friction = motor.coulomb_friction / torque;
    // Detents that outweigh the friction are large beside the strokes.
    let is_notchy = motor.phases == Phases::Two && motor.detent > 2.0 * motor.coulomb_friction;
    let (bound, of_friction) = if is_notchy { (0.3, 0.04) } else { (0.2, 0.03) };
    // Of very many motors a few in a thousand are beyond it (docs/servo.md).
    let is_soak = std::env::var_os("AXIS402_SOAK_MOTORS").is_some();
    let bound = if is_soak { 0.3 } else { bound };
    within("J", ratio(found.inertia, inertia), bound);
    within(
        "friction",
        f64::from(found.friction) / torque - friction,
        of_friction + 0.15 * friction,
    );
    // Where the rotor is now by what was found, against where it is.
    let moved = plant.clone().measure().count - begin;
    let counts = f64::from(sample.data.sensors.counts);
    let turns = moved as f64 * f64::from(motor.pole_pairs) / counts;
    let turned = Angle::from_turns(turns.rem_euclid(1.0) as f32).plus(found.angle);
    let away = turned.minus(rig::turned(plant.electrical_angle())).turns();
    within("angle", f64::from(away), 10.0 / 360.0);
    if found.pole_pairs != motor.pole_pairs {
        wrong.push(format!("pole pairs {}", found.pole_pairs));
    }
    if found.is_reversed != sample.is_reversed {
        wrong.push("direction".to_string());
    }
    wrong
}

fn measure_random(seeds: impl IntoIterator<Item = u64>) {
    measure_all(seeds.into_iter().map(|seed| (seed, random(seed))));
}

/// Measures these motors; tells of each that is not within its bounds.
fn measure_all(samples: impl Iterator<Item = (u64, Sample)>) {
    let mut wrong = Vec::new();
    for (seed, sample) in samples {
        let bad = measure(&sample, seed);
        if !bad.is_empty() {
            let pole_pairs = sample.data.motor.pole_pairs;
            wrong.push(format!("{seed} ({pole_pairs} pole pairs): {bad}"));
        }
    }
    let count = wrong.len();
    assert!(wrong.is_empty(), "{count} of them\n{}", wrong.join("\n"));
}

/// Measures a motor; tells what is not within its bounds.
fn measure(sample: &Sample, seed: u64) -> String {
    let mut plant = Plant::new(sample.data, seed).turning(sample.angle, 0.0);
    let begin = plant.measure().count;
    let setup = setup(&sample.data, sample.rated, sample.rated);
    let (found, way) = tune(&mut plant, setup, sample.is_reversed, |_, _| {});
    let mut bad = match &found {
        Ok(found) => mistakes(sample, &plant, begin, found),
        Err(failure) => vec![format!("{failure:?}")],
    };
    // A rotor that friction has held against the field, half an electrical turn away, jumps as the field turns on.
    if way.current > 1.35 * sample.rated {
        bad.push(format!("{:.2} of the current", way.current / sample.rated));
    }
    let electrical = 1.0 / f64::from(sample.data.motor.pole_pairs);
    if way.turns > 0.1 + 2.25 * electrical + 0.6 {
        bad.push(format!("{:.2} turns", way.turns));
    }
    bad.join(", ")
}

/// A half of the random motors: `AXIS402_SOAK_MOTORS` of them from the seed `AXIS402_SOAK_SEED` on, or 200 from 1 on.
fn half(which: u64) -> std::ops::Range<u64> {
    let wanted = |name: &str, otherwise: u64| {
        std::env::var(name).map_or(otherwise, |text| text.parse().unwrap())
    };
    let first = wanted("AXIS402_SOAK_SEED", 1);
    let half = wanted("AXIS402_SOAK_MOTORS", 200).div_ceil(2);
    first + which * half..first + (which + 1) * half
}

#[test]
fn random_motors_are_measured_1_of_2() {
    measure_random(half(0));
}

#[test]
fn random_motors_are_measured_2_of_2() {
    measure_random(half(1));
}

impl Sample {
    fn rated_torque(&self) -> f64 {
        self.data.motor.torque_constant() * self.rated
    }

    /// The rated current gives it this acceleration in rad/s².
    fn accelerated_by(mut self, acceleration: f64) -> Self {
        let inertia = self.data.motor.inertia + self.data.load.inertia;
        let by = self.rated_torque() / (acceleration * inertia);
        self.data.motor.inertia *= by;
        self.data.load.inertia *= by;
        self
    }

    /// At one of the edges of what can be measured.
    fn at_edge(mut self, which: u64) -> Self {
        let torque = self.rated_torque();
        let motor = &mut self.data.motor;
        match which % 7 {
            0 => self.data.sensors.counts = 2_000,
            1 => self.data.sensors.counts = 65_536,
            2 => motor.coulomb_friction = 0.12 * torque,
            3 if motor.phases == Phases::Two => motor.detent = 0.05 * torque,
            3 => motor.detent = 0.015 * torque,
            4 => motor.inductance_q = motor.inductance_d + 0.3 * motor.flux / self.rated,
            5 => return self.accelerated_by(1_000.0),
            _ => return self.accelerated_by(30_000.0),
        }
        self
    }
}

#[test]
fn motors_at_the_edges_are_measured() {
    let half = half(0);
    let count = (half.end - half.start).div_ceil(4);
    measure_all((half.start..half.start + count).map(|seed| (seed, random(seed).at_edge(seed))));
}

#[test]
fn motors_that_once_failed_are_measured() {
    // 20 pole pairs that swing at 30 Hz: the field went one turn in place of two, too fast for them, and they came to rest beyond it.
    measure_random([229]);
    // One pole pair that swings at 12 Hz for seconds: its resistance was looked at for half a swing.
    measure_random([812]);
    // Steppers whose detent torque is more than twice their friction.
    measure_random([261, 567]);
    // Half an electrical turn away from the first field, and held there by friction.
    measure_random([1081]);
    // Rotors without a load: fast enough before current and observer had settled, so there was no flux.
    let light = |seed| (seed, random(seed).accelerated_by(100_000.0));
    measure_all([3, 18, 53].map(light).into_iter());
}

/// The measurement of the 100 W servo, with something that happens.
fn disturbed(disturb: impl FnMut(f64, &mut Plant)) -> (Result<Measured, Failure>, Way) {
    let data = axes::SERVO_100W;
    let mut plant = Plant::new(data, 1).turning(0.3, 0.0);
    tune(&mut plant, setup(&data, 3.2, 4.0), false, disturb)
}

#[test]
fn what_cannot_be_measured_is_told() {
    let (found, way) = disturbed(|_, plant| plant.cut_phase = Some(0));
    assert_eq!(found, Err(Failure::Winding));
    assert!(way.current < 4.0);
    let (found, _) = disturbed(|_, plant| plant.sensor_faults.encoder_is_cut = true);
    assert_eq!(found, Err(Failure::NotFollowed));
    let (found, way) = disturbed(|_, plant| plant.load_brake = 20.0);
    assert_eq!(found, Err(Failure::NotFollowed));
    assert!(way.current < 4.0 && way.turns < 0.01, "{way:?}");
    // A load that comes as the strokes begin.
    let (found, way) =
        disturbed(|time, plant| plant.load_brake = if time > 1.9 { 20.0 } else { 0.0 });
    assert_eq!(found, Err(Failure::Held));
    assert!(way.current < 4.0);
    // A rotor of one pole pair that is too heavy for the field.
    let heavy = random(10).accelerated_by(500.0);
    let mut plant = Plant::new(heavy.data, 1).turning(heavy.angle, 0.0);
    let setup = setup(&heavy.data, heavy.rated, heavy.rated);
    let (found, way) = tune(&mut plant, setup, heavy.is_reversed, |_, _| {});
    assert_eq!(found, Err(Failure::TooFar));
    assert!(way.turns < 1.6, "{way:?}");
    // An encoder of eight counts in an electrical turn.
    let mut data = axes::NEMA17;
    data.sensors.counts = 400;
    let mut plant = Plant::new(data, 1).turning(0.3, 0.0);
    let setup = self::setup(&data, 1.7, 1.7);
    let (found, _) = tune(&mut plant, setup, false, |_, _| {});
    assert_eq!(found, Err(Failure::PolePairs));
    let (found, _) = disturbed(|time, plant| plant.is_fed = time < 0.5);
    assert_eq!(found, Err(Failure::Tripped(Trip::UnderVoltage)));
}

#[test]
fn no_input_makes_a_width_that_is_none() {
    let data = axes::NEMA17;
    let mut tuning = Tuning::new(setup(&data, 1.7, 1.7)).unwrap();
    let mut chance = Chance::new(5);
    for period in 0..200_000_u32 {
        let noise = |chance: &mut Chance| chance.between(-3.0, 3.0) as f32;
        let seen = Seen {
            currents: [noise(&mut chance), noise(&mut chance), 0.0],
            bus: 24.0,
            timer: chance.bits() as u16,
        };
        match tuning.run(&seen) {
            Step::Widths(widths) => assert!(
                widths
                    .iter()
                    .all(|width| width.abs() <= (0.96 * 32_768.0) as i16)
            ),
            Step::Done(_) | Step::Failed(_) => {
                assert!(period > 0);
                tuning = Tuning::new(setup(&data, 1.7, 1.7)).unwrap();
            }
        }
    }
    for (currents, bus, trip) in [
        ([f32::NAN, 0.0, 0.0], 24.0, Trip::OverCurrent),
        ([0.0, f32::INFINITY, 0.0], 24.0, Trip::OverCurrent),
        ([0.0; 3], f32::NAN, Trip::UnderVoltage),
        ([0.0; 3], 90.0, Trip::OverVoltage),
    ] {
        let mut tuning = Tuning::new(setup(&data, 1.7, 1.7)).unwrap();
        let seen = Seen {
            currents,
            bus,
            timer: 0,
        };
        assert_eq!(tuning.run(&seen), Step::Failed(Failure::Tripped(trip)));
        let seen = Seen {
            currents: [0.0; 3],
            bus: 24.0,
            timer: 0,
        };
        assert_eq!(
            tuning.run(&seen),
            Step::Failed(Failure::Tripped(trip)),
            "it stays so"
        );
    }
}

#[test]
fn the_ready_axes_are_measured() {
    for (data, rated) in [
        (axes::NEMA17, 1.7),
        (axes::NEMA23, 4.2),
        (axes::SERVO_100W, 4.0),
        (axes::SERVO_400W, 17.0),
    ] {
        let sample = Sample {
            data,
            rated,
            is_reversed: false,
            angle: 0.3,
        };
        let mut plant = Plant::new(data, 1).turning(sample.angle, 0.0);
        let begin = plant.measure().count;
        let (found, way) = tune(
            &mut plant,
            setup(&data, 0.8 * rated, rated),
            false,
            |_, _| {},
        );
        let wrong = mistakes(&sample, &plant, begin, &found.unwrap());
        assert!(wrong.is_empty(), "{wrong:?}");
        assert!(way.current < rated, "{way:?}");
    }
}
