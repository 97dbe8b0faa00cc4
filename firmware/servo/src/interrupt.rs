//! The current interrupt as a whole: what the converter and the timers say goes in, pulse widths come out.
//!
//! It is called in the middle of the pulses, above everything but a fault. What it shares with the control is one order: a current, and in how many
//! periods it is to be reached, evenly; so a control of a lower rate makes no steps of torque. Or a field that turns beside the stator: a rotor that swings in
//! it is pulled back at once, and not when the control comes by.

use crate::current_loop::{Sample, Trip};
use crate::feedback::{Incremental, Observer};
use crate::modulation::Widths;
use crate::motor::Implausible;
use crate::number::is_within;
use crate::offsets::CurrentSense;
use crate::transform::Rotor;
use crate::{Angle, CurrentLoop};

/// What is measured at a period, as it is read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Of the converter, of each phase.
    pub currents: [u16; 3],
    /// Of the converter, of the bus.
    pub bus: u16,
    /// Of the timer of the encoder.
    pub timer: u16,
}

/// What the loops above look at: a copy of what the interrupt has come to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Snapshot {
    /// Of the encoder, from where it began, in counts.
    pub position: i64,
    /// The electrical angle of the middle of its count.
    pub count: Angle,
    /// The electrical angle of the rotor between the counts.
    pub angle: Angle,
    /// How fast that turns, in electrical rad/s.
    pub speed: f32,
    /// Of the last sample, in A.
    pub current: Rotor,
    /// What was asked for at the last sample, within its limits, in A.
    pub demand: Rotor,
    /// The voltage that the model does not know of, in V.
    pub unknown: Rotor,
    /// How fast an error of the current goes, in 1/s.
    pub rate: f32,
    /// The current that weakens the field, in A.
    pub weakening: f32,
    /// The voltage of the bus, in V.
    pub bus: f32,
    /// The sum of all phase currents, in A.
    pub sum: f32,
}

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurrentInterrupt {
    /// The measurement of the currents.
    pub sense: CurrentSense,
    /// The encoder.
    pub encoder: Incremental,
    /// What is seen between its counts.
    pub observer: Observer,
    /// The loop.
    pub current: CurrentLoop,
    /// Volts of a count.
    bus: f32,
    demand: Rotor,
    step: Rotor,
    left: u16,
    /// From where the demand was seen, and by how much that turns in a period.
    field: Option<(Angle, Angle)>,
}

impl CurrentInterrupt {
    /// With volts of a count of the bus.
    ///
    /// # Errors
    /// With a bus of less than 10 µV or more than 10 V a count.
    pub fn new(
        sense: CurrentSense,
        encoder: Incremental,
        observer: Observer,
        current: CurrentLoop,
        bus: f32,
    ) -> Result<Self, Implausible> {
        Implausible::unless(is_within(bus, 1e-5, 10.0))?;
        Ok(Self {
            sense,
            encoder,
            observer,
            current,
            bus,
            demand: Rotor::ZERO,
            step: Rotor::ZERO,
            left: 0,
            field: None,
        })
    }

    /// Orders a current in A, reached evenly in so many periods.
    pub fn order(&mut self, demand: Rotor, periods: u16) {
        self.field = None;
        if periods == 0 {
            (self.demand, self.left) = (demand, 0);
            return;
        }
        let share = 1.0 / f32::from(periods);
        self.step = Rotor {
            d: (demand.d - self.demand.d) * share,
            q: (demand.q - self.demand.q) * share,
        };
        self.left = periods;
    }

    /// Orders a current in A as it is seen from a rotor at this angle; it goes on beside the stator with a speed in electrical rad/s.
    pub fn order_field(&mut self, demand: Rotor, from: Angle, speed: f32) {
        self.order(demand, 0);
        self.field = Some((from, self.current.turned_in_period(speed)));
    }

    /// A period: gives the pulse widths, as [`CurrentLoop::run`].
    ///
    /// # Errors
    /// The gates are to be off, until [`CurrentLoop::start`].
    #[inline(never)]
    pub fn run(&mut self, counts: &Counts) -> Result<Widths, Trip> {
        self.encoder.look_at_once(counts.timer);
        self.observer.look(self.encoder.angle_at_once());
        let sample = Sample {
            currents: self.sense.amperes(counts.currents),
            bus: f32::from(counts.bus) * self.bus,
            angle: self.observer.angle(),
            turn: self.observer.turn(),
        };
        let mut demand = self.demand;
        if self.left > 0 {
            self.left -= 1;
            demand = demand.plus(self.step);
            self.demand = demand;
        } else if let Some((from, turned)) = &mut self.field {
            *from = from.plus(*turned);
            demand = demand.turned(from.minus(sample.angle).sine_cosine());
        }
        self.current.run_in_place(&sample, demand)
    }

    /// A period in which the field stands at an angle with a current along it, in A, wherever the rotor is. Encoder and observer are left alone.
    ///
    /// # Errors
    /// As [`CurrentInterrupt::run`].
    pub fn hold(&mut self, counts: &Counts, angle: Angle, current: f32) -> Result<Widths, Trip> {
        let sample = Sample {
            currents: self.sense.amperes(counts.currents),
            bus: f32::from(counts.bus) * self.bus,
            angle,
            turn: Angle::ZERO,
        };
        self.current.run(&sample, Rotor { d: current, q: 0.0 })
    }

    /// The bus in V.
    pub fn volts(&self, counts: &Counts) -> f32 {
        f32::from(counts.bus) * self.bus
    }

    /// What it has come to, with what was measured last.
    pub fn snapshot(&self, counts: &Counts) -> Snapshot {
        Snapshot {
            position: self.encoder.position(),
            count: self.encoder.angle(),
            angle: self.observer.angle(),
            speed: self.observer.speed(),
            current: self.current.current(),
            demand: self.current.demand(),
            unknown: self.current.unknown(),
            rate: self.current.rate(),
            weakening: self.current.weakening.current(),
            bus: self.volts(counts),
            sum: self.sense.amperes(counts.currents).iter().sum(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::current_loop::CurrentConfig;
    use crate::modulation::Modulation;
    use crate::motor::tests::servo_100w;

    fn interrupt() -> CurrentInterrupt {
        let motor = servo_100w();
        let config = CurrentConfig::quick(&motor, 50e-6, 15.0, (10.0, 60.0));
        let modulation = Modulation::new(motor.wiring, 0.01, 0.1, 0.96).unwrap();
        CurrentInterrupt::new(
            CurrentSense::new(0.01, 2_048, 100).unwrap(),
            Incremental::new(&motor, 0, 2),
            Observer::new(2_000.0, 50e-6).unwrap(),
            CurrentLoop::new(&motor, config, modulation).unwrap(),
            0.016,
        )
        .unwrap()
    }

    const AT_REST: Counts = Counts {
        currents: [2_048; 3],
        bus: 3_000,
        timer: 0,
    };

    #[test]
    fn an_order_is_reached_evenly() {
        let mut interrupt = interrupt();
        interrupt.order(Rotor { d: -1.0, q: 4.0 }, 20);
        for period in 1..=20_u8 {
            interrupt.run(&AT_REST).unwrap();
            let wanted = f32::from(period) * 0.2;
            assert!((interrupt.current.demand().q - wanted).abs() < 1e-5);
        }
        interrupt.run(&AT_REST).unwrap();
        assert!((interrupt.current.demand().d + 1.0).abs() < 1e-5);
        interrupt.order(Rotor::ZERO, 0);
        interrupt.run(&AT_REST).unwrap();
        assert_eq!(interrupt.current.demand(), Rotor::ZERO);
    }

    #[test]
    fn a_field_goes_on_beside_the_stator() {
        let mut interrupt = interrupt();
        let from = interrupt.observer.angle();
        // A quarter of a turn in 100 periods of 50 µs, within what a count is.
        interrupt.order_field(Rotor { d: 1.0, q: 0.0 }, from, 314.16);
        for _ in 0..100 {
            interrupt.run(&AT_REST).unwrap();
        }
        let demand = interrupt.current.demand();
        assert!(
            (demand.q - 1.0).abs() < 5e-3 && demand.d.abs() < 5e-3,
            "{demand:?}"
        );
        interrupt.order(Rotor { d: 0.0, q: 1.0 }, 0);
        interrupt.run(&AT_REST).unwrap();
        assert_eq!(interrupt.current.demand(), Rotor { d: 0.0, q: 1.0 });
    }

    #[test]
    fn counts_beyond_the_trip_turn_it_off() {
        let mut interrupt = interrupt();
        let counts = Counts {
            currents: [2_048, 3_600, 496],
            ..AT_REST
        };
        assert_eq!(interrupt.run(&counts), Err(Trip::OverCurrent));
        let mut interrupt = self::interrupt();
        let counts = Counts {
            bus: 4_000,
            ..AT_REST
        };
        assert_eq!(interrupt.run(&counts), Err(Trip::OverVoltage));
    }
}
