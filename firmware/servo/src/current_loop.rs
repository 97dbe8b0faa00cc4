//! The current loop: once in each period of the modulation, from samples to pulse widths.
//!
//! Samples are taken in the middle of the pulses. What is worked out from them acts half a period later, for a whole one:
//!
//! ```text
//! sample k          k + ½             sample k + 1       k + 1½
//!    |   width k−1    |              width k                |
//! ```
//!
//! So the loop goes by a model of the winding. From the sample and the width that still acts it predicts the current at k + ½; the new
//! voltage is what that current needs to stay (resistance, the coupling of d and q, the voltage of the magnet), and what takes a share of its error
//! away within the period. At k + 1 the current is held against what the model has foretold: what differs is taken for a voltage that the
//! model does not know, and added up. That is the integral of a PI loop, and more: it knows what voltage was really given, so it does
//! not wind up where the bus has no more, and it is 0 error at rest whatever the data of the motor.
//!
//! An inductance that is not that of the data, as iron saturates, shows when the current changes: the model has foretold by how much, and what it has done
//! beside that is how it responds. Changes above a small part of the greatest current correct that, between [`STIFFEST`] and [`SOFTEST`].
//!
//! The voltage stays in the circle of the bus, d first: there field weakening acts. While the motor brakes it is the one that is nearest to what is wanted. The
//! current that is asked for stays in its own circle, d first.
//! A current above the trip, a bus outside its bounds, or NaN, ends it: the gates are to be off until [`CurrentLoop::start`].

mod axis;

use core::hint::cold_path;

use crate::Angle;
use crate::field_weakening::FieldWeakening;
use crate::modulation::{Modulation, Widths};
use crate::motor::{Implausible, Motor, Wiring};
use crate::number::{greater, is_within, lesser, limit, limit_at_once, root, root_of_number};
use crate::transform::{Clarke, Rotor};
use axis::Axis;
pub use axis::{SOFTEST, STIFFEST};

/// The fastest electrical speed that is reckoned with, in rad/s.
const FASTEST: f32 = 50_000.0;

/// 2³² / 2π.
const BITS_OF_RADIAN: f32 = 683_565_275.0;

/// Below any current.
const NONE: f32 = -1.0;

/// How the loop is set up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurrentConfig {
    /// Of the modulation and the loop, in s.
    pub period: f32,
    /// The share of an error that a period takes away: 0.93 comes within 2 % in 6 periods though R and L are off by 30 %.
    pub share: f32,
    /// The share of the unknown voltage that a period learns: the gain of the integral.
    pub learning: f32,
    /// The greatest current that is ever asked for, as the peak of a phase, in A.
    pub max_current: f32,
    /// The current of a phase at which the gates go off, in A.
    pub trip: f32,
    /// The least and the greatest voltage of the bus at which the gates are on, in V.
    pub bus: (f32, f32),
    /// The greatest current that may weaken the field, in A; 0 for none.
    pub weakening: f32,
}

impl CurrentConfig {
    /// A loop as fast as it can be, for a stage with this trip and bus, up to the peak current of a motor.
    pub const fn quick(motor: &Motor, period: f32, trip: f32, bus: (f32, f32)) -> Self {
        Self {
            period,
            share: 0.93,
            learning: 0.4,
            max_current: motor.peak_current,
            trip,
            bus,
            weakening: 0.0,
        }
    }
}

/// What is measured in the middle of a period.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// The currents of the phases into the motor, in A. The third of a motor of two is nothing.
    pub currents: [f32; 3],
    /// The voltage of the bus, in V.
    pub bus: f32,
    /// The electrical angle of the rotor.
    pub angle: Angle,
    /// By how much that turns in a period, less than half a turn: [`CurrentLoop::turned_in_period`].
    pub turn: Angle,
}

/// Why the gates went off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trip {
    /// A current above its bound, or none that can be.
    OverCurrent,
    /// A current above its bound that does not come back by the other phases.
    Short,
    /// The bus is below its bound, or is NaN.
    UnderVoltage,
    /// The bus is above its bound.
    OverVoltage,
}

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurrentLoop {
    config: CurrentConfig,
    modulation: Modulation,
    wiring: Wiring,
    clarke: Clarke,
    resistance: f32,
    flux: f32,
    d: Axis,
    q: Axis,
    /// A quarter of the period, in s.
    quarter: f32,
    /// The speed in rad/s that turns by a part of 2³² in a period.
    by_turn: f32,
    max_square: f32,
    weakening: FieldWeakening,
    /// The voltage that acts, seen from the rotor in the middle of its period.
    voltage: Rotor,
    current: Rotor,
    demand: Rotor,
    /// The current of a phase that ends it, in A. Before the first sample of a start and behind a trip it is [`NONE`]: each sample is beyond it, and nothing else need be asked.
    trip: f32,
    tripped: Option<Trip>,
}

impl CurrentLoop {
    /// For a motor that was checked, on a power stage.
    ///
    /// # Errors
    /// With a period outside 5 µs to 1 ms, a share outside 0.001 to 1, learning outside 0 to 0.5, currents below 0 or above 10 kA, or bounds of the bus
    /// that are none.
    pub fn new(
        motor: &Motor,
        config: CurrentConfig,
        modulation: Modulation,
    ) -> Result<Self, Implausible> {
        let motor = motor.checked()?;
        let (least, max) = config.bus;
        let is_one = is_within(config.period, 5e-6, 1e-3)
            && is_within(config.share, 1e-3, 1.0)
            && is_within(config.learning, 0.0, 0.5)
            && is_within(config.max_current, 0.0, 1e4)
            && is_within(config.trip, 0.0, 1e4)
            && is_within(config.weakening, 0.0, config.max_current)
            && is_within(least, 1.0, max)
            && is_within(max, least, 2e3);
        let current_loop = Self {
            config,
            modulation,
            wiring: motor.wiring,
            clarke: Clarke::new(motor.wiring),
            resistance: motor.resistance,
            flux: motor.flux,
            d: Axis::new(motor.inductance_d, &config),
            q: Axis::new(motor.inductance_q, &config),
            quarter: config.period / 4.0,
            by_turn: 1.0 / (config.period * BITS_OF_RADIAN),
            max_square: config.max_current * config.max_current,
            weakening: FieldWeakening::new(config.weakening),
            voltage: Rotor::ZERO,
            current: Rotor::ZERO,
            demand: Rotor::ZERO,
            trip: NONE,
            tripped: None,
        };
        is_one.then_some(current_loop).ok_or(Implausible)
    }

    /// Another share of an error that a period takes away, from the next period on.
    ///
    /// # Errors
    /// With a share outside 0.001 to 1; that of before stays.
    pub fn set_share(&mut self, share: f32) -> Result<(), Implausible> {
        if !is_within(share, 1e-3, 1.0) {
            return Err(Implausible);
        }
        self.config.share = share;
        self.d.set_share(share);
        self.q.set_share(share);
        Ok(())
    }

    /// The same along the magnet alone.
    ///
    /// # Errors
    /// As [`CurrentLoop::set_share`].
    pub fn set_share_along(&mut self, share: f32) -> Result<(), Implausible> {
        if !is_within(share, 1e-3, 1.0) {
            return Err(Implausible);
        }
        self.d.set_share(share);
        Ok(())
    }

    /// Another share of what the model does not know that a period takes up.
    ///
    /// # Errors
    /// With one outside 0 to 0.5; that of before stays.
    pub fn set_learning(&mut self, learning: f32) -> Result<(), Implausible> {
        if !is_within(learning, 0.0, 0.5) {
            return Err(Implausible);
        }
        self.config.learning = learning;
        self.d.set_learning(learning, self.config.period);
        self.q.set_learning(learning, self.config.period);
        Ok(())
    }

    /// Begins anew, with no voltage acting; ends a trip.
    pub fn start(&mut self) {
        self.voltage = Rotor::ZERO;
        self.d = Axis::new(self.d.inductance, &self.config);
        self.q = Axis::new(self.q.inductance, &self.config);
        self.weakening.reset();
        (self.tripped, self.trip) = (None, NONE);
    }

    /// The current of the last sample, in A.
    pub fn current(&self) -> Rotor {
        self.current
    }

    /// What was asked for at the last sample, within its limits, in A.
    pub fn demand(&self) -> Rotor {
        self.demand
    }

    /// How fast an error goes, in 1/s.
    pub fn rate(&self) -> f32 {
        self.config.share / self.config.period
    }

    /// By how much a speed in electrical rad/s turns in a period.
    pub fn turned_in_period(&self, speed: f32) -> Angle {
        let turned = limit(speed, FASTEST) * (self.config.period * BITS_OF_RADIAN);
        Angle::from_bits((turned as i32).cast_unsigned())
    }

    /// The voltage that acts, in V.
    pub fn voltage(&self) -> Rotor {
        self.voltage
    }

    /// The voltage that the model does not know of, in V.
    pub fn unknown(&self) -> Rotor {
        Rotor {
            d: self.d.unknown,
            q: self.q.unknown,
        }
    }

    /// Pulse widths for a current in A, from half a period after the sample on for a period.
    ///
    /// # Errors
    /// The gates are to be off. It stays so until [`CurrentLoop::start`].
    #[inline]
    pub fn run(&mut self, sample: &Sample, demand: Rotor) -> Result<Widths, Trip> {
        let turned = sample.angle.sine_cosine();
        let current = self.clarke.stator(sample.currents).from_rotor(turned);
        if !self.is_held(sample.currents, sample.bus) {
            cold_path();
            let [a, b, c] = sample.currents;
            self.begin(a, b, c, sample.bus, current)?;
        }
        self.current = current;
        self.d.learn(current.d, sample.bus);
        self.q.learn(current.q, sample.bus);

        let speed = sample.turn.bits().cast_signed() as f32 * self.by_turn;
        let keeps = self.keeping(speed);
        // By so much the rotor turns in a quarter of a period: between the middle of a width and the middle of its halves.
        let turn = speed * self.quarter;
        let late = Rotor {
            d: self.voltage.d + turn * self.voltage.q,
            q: self.voltage.q - turn * self.voltage.d,
        };
        let needed = keeps.needed(current);
        let first = Rotor {
            d: late.d - needed.d,
            q: late.q - needed.q,
        };
        let begin = self.later(current, first);

        let demand = self.within_limits(demand);
        self.demand = demand;
        let needed = keeps.needed(begin);
        let wanted = Rotor {
            d: needed.d + self.d.corrects * (demand.d - begin.d),
            q: needed.q + self.q.corrects * (demand.q - begin.q),
        };
        let max = self.modulation.max_voltage(sample.bus);
        self.weakening.look(wanted, max);
        let voltage = in_circle(wanted, max, begin.q * speed);
        self.voltage = voltage;
        let second = Rotor {
            d: voltage.d - turn * voltage.q - needed.d,
            q: voltage.q + turn * voltage.d - needed.q,
        };
        let expected = self.later(begin, second);
        (self.d.expected, self.q.expected) = (expected.d, expected.q);
        (self.d.beyond, self.q.beyond) = (first.d + second.d, first.q + second.q);

        let middle = sample.angle.plus(sample.turn).sine_cosine();
        let voltage = voltage.beside_stator(middle);
        let by_bus = 1.0 / sample.bus;
        Ok(self.modulation.widths(voltage, sample.currents, by_bus))
    }

    /// Whether nothing that was measured is beyond its bounds or NaN.
    #[inline(always)]
    fn is_held(&self, [a, b, c]: [f32; 3], bus: f32) -> bool {
        let (least, max) = self.config.bus;
        self.is_below_trip(a)
            && self.is_below_trip(b)
            && (self.wiring == Wiring::TwoPhase || self.is_below_trip(c))
            && bus >= least
            && bus <= max
    }

    #[inline(always)]
    fn is_below_trip(&self, current: f32) -> bool {
        current.abs() <= self.trip
    }

    /// The first sample; or it cannot go on.
    #[cold]
    #[inline(never)]
    fn begin(&mut self, a: f32, b: f32, c: f32, bus: f32, current: Rotor) -> Result<(), Trip> {
        // By themselves they stay in registers.
        let currents = [a, b, c];
        if let Some(trip) = self.tripped {
            return Err(trip);
        }
        self.trip = self.config.trip;
        if self.is_held(currents, bus) {
            (self.d.expected, self.q.expected) = (current.d, current.q);
            return Ok(());
        }
        let found = self.cause(currents, bus);
        (self.tripped, self.trip) = (Some(found), NONE);
        self.voltage = Rotor::ZERO;
        Err(found)
    }

    /// Why it cannot go on.
    fn cause(&self, currents: [f32; 3], bus: f32) -> Trip {
        let phases = self.wiring.phases();
        let is_beyond = |current: &f32| !self.is_below_trip(*current);
        let sum: f32 = currents.iter().sum();
        match currents.iter().take(phases).any(is_beyond) {
            // What goes out by one of three phases comes back by the others.
            true if phases == 3 && sum.abs() > 0.5 * self.config.trip => Trip::Short,
            true => Trip::OverCurrent,
            false if bus > self.config.bus.1 => Trip::OverVoltage,
            false => Trip::UnderVoltage,
        }
    }

    /// What keeps a current at a speed.
    #[inline(always)]
    fn keeping(&self, speed: f32) -> Keeping {
        Keeping {
            resistance: self.resistance,
            across: speed * self.q.inductance,
            along: speed * self.d.inductance,
            d: self.d.unknown,
            q: self.q.unknown + speed * self.flux,
        }
    }

    /// A current half a period later, with a voltage beyond what keeps it.
    #[inline(always)]
    fn later(&self, from: Rotor, beyond: Rotor) -> Rotor {
        Rotor {
            d: from.d + self.d.changes * beyond.d,
            q: from.q + self.q.changes * beyond.q,
        }
    }

    /// What may be asked for: d first, and of q what the circle leaves.
    #[inline]
    fn within_limits(&self, demand: Rotor) -> Rotor {
        let demand = Rotor {
            d: demand.d + self.weakening.current(),
            q: demand.q,
        };
        if demand.square() <= self.max_square {
            return demand;
        }
        cold_path();
        d_first(demand, self.config.max_current, self.max_square)
    }
}

/// What keeps a current at the speed of the period.
#[derive(Clone, Copy)]
struct Keeping {
    resistance: f32,
    /// Of the current across the magnet into d, and of that along it into q, in Ω.
    across: f32,
    along: f32,
    /// What is not known, and the voltage of the magnet.
    d: f32,
    q: f32,
}

impl Keeping {
    /// The voltage with which a current would stay as it is.
    #[inline(always)]
    fn needed(&self, current: Rotor) -> Rotor {
        Rotor {
            d: self.d + self.resistance * current.d - self.across * current.q,
            q: self.q + self.resistance * current.q + self.along * current.d,
        }
    }
}

/// What is beyond a circle by its radius and the square of that: d first, and of q what it leaves. NaN is 0.
#[inline(always)]
fn d_first(wanted: Rotor, max: f32, square: f32) -> Rotor {
    let d = limit_at_once(wanted.d, max);
    let left = lesser(wanted.q.abs(), root_of_number(square - d * d));
    let q = if wanted.q > 0.0 {
        left
    } else if wanted.q < 0.0 {
        -left
    } else {
        0.0
    };
    Rotor { d, q }
}

/// A voltage in the circle. `drives` is the current across times the speed: while it is not below 0 the motor drives, d comes first, and q has what
/// is left. While the motor brakes, the voltage is as near as it comes to the one that is wanted: d first would leave q to the magnet where the
/// current takes the whole voltage, and q would run away. NaN is 0.
#[inline(always)]
fn in_circle(wanted: Rotor, max: f32, drives: f32) -> Rotor {
    let square = max * max;
    if wanted.square() <= square {
        return wanted;
    }
    cold_path();
    if drives >= 0.0 {
        return d_first(wanted, max, square);
    }
    nearest(wanted, max)
}

/// As near as it comes within a circle. NaN is 0.
#[inline(never)]
fn nearest(wanted: Rotor, max: f32) -> Rotor {
    let wanted = Rotor {
        d: limit_at_once(wanted.d, 1e6),
        q: limit_at_once(wanted.q, 1e6),
    };
    let share = max / greater(root(wanted.square()), max);
    Rotor {
        d: wanted.d * share,
        q: wanted.q * share,
    }
}
