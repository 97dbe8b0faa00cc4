//! The plant of a servo: motor, load, power stage, supply and sensors, for the loops that drive them to be judged by.
//!
//! A permanent magnet synchronous motor of three phases or a hybrid stepper of two, in the frame of its rotor (d along the magnet, q a
//! quarter of an electrical turn ahead); amplitudes are those of a phase, so the torque has the factor m/2, with m phases:
//!
//! ```text
//! Ld did/dt = vd − R id + ωe Lq iq              T = m/2 p (ψ + (Ld − Lq) id) iq − detent
//! Lq diq/dt = vq − R iq − ωe (Ld id + ψ)        J dω/dt = T − friction − coupling
//! ```
//!
//! Time goes on in steps of [`STEP`]. Within one the electrical part is solved exactly, for a voltage that stands still beside the stator
//! and a rotor that turns evenly ([`electrical`]); the torque acts in two halves, before it and behind it, which makes the whole of second
//! order. The pulse widths act as the mean voltages that they are; there is no ripple of the modulation.
//!
//! All numbers are SI units: V, A, Ω, H, V·s, N·m, kg·m², rad, s. The same data, orders and seed give the same numbers on every machine.
#![forbid(unsafe_code)]

pub mod axes;
pub mod data;
pub mod electrical;
pub mod energy;
pub mod mechanical;
mod noise;
pub mod sensors;
mod short;
pub mod stage;
pub mod supply;

use data::{MotorData, PlantData};
use electrical::{Facing, Winding};
use energy::Energy;
use mechanical::{Bodies, Mechanics, Outside};
use noise::Noise;
use sensors::Sensors;
pub use sensors::{Readings, SensorFaults};
pub use short::Short;
use stage::Bridge;
pub use stage::Gates;
use supply::Supply;

/// A step, in seconds: 200 kHz.
pub const STEP: f64 = 5e-6;

/// Steps in a second.
const PER_STEP: f64 = 1.0 / STEP;

/// See the module.
#[derive(Clone, Debug)]
pub struct Plant {
    data: PlantData,
    winding: Winding,
    bodies: Bodies,
    mechanics: Mechanics,
    pose: Pose,
    supply: Supply,
    sensors: Sensors,
    noise: Noise,
    energy: Energy,
    steps: u64,
    /// What the gates of the power stage are told.
    pub gates: Gates,
    /// What acts on the load from outside, against positive motion, in N·m.
    pub load_torque: f64,
    /// What brakes the load from outside, as dry friction does, in N·m.
    pub load_brake: f64,
    /// The brake chopper burns what the bus has too much of.
    pub chopper: bool,
    /// The supply feeds the bus.
    pub is_fed: bool,
    /// The wire of this phase is cut; it carries no current.
    pub cut_phase: Option<usize>,
    /// A wire touches the negative side of the bus.
    pub short: Option<Short>,
    /// What is wrong with the sensors.
    pub sensor_faults: SensorFaults,
}

/// What the angle of the rotor makes, worked out once for each.
#[derive(Clone, Copy, Debug)]
struct Pose {
    facing: Facing,
    /// The torque of the detents, in N·m.
    detent: f64,
}

impl Pose {
    fn at(motor: &MotorData, angle: f64) -> Self {
        Self {
            facing: Facing::at(angle * f64::from(motor.pole_pairs)),
            detent: motor.detent_torque(angle),
        }
    }
}

impl Plant {
    /// At rest at angle 0, no current, the bus at the voltage of its supply, the power stage off.
    pub fn new(data: PlantData, seed: u64) -> Self {
        Self {
            winding: Winding::new(&data.motor),
            bodies: Bodies::new(&data),
            mechanics: Mechanics::default(),
            pose: Pose::at(&data.motor, 0.0),
            supply: Supply::new(&data.supply),
            sensors: Sensors::new(&data.sensors, 0.0),
            noise: Noise::new(seed),
            energy: Energy::default(),
            steps: 0,
            gates: Gates::Off,
            load_torque: 0.0,
            load_brake: 0.0,
            chopper: false,
            is_fed: true,
            cut_phase: None,
            short: None,
            sensor_faults: SensorFaults::default(),
            data,
        }
    }

    /// The same, with its rotor at this angle and with this velocity, in rad and rad/s, and the load with it.
    pub fn turning(mut self, angle: f64, velocity: f64) -> Self {
        self.mechanics = Mechanics::turning(angle, velocity);
        self.pose = Pose::at(&self.data.motor, angle);
        self.sensors = Sensors::new(&self.data.sensors, angle);
        self
    }

    /// Goes on by a step.
    pub fn step(&mut self) {
        let outside = Outside {
            torque: self.load_torque,
            brake: self.load_brake,
        };
        let before = self.torque();
        self.mechanics
            .kick(&self.bodies, outside, before, &mut self.energy);

        let start = self.pose.facing;
        let speed = self.mechanics.velocity * f64::from(self.data.motor.pole_pairs);
        let bridge = Bridge::new(&self.data, self.gates, self.supply.voltage);
        let voltage = bridge.voltage(&self.data.motor, &self.winding, start, speed);
        let work = self
            .winding
            .turn(&self.data.motor, voltage, start, speed, STEP);
        self.mechanics.drift(STEP);
        self.pose = Pose::at(&self.data.motor, self.mechanics.angle);
        let end = self.pose.facing;
        bridge.block(&self.data.motor, &mut self.winding, voltage, end);
        if let Some(phase) = self.cut_phase {
            self.winding.cut(&self.data.motor, phase, end);
        }
        self.energy.electrical += work.input;
        self.energy.copper += work.copper;
        let mut drawn = work.input * PER_STEP;
        if let Some(short) = &mut self.short {
            let currents = self.winding.phases(&self.data.motor, end);
            let voltage = bridge.of_wire(self.data.motor.phases, short.phase, currents);
            drawn += short.go_on(voltage, STEP) / STEP;
        }
        self.energy.supplied += self.supply.go_on(drawn, self.chopper, self.is_fed);

        let after = self.torque();
        self.mechanics
            .kick(&self.bodies, outside, after, &mut self.energy);
        self.steps += 1;
        let mut phases = self.winding.phases(&self.data.motor, end);
        if let Some(short) = self.short {
            phases[short.phase] += short.current();
        }
        self.sensors
            .look(&self.data.sensors, phases, self.mechanics.angle);
    }

    /// Goes on for so many steps.
    pub fn run(&mut self, steps: u32) {
        for _ in 0..steps {
            self.step();
        }
    }

    /// Seconds since the start.
    pub fn time(&self) -> f64 {
        self.steps as f64 * STEP
    }

    /// What the sensors say now. Each call is a measurement with a noise of its own.
    pub fn measure(&mut self) -> Readings {
        let (motor, sensors) = (&self.data.motor, &self.data.sensors);
        let angle = self.mechanics.angle;
        let faults = &self.sensor_faults;
        let mut readings =
            self.sensors
                .measure(sensors, motor.pole_pairs, angle, faults, &mut self.noise);
        readings.bus_voltage = self.supply.voltage;
        readings
    }

    /// What the plant is made of.
    pub fn data(&self) -> &PlantData {
        &self.data
    }

    /// The motor.
    pub fn motor(&self) -> &MotorData {
        &self.data.motor
    }

    /// The angle of the rotor in rad, turns counted on.
    pub fn angle(&self) -> f64 {
        self.mechanics.angle
    }

    /// The same in electrical rad.
    pub fn electrical_angle(&self) -> f64 {
        self.mechanics.angle * f64::from(self.data.motor.pole_pairs)
    }

    /// The velocity of the rotor, in rad/s.
    pub fn velocity(&self) -> f64 {
        self.mechanics.velocity
    }

    /// The angle of the load, in rad; that of the rotor if the coupling is rigid.
    pub fn load_angle(&self) -> f64 {
        match self.data.coupling {
            Some(_) => self.mechanics.load_angle,
            None => self.mechanics.angle,
        }
    }

    /// The current in d and q, in A.
    pub fn current(&self) -> [f64; 2] {
        self.winding.current
    }

    /// The true currents of the phases, in A. The third of a motor of two is 0.
    pub fn phase_currents(&self) -> [f64; 3] {
        self.winding.phases(&self.data.motor, self.pose.facing)
    }

    /// The torque of current and detents, in N·m.
    pub fn torque(&self) -> f64 {
        let motor = &self.data.motor;
        motor.torque(self.winding.current) + self.pose.detent
    }

    /// The voltage of the bus, in V.
    pub fn bus_voltage(&self) -> f64 {
        self.supply.voltage
    }

    /// Something from outside charges the bus to this voltage at once, in V.
    pub fn charge_bus(&mut self, voltage: f64) {
        self.supply.voltage = voltage;
    }

    /// Where the energy has gone since the start.
    pub fn energy(&self) -> Energy {
        let mut energy = self.energy;
        let (motor, mechanics) = (&self.data.motor, &self.mechanics);
        energy.magnetic = motor.magnetic_energy(self.winding.current);
        energy.detent = motor.detent_energy(mechanics.angle);
        energy.kinetic = mechanics.kinetic_energy(&self.data);
        energy.spring = mechanics.spring_energy(self.data.coupling.as_ref());
        energy
    }
}
