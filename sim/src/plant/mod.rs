//! The plant: a stepper motor on its driver, with limit and home switches, index pulses and end stops, on virtual time.
//!
//! It takes the same pulse records as the step timer of a board and plays them tick by tick. What it counts is what really left,
//! so it is the judge of every move. By itself each pulse moves the motor by one step, exactly; on an axis with a motor that has a
//! mass ([`MotorData`]) pulses turn a field, and the rotor follows it or does not. Edges at the inputs are caught at the
//! step that made them, as the capture units of a board do. The same commands and the same seed give the same motion.

mod axis_file;
mod brake;
mod chance;
mod contact;
mod counter;
mod follow;
mod motor;
mod pulses;
mod servo;
mod supply;
mod track;

pub use axis_file::Axis;
pub use contact::{Sensed, Switch};
pub use counter::SecondCounter;
pub use motor::{Heat, Load, MotorData, SupplyChange, SupplyData};
pub use pulses::{PulsePlayer, Pulses};
pub use servo::{AXES, Magnet, ServoAxisData, ServoMotor, eccentricity_table};
pub use track::{Index, SwitchStates, Track, WIRES};

use std::f64::consts::TAU;

use brake::Brake;
use canopen::{Duration, Instant};
use motion::Ticks;
use motor::Motor;
use supply::Supply;
use track::Surroundings;

/// The step clock: 84 MHz, that of the STM32F405's timer 2.
pub const STEP_CLOCK_HZ: u32 = 84_000_000;

/// The motor and what is around it.
#[derive(Clone, Debug)]
pub struct Plant {
    pulses: PulsePlayer,
    now: Instant,
    energised: bool,
    brake: Brake,
    /// Where the motor stands along the axis.
    rotor: i64,
    /// What moves it, if a pulse is not simply a step.
    motor: Option<Motor>,
    /// What moves it by its current, in place of pulses.
    servo: Option<Box<ServoMotor>>,
    /// Until when the motor has moved.
    moved: Instant,
    /// What feeds it, if that can change.
    source: Option<Supply>,
    /// Where it stood at power-on: the drive counts from there.
    origin: i64,
    surroundings: Surroundings,
    /// It ran into an end stop since the drive looked last.
    blocked: bool,
    /// The motor driver puts so many milliamperes into the motor.
    current: u16,
    /// The motor driver makes a full step of so many pulses.
    microsteps: u16,
    /// The levels of the digital outputs.
    outputs: u8,
    /// The supply of the power stage is there.
    pub supply: bool,
    /// The supply of the power stage in millivolts.
    pub supply_voltage: u32,
    /// The supply of the electronics in millivolts.
    pub auxiliary_voltage: u32,
    /// The battery of an encoder in millivolts.
    pub battery_voltage: u32,
    /// The temperature of the power stage in tenths of a degree Celsius.
    pub temperature: i16,
    /// What the converter of 12 bits at the analogue input reads.
    pub analogue: u16,
    /// What turns the second counter.
    pub second: SecondCounter,
    /// A fault the power stage reports, as a CiA 402 error code (2310h: over-current ...).
    pub fault: Option<u16>,
    /// What the power stage warns of, as a CiA 402 error code (4210h: temperature ...).
    pub warning: Option<u16>,
    /// The drive counts what the motor does. Else it counts the pulses that left, and knows nothing of those that were lost.
    pub encoder: bool,
}

impl Plant {
    /// A motor at rest at position 0 with its supply on and nothing along its axis.
    pub fn new(now: Instant) -> Self {
        Self {
            pulses: PulsePlayer::default(),
            now,
            energised: false,
            rotor: 0,
            motor: None,
            servo: None,
            moved: now,
            source: None,
            brake: Brake::new(),
            origin: 0,
            surroundings: Surroundings::default(),
            blocked: false,
            current: 0,
            microsteps: 0,
            outputs: 0,
            supply: true,
            supply_voltage: 24_000,
            auxiliary_voltage: 24_000,
            battery_voltage: 3_600,
            temperature: 250,
            analogue: 0,
            second: SecondCounter::default(),
            fault: None,
            warning: None,
            encoder: false,
        }
    }

    /// Puts the motor on an axis. It stays at rest, and counts on.
    pub fn mount(&mut self, axis: &Axis) {
        self.origin += axis.start - self.rotor;
        self.rotor = axis.start;
        self.encoder = axis.encoder;
        self.surroundings = Surroundings::new(&axis.track, axis.start, axis.seed);
        self.motor = axis
            .motor
            .as_ref()
            .map(|data| Motor::new(data, axis.start, axis.track.stops.as_ref()));
        if let Some(data) = &axis.servo {
            let mut data = *data;
            let turns = axis.start as f64 / f64::from(data.plant.sensors.counts);
            data.start += turns * TAU;
            self.servo = Some(Box::new(ServoMotor::new(&data, axis.seed)));
            self.encoder = true;
        }
        self.moved = self.now;
        self.source = axis.supply.clone().map(Supply::new);
        self.feel();
    }

    /// The power is back: no fault, no current, nothing to play, and the position counts from 0, or from the zero of an absolute encoder. The motor
    /// and its switches are where they were.
    pub fn power_on(&mut self, now: Instant) {
        self.origin = self.rotor;
        self.pulses = PulsePlayer::default();
        self.now = now;
        self.moved = now;
        if let Some(motor) = &mut self.motor {
            motor.power_on();
        }
        if let Some(servo) = &mut self.servo {
            servo.power_on();
        }
        self.energise(false);
        self.open_brake(false);
        self.fault = None;
        self.warning = None;
    }

    /// The time up to which the motor has run.
    pub fn now(&self) -> Instant {
        self.now
    }

    /// Lets the motor run until `now`.
    pub fn advance(&mut self, now: Instant) {
        let Some(span) = now.checked_duration_since(self.now) else {
            return;
        };
        if self.servo.is_some() {
            self.turn_servo(now, span);
        } else if self.motor.is_some() {
            self.turn_field(now);
        } else {
            self.step_along(now, span);
            if let Some(source) = &mut self.source {
                source.step(now, 0.0, 1.0);
            }
        }
        self.feel();
    }

    /// What the board measures of motor and supply.
    fn feel(&mut self) {
        if let Some(motor) = &self.motor {
            self.temperature = motor.temperature();
        }
        if let Some(source) = &self.source {
            self.supply_voltage = source.millivolts();
        }
    }

    /// The loops of a servo turn the motor, along a path that is played for its time.
    fn turn_servo(&mut self, now: Instant, span: Duration) {
        let Some(servo) = &mut self.servo else {
            return;
        };
        let begin = self.pulses.played();
        self.pulses.play(ticks(span), |_| {});
        let start = self.rotor - servo.moved();
        let origin = self.origin - start;
        servo.plant_mut().is_fed = self.supply;
        let order = self.pulses.ordered();
        servo.run(
            span.ticks(),
            begin,
            order.as_ref(),
            origin,
            self.temperature,
        );
        self.now = now;
        self.supply_voltage = servo.millivolts();
        self.pulses.tell(servo.rated(), servo.report(origin));
        let rotor = start + servo.moved();
        let counted = servo.begun() - self.origin;
        let time = nanoseconds(now);
        if !self.surroundings.is_empty() {
            let way = rotor - self.rotor;
            for done in 1..=way.abs() {
                let next = self.rotor + done * way.signum();
                self.surroundings.follow(next, (next + counted, time));
            }
        }
        self.rotor = rotor;
    }

    /// The servo, if one moves the motor.
    pub fn servo(&self) -> Option<&ServoMotor> {
        self.servo.as_deref()
    }

    /// The servo, to load it or to break it.
    pub fn servo_mut(&mut self) -> Option<&mut ServoMotor> {
        self.servo.as_deref_mut()
    }

    /// Each pulse is a step.
    fn step_along(&mut self, now: Instant, span: Duration) {
        let before = nanoseconds(self.now);
        self.now = now;
        let ticks = ticks(span);
        let Self {
            pulses,
            rotor,
            origin,
            surroundings,
            blocked,
            encoder,
            ..
        } = self;
        if surroundings.is_empty() {
            pulses.play(ticks, |pulses| *rotor += pulses.steps);
            return;
        }
        pulses.play(
            ticks,
            |Pulses {
                 from,
                 steps,
                 at,
                 period,
             }| {
                for done in 1..=steps.abs() {
                    let next = *rotor + steps.signum();
                    let ticks = at + (done.unsigned_abs() - 1) * u64::from(period);
                    let time = before + ticks * 1_000_000_000 / u64::from(STEP_CLOCK_HZ);
                    if !surroundings.is_free(next) {
                        *blocked = true;
                        continue;
                    }
                    *rotor = next;
                    let count = if *encoder {
                        next - *origin
                    } else {
                        from + done * steps.signum()
                    };
                    surroundings.follow(next, (count, time));
                }
            },
        );
    }

    /// Current in the motor or not.
    pub fn energise(&mut self, on: bool) {
        self.energised = on;
        if let Some(servo) = &mut self.servo {
            servo.energise(on);
        }
    }

    /// Whether there is current in the motor.
    pub fn is_energised(&self) -> bool {
        self.energised
    }

    /// The holding brake is told to open or to close; on an axis with a motor it takes its time.
    pub fn open_brake(&mut self, open: bool) {
        let delay = self.motor.as_ref().map(|motor| {
            let load = &motor.data().load;
            if open {
                load.brake_release
            } else {
                load.brake_engage
            }
        });
        self.brake
            .order(open, self.now, delay.unwrap_or(Duration::from_ticks(0)));
    }

    /// Whether the holding brake is told to be open.
    pub fn is_brake_open(&self) -> bool {
        self.brake.opens()
    }

    /// What the motor driver is set to: the current in milliamperes, and the pulses of a full step.
    pub fn set_driver(&mut self, current: u16, microsteps: u16) {
        self.current = current;
        self.microsteps = microsteps;
    }

    /// The current in the motor, in milliamperes. A driver that was never set has the rated one.
    pub fn current(&self) -> u16 {
        match &self.motor {
            Some(motor) if self.microsteps == 0 => motor.data().rated_current,
            _ => self.current,
        }
    }

    /// The pulses of a full step.
    pub fn microsteps(&self) -> u16 {
        self.microsteps
    }

    /// What a pulse is to the motor. A driver that was never set makes the steps of the axis.
    fn pulses_of_full_step(&self) -> u16 {
        match &self.motor {
            Some(motor) if self.microsteps == 0 => motor.data().microsteps,
            _ => self.microsteps,
        }
    }

    /// The drive sets its digital outputs: output `n` in bit `n − 1`.
    pub fn set_outputs(&mut self, levels: u8) {
        self.outputs = levels;
    }

    /// The levels of the digital outputs, output `n` in bit `n − 1`.
    pub fn outputs(&self) -> u8 {
        self.outputs | self.pulses.outputs()
    }

    /// The position in steps as the drive counts it: every pulse that left, by its direction, or the encoder.
    pub fn position(&self) -> i64 {
        match &self.motor {
            _ if !self.encoder => self.pulses.position(),
            Some(motor) => motor.measured(self.pulses_of_full_step()),
            None => {
                let begun = self.servo.as_ref().map_or(0, |servo| servo.begun());
                self.rotor - self.origin + begun
            }
        }
    }

    /// Steps in a turn of an absolute encoder, once it has told where in it the motor is. The position counts from its zero then.
    pub fn absolute_turn(&self) -> u32 {
        self.servo.as_ref().map_or(0, |servo| servo.absolute_turn())
    }

    /// How far the position may be from where the pulses lead while the motor is held, in pulses: an encoder shows the play of
    /// a real motor in its field.
    pub fn position_tolerance(&self) -> u32 {
        if let Some(servo) = &self.servo {
            servo.position_tolerance()
        } else if self.encoder && self.motor.is_some() {
            Motor::position_tolerance(self.pulses_of_full_step())
        } else {
            0
        }
    }

    /// Whether the motor driver senses that the motor does not follow; `None` if it has no such sense.
    pub fn stall(&self) -> Option<bool> {
        match &self.servo {
            Some(servo) => Some(servo.is_stalled()),
            None => self.motor.as_ref().and_then(Motor::stall),
        }
    }

    /// Where the motor is along the axis, in steps.
    pub fn rotor(&self) -> i64 {
        self.rotor
    }

    /// The motor is somewhere else all of a sudden, in steps, and the drive's count with it. Where pulses turn a field they are
    /// not counted for that: an encoder sees it, and else nobody.
    pub fn displace(&mut self, steps: i64) {
        self.rotor += steps;
        match &mut self.motor {
            Some(motor) => motor.displace(steps),
            None if self.servo.is_some() => {}
            None => self.pulses.displace(steps),
        }
        let count = self.position();
        let time = nanoseconds(self.now);
        self.surroundings.follow(self.rotor, (count, time));
    }

    /// What the inputs have seen since the last look.
    pub fn look(&mut self) -> [Sensed; WIRES] {
        let count = self.position();
        self.surroundings.look((count, nanoseconds(self.now)))
    }

    /// Whether the motor ran into an end stop since the last call.
    pub fn take_blocked(&mut self) -> bool {
        std::mem::take(&mut self.blocked)
    }

    /// What the switches say where the motor is.
    pub fn switch_states(&self) -> SwitchStates {
        self.surroundings.states()
    }

    /// The pulse records on their way to the motor.
    pub fn pulses(&self) -> &PulsePlayer {
        &self.pulses
    }

    /// The pulse records on their way to the motor, to add to them or to drop them.
    pub fn pulses_mut(&mut self) -> &mut PulsePlayer {
        &mut self.pulses
    }
}

/// A span in ticks of the step clock.
fn ticks(span: Duration) -> Ticks {
    span.ticks() * u64::from(STEP_CLOCK_HZ / 1_000_000)
}

/// A moment in nanoseconds.
fn nanoseconds(now: Instant) -> u64 {
    now.ticks() * 1_000
}

#[cfg(test)]
mod tests;
