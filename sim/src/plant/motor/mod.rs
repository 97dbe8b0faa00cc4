//! A motor that can fail: a rotor with inertia that follows its field like a weight on a spring.
//!
//! - The torque is the sine of the load angle, times the current. A load angle beyond a full step is too much: the rotor falls
//!   back by whole electrical turns (four full steps each) until it is caught again, or stands.
//! - The current is what the drive asks for, and less at high speed ([`driver`]); so the pull-out torque falls with the speed
//!   and rises with the supply.
//! - Detents, friction, weight, end stops and the brake act on the rotor ([`rotor`]); its swinging is damped by the field.
//! - The winding warms up ([`heat`]); the driver can sense a stall ([`stall`]).
//!
//! Time goes on in fixed steps of [`STEP`], whatever the simulation around it looks at, with arithmetic that is the same on every
//! machine. So the same pulses give the same motion, bit for bit.

mod data;
mod driver;
mod heat;
mod rotor;
mod sine;
mod stall;

pub use data::{Heat, Load, MotorData, SupplyChange, SupplyData};

use std::ops::RangeInclusive;

use canopen::Duration;
use driver::{Driver, Winding};
use heat::Temperature;
use rotor::{Mechanics, Rotor};
use sine::sine;
use stall::StallSense;

/// The step of the integration.
pub(super) const STEP: Duration = Duration::from_ticks(20);

/// The same in seconds.
pub(super) const SECONDS: f64 = 20e-6;

/// Faster swinging than this cannot be shown in steps of [`STEP`], in radians/s.
const FASTEST: f64 = 0.5 / SECONDS;

/// What the drive has ordered, and what the supply gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Orders {
    /// In mA.
    pub(super) current: u16,
    /// Pulses in a full step.
    pub(super) microsteps: u16,
    pub(super) is_braked: bool,
    /// In V.
    pub(super) supply: f64,
}

/// A motor at work.
#[derive(Clone, Debug)]
pub(super) struct Motor {
    data: MotorData,
    mechanics: Mechanics,
    winding: Winding,
    /// Torque of the windings by the field's turning past the rotor, in N·m per full step/s.
    damping: f64,
    /// At so many full steps/s of slip that is at its greatest.
    breakdown: f64,
    driver: Driver,
    rotor: Rotor,
    temperature: Temperature,
    stall: StallSense,
    /// Where it was mounted, in steps of the axis.
    start: i64,
    /// What the encoder counted at power-on.
    origin: i64,
    /// What the field did since the last step of the integration, in full steps.
    way: f64,
    /// Nothing moved in the last step, under these orders.
    asleep: Option<Orders>,
    /// What is drawn from the supply, in W.
    power: f64,
}

impl Motor {
    /// A motor at rest, mounted at `start`, with end stops in `stops`; both in steps of the axis.
    pub(super) fn new(data: &MotorData, start: i64, stops: Option<&RangeInclusive<i64>>) -> Self {
        let full = |steps: i64| (steps - start) as f64 / f64::from(data.microsteps);
        let stops = stops.map(|stops| full(*stops.start())..=full(*stops.end()));
        let mechanics = Mechanics::new(data, stops);
        let holding = rotor::newton_metres(data.holding_torque);
        let damping = f64::from(data.damping) / 100.0
            * 2.0
            * mechanics.inertia
            * mechanics.radians
            * mechanics.natural_frequency(holding * RADIANS_OF_SINE);
        Self {
            winding: Winding::new(data),
            damping,
            breakdown: if damping > 0.0 {
                holding / 2.0 / damping
            } else {
                1.0
            },
            mechanics,
            driver: Driver::new(),
            rotor: Rotor::default(),
            temperature: Temperature::new(&data.heat),
            stall: StallSense::new(),
            start,
            origin: 0,
            way: 0.0,
            asleep: None,
            power: 0.0,
            data: data.clone(),
        }
    }

    /// Whether steps of [`STEP`] can show how this motor swings about its field and at the end stops.
    pub(super) fn can_be_shown(data: &MotorData) -> bool {
        let mechanics = Mechanics::new(data, None);
        let holding = rotor::newton_metres(data.holding_torque);
        let detent = 4.0 * rotor::newton_metres(data.detent_torque);
        let stiffness = (holding + detent) * RADIANS_OF_SINE + mechanics.stop_stiffness();
        mechanics.natural_frequency(stiffness) <= FASTEST
    }

    /// The drive gets its power back: its driver begins at its first phase, its encoder at 0.
    pub(super) fn power_on(&mut self) {
        self.driver.reset(self.rotor.position);
        self.stall = StallSense::new();
        self.way = 0.0;
        self.asleep = None;
        self.origin = self.counts(self.rotor.position);
    }

    /// Pulses arrive.
    pub(super) fn take(&mut self, pulses: i64, microsteps: u16) {
        self.way += self.driver.take(pulses, microsteps);
    }

    /// Somebody turns the shaft by so many steps of the axis.
    pub(super) fn displace(&mut self, steps: i64) {
        self.rotor.position += steps as f64 / f64::from(self.data.microsteps);
        self.asleep = None;
    }

    /// [`STEP`] goes by.
    pub(super) fn step(&mut self, orders: Orders) {
        let way = std::mem::take(&mut self.way);
        let lead = self.driver.field() - self.rotor.position;
        self.stall.observe(way, lead, SECONDS);
        let demand = f64::from(orders.current) / 1e3;
        if way == 0.0 && self.asleep == Some(orders) {
            self.temperature.step(self.part(demand), SECONDS);
            return;
        }
        self.driver.pass(way, SECONDS);
        let current =
            self.driver
                .current(demand, &self.winding, orders.supply, self.rotor.velocity);
        let part = self.part(current);
        let slip = self.driver.velocity() - self.rotor.velocity;
        let ratio = slip / self.breakdown;
        let torque = part
            * (rotor::newton_metres(self.data.holding_torque) * sine(lead)
                + self.damping * slip / (1.0 + ratio * ratio));
        let before = self.rotor.velocity;
        self.rotor
            .step(&self.mechanics, torque, orders.is_braked, SECONDS);
        self.temperature.step(part, SECONDS);
        self.power =
            self.winding.loss(current) + torque * self.rotor.velocity * self.mechanics.radians;
        let rests = before == 0.0 && self.rotor.velocity == 0.0 && self.driver.velocity() == 0.0;
        self.asleep = rests.then_some(orders);
    }

    /// A current in A as a part of the rated one.
    fn part(&self, current: f64) -> f64 {
        current * 1e3 / f64::from(self.data.rated_current)
    }

    /// Where the motor is along the axis, in steps of the axis.
    pub(super) fn place(&self) -> i64 {
        self.start + (self.rotor.position * f64::from(self.data.microsteps)).round() as i64
    }

    /// What the drive makes of its encoder when the motor is at a place of the axis: pulses since power-on.
    pub(super) fn measured_at(&self, place: i64, microsteps: u16) -> i64 {
        let position = (place - self.start) as f64 / f64::from(self.data.microsteps);
        self.in_pulses(self.counts(position), microsteps)
    }

    /// What the drive makes of its encoder.
    pub(super) fn measured(&self, microsteps: u16) -> i64 {
        self.in_pulses(self.counts(self.rotor.position), microsteps)
    }

    /// What an encoder counts at a position in full steps. One that is as fine as the pulses counts as finely as any driver steps.
    fn counts(&self, position: f64) -> i64 {
        (position * f64::from(self.counts_of_turn()) / f64::from(self.data.full_steps)).round()
            as i64
    }

    fn counts_of_turn(&self) -> u32 {
        let finest = FINEST * u32::from(self.data.full_steps);
        self.data.encoder_counts.unwrap_or(finest)
    }

    fn in_pulses(&self, counts: i64, microsteps: u16) -> i64 {
        let turn = i64::from(self.counts_of_turn());
        let pulses = i64::from(self.data.full_steps) * i64::from(microsteps);
        // To the nearest one.
        ((counts - self.origin) * pulses * 2 + turn).div_euclid(turn * 2)
    }

    /// How far an encoder may be from where the pulses lead while the motor is held, in pulses. It is caught up to half an
    /// electrical turn from where it stood when the power came, and its load draws it up to half a full step from there.
    pub(super) fn position_tolerance(microsteps: u16) -> u32 {
        u32::from(microsteps) * 5 / 2
    }

    /// What it was made of.
    pub(super) const fn data(&self) -> &MotorData {
        &self.data
    }

    /// Whether the driver senses that the motor is blocked; `None` if it has no such sense.
    pub(super) fn stall(&self) -> Option<bool> {
        self.data.senses_stall.then(|| self.stall.tells())
    }

    /// Whether an end stop holds it.
    pub(super) fn is_at_stop(&self) -> bool {
        self.rotor.is_at_stop(&self.mechanics)
    }

    /// In tenths of a degree Celsius.
    pub(super) fn temperature(&self) -> i16 {
        self.temperature.tenths()
    }

    /// What is drawn from the supply, in W; negative while the motor gives.
    pub(super) const fn power(&self) -> f64 {
        self.power
    }
}

/// A full step is a quarter of an electrical turn: how steep the sine of the load angle is at zero, per full step.
const RADIANS_OF_SINE: f64 = std::f64::consts::FRAC_PI_2;

/// The finest microsteps of usual drivers.
const FINEST: u32 = 256;

#[cfg(test)]
mod tests;
