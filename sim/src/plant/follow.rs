//! How a motor with a mass goes through time: pulses into its field, the rotor behind it, and the axis behind the rotor.

use canopen::Instant;

use super::motor::{self, Orders};
use super::{Plant, nanoseconds, ticks};

impl Plant {
    /// Pulses turn the field of the motor until `now`, and the rotor does what it does.
    pub(super) fn turn_field(&mut self, now: Instant) {
        while self.moved + motor::STEP <= now {
            self.moved += motor::STEP;
            self.play_into_field(self.moved);
            self.turn_rotor();
        }
        self.play_into_field(now);
    }

    fn play_into_field(&mut self, until: Instant) {
        let Some(span) = until.checked_duration_since(self.now) else {
            return;
        };
        self.now = until;
        let before = self.pulses.position();
        self.pulses.play(ticks(span), |_| {});
        let microsteps = self.pulses_of_full_step();
        if let Some(motor) = &mut self.motor {
            motor.take(self.pulses.position() - before, microsteps);
        }
    }

    /// One step of the integration, and what the rotor passes on its way.
    fn turn_rotor(&mut self) {
        let orders = self.orders();
        let Some(motor) = &mut self.motor else {
            return;
        };
        motor.step(orders);
        self.blocked |= motor.is_at_stop();
        if let Some(source) = &mut self.source {
            source.step(self.moved, motor.power(), motor::SECONDS);
        }
        let way = motor.place() - self.rotor;
        for _ in 0..way.abs() {
            self.rotor += way.signum();
            let count = if self.encoder {
                motor.measured_at(self.rotor, orders.microsteps)
            } else {
                self.pulses.position()
            };
            let seen = (count, nanoseconds(self.moved));
            self.surroundings.follow(self.rotor, seen);
        }
    }

    /// What acts on the motor now.
    fn orders(&self) -> Orders {
        Orders {
            current: if self.energised { self.current() } else { 0 },
            microsteps: self.pulses_of_full_step(),
            is_braked: !self.brake.is_open(self.moved),
            supply: match &self.source {
                Some(source) => source.volts(),
                None => f64::from(self.supply_voltage) / 1e3,
            },
        }
    }
}
