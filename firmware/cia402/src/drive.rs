//! The control half: state machine, mode of operation, planner; once per control tick.
//!
//! A tick looks at the world once (commands, inputs, what has become of the port), decides, commits what a motor that stood begins with (where
//! there are no refills, all), and publishes statusword, mode display and actual values together. `Drive::run` is the list of its steps; an
//! early tick takes a part of them. The motor has power in operation enabled, quick stop active and fault reaction active, and nowhere else.

mod absolute;
mod command;
mod in_step;
mod network;
mod operation;
mod periphery;
mod report;
mod stopping;
mod transitions;

use core::marker::PhantomData;

use canopen::{Duration, Instant};

use crate::actuator::{Actuator, AtPort, Emitter, EmitterLock, ServoAxis, StepAxis};
use crate::board::{DriveConfig, Inputs, Outputs};
use crate::brake::Brakes;
use crate::commands::Commands;
use crate::configuration::Configuration;
use crate::controlword::Command;
use crate::cyclic::{MicrosQ16, micros_q16};
use crate::exchange::{Actuals, Exchange, Share, TickResult, Waiting};
use crate::faults::{EXTERNAL, Faults};
use crate::inputs::Switches;
use crate::mode::Mode;
use crate::modes::Modes;
use crate::monitor::Monitor;
use crate::motor::Motor;
use crate::objects::{Everything, Objects};
use crate::periphery::{Latched, Periphery, Readings};
use crate::state_machine::{State, StateMachine};
use crate::travel::SoftwareLimits;
use crate::units::PositionFrame;

use absolute::Origin;
use in_step::Cyclic;
use network::Network;
use stopping::Power;

/// The drive of a dictionary `D` with an actuator `A`: what the data sheet does not list is not linked.
#[derive(Debug)]
pub struct Drive<D = Everything, A = StepAxis> {
    /// What the network wants, as of the last tick.
    commands: Commands,
    configuration: Configuration,
    /// Which number of the user belongs to which increment.
    frame: PositionFrame,
    /// Where it begins with an absolute encoder.
    origin: Origin,
    /// Where the motor may go.
    limits: SoftwareLimits,
    machine: StateMachine,
    modes: Modes,
    faults: Faults,
    motor: Motor<A>,
    brakes: Brakes,
    monitor: Monitor,
    switches: Switches,
    periphery: Periphery,
    power: Power,
    network: Network,
    /// The restart that is asked for has been done.
    has_restarted: bool,
    /// "Shutdown" was written before the command that stands, and has not been carried out yet.
    shutdown_first: bool,
    /// When the last regular tick was.
    ticked: Instant,
    /// The sync events of the network, and what the cyclic modes go by.
    cyclic: Cyclic,
    /// Its features alone are used.
    dictionary: PhantomData<fn() -> D>,
}

/// The tick that runs.
struct Tick<'a> {
    now: Instant,
    /// Microseconds since the last regular tick. In an early one no time passes.
    elapsed: u32,
    /// It runs between two regular ticks, for a command to stop or a stage that has failed.
    is_early: bool,
    inputs: &'a Inputs,
    /// Where the motor is.
    position: i64,
    /// It is not where it should be.
    is_displaced: bool,
    /// The configuration, or where the motor may go, may have changed.
    has_changed: bool,
    /// So may the commands.
    has_commands: bool,
    /// The commands may ask for something else than in the tick before.
    is_asked: bool,
    /// A transmit PDO has shown the state, or none can.
    is_seen: bool,
}

impl<D: Objects> Drive<D> {
    /// A drive with a step axis.
    // Out of line, so that it is made where it stays.
    #[inline(never)]
    pub fn new(config: DriveConfig) -> Self {
        Self::with_emitter(config, || Emitter::new(config))
    }
}

impl<D: Objects, L: EmitterLock> Drive<D, StepAxis<L>> {
    /// A drive with a step axis whose emitter a refill of higher priority uses, too.
    #[inline]
    pub fn with_emitter(config: DriveConfig, emitter: impl FnOnce() -> L) -> Self {
        let ahead = StepAxis::<L>::commit_ahead(config);
        Self::with_actuator(|| StepAxis::new(config, emitter), ahead, config.tick)
    }
}

impl<D: Objects, L: EmitterLock> Drive<D, ServoAxis<L>> {
    /// A drive with a servo axis and its emitter. A step of `config` is a count of the encoder, and its clock is the resolution of times.
    #[inline]
    pub fn servo(config: DriveConfig, emitter: impl FnOnce() -> L) -> Self {
        let ahead = StepAxis::<L>::commit_ahead(config);
        let axis = || ServoAxis::new(config, emitter);
        Self::with_actuator(axis, ahead, config.tick)
    }
}

impl<D: Objects, A: Actuator> Drive<D, A> {
    /// The modes of its data sheet that its actuator can do, bits as in 6502h.
    const MODES: u32 = D::DRIVE.modes & A::MODES;

    /// A drive that is not ready to switch on, with an actuator that commits demands so long ahead of the motor, and with control ticks of
    /// this period. It becomes switch on disabled by itself with the first one.
    // Out of line, so that it is made where it stays.
    #[inline(never)]
    pub fn with_actuator(actuator: impl FnOnce() -> A, ahead: MicrosQ16, tick: Duration) -> Self {
        Self {
            commands: Commands::NONE,
            configuration: Configuration::NONE,
            frame: PositionFrame::new(),
            origin: Origin::NotConfigured,
            limits: SoftwareLimits::new(),
            machine: StateMachine::new(),
            modes: Modes::new(),
            faults: Faults::default(),
            cyclic: Cyclic::new(ahead, tick),
            brakes: Brakes::new(),
            monitor: Monitor::new(),
            switches: Switches::default(),
            periphery: Periphery::new(),
            power: Power::Off,
            network: Network::Lost,
            has_restarted: false,
            shutdown_first: false,
            ticked: Instant::from_ticks(0),
            dictionary: PhantomData,
            // Last, as it is large: so it is made where it stays.
            motor: Motor::new(actuator),
        }
    }

    /// The state, as published by the last tick.
    pub const fn state(&self) -> State {
        self.machine.state()
    }

    /// For the scope: what there is to see of the last tick beside what it has published.
    pub(crate) const fn result<'a>(&'a self, actuals: &'a Actuals) -> TickResult<'a> {
        TickResult {
            actuals,
            commands: &self.commands,
            units: self.configuration.units.of_drive::<D>(),
        }
    }

    /// One control tick. `now` is its time, on the clock that stamps received frames; `inputs` were read just before.
    pub fn tick<P, X: Share>(
        &mut self,
        now: Instant,
        inputs: &Inputs,
        port: &mut P,
        exchange: &mut X,
    ) -> Outputs
    where
        A: AtPort<P>,
    {
        self.run(false, (now, inputs), port, exchange)
    }

    /// An early tick, so that a stop need not wait for the next control tick: to be called when a command to stop has come
    /// ([`Exchange::calls_early`]: halt, quick stop, disable operation or voltage, a lost network), or when the board sees that its power
    /// stage has failed or that frames were lost. The regular ticks follow as they would have without it. `now` and `inputs` are as for
    /// [`Drive::tick`], but the digital inputs are ignored: their edges are for the regular tick.
    ///
    /// It does what concerns the command and the motor. Everything that goes by the regular ticks is left to these: switches and their
    /// debouncing, the touch probes, data records and set-points of the cyclic modes, the times of the ticks, pulses for a motor
    /// that moves, the sixteen ticks of the actual velocity, samples of the scope. So no time is shortened and nothing is consumed twice.
    pub fn early_tick<P, X: Share>(
        &mut self,
        now: Instant,
        inputs: &Inputs,
        port: &mut P,
        exchange: &mut X,
    ) -> Outputs
    where
        A: AtPort<P>,
    {
        self.run(true, (now, inputs), port, exchange)
    }

    /// The steps of a tick. The large ones are out of line, and so are the modes: no function is above 4 kB, and none comes twice.
    fn run<P, X: Share>(
        &mut self,
        is_early: bool,
        (now, inputs): (Instant, &Inputs),
        port: &mut P,
        exchange: &mut X,
    ) -> Outputs
    where
        A: AtPort<P>,
    {
        let waiting = self.take(is_early, exchange);
        let is_asked = is_early || waiting.has_orders || waiting.is_configured;
        let command = if self.is_unchanged(is_asked) {
            Some(Command::EnableOperation)
        } else {
            self.command()
        };
        let (position, is_displaced) = self.look_at_motor(now, inputs, port);
        let tick = &Tick {
            now,
            elapsed: self.elapse(is_early, now),
            is_early,
            inputs,
            position,
            is_displaced,
            has_changed: self.look_for_changes(waiting.is_configured, position),
            has_commands: waiting.has_commands,
            is_asked,
            is_seen: waiting.is_seen,
        };
        self.look_at_switches(tick);
        self.measure(tick);
        self.probe(tick);
        self.watch_motor(tick);
        let restarts = self.take_restart(tick);
        let mode_bits = if restarts {
            self.restart();
            0
        } else {
            self.change_state(tick, command);
            self.move_brake(now);
            self.operate(tick, command)
        };
        self.keep_records(tick, exchange);
        let next_tick = self.next_tick(tick);
        self.commit(tick, port);
        let statusword = self.publish(tick, mode_bits, restarts, exchange);
        Outputs {
            next_tick,
            power_stage: self.power.is_on(),
            brake_released: self.brakes.actual.is_released(),
            drop_pulses: !self.power.is_on() || self.motor.is_cut(),
            current: self.motor_current(tick.elapsed),
            microsteps: self.configuration.microsteps,
            digital: self.output_levels(statusword),
            compare: self.compare(),
        }
    }

    /// What has come from the network since the last tick.
    #[inline(never)]
    fn take<X: Share>(&mut self, is_early: bool, exchange: &mut X) -> Waiting {
        let waiting = exchange.lock(|exchange| {
            if is_early {
                exchange.take_early(&mut self.commands)
            } else {
                exchange.take(&mut self.commands)
            }
        });
        if waiting.is_configured {
            exchange.lock(|exchange| exchange.take_configuration(&mut self.configuration));
            self.await_origin();
        }
        if !is_early {
            let cyclic = &self.configuration.cyclic;
            let mode = self.modes.active();
            let wanted = if self.commands.mode == mode.code() {
                mode
            } else {
                Mode::among(Self::MODES, self.commands.mode).unwrap_or(mode)
            };
            let keeps_records = Mode::InterpolatedPosition.is_among(Self::MODES);
            self.cyclic
                .take(waiting, exchange, cyclic, (mode, wanted), keeps_records);
        } else if waiting.is_configured {
            self.cyclic.look_anew();
        }
        waiting
    }

    /// Where the motor is, and whether it is not where it should be.
    fn look_at_motor<P>(&mut self, now: Instant, inputs: &Inputs, port: &P) -> (i64, bool)
    where
        A: AtPort<P>,
    {
        if !self.power.is_on() {
            self.take_direction(inputs);
        }
        let position = self.motor.position_of(inputs.position);
        self.await_rotor(now, inputs);
        let is_held = self.power.is_on() && self.brakes.is_rotor_aligned(now);
        // It stood at the end of the last tick: its position must now be the one its demands lead to.
        let stood = self.motor.standstill();
        let is_displaced = is_held
            && stood
            && !self.motor.is_cut()
            && self.motor.is_displaced(position, inputs.position_tolerance);
        // The pulses of the last tick may have been cut off before they left, though they are counted.
        let is_cut_off = inputs.fault == Some(EXTERNAL) && !stood;
        if is_displaced || is_cut_off {
            self.motor.lose_reference();
        }
        self.motor.observe(micros_q16(now), position, is_held, port);
        if !self.power.is_on() && self.motor.standstill() {
            self.motor.set_up(&self.configuration);
        }
        (position, is_displaced)
    }

    /// Microseconds since the last regular tick.
    fn elapse(&mut self, is_early: bool, now: Instant) -> u32 {
        if is_early {
            self.cyclic.slots.clear();
            return 0;
        }
        let since = core::mem::replace(&mut self.ticked, now);
        let keeps_records = Mode::InterpolatedPosition.is_among(Self::MODES);
        self.cyclic
            .pass(micros_q16(now), &self.configuration.cyclic, keeps_records);
        now.checked_duration_since(since)
            .map_or(0, |span| u32::try_from(span.ticks()).unwrap_or(u32::MAX))
    }

    /// Computes again what depends on units and limits, if they or the home position may have changed.
    fn look_for_changes(&mut self, is_configured: bool, position: i64) -> bool {
        if is_configured {
            // An early tick does not look at them: the next regular one does.
            self.switches.look_anew();
        }
        let has_changed =
            is_configured || self.limits.are_old(&self.frame, self.motor.is_referenced());
        if has_changed {
            self.look_at_units(position);
        }
        has_changed
    }

    /// Computes again what depends on units and limits, when they or the home position have changed.
    #[cold]
    #[inline(never)]
    fn look_at_units(&mut self, position: i64) {
        let units = self.configuration.units.of_drive::<D>();
        if self.frame.set_units(units) {
            self.periphery.probes.show_anew();
        }
        let is_referenced = self.motor.is_referenced();
        self.limits.work_out(
            &self.configuration,
            (&self.frame, units),
            position,
            is_referenced,
        );
    }

    /// Commits the pulses of the next time slices between two ticks ([`DriveConfig::refills`]), where these and the refills come one after the other; where
    /// refills interrupt the ticks, [`Emitter::refill`] is for them. Nothing is decided here.
    pub fn refill<P>(&mut self, port: &mut P)
    where
        A: AtPort<P>,
    {
        self.motor.refill(port);
    }

    /// Compares what the motor does with what it should.
    #[inline(never)]
    fn watch_motor(&mut self, tick: &Tick<'_>) {
        let (demand, is_counted) = (self.motor.demand(), tick.inputs.position_tolerance == 0);
        if !self.power.is_on() {
            if !tick.is_early {
                self.monitor.reset(tick.now);
            }
        } else if tick.is_early {
            self.monitor.look_again(demand, tick.position, is_counted);
        } else {
            self.monitor.observe(
                tick.now,
                demand,
                tick.position,
                is_counted,
                &self.configuration,
            );
        }
    }

    /// NMT reset node: as after power-on.
    fn restart(&mut self) {
        self.machine = StateMachine::new();
        self.faults = Faults::default();
        self.monitor.forget_following_error();
    }

    /// Forgets the data records that no mode may take any more; an early tick also those that wait for the next regular one, at which they
    /// may be kept again.
    fn keep_records<X: Share>(&mut self, tick: &Tick<'_>, exchange: &mut X) {
        let keeps = self.state() == State::OperationEnabled && self.modes.keeps_records();
        if !keeps {
            self.cyclic.buffer.clear();
            if tick.is_early {
                exchange.lock(Exchange::forget_records);
            }
        }
    }

    /// When the next regular tick is due.
    fn next_tick(&mut self, tick: &Tick<'_>) -> Option<Instant> {
        if tick.is_early {
            return None;
        }
        let is_cyclic = self.modes.active().is_cyclic();
        self.cyclic.next_tick(tick.now, is_cyclic)
    }

    /// Commits what the tick has decided; an early one only for a motor that stands, as the set-points of the cyclic modes count on what is
    /// committed when.
    fn commit<P>(&mut self, tick: &Tick<'_>, port: &mut P)
    where
        A: AtPort<P>,
    {
        if !tick.is_early || self.motor.is_at_rest() {
            self.motor.advance(port);
        }
        self.motor.look_again(port);
    }

    /// Publishes what the tick has made of the drive. Returns the statusword.
    #[inline(never)]
    fn publish<X: Share>(
        &mut self,
        tick: &Tick<'_>,
        mode_bits: u16,
        restarts: bool,
        exchange: &mut X,
    ) -> u16 {
        let actuals = self.actuals(tick.now, tick.inputs, mode_bits);
        let latched = self.take_latched();
        let readings = self
            .periphery
            .take_readings::<D>(tick.inputs, &self.configuration);
        let has_news =
            latched.is_some() || readings.is_some() || restarts || self.faults.has_notices();
        exchange.lock(|exchange| {
            exchange.publish(&actuals);
            if has_news {
                self.tell(latched.as_ref(), readings, restarts, exchange);
            }
        });
        actuals.statusword
    }

    /// Tells what few ticks have to tell.
    #[cold]
    #[inline(never)]
    fn tell(
        &mut self,
        latched: Option<&Latched>,
        readings: Option<Readings>,
        restarts: bool,
        exchange: &mut Exchange,
    ) {
        if let Some(latched) = latched {
            exchange.latch(latched);
        }
        if let Some(readings) = readings {
            exchange.show(readings);
        }
        if restarts {
            exchange.forget_notices();
        }
        while let Some(notice) = self.faults.take_notice() {
            exchange.notify(notice);
        }
    }
}

#[cfg(test)]
mod tests;
