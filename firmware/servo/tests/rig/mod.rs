//! The loops at a motor of the plant, as a board would run them: a sample in the middle of the pulses, its widths half a period later.

#![allow(dead_code, reason = "each test file uses its own part of it")]

use servo::current_loop::{CurrentConfig, Sample, Trip};
use servo::feedback::{Incremental, Observer};
use servo::modulation::{Modulation, shares};
use servo::transform::Rotor;
use servo::{Angle, CurrentLoop, Motor, Wiring};
use servo_plant::data::{Phases, PlantData};
use servo_plant::{Gates, Plant};

/// A period of the modulation, in s.
pub const PERIOD: f32 = 50e-6;

/// Steps of the plant in half a period.
pub const HALF: u32 = 5;

/// The data of a motor of the plant, as the loops have them.
pub fn motor(data: &PlantData, rated: f32, peak: f32) -> Motor {
    let motor = &data.motor;
    Motor {
        wiring: match motor.phases {
            Phases::Two => Wiring::TwoPhase,
            Phases::Three => Wiring::ThreePhase,
        },
        pole_pairs: motor.pole_pairs,
        resistance: motor.resistance as f32,
        inductance_d: motor.inductance_d as f32,
        inductance_q: motor.inductance_q as f32,
        flux: motor.flux as f32,
        rated_current: rated,
        peak_current: peak,
        inertia: (motor.inertia + data.load.inertia) as f32,
        counts: data.sensors.counts,
    }
}

/// The stage of the plant, with its dead time given back.
pub fn modulation(data: &PlantData, wiring: Wiring) -> Modulation {
    let stage = &data.stage;
    let dead = (stage.dead_time / stage.period) as f32;
    Modulation::new(wiring, dead, stage.ripple as f32, 0.96).unwrap()
}

/// A motor that is driven by its current.
pub struct Rig {
    pub plant: Plant,
    pub motor: Motor,
    pub current: CurrentLoop,
    pub encoder: Incremental,
    pub observer: Observer,
    /// The loop is told the true angle and speed.
    pub is_told: bool,
    pub tripped: Option<Trip>,
}

impl Rig {
    /// With the commutation found.
    pub fn new(plant: Plant, motor: Motor, config: CurrentConfig) -> Self {
        let data = plant.data();
        let current = CurrentLoop::new(&motor, config, modulation(data, motor.wiring)).unwrap();
        let mut plant = plant.clone();
        let timer = plant.measure().count as u16;
        let mut encoder = Incremental::new(&motor, timer, 2);
        let angle = plant.electrical_angle();
        encoder.set_angle(turned(angle));
        let mut observer = Observer::new(2_000.0, PERIOD).unwrap();
        observer.stand_at(turned(angle));
        Self {
            plant,
            motor,
            current,
            encoder,
            observer,
            is_told: false,
            tripped: None,
        }
    }

    /// The middle of the pulses: what is measured.
    pub fn sense(&mut self) -> Sample {
        let readings = self.plant.measure();
        self.encoder.look(readings.count as u16);
        self.observer.look(self.encoder.angle());
        let (angle, turn) = if self.is_told {
            let speed = self.plant.velocity() * f64::from(self.motor.pole_pairs);
            let turn = self.current.turned_in_period(speed as f32);
            (turned(self.plant.electrical_angle()), turn)
        } else {
            (self.observer.angle(), self.observer.turn())
        };
        Sample {
            currents: readings.currents.map(|current| current as f32),
            bus: readings.bus_voltage as f32,
            angle,
            turn,
        }
    }

    /// What comes of it: half a period with the widths of before, half with those for this current.
    pub fn act(&mut self, sample: &Sample, demand: Rotor) {
        let widths = self.current.run(sample, demand);
        self.plant.run(HALF);
        self.plant.gates = match widths {
            Ok(widths) => Gates::On(shares(self.motor.wiring, widths).map(f64::from)),
            Err(_) => Gates::Off,
        };
        self.tripped = widths.err();
        self.plant.run(HALF);
    }

    /// A period.
    pub fn period(&mut self, demand: Rotor) {
        let sample = self.sense();
        self.act(&sample, demand);
    }

    pub fn periods(&mut self, count: u32, demand: Rotor) {
        for _ in 0..count {
            self.period(demand);
        }
    }
}

/// An angle in rad.
pub fn turned(radians: f64) -> Angle {
    let turns = (radians / core::f64::consts::TAU).rem_euclid(1.0);
    Angle::from_bits((turns * 4_294_967_296.0) as u32)
}
