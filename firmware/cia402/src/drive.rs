//! The control half: state machine, mode of operation, planner; once per control tick.
//!
//! A tick looks at the world once (commands, inputs, what has become of the pulses), decides, hands out the pulses of
//! the next segments, and publishes statusword, mode display and actual values together. The motor has power in
//! operation enabled, quick stop active and fault reaction active, and nowhere else.

mod command;
mod early;
mod periphery;
mod report;
mod stopping;

use core::marker::PhantomData;

use canopen::{Duration, Instant};
use motion::{AxisConfig, PulseSink};

use crate::actuator::{Actuator, StepAxis};
use crate::brake::Brake;
use crate::configuration::Configuration;
use crate::controlword::Command;
use crate::cyclic::{Cyclic, fine};
use crate::exchange::{Actuals, Commands, Share};
use crate::faults::{EXTERNAL, Faults, Reaction};
use crate::inputs::{DigitalInputs, Switches};
use crate::modes::{Context, Mode, Modes};
use crate::monitor::{Monitor, Observed};
use crate::motor::Motor;
use crate::objects::{Everything, Objects};
use crate::option_codes::{Stop, StopRamp};
use crate::periphery::Periphery;
use crate::recorder;
use crate::state_machine::{Conditions, State, StateMachine, Transition};
use crate::statusword;
use crate::units::{Frame, SoftwareLimits};

/// What a drive is built from.
#[derive(Clone, Copy, Debug)]
pub struct DriveConfig {
    /// The step generator: clock, segment length, timing of the motor driver.
    pub axis: AxisConfig,
    /// The period of the control tick, the nominal time between two calls of [`Drive::tick`].
    pub tick: Duration,
    /// How often in a tick pulses are handed out, at least 1: by [`Drive::tick`], and by [`Drive::refill`] the other times. Two
    /// segments are handed out ahead; a segment shorter than the time between is stretched to it, so that one may come late by
    /// as much.
    pub refills: u32,
}

/// What the board measures, read once at the start of a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Inputs {
    /// The power stage has its supply (statusword bit 4).
    pub supply: bool,
    /// Position in increments: pulses that really left, or the encoder. When the motor has power and stands, it has to be
    /// where the pulses lead, up to `slack`; anything else is the fault 8611h.
    pub position: i64,
    /// How far an encoder may be from where the pulses lead while the motor is held, in increments: two and a half full steps of
    /// a stepper motor, which loses four at a time. 0 where pulses are counted: none may be missing.
    pub slack: u32,
    /// A fault the board has found, as a CiA 402 error code; it stands as long as it is reported.
    pub fault: Option<u16>,
    /// What the board warns of, as a CiA 402 error code (temperature, load): statusword bit 7 and an emergency message as long as
    /// it is reported. It changes no state.
    pub warning: Option<u16>,
    /// The digital inputs.
    pub digital: DigitalInputs,
    /// The motor driver senses that the motor is blocked; `None` if it has no such sense.
    pub stall: Option<bool>,
    /// The supply of the power stage in millivolts; `None` if the board cannot measure it. Then `supply` alone counts.
    pub supply_voltage: Option<u32>,
    /// The temperature of the power stage in tenths of a degree Celsius; `None` if the board cannot measure it.
    pub temperature: Option<i16>,
    /// The analogue input as its converter of 12 bits reads it, 0 ..= 4095; `None` if there is none.
    pub analogue: Option<u16>,
}

/// What the board must do, set at the end of a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Outputs {
    /// When the next tick is due, in step with SYNC; `None` where nothing but the nominal period matters, and behind an early tick. To the nearest microsecond;
    /// what is rounded off does not add up.
    pub next_tick: Option<Instant>,
    /// Current in the motor.
    pub power_stage: bool,
    /// The brake is open.
    pub brake_released: bool,
    /// Pulses not yet sent must be dropped: the power is off, or there is no ramp to stop on.
    pub drop_pulses: bool,
    /// The current that the motor driver is to put into the motor, in milliamperes; 0 without power.
    pub current: u16,
    /// How many pulses of a full step the motor driver is to be set to.
    pub microsteps: u16,
    /// The levels of the digital outputs, output `n` in bit `n − 1`.
    pub digital: u8,
}

/// The drive of a dictionary `D`: what the data sheet does not list is not linked.
#[derive(Debug)]
pub struct Drive<D = Everything> {
    /// What the network wants, as of the last tick.
    commands: Commands,
    configuration: Configuration,
    /// How the numbers of the user lie on the increments.
    frame: Frame,
    /// Where the motor may go.
    limits: SoftwareLimits,
    /// In this tick the configuration, or where the motor may go, may have changed.
    has_changed: bool,
    machine: StateMachine,
    modes: Modes,
    faults: Faults,
    motor: Motor<StepAxis>,
    /// The brake as the state machine wants it.
    brake: Brake,
    /// The brake itself: 60FEh may want it otherwise.
    fitted_brake: Brake,
    monitor: Monitor,
    /// What the monitor found in this tick.
    observed: Observed,
    /// The following error has been too large since the last fault reset.
    lost: bool,
    switches: Switches,
    periphery: Periphery,
    power: bool,
    /// The motor stood at the end of the last tick: its position must now be the one its pulses lead to.
    settled: bool,
    /// When the field has caught the rotor: from then on the motor may move.
    caught: Instant,
    /// The restart that is asked for has been done.
    restarted: bool,
    /// "Shutdown" was written before the command that stands, and has not been carried out yet.
    shutdown_first: bool,
    /// "Shutdown" or "disable operation" was the last command, and waits for the motor to stand.
    pending: Option<Command>,
    /// The network may command the drive, or 6007h lets it go on without.
    is_commanded: bool,
    /// The fault that 6007h = 1 makes of a loss of the network has been raised.
    is_abandoned: bool,
    /// When the last tick was.
    ticked: Instant,
    /// When the state began.
    entered: Instant,
    /// When the drive began to stop on its own: no remote control, or a fault. Until the power is off.
    own_stop: Option<Instant>,
    /// The state has been seen on the bus, or nobody looks.
    is_seen: bool,
    /// The fault reaction is over, and goes on only to be seen.
    is_only_shown: bool,
    /// A fault was reset meanwhile.
    resets_early: bool,
    /// The beat of the network, and what the cyclic modes go by.
    cyclic: Cyclic,
    /// The tick that runs is an early one.
    is_early: bool,
    /// Only its features are of interest.
    dictionary: PhantomData<fn() -> D>,
}

impl<D: Objects> Drive<D> {
    /// A drive that is not ready to switch on. It becomes switch on disabled by itself with the first tick.
    pub fn new(config: DriveConfig) -> Self {
        Self {
            commands: Commands::NONE,
            configuration: Configuration::NONE,
            frame: Frame::new(),
            limits: SoftwareLimits::new(),
            has_changed: false,
            machine: StateMachine::new(),
            modes: Modes::new(),
            faults: Faults::default(),
            motor: Motor::new(outlast_tick(config)),
            brake: Brake::new(),
            fitted_brake: Brake::new(),
            monitor: Monitor::new(),
            observed: Observed::default(),
            lost: false,
            switches: Switches::default(),
            periphery: Periphery::new(),
            power: false,
            settled: false,
            caught: Instant::from_ticks(0),
            restarted: false,
            shutdown_first: false,
            pending: None,
            is_commanded: false,
            is_abandoned: false,
            ticked: Instant::from_ticks(0),
            entered: Instant::from_ticks(0),
            own_stop: None,
            is_seen: true,
            is_only_shown: false,
            resets_early: false,
            cyclic: Cyclic::new(&outlast_tick(config), config.tick),
            is_early: false,
            dictionary: PhantomData,
        }
    }

    /// The state, as published by the last tick.
    pub const fn state(&self) -> State {
        self.machine.state()
    }

    /// For the scope: what there is to see of the last tick beside what it has published.
    pub(crate) const fn seen<'a>(&'a self, actuals: &'a Actuals) -> recorder::Tick<'a> {
        recorder::Tick {
            actuals,
            commands: &self.commands,
            units: &self.configuration.units,
        }
    }

    /// One control tick. `now` is its time, on the clock that stamps received frames; `inputs` were read just before.
    pub fn tick<S: PulseSink, X: Share>(
        &mut self,
        now: Instant,
        inputs: &Inputs,
        pulses: &mut S,
        exchange: &mut X,
    ) -> Outputs {
        let waiting = exchange.lock(|exchange| exchange.take(&mut self.commands));
        if waiting.is_configured {
            exchange.lock(|exchange| exchange.take_configuration(&mut self.configuration));
        }
        let cyclic = &self.configuration.cyclic;
        let mode = self.modes.active();
        let wanted = Mode::among(D::DRIVE.modes, self.commands.mode).unwrap_or(mode);
        self.cyclic.take(waiting, exchange, cyclic, (mode, wanted));
        self.is_seen = waiting.is_seen;
        let command = self.command();
        let elapsed = now
            .checked_duration_since(self.ticked)
            .map_or(0, |span| u32::try_from(span.ticks()).unwrap_or(u32::MAX));
        self.ticked = now;
        let (position, displaced) = self.look_at_motor(now, inputs, pulses);
        self.cyclic.pass(fine(now), &self.configuration.cyclic);
        self.is_early = false;
        self.look_for_changes(waiting.is_configured, position);
        self.switches.observe(
            &inputs.digital,
            &self.configuration.inputs,
            self.motor.count(position),
            elapsed,
        );
        self.measure(inputs, elapsed);
        self.probe(inputs, now, position);
        self.monitor(now, position, inputs.slack == 0);

        let restart = self.commands.restart;
        let restarts = restart && !self.restarted && self.is_idle();
        self.restarted = restart && (self.restarted || restarts);
        let mode_bits = if restarts {
            self.restart();
            0
        } else {
            self.change_state(now, inputs, command, displaced);
            self.move_brake(now);
            let blocked = self.blocked(inputs, position);
            self.operate(now, position, elapsed, blocked, command, pulses)
        };
        if !self.keeps_records() {
            self.cyclic.buffer.clear();
        }

        let is_cyclic = self.modes.active().is_cyclic();
        let next_tick = self.cyclic.next_tick(now, is_cyclic);

        let outputs = self.hand_over(
            (now, elapsed),
            inputs,
            mode_bits,
            restarts,
            pulses,
            exchange,
        );
        Outputs {
            next_tick,
            ..outputs
        }
    }

    /// Where the motor is, and whether it is not where it should be.
    fn look_at_motor<S: PulseSink>(
        &mut self,
        now: Instant,
        inputs: &Inputs,
        pulses: &S,
    ) -> (i64, bool) {
        if !self.power {
            let is_reversed = self.configuration.is_reversed;
            self.motor.set_reversed(is_reversed, inputs.position);
        }
        let position = self.motor.position_of(inputs.position);
        self.await_rotor(now, inputs);
        let is_held = self.power && self.is_caught(now);
        let displaced = is_held
            && self.settled
            && !self.motor.is_cut()
            && self.motor.is_displaced(position, inputs.slack);
        // The pulses of the last tick may have been cut off before they left, though they are counted.
        let is_cut_off = inputs.fault == Some(EXTERNAL) && !self.settled;
        if displaced || is_cut_off {
            self.motor.lose_reference();
        }
        if !self.power && self.motor.standstill() {
            self.motor.set_timing(self.configuration.pulse_timing);
        }
        self.motor.observe(position, is_held, pulses);
        self.motor.set_time(fine(now));
        (position, displaced)
    }

    /// Hands out pulses (an early tick only to a motor that stands), and publishes what the tick has made of the drive.
    fn hand_over<S: PulseSink, X: Share>(
        &mut self,
        (now, elapsed): (Instant, u32),
        inputs: &Inputs,
        mode_bits: u16,
        restarts: bool,
        pulses: &mut S,
        exchange: &mut X,
    ) -> Outputs {
        if !self.is_early {
            self.motor.plan_on(pulses);
        }
        // The set-points of the cyclic modes count on what is handed out when.
        if !self.is_early || self.motor.is_at_rest() {
            self.motor.advance(pulses);
        }
        self.settled = self.motor.is_settled(pulses);

        let actuals = self.actuals(now, inputs, mode_bits);
        let news = self.periphery_news(inputs);
        exchange.lock(|exchange| {
            exchange.publish(&actuals);
            if let Some(latched) = news.latched {
                exchange.latch(latched);
            }
            if let Some(readings) = news.readings {
                exchange.show(readings);
            }
            if restarts {
                exchange.forget_notices();
            }
            while let Some(notice) = self.faults.take_notice() {
                exchange.notify(notice);
            }
        });
        Outputs {
            next_tick: None,
            power_stage: self.power,
            brake_released: self.fitted_brake.is_released(),
            drop_pulses: !self.power || self.motor.is_cut(),
            current: self.motor_current(elapsed),
            microsteps: self.configuration.microsteps,
            digital: self.output_levels(actuals.statusword),
        }
    }

    /// Works out anew what hangs on units and limits, if they or the home position may have changed.
    fn look_for_changes(&mut self, is_configured: bool, position: i64) {
        if is_configured {
            // An early tick does not look at them: the next regular one does.
            self.switches.look_anew();
        }
        self.has_changed =
            is_configured || self.limits.are_old(&self.frame, self.motor.is_referenced());
        if self.has_changed {
            self.look_at_units(position);
        }
    }

    /// Works out anew what hangs on units and limits, when they or the home position have changed.
    #[cold]
    #[inline(never)]
    fn look_at_units(&mut self, position: i64) {
        if self.frame.set_units(&self.configuration.units) {
            self.periphery.probes.show_anew();
        }
        let is_referenced = self.motor.is_referenced();
        self.limits
            .work_out(&self.configuration, &self.frame, position, is_referenced);
    }

    /// Hands out the pulses of the next segments between two ticks ([`DriveConfig::refills`]). Nothing is decided here.
    pub fn refill<S: PulseSink>(&mut self, pulses: &mut S) {
        self.motor.advance(pulses);
    }

    /// To be called before an early tick where ticks and refills do not interrupt each other: hands out pulses if a refill will soon be due, which would
    /// have to wait for that tick, and for the regular one behind it.
    pub fn top_up<S: PulseSink>(&mut self, pulses: &mut S) {
        if self.motor.runs_short(pulses) {
            self.refill(pulses);
        }
    }

    /// Whether data records may wait.
    fn keeps_records(&self) -> bool {
        self.state() == State::OperationEnabled && self.modes.keeps_records()
    }

    /// Compares what the motor does with what it should.
    fn monitor(&mut self, now: Instant, position: i64, is_counted: bool) {
        if self.power {
            let demand = self.motor.demand();
            self.observed =
                self.monitor
                    .observe(now, demand, position, is_counted, &self.configuration);
            self.lost |= self.observed.is_lost;
        } else {
            self.monitor.reset(now);
            self.observed = Observed::default();
        }
    }

    /// Whether there is no power and nothing that still has to be done: the device may start anew.
    fn is_idle(&self) -> bool {
        !self.power && self.motor.standstill() && self.machine.state() != State::FaultReactionActive
    }

    /// NMT reset node: as after power-on.
    fn restart(&mut self) {
        self.machine = StateMachine::new();
        self.faults = Faults::default();
        self.lost = false;
        self.resets_early = false;
    }

    /// Faults, then the state machine, then what a transition does to the motor.
    fn change_state(
        &mut self,
        now: Instant,
        inputs: &Inputs,
        command: Option<Command>,
        displaced: bool,
    ) {
        let both_limits = self.switches.both_limits();
        let detected = self.faults.detect(
            inputs,
            self.power,
            displaced || self.observed.is_lost,
            both_limits,
            &self.periphery.stage,
        );
        let (remote, command, lost) = self.under_6007h(command);
        let lost_now = core::mem::replace(&mut self.is_commanded, remote) && !remote;
        let silent = self.set_points_lost();
        let late = self.pulses_late();
        let reaction = detected.or(lost).or(silent).or(late);
        let is_over = self.motor.standstill() && self.is_held_by_brake(now, remote, command);
        let has_shown = self.has_shown(now);
        let reset = self.resets_fault(is_over, has_shown, reaction.is_some());
        let conditions = Conditions {
            command,
            remote,
            quick_stop: self.configuration.quick_stop,
            at_once: self.leaving(command) == Some(Stop::PowerOff),
            standstill: is_over && has_shown,
            fault: reaction.is_some(),
            fault_reset: reset && !self.faults.cause_stands(),
        };
        if reset && self.machine.state() == State::Fault && self.faults.cause_stands() {
            self.faults.renew();
        }
        if let Some(transition) = self.machine.step(&conditions) {
            self.entered = now;
            self.carry_out(transition, reaction);
        } else if reaction == Some(Reaction::PowerOff) {
            self.power_off();
        } else if lost_now && !self.is_abandoned && self.is_stopped_by_state() {
            self.stop(Stop::Ramp(StopRamp::QuickStop));
        }
        if command == Some(Command::DisableVoltage) {
            // It waits for nothing, and no fault reaction goes on against it.
            self.power_off();
        }
        self.brake.set(
            self.power && (self.brake.is_released() || !self.is_leaving(remote, command)),
            now,
        );
        self.end_own_stop(now, remote);
    }

    /// The action of a transition (CiA 402-2, "transition events and actions").
    fn carry_out(&mut self, transition: Transition, reaction: Option<Reaction>) {
        match transition.to {
            State::OperationEnabled => {
                self.power = true;
                self.modes.enter(&self.motor);
            }
            State::QuickStopActive => self.stop(self.machine.quick_stop().stop()),
            State::FaultReactionActive => match reaction {
                Some(Reaction::AsConfigured) if self.power => {
                    self.stop(self.configuration.fault_reaction);
                }
                _ => self.power_off(),
            },
            State::SwitchOnDisabled if transition.from == State::Fault => {
                self.lost = false;
                self.faults.reset();
            }
            _ => self.power_off(),
        }
    }

    /// Whether the motor is blocked: the motor driver says so, or it is too far behind its pulses. `None` if neither can tell.
    fn blocked(&self, inputs: &Inputs, position: i64) -> Option<bool> {
        let window = self.configuration.homing.block_window;
        if window == 0 {
            return inputs.stall;
        }
        let behind = self.motor.demand().position.wrapping_sub(position) as i32;
        Some(inputs.stall == Some(true) || behind.unsigned_abs() >= window)
    }

    /// The mode of operation. Returns its bits of the statusword.
    fn operate(
        &mut self,
        now: Instant,
        position: i64,
        elapsed: u32,
        blocked: Option<bool>,
        command: Option<Command>,
        pulses: &mut dyn PulseSink,
    ) -> u16 {
        let state = self.machine.state();
        if state != State::OperationEnabled && self.motor.standstill() {
            self.modes.select::<D>(self.commands.mode);
        }
        let bits = match state {
            State::OperationEnabled => {
                if let Some(Stop::Ramp(ramp)) = self.leaving(command) {
                    // The transition waits until the motor stands.
                    self.modes.interrupt(
                        &mut self.motor,
                        ramp,
                        &self.commands,
                        &self.configuration,
                    );
                    return self.mind_limits() | self.mind_travel();
                }
                let limit = self.mind_limits();
                let is_brake_open = self.is_brake_open(now);
                let bits = self.modes.tick::<D>(&mut Context {
                    now,
                    mode: self.modes.active(),
                    commands: &self.commands,
                    configuration: &self.configuration,
                    demand: self.motor.demand(),
                    observed: self.observed,
                    travel: self.limits.travel(),
                    has_changed: self.has_changed,
                    frame: &mut self.frame,
                    switches: &self.switches,
                    blocked,
                    elapsed,
                    position,
                    is_brake_open,
                    motor: &mut self.motor,
                    pulses,
                    slots: &self.cyclic.slots,
                    buffer: &mut self.cyclic.buffer,
                    pipeline: &self.cyclic.pipeline,
                    is_early: self.is_early,
                    lost_set_points: &mut self.cyclic.has_lost,
                });
                bits | limit
            }
            State::QuickStopActive | State::FaultReactionActive => {
                let stays = state == State::QuickStopActive && self.machine.quick_stop().stays();
                let bits = if stays && self.motor.standstill() {
                    statusword::TARGET_REACHED
                } else {
                    0
                };
                bits | self.idle_bits() | self.mind_limits()
            }
            _ => return self.idle_bits(),
        };
        bits | self.mind_travel()
    }
}

/// The axis with segments at least as long as pulses are handed out apart, so that with two of them one may come late by as much.
fn outlast_tick(config: DriveConfig) -> AxisConfig {
    let tick = u64::from(config.axis.clock.hz()).saturating_mul(config.tick.ticks()) / 1_000_000;
    let apart = tick.checked_div(config.refills.into()).unwrap_or(tick);
    let least = u32::try_from(apart).unwrap_or(u32::MAX);
    AxisConfig {
        segment: config.axis.segment.max(least),
        ..config.axis
    }
}

#[cfg(test)]
mod tests;
