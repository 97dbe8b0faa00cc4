//! A motor that is moved by its current: the plant of the crate [`servo_plant`], with the loops of the firmware's servo above it as a board runs them.
//!
//! Time goes on in periods of the modulation. A sample in the middle of the pulses, what the converter makes of it, the current interrupt, and its widths half a period later; the
//! control each [`CONTROL`] periods. Where the magnet is, is known from the beginning, as from an absolute encoder.

mod measurement;
mod settings;

use motion::Ticks;
use servo::control::{Fault, Goal, Order, Seen};
use servo::feedback::{Incremental, Observer};
use servo::interrupt::Counts;
use servo::offsets::CurrentSense;
use servo::transform::Rotor;
use servo::{Angle, Control, CurrentInterrupt, Motor, Wiring};
use servo_plant::data::{Phases, PlantData};
use servo_plant::{Gates, Plant, axes};

use super::STEP_CLOCK_HZ;
use crate::plant::pulses::Ordered;
use cia402::{ServoGoal, ServoReport};
use measurement::{Ending, Measurement};
pub use measurement::{Found, Request};
use settings::loops;
pub use settings::{ServoSettings, StepperSettings};

/// A period of the modulation, in microseconds.
const PERIOD: u64 = 50;

/// The same in s.
const SECONDS: f32 = PERIOD as f32 * 1e-6;

/// Periods of the modulation in one of the control.
const CONTROL: u64 = 5;

/// Steps of the plant in half a period.
const HALF: u32 = 5;

/// Volts of a count of the bus.
const BUS: f32 = 0.025;

/// The middle of the converter: one of 16 bits, as industrial servos have.
const MIDDLE: u16 = 32_768;

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
}

/// The ready axes.
pub const AXES: [ServoAxisData; 4] = [
    axis("nema17", axes::NEMA17, (1.7, 2.4), 700.0, 1_200),
    axis("nema23", axes::NEMA23, (4.2, 6.0), 700.0, 1_200),
    axis("servo_100w", axes::SERVO_100W, (4.0, 12.0), 800.0, 3_000),
    axis("servo_400w", axes::SERVO_400W, (17.0, 40.0), 500.0, 3_000),
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
    motor: Motor,
    interrupt: CurrentInterrupt,
    control: Control,
    /// Amperes of a count.
    scale: f32,
    /// Microseconds up to which it has run, and the periods in them.
    time: u64,
    periods: u64,
    is_on: bool,
    /// The order that the control has.
    taken: Option<Ordered>,
    fault: Option<Fault>,
    settings: ServoSettings,
    measurement: Measurement,
}

impl ServoMotor {
    /// At rest, with an encoder at 0.
    pub fn new(data: &ServoAxisData, seed: u64) -> Self {
        let motor = data.motor();
        let mut plant = Plant::new(data.plant, seed);
        let scale = 2.5 * data.peak_current / f32::from(MIDDLE);
        let known = "the axes are plausible";
        let mut encoder = Incremental::new(&motor, plant.measure().count as u16, 2);
        encoder.set_angle(angle(plant.electrical_angle()));
        let mut observer = Observer::new(3_000.0, SECONDS).expect(known);
        observer.stand_at(encoder.angle());
        let settings = ServoSettings::default();
        let (current, control) = loops(data, &motor, &settings).expect(known);
        Self {
            data: *data,
            interrupt: CurrentInterrupt::new(
                CurrentSense::new(scale, MIDDLE, 100).expect(known),
                encoder,
                observer,
                current,
                BUS,
            )
            .expect(known),
            control,
            plant,
            motor,
            scale,
            time: 0,
            periods: 0,
            is_on: false,
            taken: None,
            fault: None,
            settings,
            measurement: Measurement::default(),
        }
    }

    /// The motor and what is around it, to load it or to break it.
    pub fn plant_mut(&mut self) -> &mut Plant {
        &mut self.plant
    }

    /// The motor and what is around it.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// The motor as its loops know it.
    pub fn motor(&self) -> &Motor {
        &self.motor
    }

    /// Of the encoder, from where it began.
    pub fn position(&self) -> i64 {
        self.interrupt.encoder.position()
    }

    /// The bus in mV.
    pub fn millivolts(&self) -> u32 {
        (self.plant.bus_voltage() * 1e3) as u32
    }

    /// Whether the loops may put current into the motor.
    pub fn energise(&mut self, on: bool) {
        if on == self.is_on {
            return;
        }
        self.is_on = on;
        self.fault = None;
        self.begin_anew();
        if !on {
            self.end_measurement(Ending::PowerOff);
            self.plant.gates = Gates::Off;
        }
    }

    /// The loops begin without a current.
    fn begin_anew(&mut self) {
        self.interrupt.current.start();
        self.interrupt.order(Rotor::ZERO, 0);
        self.control.start();
    }

    /// Why the motor has no current though it is to have some, as an error code of CiA 402.
    pub fn error_code(&self) -> Option<u16> {
        self.fault.map(|fault| match fault {
            Fault::OverCurrent => 0x2310,
            Fault::Short => 0x2320,
            Fault::UnderVoltage => 0x3220,
            Fault::OverVoltage => 0x3210,
            Fault::Temperature => 0x4310,
            Fault::Blocked => 0x7121,
            Fault::PhaseLost => 0x7122,
            Fault::CurrentSensor => 0x7300,
            Fault::Encoder => 0x7305,
            Fault::OverSpeed => 0x7310,
        })
    }

    /// Runs for so many microseconds. `order` was given at its moment of the step clock, of which the run begins at `begin`; its positions count from `origin` on.
    pub fn run(&mut self, span: u64, begin: Ticks, order: Option<&Ordered>, origin: i64, hot: i16) {
        let end = self.time + span;
        let start = self.time;
        if order.copied() != self.taken {
            self.taken = order.copied();
        }
        while (self.periods + 1) * PERIOD <= end {
            let at = (self.periods + 1) * PERIOD;
            let ticks = begin + at.saturating_sub(start) * u64::from(STEP_CLOCK_HZ / 1_000_000);
            self.period(ticks, origin, hot);
            self.periods += 1;
        }
        self.time = end;
    }

    /// A period of the modulation.
    fn period(&mut self, ticks: Ticks, origin: i64, hot: i16) {
        let readings = self.plant.measure();
        let current = |amperes: f64| {
            let counts = (amperes / f64::from(self.scale)).round() + f64::from(MIDDLE);
            counts.clamp(0.0, 65_535.0) as u16
        };
        let counts = Counts {
            currents: readings.currents.map(current),
            bus: (readings.bus_voltage / f64::from(BUS)).round() as u16,
            timer: readings.count as u16,
        };
        let bus = f32::from(counts.bus) * BUS;
        self.plant.chopper = self.control.chops(bus);
        let measures = self.measures();
        let widths = if measures {
            self.measure(&counts, bus, hot)
        } else if self.is_on && self.fault.is_none() {
            let widths = self.interrupt.run(&counts);
            widths.map_err(|trip| self.control.fail(trip.into())).ok()
        } else {
            self.interrupt.encoder.look(counts.timer);
            let angle = self.interrupt.encoder.angle();
            self.interrupt.observer.look(angle);
            None
        };
        if self.is_on && !measures && self.periods.is_multiple_of(CONTROL) {
            self.order(ticks, origin);
            let seen = Seen {
                bus,
                temperature: f32::from(hot) / 10.0,
                sum: match self.motor.wiring {
                    Wiring::TwoPhase => 0.0,
                    Wiring::ThreePhase => {
                        let currents = self.interrupt.sense.amperes(counts.currents);
                        currents.iter().sum()
                    }
                },
            };
            // The control goes on where the interrupt has ended: it tells the fault.
            if let Ok(current) = self.control.run(&self.interrupt, &seen) {
                self.interrupt.order(current, 0);
            }
        }
        self.fault = self.control.fault();
        self.plant.run(HALF);
        self.plant.gates = match (widths, self.fault) {
            (Some(widths), None) => Gates::On(widths.map(f64::from)),
            _ => Gates::Off,
        };
        self.plant.run(HALF);
    }

    /// Hands the order on.
    fn order(&mut self, ticks: Ticks, origin: i64) {
        let Some(Ordered { order, at }) = self.taken else {
            return;
        };
        let speed = |bits: i64| bits as f32 / 4_294_967_296.0;
        let torque = |micro: u32| micro as f32 * 1e-6;
        let by_current = order.current as f32 * 1e-3 * self.motor.torque_constant();
        let held = self.held_at();
        let goal = match order.goal {
            ServoGoal::Free if held.is_some() => Goal::Position {
                counts: held.unwrap_or_default(),
                part: 1 << 31,
                velocity: 0.0,
                acceleration: 0.0,
            },
            ServoGoal::Torque | ServoGoal::Free => Goal::Torque,
            ServoGoal::Position {
                counts,
                part,
                velocity,
                acceleration,
            } => Goal::Position {
                counts: counts + origin,
                part,
                velocity: speed(velocity.bits()),
                acceleration: acceleration as f32,
            },
        };
        let since = ticks.saturating_sub(at) as f32 / STEP_CLOCK_HZ as f32;
        self.control.order(
            Order {
                goal,
                torque: order.torque as f32 * 1e-6,
                velocity_ahead: speed(order.velocity_ahead.bits()),
                most: (
                    torque(order.most.0).min(by_current),
                    torque(order.most.1).min(by_current),
                ),
                speed: (order.velocity.bits() as f64 / 4_294_967_296.0) as f32,
            },
            since,
        );
    }

    /// What has become of the orders, in counts from `origin` on.
    pub fn report(&self, origin: i64) -> ServoReport {
        let report = self.control.report(&self.interrupt);
        let micro = |value: f32, by: f32| (value * by).round() as i32;
        ServoReport {
            counts: self.position() - origin,
            velocity: motion::SignedSpeed::from_bits(
                (f64::from(report.velocity) * 4_294_967_296.0) as i64,
            ),
            demand: micro(report.demand, 1e6),
            torque: micro(report.torque, 1e6),
            current: micro(report.current, 1e3),
            is_limited: report.is_limited,
            wants_free: self.wants_free(),
        }
    }

    /// The lead of a stepper's field in hundredths of a full step.
    pub fn lead(&self) -> u16 {
        let lead = self.control.report(&self.interrupt).lead;
        (lead.abs() * 100.0).round() as u16
    }

    /// How far the rotor may be from where it is held at rest, in counts: a stepper that is only supervised has no more than its field, and loses
    /// four full steps at a time. Of anything else its following error tells.
    pub fn slack(&self) -> u32 {
        let supervised = self.settings.stepper.way == 1;
        let four_steps = self.motor.counts / u32::from(self.motor.pole_pairs);
        if supervised {
            four_steps * 5 / 8
        } else {
            i32::MAX.unsigned_abs()
        }
    }

    /// The rotor stands against a limit of the torque.
    pub fn is_stalled(&self) -> bool {
        let report = self.control.report(&self.interrupt);
        report.is_limited && report.velocity.abs() < 0.02 * self.motor.counts as f32
    }

    /// The heat of motor and stage has come near its bound.
    pub fn is_hot(&self) -> bool {
        self.control.report(&self.interrupt).is_hot
    }
}

/// An angle in rad.
fn angle(radians: f64) -> Angle {
    let turns = (radians / std::f64::consts::TAU).rem_euclid(1.0);
    Angle::from_bits((turns * 4_294_967_296.0) as u32)
}

#[cfg(test)]
mod tests;
