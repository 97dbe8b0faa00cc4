//! The current loop at motors of the plant.

mod rig;

use proptest::prelude::*;
use rig::{PERIOD, Rig, motor};
use servo::current_loop::{CurrentConfig, Sample, Trip};
use servo::modulation::Modulation;
use servo::transform::Rotor;
use servo::{CurrentLoop, Motor};
use servo_plant::Plant;
use servo_plant::axes::{self, NEMA17, SERVO_100W, SERVO_400W};
use servo_plant::data::PlantData;

const BUS: (f32, f32) = (10.0, 60.0);

/// Rated and peak current of each axis, in A.
fn currents(name: &str) -> (f32, f32) {
    match name {
        "nema17" => (1.7, 2.4),
        "nema23" => (4.2, 6.0),
        "servo_100w" => (4.0, 12.0),
        _ => (17.0, 40.0),
    }
}

fn q(current: f32) -> Rotor {
    Rotor { d: 0.0, q: current }
}

/// With a rotor that cannot turn.
fn held(data: &PlantData) -> PlantData {
    let mut data = *data;
    data.motor.inertia = 1e12;
    data
}

/// Within 2 % in 6 periods, at most 10 % beyond, though R and L of the plant are off by 30 %.
#[test]
fn a_step_is_there_in_six_periods_with_a_motor_that_is_off_by_30_percent() {
    let mut worst = (0.0_f64, 0.0_f64);
    for (name, data) in axes::ALL {
        let (rated, peak) = currents(name);
        for resistance in [0.7, 1.0, 1.3] {
            for inductance in [0.7, 1.0, 1.3] {
                let known = motor(&data, rated, peak);
                let mut off = held(&data);
                off.motor.resistance *= resistance;
                off.motor.inductance_d *= inductance;
                off.motor.inductance_q *= inductance;
                let config = CurrentConfig::quick(&known, PERIOD, 2.0 * peak, BUS);
                let mut rig = Rig::new(Plant::new(off, 1), known, config);
                rig.is_told = true;
                rig.periods(20, q(0.0));
                // Not more than the bus has enough for.
                let step = 0.15 * f64::from(peak);
                let mut max = 0.0_f64;
                for period in 1..=40 {
                    rig.period(q(step as f32));
                    let current = rig.plant.current()[1];
                    max = max.max(current / step - 1.0);
                    if period >= 6 {
                        let away = (current / step - 1.0).abs();
                        worst.0 = worst.0.max(away);
                        assert!(
                            away <= 0.02,
                            "{name} R·{resistance} L·{inductance}: {away} after {period}"
                        );
                    }
                }
                worst.1 = worst.1.max(max);
                assert!(
                    max <= 0.1,
                    "{name} R·{resistance} L·{inductance}: {max} beyond"
                );
            }
        }
    }
    println!(
        "at most {:.1} % away after 6 periods, {:.1} % beyond",
        worst.0 * 100.0,
        worst.1 * 100.0
    );
}

/// The model of the loop knows of no delay of its sensors. One of up to a third of a period makes a step go beyond, by more the quicker the loop is; it settles all the same.
#[test]
fn a_step_with_late_and_noisy_sensors_settles() {
    for (name, data) in axes::ALL {
        let (rated, peak) = currents(name);
        // In steps of the plant of 5 µs, the share of 60F6h, and the most beyond.
        for (delay, share, beyond) in [
            (0, 0.93, 0.05),
            (1, 0.93, 0.15),
            (3, 0.93, 0.6),
            (3, 0.3, 0.05),
        ] {
            let mut late = held(&data);
            late.sensors.current_delay = delay;
            late.sensors.current_noise = 0.002 * f64::from(peak);
            let known = motor(&data, rated, peak);
            let config = CurrentConfig {
                share,
                ..CurrentConfig::quick(&known, PERIOD, 2.0 * peak, BUS)
            };
            let mut rig = Rig::new(Plant::new(late, 1), known, config);
            rig.is_told = true;
            rig.periods(20, q(0.0));
            let step = 0.15 * f64::from(peak);
            for period in 1..=200 {
                rig.period(q(step as f32));
                let off = rig.plant.current()[1] / step - 1.0;
                assert!(off < beyond, "{name}, {delay}: {off}");
                assert!(period < 20 || off.abs() < 0.05, "{name}, {delay}: {off}");
            }
        }
    }
}

/// Torque is that of the current, within 1 %, with ideal sensors, at rest and at speed, under the loop's own angle.
#[test]
fn the_torque_is_that_of_the_current() {
    for (name, mut data) in axes::ALL {
        let (rated, peak) = currents(name);
        data.motor.detent = 0.0;
        let known = motor(&data, rated, peak);
        // Not so fast that the bus has no more.
        data.load.viscous_friction = f64::from(known.rated_torque()) * 0.2 / 40.0;
        let config = CurrentConfig::quick(&known, PERIOD, 2.0 * peak, BUS);
        let mut rig = Rig::new(Plant::new(data, 1), known, config);
        for part in [0.25, 1.0, -0.5] {
            rig.plant.load_torque = f64::from(part * known.rated_torque()) * 0.8;
            rig.periods(2_000, q(part * rated));
            let periods = 2_000;
            let mut sum = 0.0;
            for _ in 0..periods {
                rig.period(q(part * rated));
                sum += rig.plant.torque();
            }
            let wanted = f64::from(part * known.rated_torque());
            let away = (sum / f64::from(periods) / wanted - 1.0).abs();
            assert!(
                away < 0.01,
                "{name} at {part}: {away}, {} rad/s",
                rig.plant.velocity()
            );
        }
    }
}

/// Nothing winds up where the bus has no more: out of it the current is there as soon as from anywhere else.
#[test]
fn a_bus_without_a_rest_winds_nothing_up() {
    let data = held(&SERVO_100W);
    let known = motor(&SERVO_100W, 4.0, 12.0);
    let config = CurrentConfig {
        max_current: 100.0,
        ..CurrentConfig::quick(&known, PERIOD, 100.0, BUS)
    };
    let mut rig = Rig::new(Plant::new(data, 1), known, config);
    rig.is_told = true;
    rig.periods(2_000, q(100.0));
    assert!(rig.plant.current()[1] < 60.0, "the bus cannot give it");
    rig.periods(12, q(40.0));
    for _ in 0..20 {
        rig.period(q(40.0));
        let away = rig.plant.current()[1] / 40.0 - 1.0;
        assert!(away.abs() < 0.02, "{away}");
    }
}

/// Without weakening the magnet leaves no voltage at this speed; with it the motor goes on.
#[test]
fn a_weak_field_takes_the_motor_beyond_the_speed_of_its_bus() {
    let reached = |weakening: f32| {
        let mut data = SERVO_400W;
        data.motor.viscous_friction = 1e-5;
        let known = motor(&data, 17.0, 40.0);
        let config = CurrentConfig {
            weakening,
            ..CurrentConfig::quick(&known, PERIOD, 80.0, BUS)
        };
        let mut rig = Rig::new(Plant::new(data, 1), known, config);
        rig.periods(10_000, q(5.0));
        let [d, q] = rig.plant.current();
        assert!(d.hypot(q) < 41.0);
        rig.plant.velocity()
    };
    let (without, with) = (reached(0.0), reached(30.0));
    assert!(with > 1.15 * without, "{without} to {with} rad/s");
}

/// A stepper has a magnet that 1.14 A take away: more would be a field again.
#[test]
fn a_field_is_weakened_to_nothing_at_most() {
    let known = motor(&NEMA17, 1.7, 2.4);
    let config = CurrentConfig {
        weakening: 2.4,
        ..CurrentConfig::quick(&known, PERIOD, 5.0, BUS)
    };
    let plant = Plant::new(held(&NEMA17), 1).turning(0.0, 250.0);
    let mut rig = Rig::new(plant, known, config);
    rig.is_told = true;
    rig.periods(400, q(2.0));
    let weakened = rig.current.weakening.current();
    assert!((1.13..1.145).contains(&weakened), "{weakened} A");
}

/// What the dead time takes bends the current where the phases pass through zero; given back it bends it a third as much.
#[test]
fn the_dead_time_does_not_bend_the_current() {
    let mut data = NEMA17;
    data.stage.dead_time = 1.5e-6;
    let known = motor(&data, 1.7, 2.4);
    let config = CurrentConfig::quick(&known, PERIOD, 5.0, BUS);
    let bent = |dead_time: f32| {
        let plant = Plant::new(held(&data), 1).turning(0.0, 10.0);
        let mut rig = Rig::new(plant, known, config);
        let modulation = Modulation::new(known.wiring, dead_time, 0.1, 0.96).unwrap();
        rig.current = CurrentLoop::new(&known, config, modulation).unwrap();
        rig.is_told = true;
        rig.periods(400, q(0.5));
        let mut worst = 0.0_f64;
        for _ in 0..2_000 {
            rig.period(q(0.5));
            let [d, q] = rig.plant.current();
            worst = worst.max(d.hypot(q - 0.5));
        }
        worst
    };
    let (taken, given_back) = (bent(0.0), bent(0.03));
    assert!(given_back < 0.4 * taken, "{taken} and {given_back} A");
}

/// With three times the inductance across the magnet a step in q at speed is there in six periods, and leaves d alone. A loop that takes the one inductance for the
/// other does not do that.
#[test]
fn a_salient_motor_keeps_d_and_q_apart() {
    let mut data = held(&SERVO_400W);
    data.motor.inductance_q = 3.0 * data.motor.inductance_d;
    data.supply.capacitance = 1e3;
    let known = Motor {
        inductance_q: data.motor.inductance_q as f32,
        ..motor(&SERVO_400W, 17.0, 40.0)
    };
    let swapped = Motor {
        inductance_d: known.inductance_q,
        inductance_q: known.inductance_d,
        ..known
    };
    // How far d and q are away, as shares of the step.
    let away = |known: Motor| {
        let config = CurrentConfig::quick(&known, PERIOD, 80.0, BUS);
        let plant = Plant::new(data, 1).turning(0.0, 200.0);
        let mut rig = Rig::new(plant, known, config);
        rig.is_told = true;
        rig.periods(40, q(0.0));
        let (mut in_d, mut in_q) = (0.0_f64, 0.0_f64);
        for period in 1..=40 {
            rig.period(q(6.0));
            let [d, q] = rig.plant.current();
            in_d = in_d.max(d.abs() / 6.0);
            if period >= 6 {
                in_q = in_q.max((q / 6.0 - 1.0).abs());
            }
        }
        (in_d, in_q)
    };
    let (in_d, in_q) = away(known);
    assert!(in_d < 0.02 && in_q < 0.02, "{in_d}, {in_q}");
    let swapped = away(swapped);
    assert!(swapped.0 > 0.3 && swapped.1 > 0.3, "{swapped:?}");
}

#[test]
fn a_current_above_the_trip_turns_the_gates_off_until_a_start() {
    let known = motor(&SERVO_100W, 4.0, 12.0);
    let config = CurrentConfig::quick(&known, PERIOD, 12.0, BUS);
    let mut rig = Rig::new(Plant::new(SERVO_100W, 1), known, config);
    let sample = |current, bus| Sample {
        currents: [current, -current, 0.0],
        bus,
        ..Sample::default()
    };
    let beside = |current| Sample {
        currents: [current, 0.0, 0.0],
        ..sample(0.0, 48.0)
    };
    // What is near a bound is not beyond it.
    let near = sample(11.9, 59.9);
    for (sample, trip) in [
        (sample(12.1, 48.0), Trip::OverCurrent),
        (sample(-12.1, 48.0), Trip::OverCurrent),
        (sample(f32::NAN, 48.0), Trip::OverCurrent),
        (beside(12.1), Trip::Short),
        (beside(-12.1), Trip::Short),
        (sample(0.0, 60.1), Trip::OverVoltage),
        (sample(0.0, f32::INFINITY), Trip::OverVoltage),
        (sample(0.0, 9.9), Trip::UnderVoltage),
        (sample(0.0, f32::NAN), Trip::UnderVoltage),
    ] {
        let good = Sample {
            bus: 48.0,
            ..Sample::default()
        };
        assert!(rig.current.run(&good, q(1.0)).is_ok());
        assert!(rig.current.run(&near, q(1.0)).is_ok());
        assert_eq!(rig.current.run(&sample, q(1.0)), Err(trip));
        assert_eq!(rig.current.run(&good, q(1.0)), Err(trip), "it stays");
        rig.current.start();
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
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// With any data that are taken, any samples and any demand: widths are widths, and what is asked for is within the limit.
    #[test]
    fn no_number_gets_through(
        data in prop::array::uniform6(any_number()),
        gains in prop::array::uniform4(0.0..1.0_f32),
        two_phase: bool,
        samples in prop::collection::vec((prop::array::uniform6(any_number()), any::<u32>()), 1..40),
    ) {
        let base = motor(&if two_phase { NEMA17 } else { SERVO_100W }, 4.0, 12.0);
        let [resistance, ld, lq, flux, max, weakening] = data;
        let chosen = Motor {
            resistance: resistance.abs(),
            inductance_d: ld.abs() * 1e-3,
            inductance_q: lq.abs() * 1e-3,
            flux: flux.abs() * 1e-3,
            ..base
        };
        let known = chosen.check().map_or(base, |()| chosen);
        let config = CurrentConfig {
            period: PERIOD * (0.2 + gains[0]),
            share: gains[1],
            learning: gains[2] / 2.0,
            max_current: max.abs(),
            trip: 1e4 * gains[3],
            bus: (1.0, 2e3),
            weakening: weakening.abs(),
        };
        let modulation = rig::modulation(&SERVO_100W, known.wiring);
        if let Ok(mut current) = CurrentLoop::new(&known, config, modulation) {
            for ([a, b, c, bus, demand_q, speed], angle) in samples {
                let sample = Sample {
                    currents: [a, b, c],
                    bus: if bus.is_nan() { 48.0 } else { bus },
                    angle: servo::Angle::from_bits(angle),
                    turn: current.turned_in_period(speed),
                };
                if let Ok(widths) = current.run(&sample, Rotor { d: c, q: demand_q }) {
                    for width in widths {
                        prop_assert!(width.abs() <= (0.96 * 32_768.0) as i16, "{}", width);
                    }
                } else {
                    current.start();
                }
                let asked = current.demand();
                prop_assert!(asked.d.hypot(asked.q) <= config.max_current * 1.000_01);
            }
        }
    }

    /// With any gains at a real motor: the current is never beyond the trip by more than the bus drives it in the half period until the gates are off.
    #[test]
    fn no_gains_take_the_current_beyond_the_trip(
        share in 0.001..1.0_f32,
        learning in 0.0..0.5_f32,
        off in prop::array::uniform3(0.1..10.0_f32),
        demands in prop::collection::vec((-50.0..50.0_f32, -50.0..50.0_f32), 8),
    ) {
        let data = SERVO_100W;
        let known = motor(&data, 4.0, 12.0);
        let wrong = Motor {
            resistance: known.resistance * off[0],
            inductance_d: known.inductance_d * off[1],
            inductance_q: known.inductance_q * off[1],
            flux: known.flux * off[2],
            ..known
        };
        let trip = 14.0;
        let config = CurrentConfig { share, learning, ..CurrentConfig::quick(&wrong, PERIOD, trip, BUS) };
        let mut rig = Rig::new(Plant::new(data, 1), wrong, config);
        // A period until the next sample and half of one until it acts, from the worst voltage and magnet together.
        let beyond = 1.5 * f64::from(PERIOD) * (48.0 * 2.0 / 3.0 + 48.0) / 0.8e-3;
        for (d, q) in demands {
            for _ in 0..60 {
                rig.period(Rotor { d, q });
                for current in rig.plant.phase_currents() {
                    prop_assert!(current.abs() <= f64::from(trip) + beyond, "{}", current);
                }
            }
        }
    }
}

/// What brakes a fast rotor takes the most voltage: where the bus has not enough for it, the current does not run away.
#[test]
fn a_rotor_that_is_braked_fast_keeps_its_current() {
    for (name, data) in axes::ALL {
        let (rated, peak) = currents(name);
        let known = motor(&data, rated, peak);
        let mut data = held(&data);
        data.supply.capacitance = 1e3;
        let bus = rig::modulation(&data, known.wiring).max_voltage(data.supply.voltage as f32);
        let magnet = f64::from(bus / (known.flux * f32::from(known.pole_pairs)));
        for speed in 1..=19 {
            for share in [0.5, 0.75, 1.0] {
                // Of the speed at which the magnet leaves nothing of the bus.
                let part = 0.05 * f64::from(speed);
                let config = CurrentConfig::quick(&known, PERIOD, 10.0 * peak, BUS);
                let plant = Plant::new(data, 1).turning(0.0, part * magnet);
                let mut rig = Rig::new(plant, known, config);
                rig.is_told = true;
                rig.periods(40, q(0.3 * peak));
                let mut max = 0.0_f64;
                for _ in 0..400 {
                    rig.period(q(-share * peak));
                    let [d, q] = rig.plant.current();
                    max = max.max(d.hypot(q) / f64::from(peak));
                }
                let what = format!("{name}, {share} of its peak at {part} of its speed");
                assert!(max < 1.25, "{what}: {max}");
                let [d, q] = rig.plant.current().map(|amperes| amperes / f64::from(peak));
                // Up to a third of the speed all of it is there, and a good part of it at each.
                let least = if part < 0.34 { 0.98 } else { 0.45 };
                assert!(-q > least * f64::from(share), "{what}: {d}, {q}");
            }
        }
    }
}

/// What drives where the bus ends has what it leaves: with d kept by it, the magnet takes no more than its own.
#[test]
fn a_rotor_that_is_driven_fast_has_what_the_bus_leaves() {
    for (name, data) in axes::ALL {
        let (rated, peak) = currents(name);
        let known = motor(&data, rated, peak);
        let bus = rig::modulation(&data, known.wiring).max_voltage(data.supply.voltage as f32);
        let magnet = f64::from(bus / (known.flux * f32::from(known.pole_pairs)));
        let config = CurrentConfig::quick(&known, PERIOD, 2.0 * peak, BUS);
        let plant = Plant::new(held(&data), 1).turning(0.0, 0.88 * magnet);
        let mut rig = Rig::new(plant, known, config);
        rig.is_told = true;
        rig.periods(400, q(peak));
        let [d, q] = rig.plant.current().map(|amperes| amperes / f64::from(peak));
        assert!(q > 0.15 && d.abs() < 0.05, "{name}: {d}, {q} of the peak");
    }
}
