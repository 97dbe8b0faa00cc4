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

use crate::Angle;
use crate::field_weakening::FieldWeakening;
use crate::modulation::{Modulation, Widths};
use crate::motor::{Implausible, Motor, Wiring};
use crate::number::{is_within, limit, root, within};
use crate::transform::{Rotor, Stator};

/// The fastest electrical speed that is reckoned with, in rad/s.
const FASTEST: f32 = 50_000.0;

/// 2³² / 2π.
const BITS_OF_RADIAN: f32 = 683_565_275.0;

/// The least and the greatest response of a winding, as a share of that of its data.
pub const STIFFEST: f32 = 0.6;
/// See [`STIFFEST`].
pub const SOFTEST: f32 = 1.7;

/// How much of a response that was other than foretold is taken over at once.
const TAKEN_OVER: f32 = 1.2;

/// From this share of the greatest current on a change tells of the response.
const TELLING: f32 = 0.02;

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
    /// The electrical speed of the rotor, in rad/s.
    pub speed: f32,
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

/// The model of one axis of the rotor.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Axis {
    inductance: f32,
    /// period / 2 L
    half: f32,
    /// share · L / period
    gain: f32,
    /// learning · L / period
    learning: f32,
    /// A change of the current that tells of the response, squared.
    telling: f32,
    /// By how much more the current changes than by the data.
    response: f32,
    /// The change of the current in the period, by the data.
    change: f32,
    /// The current that the model has foretold for the next sample.
    expected: f32,
    /// The voltage that the model does not know.
    unknown: f32,
}

impl Axis {
    fn new(inductance: f32, config: &CurrentConfig) -> Self {
        let telling = TELLING * config.max_current;
        Self {
            inductance,
            half: 0.5 * config.period / inductance,
            gain: config.share * inductance / config.period,
            learning: config.learning * inductance / config.period,
            telling: telling * telling,
            response: 1.0,
            change: 0.0,
            expected: 0.0,
            unknown: 0.0,
        }
    }

    /// Learns the unknown voltage from the error of the last prediction: the integral of the loop.
    #[inline]
    fn learn(&mut self, current: f32, bus: f32) {
        let away = current - self.expected;
        let square = self.change * self.change;
        if square > self.telling {
            let response = self.response + TAKEN_OVER * self.change * away / square;
            self.response = within(response, STIFFEST, SOFTEST);
        }
        self.unknown = limit(self.unknown - self.learning * away, bus);
    }

    /// The current half a period later, with a voltage beyond what keeps it.
    #[inline]
    fn half_later(&mut self, from: f32, beyond: f32) -> f32 {
        let change = self.half * beyond;
        self.change += change;
        from + self.response * change
    }

    /// The voltage that takes a share of an error away in a period.
    #[inline]
    fn correction(&self, error: f32) -> f32 {
        self.gain * error / self.response
    }
}

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurrentLoop {
    config: CurrentConfig,
    modulation: Modulation,
    wiring: Wiring,
    resistance: f32,
    flux: f32,
    d: Axis,
    q: Axis,
    quarter: f32,
    max_square: f32,
    weakening: FieldWeakening,
    /// The voltage that acts, seen from the rotor in the middle of its period.
    voltage: Rotor,
    current: Rotor,
    demand: Rotor,
    state: State,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// The next sample is the first.
    Starting,
    Running,
    Tripped(Trip),
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
            resistance: motor.resistance,
            flux: motor.flux,
            d: Axis::new(motor.inductance_d, &config),
            q: Axis::new(motor.inductance_q, &config),
            quarter: config.period / 4.0,
            max_square: config.max_current * config.max_current,
            weakening: FieldWeakening::new(config.weakening),
            voltage: Rotor::ZERO,
            current: Rotor::ZERO,
            demand: Rotor::ZERO,
            state: State::Starting,
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
        for axis in [&mut self.d, &mut self.q] {
            axis.gain = share * axis.inductance / self.config.period;
        }
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
        self.d.gain = share * self.d.inductance / self.config.period;
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
        for axis in [&mut self.d, &mut self.q] {
            axis.learning = learning * axis.inductance / self.config.period;
        }
        Ok(())
    }

    /// Begins anew, with no voltage acting; ends a trip.
    pub fn start(&mut self) {
        self.voltage = Rotor::ZERO;
        self.d = Axis::new(self.d.inductance, &self.config);
        self.q = Axis::new(self.q.inductance, &self.config);
        self.weakening.reset();
        self.state = State::Starting;
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
        let turned = limit(speed, FASTEST) * self.quarter * 4.0 * BITS_OF_RADIAN;
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
    pub fn run(&mut self, sample: &Sample, demand: Rotor) -> Result<Widths, Trip> {
        let current = Stator::of_phases(self.wiring, sample.currents);
        let angle = sample.angle.sine_cosine();
        let current = current.from_rotor(angle);
        self.check(sample)?;
        self.current = current;
        self.learn(current, sample.bus);

        let speed = limit(sample.speed, FASTEST);
        // By so much the rotor turns in a quarter of a period: between the middle of a width and the middle of its halves.
        let turn = speed * self.quarter;
        let late = Rotor {
            d: self.voltage.d + turn * self.voltage.q,
            q: self.voltage.q - turn * self.voltage.d,
        };
        let begin = self.half_later(current, late, self.needed(current, speed));

        let demand = self.within_limits(demand);
        self.demand = demand;
        let needed = self.needed(begin, speed);
        let wanted = Rotor {
            d: needed.d + self.d.correction(demand.d - begin.d),
            q: needed.q + self.q.correction(demand.q - begin.q),
        };
        let max = self.modulation.max_voltage(sample.bus);
        self.weakening.look(wanted, max);
        let voltage = in_circle(wanted, max, begin.q * speed < 0.0);
        self.voltage = voltage;
        let early = Rotor {
            d: voltage.d - turn * voltage.q,
            q: voltage.q + turn * voltage.d,
        };
        let expected = self.half_later(begin, early, needed);
        (self.d.expected, self.q.expected) = (expected.d, expected.q);

        let ahead = (turn * (4.0 * BITS_OF_RADIAN)) as i32;
        let middle = sample.angle.plus(Angle::from_bits(ahead.cast_unsigned()));
        let voltage = voltage.beside_stator(middle.sine_cosine());
        let by_bus = 1.0 / sample.bus;
        Ok(self.modulation.widths(voltage, sample.currents, by_bus))
    }

    /// Ends everything if a measured value is beyond its bounds or is NaN.
    #[inline]
    fn check(&mut self, sample: &Sample) -> Result<(), Trip> {
        let (least, max) = self.config.bus;
        if self.is_held(sample)
            && sample.bus >= least
            && sample.bus <= max
            && !matches!(self.state, State::Tripped(_))
        {
            return Ok(());
        }
        let found = self.cause(sample);
        self.state = State::Tripped(found);
        self.voltage = Rotor::ZERO;
        Err(found)
    }

    /// Whether no current is above the trip.
    #[inline]
    fn is_held(&self, sample: &Sample) -> bool {
        let [a, b, c] = sample.currents;
        let trip = self.config.trip;
        a.abs() <= trip && b.abs() <= trip && (self.wiring == Wiring::TwoPhase || c.abs() <= trip)
    }

    /// Why it cannot go on.
    #[cold]
    fn cause(&self, sample: &Sample) -> Trip {
        let [a, b, c] = sample.currents;
        let is_held = self.is_held(sample);
        match self.state {
            State::Tripped(trip) => trip,
            // What goes out by one of three phases comes back by the others.
            _ if !is_held
                && self.wiring == Wiring::ThreePhase
                && (a + b + c).abs() > 0.5 * self.config.trip =>
            {
                Trip::Short
            }
            _ if !is_held => Trip::OverCurrent,
            _ if sample.bus > self.config.bus.1 => Trip::OverVoltage,
            _ => Trip::UnderVoltage,
        }
    }

    /// Learns the unknown voltage from the error of the last prediction: the integral of the loop.
    #[inline]
    fn learn(&mut self, current: Rotor, bus: f32) {
        if matches!(self.state, State::Starting) {
            self.state = State::Running;
            (self.d.expected, self.q.expected) = (current.d, current.q);
        }
        self.d.learn(current.d, bus);
        self.q.learn(current.q, bus);
        (self.d.change, self.q.change) = (0.0, 0.0);
    }

    /// The voltage with which a current would stay as it is.
    #[inline]
    fn needed(&self, current: Rotor, speed: f32) -> Rotor {
        let magnet = self.d.inductance * current.d + self.flux;
        Rotor {
            d: self.resistance * current.d - speed * self.q.inductance * current.q + self.d.unknown,
            q: self.resistance * current.q + speed * magnet + self.q.unknown,
        }
    }

    #[inline]
    fn half_later(&mut self, from: Rotor, voltage: Rotor, needed: Rotor) -> Rotor {
        Rotor {
            d: self.d.half_later(from.d, voltage.d - needed.d),
            q: self.q.half_later(from.q, voltage.q - needed.q),
        }
    }

    /// What may be asked for: d first, and of q what the circle leaves.
    #[inline]
    fn within_limits(&self, demand: Rotor) -> Rotor {
        let max = self.config.max_current;
        let d = limit(demand.d + self.weakening.current(), max);
        let q = limit(demand.q, max);
        let square = d * d;
        if square + q * q <= self.max_square {
            return Rotor { d, q };
        }
        let left = root(self.max_square - square);
        Rotor {
            d,
            q: limit(q, left),
        }
    }
}

/// A voltage in the circle. While the motor drives d comes first, and q has what is left. While it brakes the voltage is as near as it comes to the one that is
/// wanted: d first would leave q to the magnet where the current takes the whole voltage, and q would run away. NaN is 0.
#[inline]
fn in_circle(wanted: Rotor, max: f32, brakes: bool) -> Rotor {
    if wanted.square() <= max * max {
        return wanted;
    }
    if !brakes {
        let d = limit(wanted.d, max);
        return Rotor {
            d,
            q: limit(wanted.q, root(max * max - d * d)),
        };
    }
    let wanted = Rotor {
        d: limit(wanted.d, 1e6),
        q: limit(wanted.q, 1e6),
    };
    let share = max / root(wanted.square()).max(max);
    Rotor {
        d: wanted.d * share,
        q: wanted.q * share,
    }
}
