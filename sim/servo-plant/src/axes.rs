//! Motors of common sizes, each with a load of its own inertia, a supply that suits it, and ideal sensors.

use crate::data::{LoadData, MotorData, Phases, PlantData, SensorData, StageData, SupplyData};

/// A stage at 20 kHz with half a microsecond of dead time.
const STAGE: StageData = StageData {
    dead_time: 0.5e-6,
    period: 50e-6,
    ripple: 0.1,
};

const fn supply(voltage: f64) -> SupplyData {
    SupplyData {
        voltage,
        resistance: 0.1,
        capacitance: 1e-3,
        chopper: 4.7,
    }
}

/// A plant with a load of the inertia of its rotor.
const fn plant(motor: MotorData, voltage: f64, counts: u32) -> PlantData {
    PlantData {
        motor,
        load: LoadData {
            inertia: motor.inertia,
            coulomb_friction: 0.0,
            viscous_friction: 0.0,
        },
        coupling: None,
        stage: STAGE,
        supply: supply(voltage),
        sensors: SensorData::ideal(counts),
    }
}

/// A stepper of 42 mm: 200 full steps, 1.7 A, 0.44 N·m with both phases on, at 24 V.
pub const NEMA17: PlantData = plant(
    MotorData {
        phases: Phases::Two,
        pole_pairs: 50,
        resistance: 1.65,
        inductance_d: 3.2e-3,
        inductance_q: 3.2e-3,
        flux: 3.66e-3,
        detent: 0.015,
        detent_periods: 200,
        inertia: 5.4e-6,
        coulomb_friction: 0.004,
        viscous_friction: 2e-5,
    },
    24.0,
    4_096,
);

/// A stepper of 57 mm: 200 full steps, 4.2 A, 1.26 N·m with both phases on, at 36 V.
pub const NEMA23: PlantData = plant(
    MotorData {
        phases: Phases::Two,
        pole_pairs: 50,
        resistance: 0.4,
        inductance_d: 1.2e-3,
        inductance_q: 1.2e-3,
        flux: 4.24e-3,
        detent: 0.04,
        detent_periods: 200,
        inertia: 30e-6,
        coulomb_friction: 0.01,
        viscous_friction: 5e-5,
    },
    36.0,
    4_096,
);

/// A servo motor of 40 mm: 100 W, 0.32 N·m at 4 A, 3,000 turns/min, at 48 V.
pub const SERVO_100W: PlantData = plant(
    MotorData {
        phases: Phases::Three,
        pole_pairs: 4,
        resistance: 0.6,
        inductance_d: 0.8e-3,
        inductance_q: 0.8e-3,
        flux: 13.33e-3,
        detent: 0.003,
        detent_periods: 24,
        inertia: 4.8e-6,
        coulomb_friction: 0.003,
        viscous_friction: 5e-6,
    },
    48.0,
    10_000,
);

/// A servo motor of 60 mm: 400 W, 1.27 N·m at 17 A, 3,000 turns/min, at 48 V; slightly salient.
pub const SERVO_400W: PlantData = plant(
    MotorData {
        phases: Phases::Three,
        pole_pairs: 4,
        resistance: 0.12,
        inductance_d: 0.20e-3,
        inductance_q: 0.24e-3,
        flux: 12.5e-3,
        detent: 0.01,
        detent_periods: 24,
        inertia: 28e-6,
        coulomb_friction: 0.01,
        viscous_friction: 2e-5,
    },
    48.0,
    10_000,
);

/// All of them by name.
pub const ALL: [(&str, PlantData); 4] = [
    ("nema17", NEMA17),
    ("nema23", NEMA23),
    ("servo_100w", SERVO_100W),
    ("servo_400w", SERVO_400W),
];
