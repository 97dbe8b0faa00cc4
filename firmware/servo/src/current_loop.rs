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
mod keeping;

use core::hint::cold_path;

use crate::Angle;
use crate::angle::sine_cosine_of_four;
use crate::field_weakening::FieldWeakening;
use crate::modulation::{Modulation, Widths};
use crate::motor::{Implausible, Motor, Wiring};
use crate::number::{
    are_within, inverse_root, is_within, lesser, limit, limit_at_once, root_of_number,
};
use crate::transform::{Clarke, Rotor};
use axis::Axis;
pub use axis::{SOFTEST, STIFFEST};
use keeping::Keeping;

/// The fastest that is reckoned with, in parts of 2³² of a turn in a period: an eighth of a turn, as the observer.
const FASTEST: f32 = 536_870_912.0;

/// 2³² / 2π.
const BITS_OF_RADIAN: f32 = 683_565_275.0;

/// Below the square of any current.
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
    /// The greatest current that may weaken the field, in A; 0 for none. Where the magnet has less, no more than that: beyond it the field would grow again.
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
    /// The currents of the phases into the motor, in A. The third of a motor of two is any number.
    pub currents: [f32; 3],
    /// The voltage of the bus, in V.
    pub bus: f32,
    /// The electrical angle of the rotor.
    pub angle: Angle,
    /// By how much that turns in a period, at most an eighth of a turn: [`CurrentLoop::turned_in_period`].
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
    /// The voltage of the magnet at the speed that turns by a part of 2³² of a turn in a period.
    induced: f32,
    d: Axis,
    q: Axis,
    max_square: f32,
    /// The circle of the voltage, in parts of the modulation, and its square.
    circle: f32,
    circle_square: f32,
    /// The current that weakens the field, within [`CurrentConfig::weakening`].
    pub weakening: FieldWeakening,
    /// The voltage that acts, seen from the rotor in the middle of its period.
    voltage: Rotor,
    current: Rotor,
    demand: Rotor,
    /// The sum of the squares of the phases that none of them is beyond the trip. Before the first sample of a start and behind a trip it is [`NONE`]: each sample is
    /// beyond it, and nothing else need be asked.
    safe_square: f32,
    /// The bits of the least voltage of the bus, and how many more the greatest has: those of numbers above 0 go up with them, and those of NaN are beyond.
    least_bus: u32,
    bus_range: u32,
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
        motor.check()?;
        let (least, max) = config.bus;
        Implausible::unless(
            are_within(
                [
                    config.period,
                    config.share,
                    config.learning,
                    config.max_current,
                    config.trip,
                    config.weakening,
                    max,
                ],
                &[
                    (5e-6, 1e-3),
                    (1e-3, 1.0),
                    (0.0, 0.5),
                    (0.0, 1e4),
                    (0.0, 1e4),
                    (0.0, 1e4),
                    (1.0, 2e3),
                ],
            ) && config.weakening <= config.max_current
                && is_within(least, 1.0, max),
        )?;
        let circle = modulation.circle();
        let weakening = lesser(config.weakening, motor.flux / motor.inductance_d);
        Ok(Self {
            config,
            modulation,
            wiring: motor.wiring,
            clarke: Clarke::new(motor.wiring),
            resistance: motor.resistance,
            induced: motor.flux / (config.period * BITS_OF_RADIAN),
            d: Axis::new(motor.inductance_d, &config),
            q: Axis::new(motor.inductance_q, &config),
            max_square: config.max_current * config.max_current,
            circle,
            circle_square: circle * circle,
            weakening: FieldWeakening::new(weakening, circle * circle),
            voltage: Rotor::ZERO,
            current: Rotor::ZERO,
            demand: Rotor::ZERO,
            safe_square: NONE,
            least_bus: least.to_bits(),
            bus_range: max.to_bits().wrapping_sub(least.to_bits()),
            tripped: None,
        })
    }

    /// Another share of an error that a period takes away, from the next period on.
    ///
    /// # Errors
    /// With a share outside 0.001 to 1; that of before stays.
    pub fn set_share(&mut self, share: f32) -> Result<(), Implausible> {
        self.set_share_along(share)?;
        self.config.share = share;
        self.q.set_share(share);
        Ok(())
    }

    /// The same along the magnet alone.
    ///
    /// # Errors
    /// As [`CurrentLoop::set_share`].
    pub fn set_share_along(&mut self, share: f32) -> Result<(), Implausible> {
        Implausible::unless(is_within(share, 1e-3, 1.0))?;
        self.d.set_share(share);
        Ok(())
    }

    /// Another share of what the model does not know that a period takes up.
    ///
    /// # Errors
    /// With one outside 0 to 0.5; that of before stays.
    pub fn set_learning(&mut self, learning: f32) -> Result<(), Implausible> {
        Implausible::unless(is_within(learning, 0.0, 0.5))?;
        self.config.learning = learning;
        self.d.set_learning(learning, self.config.period);
        self.q.set_learning(learning, self.config.period);
        Ok(())
    }

    /// Begins anew, with no voltage acting; ends a trip.
    pub fn start(&mut self) {
        self.voltage = Rotor::ZERO;
        self.d.restart(&self.config);
        self.q.restart(&self.config);
        self.weakening.reset();
        (self.tripped, self.safe_square) = (None, NONE);
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

    /// By how much a speed in electrical rad/s turns in a period: at most an eighth of a turn.
    pub fn turned_in_period(&self, speed: f32) -> Angle {
        let turned = limit(speed * (self.config.period * BITS_OF_RADIAN), FASTEST);
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
    #[inline(never)]
    pub fn run(&mut self, sample: &Sample, demand: Rotor) -> Result<Widths, Trip> {
        self.run_in_place(sample, demand)
    }

    /// The same within who calls it.
    #[inline(always)]
    pub(crate) fn run_in_place(&mut self, sample: &Sample, demand: Rotor) -> Result<Widths, Trip> {
        let by_bus = 1.0 / sample.bus;
        let turned = sample.angle.sine_cosine();
        let currents = self.clarke.phases(sample.currents);
        let current = self.clarke.stator(currents).from_rotor(turned);
        if !self.is_safe(currents, sample.bus) {
            cold_path();
            let [a, b, c] = currents;
            self.begin(a, b, c, sample.bus, current)?;
        }
        let before = self.current;
        self.current = current;
        self.d.learn(current.d, before.d);
        self.q.learn(current.q, before.q);
        self.limit_unknown(sample.bus);

        let turn = sample.turn.bits().cast_signed() as f32;
        // By so much the rotor turns in a quarter of a period, in rad: between the middle of a width and the middle of its halves.
        let quarter = turn * (0.25 / BITS_OF_RADIAN);
        let keeps = self.keeping(turn);
        let first = keeps.beyond(self.voltage, quarter, current);
        let begin = self.later(current, first);

        let demand = self.within_limits(demand);
        self.demand = demand;
        let needed = keeps.needed(begin);
        let corrects = Rotor {
            d: self.d.corrects * (demand.d - begin.d),
            q: self.q.corrects * (demand.q - begin.q),
        };
        let wanted = needed.plus(corrects);
        // In parts of the modulation the circle is the same whatever the bus.
        let of_volt = self.modulation.of_volt(by_bus);
        let (mut voltage, mut beyond, mut parts) = (wanted, corrects, wanted.times(of_volt));
        let square = parts.square();
        self.weakening.look(square);
        let fits = square <= self.circle_square;
        if !fits {
            cold_path();
            // While the motor drives, d comes first, and q has what is left. While it brakes, the voltage is as near as it comes to the one that is wanted: d first
            // would leave q to the magnet where the current takes the whole voltage, and q would run away.
            if begin.q * turn < 0.0 && square.is_finite() {
                let share = self.circle * inverse_root(square);
                (voltage, parts) = (wanted.times(share), parts.times(share));
            } else {
                parts = d_first(parts, square, self.circle);
                voltage = parts.times(self.modulation.volts(sample.bus));
            }
            beyond = voltage.minus(needed);
        }
        self.voltage = voltage;
        let second = Rotor {
            d: beyond.d - quarter * voltage.q,
            q: beyond.q + quarter * voltage.d,
        };
        let expected = self.later(begin, second);
        (self.d.expected, self.q.expected) = (expected.d, expected.q);

        // Until the middle of its width the rotor turns on.
        let parts = parts
            .turned(sine_cosine_of_four(quarter))
            .beside_stator(turned);
        Ok(self.modulation.widths_of_parts(parts, currents))
    }

    /// Whether what was measured is so far within its bounds that it need not be looked at more closely: beyond 0.8 of the trip it is; NaN always.
    #[inline(always)]
    fn is_safe(&self, [a, b, c]: [f32; 3], bus: f32) -> bool {
        a * a + b * b + c * c <= self.safe_square
            && bus.to_bits().wrapping_sub(self.least_bus) <= self.bus_range
    }

    /// What is not known stays a voltage that the bus has; NaN becomes 0. While both are within it together, each is.
    #[inline(always)]
    fn limit_unknown(&mut self, bus: f32) {
        let fits = self.d.unknown.abs() + self.q.unknown.abs() <= bus;
        if !fits {
            cold_path();
            self.d.unknown = limit_at_once(self.d.unknown, bus);
            self.q.unknown = limit_at_once(self.q.unknown, bus);
        }
    }

    /// The first sample, one near its bounds; or it cannot go on.
    #[cold]
    #[inline(never)]
    fn begin(&mut self, a: f32, b: f32, c: f32, bus: f32, current: Rotor) -> Result<(), Trip> {
        // By themselves they stay in registers.
        let currents = [a, b, c];
        if let Some(trip) = self.tripped {
            return Err(trip);
        }
        if let Some(found) = self.cause(currents, bus) {
            (self.tripped, self.safe_square) = (Some(found), NONE);
            self.voltage = Rotor::ZERO;
            return Err(found);
        }
        if self.safe_square == NONE {
            self.safe_square = self.config.trip * self.config.trip;
            self.current = current;
            (self.d.expected, self.q.expected) = (current.d, current.q);
        }
        Ok(())
    }

    /// Why it cannot go on, if it cannot.
    fn cause(&self, currents: [f32; 3], bus: f32) -> Option<Trip> {
        let CurrentConfig {
            trip,
            bus: (least, max),
            ..
        } = self.config;
        let is_below = |current: &f32| current.abs() <= trip;
        let sum: f32 = currents.iter().sum();
        if !currents.iter().all(is_below) {
            // What goes out by one of three phases comes back by the others.
            let is_short = self.wiring == Wiring::ThreePhase && sum.abs() > 0.5 * trip;
            return Some(if is_short {
                Trip::Short
            } else {
                Trip::OverCurrent
            });
        }
        if bus > max {
            return Some(Trip::OverVoltage);
        }
        (!is_within(bus, least, max)).then_some(Trip::UnderVoltage)
    }

    /// What keeps a current while the rotor turns by so many parts of 2³² of a turn in a period.
    #[inline(always)]
    fn keeping(&self, turn: f32) -> Keeping {
        Keeping {
            resistance: self.resistance,
            across: turn * self.q.reactance,
            along: turn * self.d.reactance,
            d: self.d.unknown,
            q: self.q.unknown + turn * self.induced,
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
            d: demand.d - self.weakening.current(),
            q: demand.q,
        };
        let square = demand.square();
        if square <= self.max_square {
            return demand;
        }
        cold_path();
        d_first(demand, square, self.config.max_current)
    }
}

/// What is beyond a circle, with its square: d first, and of q what it leaves. What is no number is nothing.
#[inline(always)]
fn d_first(wanted: Rotor, square: f32, max: f32) -> Rotor {
    if !square.is_finite() {
        return Rotor::ZERO;
    }
    let signed = |size: f32, sign: f32| if sign < 0.0 { -size } else { size };
    if wanted.d.abs() >= max {
        return Rotor {
            d: signed(max, wanted.d),
            q: 0.0,
        };
    }
    let left = root_of_number((max - wanted.d) * (max + wanted.d));
    Rotor {
        d: wanted.d,
        q: signed(left, wanted.q),
    }
}
