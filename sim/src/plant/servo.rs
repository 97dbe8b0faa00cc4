//! A motor that is moved by its current: the plant of the crate [`servo_plant`], with the loops of the firmware's servo above it as a board runs them.
//!
//! Time goes on in periods of the modulation. A sample in the middle of the pulses, what the converter makes of it, the current interrupt, and its widths half a period later; the
//! control each [`CONTROL`] periods. How the loops come to know where the magnet is, [`Magnet`] says.

use std::f64::consts::TAU;

use motion::Ticks;
use runtime::servo::{
    Current, Feedback, LoopReport, Loops, Port, Request, ServoData, ServoSettings, StageData,
    error_code,
};
use servo::control::Fault;
use servo::feedback::absolute::{ENTRIES, NO_ERROR};
use servo::interrupt::Counts;
use servo::modulation::shares;
use servo::{Angle, Motor, Wiring};
use servo_plant::data::{Phases, PlantData};
use servo_plant::{Gates, Plant, axes};

use super::STEP_CLOCK_HZ;
use crate::plant::pulses::Ordered;
use cia402::{RatedMotor, ServoReport};

/// A period of the modulation, in microseconds.
const PERIOD: u64 = 50;

/// Periods of the modulation in one of the control.
const CONTROL: u8 = 5;

/// Steps of the plant in half a period.
const HALF: u32 = 5;

/// Volts of a count of the bus.
const BUS: f32 = 0.025;

/// The middle of the converter: one of 16 bits, as industrial servos have.
const MIDDLE: u16 = 32_768;

/// How the loops come to know where the magnet is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Magnet {
    /// From the beginning, and the sensors of the currents are right: nothing precedes the loops.
    #[default]
    Known,
    /// It is looked for as the power comes first.
    Searched,
    /// By Hall sensors beside the encoder.
    Hall,
    /// By the word of an absolute encoder, which is in place of the other; the table takes out that it is off its centre.
    Absolute(&'static [i32; ENTRIES]),
}

/// A ready axis: a motor of [`servo_plant::axes`], and how it is driven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ServoAxisData {
    /// Its name.
    pub name: &'static str,
    /// Motor, load, stage, supply and sensors.
    pub plant: PlantData,
    /// The peaks of a phase, in A: for ever, and for two seconds.
    pub rated_current: f32,
    /// See `rated_current`.
    pub peak_current: f32,
    /// What the stage bears for ever, in A, and how long it bears the peak, in s.
    pub stage: (f32, f32),
    /// Of the velocity loop, in rad/s.
    pub bandwidth: f32,
    /// The greatest speed, in 1/min.
    pub speed: u32,
    /// How the loops come to know where the magnet is.
    pub magnet: Magnet,
    /// Where the rotor stands at first, in rad.
    pub start: f64,
    /// The encoder of another motor is on it: the counts that it has in a turn, while the loops know those of the plant.
    pub other_counts: Option<u32>,
}

/// A ready axis of a servo motor with other sensors.
const SERVO_100W: ServoAxisData = axis("servo_100w", axes::SERVO_100W, (4.0, 12.0), 800.0, 3_000);

/// The ready axes.
pub const AXES: [ServoAxisData; 6] = [
    axis("nema17", axes::NEMA17, (1.7, 2.4), 700.0, 1_200),
    axis("nema23", axes::NEMA23, (4.2, 6.0), 700.0, 1_200),
    SERVO_100W,
    axis("servo_400w", axes::SERVO_400W, (17.0, 40.0), 500.0, 3_000),
    ServoAxisData {
        name: "servo_100w_hall",
        magnet: Magnet::Hall,
        ..SERVO_100W
    },
    ServoAxisData {
        name: "servo_100w_absolute",
        magnet: Magnet::Absolute(&NO_ERROR),
        ..SERVO_100W
    },
];

const fn axis(
    name: &'static str,
    plant: PlantData,
    (rated_current, peak_current): (f32, f32),
    bandwidth: f32,
    speed: u32,
) -> ServoAxisData {
    ServoAxisData {
        name,
        plant,
        rated_current,
        peak_current,
        stage: (peak_current, 2.0),
        bandwidth,
        speed,
        magnet: Magnet::Known,
        start: 0.0,
        other_counts: None,
    }
}

impl ServoAxisData {
    /// The axis of this name.
    pub fn named(name: &str) -> Option<Self> {
        AXES.into_iter().find(|axis| axis.name == name)
    }

    /// With a machine behind the motor, whose dry friction takes 15 % of the rated torque: a tenth of it is held, and does not run away as a
    /// motor without a load does.
    pub fn at_work(mut self) -> Self {
        self.plant.load.coulomb_friction += 0.15 * f64::from(self.motor().rated_torque());
        self
    }

    /// The motor as the loops know it.
    pub fn motor(&self) -> Motor {
        let motor = &self.plant.motor;
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
            rated_current: self.rated_current,
            peak_current: self.peak_current,
            inertia: (motor.inertia + self.plant.load.inertia) as f32,
            counts: self.plant.sensors.counts,
        }
    }

    /// Motor and stage as the loops know them.
    fn loops(&self) -> ServoData {
        let stage = &self.plant.stage;
        ServoData {
            motor: self.motor(),
            friction: self.plant.motor.coulomb_friction as f32,
            bandwidth: self.bandwidth,
            speed: self.speed,
            encoder: 0,
            feedback: match self.magnet {
                Magnet::Known | Magnet::Searched => Feedback::Incremental,
                Magnet::Hall => Feedback::Hall,
                Magnet::Absolute(table) => Feedback::Absolute {
                    bits: self.plant.sensors.bits,
                    table,
                    offset: angle(self.plant.sensors.zero * f64::from(self.plant.motor.pole_pairs)),
                },
            },
            stage: StageData {
                period: PERIOD as f32 * 1e-6,
                control: CONTROL,
                voltage: self.plant.supply.voltage as f32,
                dead_time: (stage.dead_time / stage.period) as f32,
                ripple: stage.ripple as f32,
                reach: 0.96,
                current: self.scale(),
                middle: (MIDDLE, 100),
                bus: BUS,
                bears: self.stage,
            },
        }
    }

    /// Amperes of a count.
    fn scale(&self) -> f32 {
        2.5 * self.peak_current / f32::from(MIDDLE)
    }

    /// The rated torque in mN·m, 6076h.
    pub fn rated_torque(&self) -> u32 {
        (self.motor().rated_torque() * 1e3).round() as u32
    }
}

/// The motor at work.
#[derive(Clone, Debug)]
pub struct ServoMotor {
    data: ServoAxisData,
    plant: Plant,
    rated: RatedMotor,
    current: Current,
    loops: Loops,
    /// The count of an absolute encoder at its first word.
    begun: i64,
    /// Amperes of a count.
    scale: f32,
    /// Microseconds up to which it has run, and the periods in them.
    time: u64,
    periods: u64,
}

impl ServoMotor {
    /// At rest, with an encoder at 0.
    pub fn new(data: &ServoAxisData, seed: u64) -> Self {
        let mut sensed = data.plant;
        sensed.sensors.counts = data.other_counts.unwrap_or(sensed.sensors.counts);
        let mut plant = Plant::new(sensed, seed).turning(data.start, 0.0);
        let (current, loops) = loops(data, &mut plant);
        Self {
            data: *data,
            plant,
            current,
            loops,
            begun: 0,
            rated: Port::rated(&data.motor()),
            scale: data.scale(),
            time: 0,
            periods: 0,
        }
    }

    /// The power is back: the loops know nothing, and the motor is where it was.
    pub(super) fn power_on(&mut self) {
        (self.current, self.loops) = loops(&self.data, &mut self.plant);
        self.begun = 0;
    }

    /// The motor and what is around it, to load it or to break it.
    pub fn plant_mut(&mut self) -> &mut Plant {
        &mut self.plant
    }

    /// The motor and what is around it.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// Sets the loops up.
    pub fn set_up(&mut self, settings: &ServoSettings) {
        self.loops.set_up(&mut self.current, settings);
    }

    /// Has them measure the motor.
    pub fn request(&mut self, request: Request) {
        self.loops.request(&mut self.current, request);
    }

    /// Positions in a turn, as [`Current::absolute_turn`] says it.
    pub fn absolute_turn(&self) -> u32 {
        self.current.absolute_turn()
    }

    /// The loops above the current.
    pub fn loops(&self) -> &Loops {
        &self.loops
    }

    /// What the loops report beside the actual values.
    pub fn loop_report(&mut self) -> LoopReport {
        self.loops.loop_report(&mut self.current)
    }

    /// Counts since the power came.
    pub fn moved(&self) -> i64 {
        self.current.position() - self.begun
    }

    /// The count of an absolute encoder as the power came, once it has told; 0 for others, which count from there.
    pub fn begun(&self) -> i64 {
        self.begun
    }

    /// The bus in mV.
    pub fn millivolts(&self) -> u32 {
        (self.plant.bus_voltage() * 1e3) as u32
    }

    /// Whether the loops may put current into the motor.
    pub fn energise(&mut self, on: bool) {
        self.loops.energise(&mut self.current, on);
        if !on {
            self.plant.gates = Gates::Off;
        }
    }

    /// Why the motor has no current though it is to have some, as an error code of CiA 402.
    pub fn error_code(&self) -> Option<u16> {
        self.fault().map(error_code)
    }

    fn fault(&self) -> Option<Fault> {
        self.current.fault()
    }

    /// Runs for so many microseconds. `order` was given at its moment of the step clock, of which the run begins at `begin`; its positions count from `origin` on.
    pub fn run(&mut self, span: u64, begin: Ticks, order: Option<&Ordered>, origin: i64, hot: i16) {
        let end = self.time + span;
        let start = self.time;
        self.loops.take(order.map(|ordered| ordered.order));
        while (self.periods + 1) * PERIOD <= end {
            let at = (self.periods + 1) * PERIOD;
            let ticks = begin + at.saturating_sub(start) * u64::from(STEP_CLOCK_HZ / 1_000_000);
            let since = ticks.saturating_sub(order.map_or(ticks, |ordered| ordered.at));
            self.period(since as f32 / STEP_CLOCK_HZ as f32, origin, hot);
            self.periods += 1;
        }
        self.time = end;
    }

    /// A period of the modulation, so many s after the order.
    fn period(&mut self, since: f32, origin: i64, hot: i16) {
        let readings = self.plant.measure();
        let current = |amperes: f64| {
            let counts = (amperes / f64::from(self.scale)).round() + f64::from(MIDDLE);
            counts.clamp(0.0, 65_535.0) as u16
        };
        let timer = match (self.data.magnet, readings.index) {
            (Magnet::Absolute(_), _) => {
                let (moved, is_first) = (self.moved(), self.current.absolute_turn() == 0);
                let timer = self.current.word(readings.word);
                if is_first && self.current.absolute_turn() != 0 {
                    self.begun = self.current.position() - moved;
                }
                timer
            }
            (_, index) => {
                self.current.hall(readings.hall);
                if let Some(index) = index {
                    self.current.index(index as u16);
                }
                readings.count as u16
            }
        };
        let counts = Counts {
            currents: readings.currents.map(current),
            bus: (readings.bus_voltage / f64::from(BUS)).round() as u16,
            timer,
        };
        self.plant.chopper = self.loops.chops(&counts);
        let widths = self.current.period(&counts);
        if self.current.is_due() {
            self.loops.run(&mut self.current, since, origin, hot);
        }
        self.plant.run(HALF);
        let widths = widths.filter(|_| !self.current.is_off());
        let shares = |widths| shares(self.loops.motor().wiring, widths).map(f64::from);
        self.plant.gates = widths.map_or(Gates::Off, |widths| Gates::On(shares(widths)));
        self.plant.run(HALF);
    }

    /// The motor as the axis knows it.
    pub fn rated(&self) -> RatedMotor {
        self.rated
    }

    /// What has become of the orders, in counts from `origin` on.
    pub fn report(&self, origin: i64) -> ServoReport {
        self.loops.report(&self.current.state(), origin)
    }

    /// How far the rotor may be from where it is held at rest, in counts.
    pub fn position_tolerance(&self) -> u32 {
        self.loops.position_tolerance()
    }

    /// The rotor stands against a limit of the torque.
    pub fn is_stalled(&self) -> bool {
        self.loops.is_stalled(&self.current.state())
    }

    /// The heat of motor and stage has come near its bound.
    pub fn is_hot(&self) -> bool {
        self.loops.is_hot()
    }
}

/// The loops of a drive that has just got power.
fn loops(data: &ServoAxisData, plant: &mut Plant) -> (Current, Loops) {
    let is_known = data.magnet == Magnet::Known;
    let magnet = is_known.then(|| angle(plant.electrical_angle()));
    let timer = match data.magnet {
        Magnet::Absolute(_) => 0,
        _ => plant.measure().count as u16,
    };
    let data = data.loops();
    let current = Current::new(&data, timer, magnet).expect("the axes are plausible");
    let loops = Loops::new(&data).expect("the axes are plausible");
    (current, loops)
}

/// The table that takes out what a magnet off its centre shows: so much too much, in rad, at the sine of its angle.
///
/// It is one for the rest of the program, as a drive has it in its flash.
pub fn eccentricity_table(peak: f64) -> &'static [i32; ENTRIES] {
    let table = std::array::from_fn(|entry| {
        let shown = entry as f64 / ENTRIES as f64 * TAU;
        let turned = (0..60).fold(shown, |angle, _| shown - peak * f64::sin(angle));
        ((shown - turned) / TAU * 4_294_967_296.0) as i32
    });
    Box::leak(Box::new(table))
}

/// An angle in rad.
fn angle(radians: f64) -> Angle {
    let turns = (radians / TAU).rem_euclid(1.0);
    Angle::from_bits((turns * 4_294_967_296.0) as u32)
}

#[cfg(test)]
mod tests;
