//! The port of a servo axis: records pass in time, orders and reports go over the link.

use core::cell::Cell;

use cia402::{RatedMotor, ServoOrder, ServoPort, ServoReport};
use motion::{PulseSink, Record, Ticks};
use servo::Motor;

use super::link::Link;

/// Records that are taken at once. None is kept: they are nothing but time.
const CAPACITY: usize = 64;

/// See the module.
#[derive(Debug)]
pub struct Port {
    link: &'static Link,
    pending: Ticks,
    /// The clock at the last look; it is that of the records, and wraps.
    now: u32,
    /// The same when it was asked last what is pending: an order is for that moment, whoever has looked at the clock since.
    asked: Cell<u32>,
    /// The timer of the encoder where the position is 0.
    timer: u16,
    /// Its counts in a turn, and the positions in one.
    counts: (i64, i64),
    motor: RatedMotor,
}

impl Port {
    /// Without a record, at this count of the clock, and with the timer of the encoder as the loops have begun with it.
    pub const fn new(link: &'static Link, now: u32, timer: u16) -> Self {
        Self {
            link,
            pending: 0,
            now,
            asked: Cell::new(now),
            timer,
            counts: (1, 1),
            motor: RatedMotor::NONE,
        }
    }

    /// The same with a motor.
    pub fn with_motor(mut self, motor: &Motor) -> Self {
        self.motor = Self::rated(motor);
        self
    }

    /// A motor as its axis knows it.
    pub fn rated(motor: &Motor) -> RatedMotor {
        RatedMotor {
            current: (motor.rated_current * 1e3 + 0.5) as u32,
            torque: (motor.rated_torque() * 1e3 + 0.5) as u32,
            inertia: (motor.inertia * 1e9 + 0.5) as u32,
            counts: motor.counts,
        }
    }

    /// The same with an encoder that has so many counts in a turn of so many positions.
    pub fn with_counts(mut self, counts: u32, positions: u32) -> Self {
        self.counts = (counts.max(1).into(), positions.max(1).into());
        self
    }

    /// The position of the encoder, in counts from where it began; from its zero, if it is absolute.
    pub fn position(&self) -> i64 {
        self.link.status().report.counts
    }

    /// The same where its timer was at this count a short while ago.
    pub fn position_at(&self, timer: u16) -> i64 {
        let position = self.position();
        let (counts, positions) = self.counts;
        let scaled = |number: i64, by: i64, of: i64| {
            let product = number.wrapping_mul(by);
            product.checked_div_euclid(of).unwrap_or(0)
        };
        let told = self
            .timer
            .wrapping_add(scaled(position, counts, positions) as u16);
        let moved = timer.wrapping_sub(told).cast_signed();
        position.wrapping_add(scaled(moved.into(), positions, counts))
    }

    /// The clock has come so far, less than its range since the last call.
    pub fn pass(&mut self, now: u32) {
        let passed = now.wrapping_sub(self.now);
        self.now = now;
        self.pending = self.pending.saturating_sub(passed.into());
    }
}

impl PulseSink for Port {
    fn push(&mut self, record: Record) -> Result<(), Record> {
        let ticks = u64::from(record.period.max(1)).saturating_mul(record.repeat.into());
        self.pending = self.pending.saturating_add(ticks);
        Ok(())
    }

    fn pending(&self) -> Ticks {
        self.asked.set(self.now);
        self.pending
    }

    fn free(&self) -> usize {
        CAPACITY
    }
}

impl ServoPort for Port {
    fn motor(&self) -> RatedMotor {
        self.motor
    }

    fn order(&mut self, order: &ServoOrder) {
        self.link.order(order, self.asked.get());
    }

    fn report(&self) -> ServoReport {
        self.link.status().report
    }

    fn forget(&mut self) {
        self.pending = 0;
    }
}
