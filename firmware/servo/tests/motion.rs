//! Position and velocity loops at motors of the plant: cyclic set-points, disturbances, blocked rotors, lost phases.

mod rig;

use std::f64::consts::TAU;

use proptest::prelude::*;
use rig::{PERIOD, Rig, motor};
use servo::cascade::{Actual, Demand, Gains, Limits};
use servo::current_loop::CurrentConfig;
use servo::filter::Filter;
use servo::protection::{Blocked, Bus, PhaseLoss, Thermal};
use servo::transform::Rotor;
use servo::{Cascade, Motor};
use servo_plant::Plant;
use servo_plant::axes::{NEMA23, SERVO_100W, SERVO_400W};
use servo_plant::data::PlantData;

const BUS: (f32, f32) = (10.0, 60.0);

/// Periods of the current loop in one of the control.
const PERIODS: u32 = 5;

/// A control period in s: 4 kHz.
const CONTROL: f32 = PERIODS as f32 * PERIOD;

/// A rig with the loops above it.
struct Servo {
    rig: Rig,
    cascade: Cascade,
    limits: Limits,
    current: f32,
}

impl Servo {
    fn new(data: &PlantData, known: Motor, bandwidth: f32) -> Self {
        let config = CurrentConfig::quick(&known, PERIOD, 2.5 * known.peak_current, BUS);
        let mut rig = Rig::new(Plant::new(*data, 1), known, config);
        rig.observer = servo::feedback::Observer::new(3_000.0, PERIOD).unwrap();
        let gains = Gains::from_bandwidth(bandwidth);
        let friction = data.motor.coulomb_friction as f32 / known.torque_constant();
        let cascade = Cascade::new(&known, gains, friction, CONTROL).unwrap();
        Self {
            rig,
            cascade,
            limits: Limits::both(known.peak_current),
            current: 0.0,
        }
    }

    fn actual(&self) -> Actual {
        let pole_pairs = f32::from(self.rig.motor.pole_pairs);
        Actual {
            position: self.rig.encoder.position(),
            velocity: self.rig.observer.speed() / pole_pairs,
        }
    }

    /// A control period; its loops come with the first of its samples.
    fn run(&mut self, demand: &Demand) {
        let sample = self.rig.sense();
        self.current = self.cascade.run(demand, self.actual(), self.limits);
        let current = Rotor {
            d: 0.0,
            q: self.current,
        };
        self.rig.act(&sample, current);
        self.rig.periods(PERIODS - 1, current);
    }

    /// For so long along a motion, position in turns with its two derivatives by the time; gives the greatest error behind the first fifth, in counts.
    fn follow(&mut self, seconds: f64, motion: impl Fn(f64) -> [f64; 3]) -> f64 {
        let counts = f64::from(self.rig.motor.counts);
        let control = f64::from(CONTROL);
        let periods = (seconds / control) as u32;
        let mut worst = 0.0_f64;
        for period in 0..periods {
            let time = f64::from(period) * control;
            let [turns, velocity, _] = motion(time);
            let [_, _, acceleration] = motion(time + control / 2.0);
            let whole = (turns * counts).floor();
            let away = (self.rig.plant.angle() / TAU - turns) * counts;
            if period > periods / 5 {
                worst = worst.max(away.abs());
            }
            self.run(&Demand {
                position: Some(whole as i64),
                part: (turns * counts - whole) as f32,
                velocity: (velocity * TAU) as f32,
                acceleration: (acceleration * TAU) as f32,
                current: 0.0,
            });
        }
        worst
    }
}

fn sine(time: f64) -> [f64; 3] {
    let speed = TAU * 10.0;
    let (sine, cosine) = (speed * time).sin_cos();
    // A tenth of a turn, beginning at rest.
    [
        0.1 * (1.0 - cosine),
        0.1 * speed * sine,
        0.1 * speed * speed * cosine,
    ]
}

/// A turn in 0.2 s, at rest at both ends.
fn quintic(time: f64) -> [f64; 3] {
    let t = (time / 0.2).min(1.0);
    [
        t * t * t * (10.0 - 15.0 * t + 6.0 * t * t),
        30.0 * t * t * (1.0 - t) * (1.0 - t) / 0.2,
        60.0 * t * (1.0 - t) * (1.0 - 2.0 * t) / 0.04,
    ]
}

fn ideal(data: &PlantData) -> PlantData {
    let mut data = *data;
    data.motor.detent = 0.0;
    data.motor.coulomb_friction = 0.0;
    data
}

fn servo_100w() -> Motor {
    motor(&SERVO_100W, 4.0, 12.0)
}

#[test]
fn a_motion_is_followed_within_two_counts() {
    for (name, motion) in [
        ("sine of 10 Hz", sine as fn(f64) -> [f64; 3]),
        ("quintic", quintic),
    ] {
        let mut servo = Servo::new(&ideal(&SERVO_100W), servo_100w(), 800.0);
        let away = servo.follow(0.4, motion);
        println!("{name}: {away:.2} counts ideal");
        assert!(away <= 2.0, "{name}: {away}");
        // As it is, and told only.
        let mut noisy = SERVO_100W;
        noisy.sensors.current_noise = 0.05;
        noisy.sensors.count_noise = 0.3;
        for (what, data, inertia) in [
            ("cogging and friction", SERVO_100W, 1.0),
            ("and noise", noisy, 1.0),
            ("and 30 % more inertia", noisy, 1.3),
            ("and 30 % less inertia", noisy, 0.7),
        ] {
            let mut data = data;
            data.load.inertia *= inertia;
            data.motor.inertia *= inertia;
            let away = Servo::new(&data, servo_100w(), 800.0).follow(0.4, motion);
            println!("{name}: {away:.2} counts with {what}");
            assert!(away <= 5.0, "{name} with {what}: {away}");
        }
    }
}

/// Half the peak torque at once: back within 2 counts in 50 ms.
#[test]
fn a_disturbance_is_taken_out_in_50_ms() {
    let known = servo_100w();
    let mut servo = Servo::new(&ideal(&SERVO_100W), known, 800.0);
    let stand = |_: f64| [0.0, 0.0, 0.0];
    servo.follow(0.05, stand);
    servo.rig.plant.load_torque = f64::from(known.torque_constant() * known.peak_current) / 2.0;
    servo.follow(0.05, stand);
    let worst = servo.follow(0.05, stand);
    println!("{worst:.2} counts away after 50 ms");
    let max = servo.follow(0.1, stand);
    assert!(worst <= 2.0 && max <= 2.0, "{worst} {max}");
}

/// From a held velocity to a torque to a position: the current goes on where it was.
#[test]
fn a_loop_takes_over_without_a_bump() {
    let mut servo = Servo::new(&SERVO_100W, servo_100w(), 500.0);
    let velocity = Demand {
        velocity: 50.0,
        ..Demand::default()
    };
    servo.rig.plant.load_torque = 0.2;
    (0..800).for_each(|_| servo.run(&velocity));
    let before = servo.current;
    assert!(before > 2.0);
    // With position errors and gains of any size.
    for (position, gains) in [(300, 500.0), (-2_000, 200.0), (40, 900.0)] {
        let actual = servo.actual();
        let demand = Demand {
            position: Some(actual.position + position),
            velocity: 50.0,
            ..Demand::default()
        };
        let mut cascade = servo.cascade;
        cascade.take_over(before, &demand, actual);
        let after = cascade.run(&demand, actual, servo.limits);
        assert!(
            (after - before).abs() < 1.0,
            "{position}: {before} to {after}"
        );
        cascade.set_gains(Gains::from_bandwidth(gains)).unwrap();
        let switched = cascade.run(&demand, actual, servo.limits);
        assert!(
            (switched - after).abs() < 1.5,
            "{gains}: {after} to {switched}"
        );
    }
}

/// A motor that brakes a great inertia: without a limit of the braking the bus is beyond its bound, with it and without a chopper it is not.
#[test]
fn braking_leaves_the_bus_below_its_bound() {
    let run = |is_limited: bool| {
        let mut data = SERVO_400W;
        data.load.inertia = 3e-4;
        data.motor.detent = 0.0;
        let known = motor(&data, 17.0, 40.0);
        let mut servo = Servo::new(&data, known, 300.0);
        let mut bus = Bus::new(49.0, 49.5, 56.0).unwrap();
        let mut highest = 0.0_f64;
        for period in 0..6_000 {
            let velocity = if period < 2_000 { 200.0 } else { 0.0 };
            let voltage = servo.rig.plant.bus_voltage();
            bus.run(voltage as f32);
            let braking = if is_limited {
                bus.braking(voltage as f32)
            } else {
                1.0
            };
            servo.limits = Limits {
                positive: 40.0,
                negative: 40.0 * braking,
            };
            servo.run(&Demand {
                velocity,
                ..Demand::default()
            });
            highest = highest.max(servo.rig.plant.bus_voltage());
            if let Some(trip) = servo.rig.tripped {
                println!("{trip:?} at {period}, {highest} V");
                return f64::INFINITY;
            }
        }
        highest
    };
    assert!(run(false) > 60.0, "the bus trips");
    let held = run(true);
    assert!(held < 59.0, "{held}");
}

#[test]
fn a_rotor_that_is_held_is_found_blocked_within_its_current() {
    let known = servo_100w();
    let mut data = SERVO_100W;
    data.load.coulomb_friction = 2.0;
    let mut servo = Servo::new(&data, known, 500.0);
    let mut blocked = Blocked::new(1.0, 0.2, CONTROL).unwrap();
    let mut thermal = Thermal::new(4.0, 12.0, 0.1, CONTROL).unwrap();
    let demand = Demand {
        velocity: 100.0,
        ..Demand::default()
    };
    let mut found = None;
    for period in 0..8_000 {
        servo.run(&demand);
        let allowed = thermal.run(servo.rig.current.current().square());
        servo.limits = Limits::both(allowed);
        let is_pushed = servo.current.abs() > known.rated_current;
        if blocked.run(is_pushed, servo.actual().velocity) && found.is_none() {
            found = Some(period);
        }
        let size = servo.rig.plant.current().map(|part| part * part);
        assert!((size[0] + size[1]).sqrt() < 13.5);
    }
    let found = found.expect("it is blocked");
    assert!((799..1_600).contains(&found), "{found}");
    assert!(servo.limits.positive < 4.2, "the heat has taken the rest");
}

#[test]
fn a_phase_that_is_cut_is_found_and_no_other() {
    for data in [NEMA23, SERVO_100W] {
        let known = motor(&data, 4.0, 6.0);
        for cut in 0..known.wiring.phases() {
            let mut servo = Servo::new(&data, known, 200.0);
            let mut loss = PhaseLoss::new(known.wiring, 0.2, 0.02, CONTROL).unwrap();
            servo.rig.plant.load_torque = f64::from(known.torque_constant());
            let mut found = None;
            for period in 0..4_000 {
                servo.rig.plant.cut_phase = (period >= 2_000).then_some(cut);
                servo.run(&Demand {
                    velocity: 10.0,
                    ..Demand::default()
                });
                let angle = servo.rig.observer.angle().sine_cosine();
                let asked = servo
                    .rig
                    .current
                    .demand()
                    .beside_stator(angle)
                    .phases(known.wiring);
                let currents = servo
                    .rig
                    .plant
                    .phase_currents()
                    .map(|current| current as f32);
                let lost = loss.run(asked, currents);
                assert!(period >= 2_000 || lost.is_none(), "at {period}: {lost:?}");
                if lost.is_some() {
                    found = lost;
                    break;
                }
            }
            assert_eq!(found, Some(cut), "{:?}", known.wiring);
        }
    }
}

fn any_number() -> impl Strategy<Value = f32> {
    prop_oneof![
        any::<u32>().prop_map(f32::from_bits),
        -100.0..100.0_f32,
        Just(f32::NAN)
    ]
}

proptest! {
    /// With any gains, filters, errors and limits a current is one, within its limits.
    #[test]
    fn no_number_gets_through_the_cascade(
        gains in prop::array::uniform3(0.0..1e4_f32),
        other in prop::array::uniform3(any_number()),
        filters in prop::array::uniform4(any_number()),
        limits in prop::array::uniform2(any_number()),
        runs in prop::collection::vec((prop::array::uniform5(any_number()), any::<i64>(), any::<i64>()), 1..50),
    ) {
        let of = |[position, velocity, integral]: [f32; 3]| Gains { position, velocity, integral };
        let [a, b, c, d] = filters;
        let low_pass = Filter::low_pass(a, b, CONTROL).unwrap_or(Filter::low_pass(300.0, 0.7, CONTROL).unwrap());
        let notch = Filter::notch(c, d, CONTROL).unwrap_or(Filter::notch(500.0, 3.0, CONTROL).unwrap());
        let mut cascade = Cascade::new(&servo_100w(), of(gains), 0.1, CONTROL).unwrap();
        cascade.set_filters(low_pass, notch, 0.0);
        let is_taken = cascade.set_gains(of(other)).is_ok();
        prop_assert_eq!(is_taken, other.iter().all(|gain| (0.0..=1e4).contains(gain)));
        let [positive, negative] = limits;
        for (at, ([part, velocity, acceleration, current, seen], wanted, position)) in runs.into_iter().enumerate() {
            let demand = Demand { position: Some(wanted), part, velocity, acceleration, current };
            let actual = Actual { position, velocity: seen };
            if at % 7 == 3 {
                cascade.take_over(current, &demand, actual);
            }
            let asked = cascade.run(&demand, actual, Limits { positive, negative });
            prop_assert!(asked <= positive.max(0.0) && asked >= -negative.max(0.0), "{}", asked);
        }
    }
}
