//! A drive on virtual time for tests: the control tick, and a motor that plays the pulses.

use canopen::{Duration, Instant};
use motion::{AxisConfig, Clock, DriverTiming, PulseSink, Record, Ticks};
use std::collections::VecDeque;

use crate::commands::Commands;
use crate::configuration::Configuration;
use crate::controlword::ControlwordHistory;
use crate::exchange::{Actuals, Exchange};
use crate::faults::FaultNotice;
use crate::inputs::DigitalInputs;
use crate::option_codes::QuickStopOption;
use crate::state_machine::State;
use crate::statusword;
use crate::{Drive, DriveConfig, Inputs, Outputs};

/// The step timer runs at 1 MHz, so that a tick of it is a microsecond.
const STEP_CLOCK: u32 = 1_000_000;
const TIMING: DriverTiming = DriverTiming {
    pulse_high: 2,
    pulse_low: 2,
    direction_setup: 5,
    direction_hold: 5,
};

/// A motor that does what the records say.
#[derive(Debug, Default)]
pub(crate) struct Player {
    records: VecDeque<Record>,
    /// Ticks of the first record that have been played.
    played: Ticks,
    /// Steps that have left.
    pub(crate) position: i64,
    /// The most records it takes.
    capacity: usize,
}

impl Player {
    /// A motor at 0 that takes so many records at a time.
    pub(crate) fn with_capacity(capacity: usize) -> Self {
        Self {
            capacity,
            ..Self::default()
        }
    }

    /// Lets `ticks` pass. A step happens at the beginning of its period.
    pub(crate) fn play(&mut self, mut ticks: Ticks) {
        while ticks > 0
            && let Some(record) = self.records.front().copied()
        {
            let period = u64::from(record.period);
            let now = ticks.min(record.ticks() - self.played);
            let begun = (self.played + now).div_ceil(period) - self.played.div_ceil(period);
            if record.width > 0 {
                self.position += i64::try_from(begun).unwrap() * i64::from(record.direction.sign());
            }
            self.played += now;
            ticks -= now;
            if self.played == record.ticks() {
                self.records.pop_front();
                self.played = 0;
            }
        }
    }

    /// Power is off: what has not left is dropped.
    pub(crate) fn clear(&mut self) {
        self.records.clear();
        self.played = 0;
    }
}

impl PulseSink for Player {
    fn push(&mut self, record: Record) -> Result<(), Record> {
        if self.free() == 0 {
            return Err(record);
        }
        self.records.push_back(record);
        Ok(())
    }

    fn pending(&self) -> Ticks {
        self.records.iter().map(Record::ticks).sum::<Ticks>() - self.played
    }

    fn free(&self) -> usize {
        self.capacity.saturating_sub(self.records.len())
    }
}

/// A code of 605Ah, or the default if there is none like it.
pub(crate) fn quick_stop(code: i16) -> QuickStopOption {
    QuickStopOption::from_code(code).unwrap_or(Configuration::NONE.quick_stop)
}

/// A drive, its motor, and the commands of a master.
pub(crate) struct Rig {
    pub(crate) drive: Drive,
    pub(crate) exchange: Exchange,
    pub(crate) motor: Player,
    pub(crate) commands: Commands,
    pub(crate) configuration: Configuration,
    history: ControlwordHistory,
    pub(crate) supply: bool,
    pub(crate) fault: Option<u16>,
    pub(crate) warning: Option<u16>,
    pub(crate) digital: DigitalInputs,
    pub(crate) stall: Option<bool>,
    pub(crate) position_tolerance: u32,
    pub(crate) supply_voltage: Option<u32>,
    pub(crate) temperature: Option<i16>,
    pub(crate) analogue: Option<u16>,
    pub(crate) outputs: Outputs,
    /// Where the tick found the motor.
    pub(crate) seen: i64,
    now: Instant,
}

impl Rig {
    pub(crate) const TICK: Duration = Duration::from_ticks(1_000);

    /// A drive as it is before its first tick, in profile position mode.
    pub(crate) fn new() -> Self {
        let clock = Clock::new(STEP_CLOCK).unwrap();
        let axis = AxisConfig {
            clock,
            time_slice: 500,
            timing: TIMING,
        };
        Self {
            drive: Drive::new(DriveConfig {
                axis,
                tick: Self::TICK,
                refills: 1,
            }),
            exchange: Exchange::new(),
            motor: Player::with_capacity(256),
            commands: Commands {
                remote: true,
                mode: 1,
                profile_velocity: 10_000.into(),
                profile_acceleration: 100_000,
                profile_deceleration: 100_000,
                ..Commands::NONE
            },
            configuration: Configuration {
                position_window: 10,
                position_window_time: 10,
                quick_stop_deceleration: 1_000_000,
                ..Configuration::NONE
            },
            history: ControlwordHistory::new(0),
            supply: true,
            fault: None,
            warning: None,
            digital: DigitalInputs::NONE,
            stall: None,
            position_tolerance: 0,
            supply_voltage: None,
            temperature: None,
            analogue: None,
            outputs: Outputs::default(),
            seen: 0,
            now: Instant::from_ticks(0),
        }
    }

    /// A drive in operation enabled.
    pub(crate) fn enabled() -> Self {
        let mut rig = Self::new();
        rig.enable();
        rig
    }

    /// From switch on disabled, or from power-on, to operation enabled.
    pub(crate) fn enable(&mut self) {
        self.ticks(2);
        for controlword in [0x06, 0x07, 0x0F] {
            self.write(controlword);
            self.tick();
        }
        assert_eq!(self.state(), State::OperationEnabled);
    }

    /// The master writes the controlword; all other commands are posted with it.
    pub(crate) fn write(&mut self, controlword: u16) {
        self.commands.controlword = controlword;
        self.history.write(controlword);
        self.post();
    }

    /// The other commands have changed.
    pub(crate) fn post(&mut self) {
        let passed = self.history.take();
        self.exchange.configure(&self.configuration);
        self.exchange.post(Commands {
            rising: passed.rising,
            stop: passed.stop,
            shutdown_first: passed.shutdown_first,
            overwritten: passed.command,
            ..self.commands
        });
    }

    /// A set-point: target, then the edge of bit 4 with these other bits.
    pub(crate) fn set_point(&mut self, target: i32, bits: u16) {
        self.write(0x0F | bits);
        self.commands.target_position = target;
        self.write(0x1F | bits);
    }

    /// One control tick, then the motor plays until the next one.
    pub(crate) fn tick(&mut self) -> Actuals {
        self.tick_and_play(Self::TICK)
    }

    /// One control tick, then the motor plays for so long.
    pub(crate) fn tick_and_play(&mut self, time: Duration) -> Actuals {
        let inputs = self.inputs();
        self.digital.changed = 0;
        self.digital.captured = DigitalInputs::NONE.captured;
        self.seen = inputs.position;
        self.outputs = self
            .drive
            .tick(self.now, &inputs, &mut self.motor, &mut self.exchange);
        self.play(time)
    }

    /// An early tick, then the motor plays for so long. Edges of inputs are for the regular one.
    pub(crate) fn early_tick_and_play(&mut self, time: Duration) -> Actuals {
        let inputs = self.inputs();
        self.outputs =
            self.drive
                .early_tick(self.now, &inputs, &mut self.motor, &mut self.exchange);
        self.play(time)
    }

    fn inputs(&self) -> Inputs {
        Inputs {
            supply: self.supply,
            position: self.motor.position,
            warning: self.warning,
            fault: self.fault,
            digital: self.digital,
            stall: self.stall,
            absolute_turn: 0,
            position_tolerance: self.position_tolerance,
            supply_voltage: self.supply_voltage,
            temperature: self.temperature,
            analogue: self.analogue,
            auxiliary_voltage: None,
            battery_voltage: None,
            has_compare: false,
            counter: 0,
        }
    }

    fn play(&mut self, time: Duration) -> Actuals {
        if self.outputs.drop_pulses {
            self.motor.clear();
        }
        self.motor_plays(time);
        self.actuals()
    }

    /// Time without a tick.
    pub(crate) fn motor_plays(&mut self, time: Duration) {
        self.motor.play(time.ticks());
        self.now += time;
    }

    /// The time of the next tick.
    pub(crate) const fn now(&self) -> Instant {
        self.now
    }

    pub(crate) fn ticks(&mut self, count: usize) -> Actuals {
        for _ in 0..count {
            self.tick();
        }
        self.actuals()
    }

    /// Ticks until a condition holds; fails after ten seconds.
    pub(crate) fn until(&mut self, what: &str, condition: impl Fn(&Self) -> bool) -> usize {
        for count in 0..10_000 {
            if condition(self) {
                return count;
            }
            self.tick();
        }
        panic!("never: {what}; {:?}", self.actuals());
    }

    pub(crate) fn actuals(&self) -> Actuals {
        self.exchange.actuals_at(self.now)
    }

    pub(crate) fn state(&self) -> State {
        State::from_statusword(self.actuals().statusword).unwrap()
    }

    pub(crate) fn has(&self, bits: u16) -> bool {
        self.actuals().statusword & bits == bits
    }

    pub(crate) fn reached(&self) -> bool {
        self.has(statusword::TARGET_REACHED)
    }

    pub(crate) fn acknowledged(&self) -> bool {
        self.has(statusword::SET_POINT_ACKNOWLEDGE)
    }

    pub(crate) fn limited(&self) -> bool {
        self.has(statusword::INTERNAL_LIMIT)
    }

    /// Steps the motor makes in one tick.
    pub(crate) fn speed(&mut self) -> i64 {
        let before = self.motor.position;
        self.tick();
        self.motor.position - before
    }

    /// Runs until the motor stands and returns where.
    pub(crate) fn rest(&mut self) -> i64 {
        self.tick();
        self.until("motor at rest", |rig| rig.motor.pending() == 0);
        self.ticks(3);
        self.motor.position
    }

    pub(crate) fn notices(&mut self) -> std::vec::Vec<FaultNotice> {
        std::iter::from_fn(|| self.exchange.take_notice()).collect()
    }
}
