//! What the plant must do where the equations have a closed form, and whether no energy comes from nowhere.

use servo_plant::axes::{self, NEMA17, SERVO_100W, SERVO_400W};
use servo_plant::data::{Coupling, LoadData, MotorData, Phases, PlantData};
use servo_plant::electrical::{Facing, to_phases};
use servo_plant::{Gates, Plant, STEP};

/// The bus stays as it is, nothing rubs, and the dead time is none.
fn ideal(data: PlantData) -> PlantData {
    let mut data = data;
    data.stage.dead_time = 0.0;
    data.supply.resistance = 1e-6;
    data.supply.capacitance = 1e3;
    data.motor.detent = 0.0;
    data.motor.coulomb_friction = 0.0;
    data.motor.viscous_friction = 0.0;
    data
}

/// The gates that give a voltage in d and q, turned on by half a step's motion.
fn gates(plant: &Plant, voltage: [f64; 2]) -> Gates {
    let speed = plant.velocity() * f64::from(plant.motor().pole_pairs);
    let angle = plant.electrical_angle() + speed * STEP / 2.0;
    let phases = to_phases(plant.motor().phases, Facing::at(angle).to_stator(voltage));
    let middle = match plant.motor().phases {
        Phases::Two => 0.0,
        Phases::Three => 0.5,
    };
    Gates::On(phases.map(|volts| middle + volts / plant.bus_voltage()))
}

fn run(plant: &mut Plant, voltage: [f64; 2], seconds: f64) {
    for _ in 0..(seconds / STEP).round() as u32 {
        plant.gates = gates(plant, voltage);
        plant.step();
    }
}

fn close(is: f64, to: f64, part: f64) {
    let away = (is - to).abs();
    assert!(away <= part * to.abs(), "{is} is not {to}: {away} away");
}

/// With a rotor that cannot turn: V/R (1 − e^(−tR/L)), to the last digits, however long a step is beside the time constant.
#[test]
fn a_current_rises_with_the_time_constant_of_its_axis() {
    for data in [NEMA17, SERVO_400W] {
        let mut data = ideal(data);
        data.motor.inertia = 1e12;
        for (axis, inductance) in [(0, data.motor.inductance_d), (1, data.motor.inductance_q)] {
            for shorter in [1.0, 1e3] {
                let inductance = inductance / shorter;
                let mut data = data;
                data.motor.inductance_d /= shorter;
                data.motor.inductance_q /= shorter;
                let mut plant = Plant::new(data, 1);
                let mut voltage = [0.0; 2];
                voltage[axis] = 1.0;
                for _ in 0..200 {
                    run(&mut plant, voltage, STEP);
                    let resistance = data.motor.resistance;
                    let tau = inductance / resistance;
                    let wanted = (1.0 - (-plant.time() / tau).exp()) / resistance;
                    close(plant.current()[axis], wanted, 1e-9);
                    assert!(plant.current()[1 - axis].abs() < 1e-9);
                }
            }
        }
    }
}

/// m/2 p ψ V/R.
#[test]
fn a_motor_that_is_held_has_its_stall_torque() {
    for (name, data) in axes::ALL {
        let mut data = ideal(data);
        data.motor.inertia = 1e12;
        let mut plant = Plant::new(data, 1);
        run(&mut plant, [0.0, 5.0], 0.1);
        let phases = data.motor.phases.count() as f64;
        let constant = phases / 2.0 * f64::from(data.motor.pole_pairs) * data.motor.flux;
        let wanted = constant * 5.0 / data.motor.resistance;
        close(plant.torque(), wanted, 1e-9);
        println!("{name}: {wanted} N·m");
    }
}

/// Where the voltage of the magnet is that of the terminals: V/(p ψ).
#[test]
fn a_motor_without_load_comes_to_its_no_load_speed() {
    for (_, data) in axes::ALL {
        let data = ideal(data);
        let mut plant = Plant::new(data, 1);
        run(&mut plant, [0.0, 5.0], 2.0);
        let wanted = 5.0 / (f64::from(data.motor.pole_pairs) * data.motor.flux);
        close(plant.velocity(), wanted, 1e-4);
        assert!(plant.current()[1].abs() < 0.05, "nothing holds it");
    }
}

/// With its current pressed in, the rotor speeds up by T/J; then by viscous friction alone it fades with J/b.
#[test]
fn what_turns_has_its_inertia_and_friction() {
    let mut data = ideal(SERVO_100W);
    data.motor.viscous_friction = 1e-4;
    let inertia = data.motor.inertia + data.load.inertia;
    let mut plant = Plant::new(data, 1).turning(0.0, 100.0);
    plant.run(10_000);
    close(
        plant.velocity(),
        100.0 * (-plant.time() * 1e-4 / inertia).exp(),
        1e-9,
    );
    // Dry friction: evenly, down to a standstill, which holds.
    data.motor.viscous_friction = 0.0;
    data.motor.coulomb_friction = 0.01;
    let mut plant = Plant::new(data, 1).turning(0.0, 10.0);
    let time = 10.0 * inertia / 0.01;
    plant.run((time / 2.0 / STEP) as u32);
    close(plant.velocity(), 5.0, 1e-3);
    plant.load_torque = -0.009;
    plant.run(100_000);
    assert_eq!(
        plant.velocity(),
        0.0,
        "less than the friction moves nothing"
    );
    plant.load_torque = -0.011;
    plant.run(1_000);
    close(plant.velocity(), 0.001 / inertia * 1_000.0 * STEP, 1e-3);
}

/// A light rotor on a coupling swings against its load with √(k/J), J as of both in series.
#[test]
fn a_coupling_swings_with_its_own_frequency() {
    let mut data = ideal(SERVO_100W);
    data.coupling = Some(Coupling {
        stiffness: 20.0,
        damping: 0.0,
        backlash: 0.0,
    });
    data.load = LoadData {
        inertia: 20e-6,
        ..LoadData::default()
    };
    let reduced = 1.0 / (1.0 / data.motor.inertia + 1.0 / data.load.inertia);
    let mut plant = Plant::new(data, 1);
    plant.load_torque = 0.5;
    plant.run(20);
    plant.load_torque = 0.0;
    let mut crossings = Vec::new();
    let mut before = 0.0;
    for _ in 0..200_000 {
        plant.step();
        let twist = plant.angle() - plant.load_angle();
        if before < 0.0 && twist >= 0.0 {
            crossings.push(plant.time());
        }
        before = twist;
    }
    let periods = crossings.len() - 1;
    let period = (crossings[periods] - crossings[0]) / periods as f64;
    close(
        period,
        std::f64::consts::TAU / (20.0 / reduced).sqrt(),
        1e-4,
    );
}

#[test]
fn a_backlash_is_crossed_without_a_torque() {
    let mut data = ideal(SERVO_100W);
    let coupling = Coupling {
        stiffness: 100.0,
        damping: 0.01,
        backlash: 0.02,
    };
    data.coupling = Some(coupling);
    data.load.coulomb_friction = 0.05;
    let mut plant = Plant::new(data, 1);
    while plant.angle() < 0.01 {
        assert_eq!(plant.load_angle(), 0.0);
        run(&mut plant, [0.0, 1.0], STEP);
    }
    let free = plant.velocity();
    let torque = plant.motor().torque(plant.current());
    assert!(torque * plant.time() / data.motor.inertia >= free);
    run(&mut plant, [0.0, 1.0], 0.02);
    let twist = plant.angle() - plant.load_angle();
    assert!((0.01..0.012).contains(&twist), "it pulls the load: {twist}");
}

/// Through a start, a reversal under load and a stop by the diodes, with everything that can take energy.
#[test]
fn no_energy_comes_from_nowhere() {
    for (name, data) in axes::ALL {
        for coupling in [
            None,
            Some(Coupling {
                stiffness: 50.0,
                damping: 0.002,
                backlash: 0.01,
            }),
        ] {
            let mut data = data;
            data.coupling = coupling;
            data.load.coulomb_friction = 0.005;
            let mut plant = Plant::new(data, 1);
            let volts = if data.motor.phases == Phases::Two {
                10.0
            } else {
                15.0
            };
            run(&mut plant, [-1.0, volts], 0.05);
            plant.load_torque = 0.05;
            run(&mut plant, [1.0, -volts], 0.05);
            let energy = plant.energy();
            let part = energy.missing() / energy.electrical.abs();
            assert!(part.abs() < 2e-3, "{name}: {part} of {energy:?}");
        }
    }
}

/// What the supply gives is what the motor takes, the capacitor keeps, and its own resistance does not burn.
#[test]
fn the_bus_rises_when_the_motor_brakes_and_the_chopper_holds_it() {
    let run_down = |chops: bool| {
        let mut data = SERVO_400W;
        data.load.inertia = 5e-4;
        let mut plant = Plant::new(data, 1).turning(0.0, 250.0);
        let mut highest = 0.0_f64;
        for _ in 0..40_000 {
            plant.chopper = chops && plant.bus_voltage() > 52.0;
            plant.gates = gates(&plant, [0.0, plant.velocity() * 4.0 * 12.5e-3 - 1.5]);
            plant.step();
            highest = highest.max(plant.bus_voltage());
        }
        highest
    };
    assert!(run_down(false) > 60.0, "it has nowhere to go");
    let held = run_down(true);
    assert!((52.0..52.5).contains(&held), "{held}");
}

/// ½ C V² is what the motor gave, where the supply takes nothing.
#[test]
fn the_capacitor_keeps_what_the_motor_gives() {
    let mut data = SERVO_400W;
    data.load.inertia = 5e-4;
    let mut plant = Plant::new(data, 1).turning(0.0, 250.0);
    plant.is_fed = false;
    let before = plant.bus_voltage();
    for _ in 0..10_000 {
        plant.gates = gates(&plant, [0.0, plant.velocity() * 4.0 * 12.5e-3 - 1.5]);
        plant.step();
    }
    let kept = 0.5e-3 * (plant.bus_voltage().powi(2) - before.powi(2));
    assert!(kept > 0.1);
    close(-plant.energy().electrical, kept, 1e-3);
}

/// Of the bus, in the direction of the current, and none where it passes zero.
#[test]
fn the_dead_time_takes_its_share_of_the_bus() {
    let mut data = ideal(SERVO_100W);
    data.motor.inertia = 1e12;
    data.stage.dead_time = 0.5e-6;
    let lost = 48.0 * 0.5e-6 / 50e-6;
    let mut plant = Plant::new(data, 1);
    // 1 A in phase A, and half of it back through B and C: the vector of the losses is 4/3 of one of them.
    run(&mut plant, [0.6 + lost * 4.0 / 3.0, 0.0], 0.1);
    close(plant.current()[0], 1.0, 1e-6);
    run(&mut plant, [0.0, 0.0], 0.1);
    assert!(plant.current()[0].abs() < 1e-6);
}

#[test]
fn a_stage_that_is_off_lets_the_current_die_and_the_motor_coast() {
    for (name, data) in axes::ALL {
        let mut plant = Plant::new(data, 1).turning(0.3, 20.0);
        run(&mut plant, [0.0, 5.0], 0.001);
        let current = plant.current()[1];
        assert!(current.abs() > 0.05, "{name}: {current}");
        plant.gates = Gates::Off;
        plant.run(400);
        assert_eq!(plant.current(), [0.0; 2], "{name}");
        assert_eq!(plant.phase_currents(), [0.0; 3], "{name}");
    }
    // So fast that the magnet overcomes the bus, it brakes.
    let mut plant = Plant::new(ideal(SERVO_100W), 1).turning(0.0, 900.0);
    plant.run(40);
    assert!(plant.current()[1] < -0.1);
    assert!(plant.energy().electrical < 0.0);
}

#[test]
fn a_phase_that_is_cut_carries_nothing() {
    for data in [NEMA17, SERVO_100W] {
        for phase in 0..data.motor.phases.count() {
            let mut plant = Plant::new(data, 1);
            plant.cut_phase = Some(phase);
            let mut max = 0.0_f64;
            for _ in 0..2_000 {
                run(&mut plant, [3.0, 4.0], STEP);
                assert!(plant.phase_currents()[phase].abs() < 1e-9);
                let others = plant.phase_currents();
                max = others.into_iter().fold(max, f64::max);
            }
            assert!(max > 0.1, "the others do: {max}");
        }
    }
}

/// A detent holds up to its peak, and gives way above it.
#[test]
fn detents_hold_the_rotor() {
    let mut data = ideal(NEMA17);
    data.motor.detent = 0.02;
    data.motor.viscous_friction = 0.01;
    for (load, moves) in [(0.0199, false), (0.0201, true)] {
        let mut plant = Plant::new(data, 1);
        for at in 0..200_000 {
            plant.load_torque = load * f64::from(at.min(100_000)) / 100_000.0;
            plant.step();
        }
        let full_step = std::f64::consts::TAU / 200.0;
        assert_eq!(plant.angle() < -full_step, moves, "{}", plant.angle());
    }
}

#[test]
fn a_salient_motor_has_a_torque_of_its_own() {
    let motor = MotorData {
        inductance_d: 1e-3,
        inductance_q: 3e-3,
        ..SERVO_400W.motor
    };
    let magnet = motor.torque([0.0, 10.0]);
    let with_reluctance = motor.torque([-5.0, 10.0]);
    close(
        with_reluctance - magnet,
        1.5 * 4.0 * 2e-3 * 5.0 * 10.0,
        1e-12,
    );
}
