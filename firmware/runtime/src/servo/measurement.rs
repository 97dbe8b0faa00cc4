//! The measurement of the motor, and what a master sets while the loops run: the part of it that the loops have. What is measured in each period is part of
//! the current interrupt.

use cia402::ServoGoal;
use cia402::loops::{Found, Request, ServoSettings};
use servo::Angle;
use servo::cascade::Gains;
use servo::control::Fault;
use servo::motor::Implausible;
use servo::tuning::{Chirp, Failure, Measured, Setup, Tuning};

use super::current::{CurrentLock, CurrentState, Work as CurrentWork};
use super::feedback::SensorSettings;
use super::loops::Loops;
use super::settings::{
    LoopSettings as _, StepperLoops as _, config, control, current_loop, derating, modulation,
    set_current_gains,
};

/// The bandwidth of the velocity loop for which a measurement proposes gains, if none is wanted, in 1/s: loops of 4 kHz leave room for it.
const BANDWIDTH: f32 = 600.0;

/// The share of their gains that the loops have while a sine is added: stiff ones would take it away.
const SOFT: f32 = 0.1;

/// How a measurement ends, as 20C1h:2 tells it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ending {
    /// The power went off.
    PowerOff = 1,
    /// See [`Failure`].
    NoCurrent = 2,
    NotFollowed = 3,
    PolePairs = 4,
    Held = 5,
    TooFar = 6,
    /// A demand, or a master, wanted something else.
    Demand = 7,
    /// There is no power, or what was asked for cannot be.
    Impossible = 8,
}

impl From<Failure> for Ending {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Tripped(_) => Self::PowerOff,
            Failure::Winding => Self::NoCurrent,
            Failure::NotFollowed => Self::NotFollowed,
            Failure::PolePairs => Self::PolePairs,
            Failure::Held => Self::Held,
            Failure::TooFar => Self::TooFar,
        }
    }
}

/// Where it is.
#[derive(Clone, Debug, Default)]
enum Work {
    #[default]
    Nothing,
    /// The axis has not let the motor go yet.
    Waits(Wish),
    Runs,
    /// Soft loops hold the motor where it began, and a sine is added.
    Excites,
    Ended,
}

/// What waits.
#[derive(Clone, Copy, Debug)]
enum Wish {
    Motor(Setup),
    Chirp(Chirp),
}

/// A measurement, and what it has found.
#[derive(Clone, Debug, Default)]
pub(super) struct Measurement {
    work: Work,
    found: Found,
    /// 20C0h:4.
    bandwidth: u16,
    /// Where the encoder was as it began, and how far from there a sine may move the rotor, in counts.
    begin: i64,
    distance: u64,
}

impl Loops {
    /// Sets up the loops; the motor that they go by while there is no power. Returns whether all of it is taken over.
    pub fn set_up(&mut self, current: &mut impl CurrentLock, settings: &ServoSettings) -> bool {
        if *settings == self.settings {
            return true;
        }
        let gains = ServoSettings {
            motor: self.settings.motor,
            weakening: self.settings.weakening,
            pole_pairs: self.settings.pole_pairs,
            offset: self.settings.offset,
            is_turned: self.settings.is_turned,
            encoder: self.settings.encoder,
            hall: self.settings.hall,
            is_searched: self.settings.is_searched,
            stepper: self.settings.stepper,
            ..*settings
        };
        if gains != self.settings {
            self.set_up_gains(current, &gains);
        }
        let is_stepper = settings.stepper.mode != 0 && self.settings.stepper.mode != 0;
        let is_at_once = settings.stepper.is_at_once;
        let is_other = settings.stepper != self.settings.stepper;
        if is_other && (!self.is_on || is_at_once && !is_stepper) {
            self.settings.stepper = settings.stepper;
            let config = settings.stepper.config(&self.data, &self.motor);
            let _ = self.control.set_stepper(config);
        } else if is_other && is_at_once {
            self.settings.stepper = settings.stepper;
            if let Some(config) = settings.stepper.config(&self.data, &self.motor) {
                // What cannot be leaves it as it is.
                let _ = self.control.change_stepper(config);
            }
        }
        if !self.is_on {
            self.set_up_motor(current, settings);
        }
        self.settings == *settings
    }

    /// What changes without a bump.
    fn set_up_gains(&mut self, current: &mut impl CurrentLock, gains: &ServoSettings) {
        let before = core::mem::replace(&mut self.settings, *gains);
        if gains.filters != before.filters {
            let (low_pass, notch) = gains.filters(&self.data);
            self.control.set_filters(low_pass, notch);
        }
        // What is no gain was refused by its limits.
        let _ = self.control.set_gains(gains.gains(&self.data));
        let _ = self.control.set_blocked(gains.blocked());
        current
            .lock(|current| set_current_gains(&mut current.interrupt.current, &self.data, gains));
        if gains.is_barred != before.is_barred {
            self.end_measurement(current, Ending::PowerOff);
            self.switch(current);
        }
    }

    /// Where the magnet is, what the sensors mean, and the motor that all of it goes by: while there is no power.
    fn set_up_motor(&mut self, current: &mut impl CurrentLock, settings: &ServoSettings) {
        let counts = self.data.encoder_counts(settings.encoder);
        let sensors = SensorSettings::from(settings);
        if sensors != SensorSettings::from(&self.settings) {
            current.lock(|current| current.set_sensors(sensors, counts));
        }
        let own =
            |settings: &ServoSettings| (settings.motor, settings.pole_pairs, settings.weakening);
        let is_other = own(settings) != own(&self.settings);
        self.settings = *settings;
        if !is_other {
            return;
        }
        let (motor, _) = settings.motor(&self.data);
        // A motor that cannot be is none: the one before stays.
        if let Ok(current_loop) = current_loop(&self.data, &motor, settings)
            && let Ok(mut control) = control(&self.data, &motor, settings)
        {
            control.take_heat(&self.control);
            self.control = control;
            self.motor = motor;
            current.lock(|current| current.set_motor(&motor, current_loop));
        }
    }

    /// Begins a measurement, or ends it.
    pub fn request(&mut self, current: &mut impl CurrentLock, request: Request) {
        self.end_measurement(current, Ending::Demand);
        let begun = match request {
            Request::End => return,
            _ if !self.is_on || current.lock(|current| current.fault().is_some()) => {
                Err(Implausible)
            }
            Request::Motor {
                current,
                distance,
                bandwidth,
            } => {
                self.measurement.bandwidth = bandwidth;
                self.begin_measuring(current, distance)
            }
            Request::Chirp {
                torque,
                frequencies,
                time,
                distance,
            } => self.begin_chirp(torque, frequencies, time, distance),
        };
        match begun {
            Ok(work) => self.measurement.work = work,
            Err(Implausible) => self.end_as(Err(Ending::Impossible)),
        }
    }

    fn begin_measuring(&mut self, current: u16, distance: u16) -> Result<Work, Implausible> {
        let config = config(&self.data);
        let setup = Setup {
            wiring: self.motor.wiring,
            counts: self.data.encoder_counts(self.settings.encoder),
            period: self.data.stage.period,
            current: f32::from(current) * 1e-3 * self.motor.rated_current,
            trip: config.trip,
            bus: config.bus,
            modulation: modulation(&self.data)?,
            distance: f32::from(distance) * 1e-3,
            max_speed: self.data.max_speed(),
        };
        Tuning::new(setup)?;
        self.measurement.found.state = 1;
        Ok(Work::Waits(Wish::Motor(setup)))
    }

    fn begin_chirp(
        &mut self,
        torque: u16,
        (first, last): (u16, u16),
        time: u16,
        distance: u16,
    ) -> Result<Work, Implausible> {
        let current = f32::from(torque) * 1e-3 * self.motor.rated_current;
        let frequencies = (f32::from(first) * 0.1, f32::from(last) * 0.1);
        let period = self.data.control_period();
        let chirp = Chirp::new(current, frequencies, f32::from(time) * 1e-3, period)?;
        self.measurement.distance = u64::from(distance) * u64::from(self.motor.counts) / 1_000;
        self.measurement.found.state = 1;
        Ok(Work::Waits(Wish::Chirp(chirp)))
    }

    /// What was found.
    pub fn found(&self) -> &Found {
        &self.measurement.found
    }

    /// Where the loops hold a motor that the axis has let go.
    pub(super) fn held_at(&self) -> Option<i64> {
        matches!(self.measurement.work, Work::Excites).then_some(self.measurement.begin)
    }

    /// Ends it if there is one.
    pub(super) fn end_measurement(&mut self, current: &mut impl CurrentLock, ending: Ending) {
        match self.measurement.work {
            Work::Nothing | Work::Ended => return,
            Work::Runs => {
                self.control.start();
                current.lock(|current| current.take_measured());
            }
            Work::Excites => self.end_excitation(),
            Work::Waits(_) => {}
        }
        self.end_as(Err(ending));
    }

    /// The loops are as stiff as before.
    fn end_excitation(&mut self) {
        self.control.excite(None);
        // They were right before.
        let _ = self.control.set_gains(self.settings.gains(&self.data));
    }

    fn end_as(&mut self, ending: Result<(), Ending>) {
        let found = &mut self.measurement.found;
        (found.state, found.failure) = match ending {
            Ok(()) => (6, 0),
            Err(ending) => (7, ending as u8),
        };
        self.measurement.work = Work::Ended;
    }

    /// Whether the measurement has the motor.
    pub(super) fn is_measured(&self) -> bool {
        matches!(self.measurement.work, Work::Runs)
    }

    /// Whether one waits for the motor, or has it.
    #[inline]
    pub(super) fn is_measuring(&self) -> bool {
        !matches!(self.measurement.work, Work::Nothing | Work::Ended)
    }

    /// Takes the motor as soon as the axis has let it go, and sees what has become of that.
    #[inline(never)]
    pub(super) fn attend_measurement(
        &mut self,
        current: &mut impl CurrentLock,
        state: &CurrentState,
        temperature: f32,
    ) {
        let is_free = self
            .order
            .is_some_and(|order| order.goal == ServoGoal::Free);
        let runs = state.work == CurrentWork::Loops;
        match &self.measurement.work {
            Work::Waits(wish) if is_free && runs => {
                let wish = *wish;
                self.measurement.begin = state.seen.position;
                self.begin(current, wish);
            }
            Work::Runs => self.watch_measurement(current, state, is_free, temperature),
            Work::Excites if runs => self.watch_excitation(current, state, is_free),
            _ => {}
        }
    }

    /// The axis has let the motor go.
    fn begin(&mut self, current: &mut impl CurrentLock, wish: Wish) {
        match wish {
            Wish::Motor(setup) => {
                let Ok(tuning) = Tuning::new(setup) else {
                    return;
                };
                self.measurement.found = Found::default();
                self.measurement.work = Work::Runs;
                current.lock(|current| current.begin_measurement(tuning));
            }
            Wish::Chirp(chirp) => {
                let soft = Gains::from_bandwidth(SOFT * self.settings.gains(&self.data).velocity);
                let _ = self.control.set_gains(soft);
                self.control.excite(Some(chirp));
                self.measurement.found.state = 5;
                self.measurement.work = Work::Excites;
            }
        }
    }

    fn watch_measurement(
        &mut self,
        current: &mut impl CurrentLock,
        state: &CurrentState,
        is_free: bool,
        temperature: f32,
    ) {
        self.measurement.found.state = 2 + state.stage.min(2);
        if state.is_measured {
            self.control.start();
            let ending = match current.lock(|current| current.take_measured()) {
                Some(Ok(measured)) => {
                    self.found_all(&measured);
                    Ok(())
                }
                Some(Err(failure)) => Err(failure.into()),
                None => return,
            };
            self.end_as(ending);
        } else if state.work != CurrentWork::Measurement {
            // It ended by a fault, which is told until the power goes.
        } else if derating().is_none_or(|derating| derating.share(temperature) <= 0.0) {
            self.control.fail(Fault::Temperature);
            self.end_as(Err(Ending::PowerOff));
        } else if !is_free {
            self.end_measurement(current, Ending::Demand);
        }
    }

    fn watch_excitation(
        &mut self,
        current: &mut impl CurrentLock,
        state: &CurrentState,
        is_free: bool,
    ) {
        let away = state.seen.position.abs_diff(self.measurement.begin);
        if !is_free {
            self.end_measurement(current, Ending::Demand);
        } else if away > self.measurement.distance {
            self.end_measurement(current, Ending::TooFar);
        } else if !self.control.is_excited() {
            self.end_excitation();
            self.end_as(Ok(()));
        }
    }

    fn found_all(&mut self, measured: &Measured) {
        let number = |value: f32, unit: f32| (value / unit + 0.5) as u32;
        let counts = self.motor.counts as f32;
        let direction = if measured.is_reversed { -1.0 } else { 1.0 };
        let turned = direction * self.measurement.begin as f32 / counts;
        let at_zero = measured
            .angle
            .minus(Angle::from_turns(turned * f32::from(measured.pole_pairs)));
        let bandwidth = match self.measurement.bandwidth {
            0 => BANDWIDTH,
            wanted => wanted.into(),
        };
        let gains = Gains::from_bandwidth(bandwidth);
        self.measurement.found = Found {
            winding: [
                number(measured.resistance, 1e-6),
                number(measured.inductance_d, 1e-9),
                number(measured.inductance_q, 1e-9),
                number(measured.flux, 1e-9),
            ],
            pole_pairs: measured.pole_pairs,
            direction: direction as i8,
            angle: (at_zero.bits() >> 16) as u16,
            loads: [
                number(measured.inertia, 1e-9),
                number(measured.friction, 1e-6),
            ],
            gains: [gains.velocity, gains.integral, gains.position].map(|gain| (gain + 0.5) as u16),
            ..self.measurement.found
        };
    }
}
