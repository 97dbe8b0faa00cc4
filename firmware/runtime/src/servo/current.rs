//! What runs in the current interrupt: samples in, pulse widths out, and what must come in each period before the loops may run.
//!
//! It knows nothing of orders. The loops above copy what they look at out of it and put what they want into it, under a [`CurrentLock`].

use core::hint::cold_path;

use servo::control::Fault;
use servo::feedback::commutation::Step;
use servo::feedback::{Commutation, Incremental, Observer};
use servo::interrupt::{Counts, Snapshot};
use servo::modulation::Widths;
use servo::offsets::{Calibration, CurrentSense};
use servo::transform::Rotor;
use servo::tuning::{self, Failure, Measured, Tuning};
use servo::{Angle, CurrentInterrupt, CurrentLoop, Implausible, Motor};

use super::ServoSettings;
use super::data::{Feedback, ServoData};
use super::feedback::{Sensor, SensorSettings};
use super::settings::current_loop;

/// Of the observer, in rad/s.
const OBSERVER: f32 = 3_000.0;

/// The way of the loops to what the current interrupt has. Nothing is done there that would take long: it waits until that is over.
pub trait CurrentLock {
    /// While the current interrupt does not come.
    fn lock<R>(&mut self, f: impl FnOnce(&mut Current) -> R) -> R;
}

/// Where the loops run right behind it.
impl CurrentLock for Current {
    fn lock<R>(&mut self, f: impl FnOnce(&mut Current) -> R) -> R {
        f(self)
    }
}

/// What a period is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Work {
    /// There is no power, or a fault: the encoder is looked at.
    Nothing,
    /// The gates are off, and what the sensors say is no current.
    Sensors,
    /// The magnet is looked for.
    Magnet,
    /// The motor is measured.
    Measurement,
    /// That is over, and the loops have not seen it yet.
    Measured,
    /// The current that the loops ask for.
    Loops,
}

/// What the loops look at, copied at once.
#[derive(Clone, Copy, Debug)]
pub struct CurrentState {
    pub(super) seen: Snapshot,
    pub(super) work: Work,
    pub(super) fault: Option<Fault>,
    /// A measurement has ended, and the loops have not taken what has come of it.
    pub(super) is_measured: bool,
    /// How much of one is done, as [`Tuning::stage`] has it.
    pub(super) stage: u8,
}

/// See the module.
#[derive(Clone, Debug)]
pub struct Current {
    pub(super) interrupt: CurrentInterrupt,
    pub(super) work: Work,
    fault: Option<Fault>,
    /// There is power, and nothing bars it.
    pub(super) is_on: bool,
    /// Where the magnet and the sensors are is known from the start.
    is_ideal: bool,
    /// Periods until the loops are due, and from one in which they are to the next how many there are in which they are not.
    left: u8,
    between: u8,
    /// The last ones.
    counts: Counts,
    /// What is beside the encoder, or in its place, and what it means.
    pub(super) sensor: Sensor,
    pub(super) settings: SensorSettings,
    pub(super) motor: Motor,
    /// Of the modulation, in s.
    pub(super) period: f32,
    /// Until the magnet is found for the first time.
    pub(super) search: Option<Commutation>,
    /// While the motor is measured, and what has come of it.
    tuning: Option<Tuning>,
    measured: Option<Result<Measured, Failure>>,
}

impl Current {
    /// At rest, with the timer of the encoder at `timer`; 0 with [`Feedback::Absolute`]. Where the magnet stands may be known, in a plant; then nothing is to
    /// be found and the sensors are right, too.
    ///
    /// # Errors
    /// With data that cannot be.
    pub fn new(data: &ServoData, timer: u16, magnet: Option<Angle>) -> Result<Self, Implausible> {
        let stage = &data.stage;
        let motor = &data.motor;
        motor.check()?;
        let current = current_loop(data, motor, &ServoSettings::NONE)?;
        let mut encoder = Incremental::new(motor, timer, 2);
        encoder.set_counts(data.encoder_counts(0));
        if let Some(angle) = magnet {
            encoder.set_angle(angle);
        }
        let mut observer = Observer::new(OBSERVER, stage.period)?;
        observer.stand_at(encoder.angle());
        let (middle, spread) = stage.middle;
        let sense = CurrentSense::new(stage.current, middle, spread)?;
        let search = Commutation::new(motor, motor.rated_current, stage.period)?;
        let is_found = magnet.is_some() || data.feedback != Feedback::Incremental;
        Ok(Self {
            interrupt: CurrentInterrupt::new(sense, encoder, observer, current, stage.bus)?,
            work: Work::Nothing,
            fault: None,
            is_on: false,
            is_ideal: magnet.is_some(),
            left: 1,
            between: stage.control.saturating_sub(1),
            counts: Counts::default(),
            sensor: Sensor::new(data, motor)?,
            settings: SensorSettings::NONE,
            motor: *motor,
            period: stage.period,
            search: (!is_found).then_some(search),
            tuning: None,
            measured: None,
        })
    }

    /// A period of the modulation: the pulse widths; without any the gates are to be off.
    #[inline]
    pub fn period(&mut self, counts: &Counts) -> Option<Widths> {
        self.counts = *counts;
        self.left = self.left.checked_sub(1).unwrap_or(self.between);
        if self.work != Work::Loops {
            cold_path();
            return self.period_beside();
        }
        // The copy, so that what was read goes there from its registers.
        match self.interrupt.run(&self.counts) {
            Ok(widths) => Some(widths),
            Err(trip) => {
                cold_path();
                self.fail(trip.into());
                None
            }
        }
    }

    /// Whether the loops are to run behind this period.
    #[inline]
    pub fn is_due(&self) -> bool {
        self.left == 0
    }

    /// Whether the gates are to be off, as they are without widths: at once, where the loops have taken the current.
    #[inline]
    pub fn is_off(&self) -> bool {
        self.work == Work::Nothing
    }

    /// Of the encoder, from where it began; from its zero, if it is absolute.
    pub fn position(&self) -> i64 {
        self.interrupt.encoder.position()
    }

    /// Why the motor has no current though it is to have some.
    pub fn fault(&self) -> Option<Fault> {
        self.fault
    }

    /// The current that is asked of its loop.
    pub fn demand(&self) -> Rotor {
        self.interrupt.current.demand()
    }

    /// What the loops look at.
    pub fn state(&self) -> CurrentState {
        CurrentState {
            seen: self.interrupt.snapshot(&self.counts),
            work: self.work,
            fault: self.fault,
            is_measured: self.measured.is_some(),
            stage: self.tuning.as_ref().map_or(0, Tuning::stage),
        }
    }

    /// A period in which the loops do not run.
    #[inline(never)]
    fn period_beside(&mut self) -> Option<Widths> {
        let counts = &{ self.counts };
        self.interrupt.encoder.look(counts.timer);
        let angle = self.interrupt.encoder.angle();
        self.interrupt.observer.look(angle);
        match self.work {
            Work::Nothing | Work::Measured | Work::Loops => None,
            Work::Sensors => {
                self.learn(counts);
                None
            }
            Work::Magnet => self.look_for_magnet(counts),
            Work::Measurement => self.measure(counts),
        }
    }

    /// What the sensors say without a current.
    fn learn(&mut self, counts: &Counts) {
        match self.interrupt.sense.learn(counts.currents) {
            Calibration::Running => {}
            Calibration::Done if self.search.is_some() => self.work = Work::Magnet,
            Calibration::Done => self.work = Work::Loops,
            Calibration::Failed => self.fail(Fault::CurrentSensor),
        }
    }

    fn look_for_magnet(&mut self, counts: &Counts) -> Option<Widths> {
        let (position, speed) = (self.position(), self.interrupt.observer.speed());
        match self.search.as_mut()?.run(position, speed) {
            Step::Hold { angle, current } => {
                let widths = self.interrupt.hold(counts, angle, current);
                widths.map_err(|trip| self.fail(trip.into())).ok()
            }
            Step::Found(angle) => {
                self.search = None;
                let angle = angle.plus(self.settings.offset);
                self.interrupt.encoder.set_angle(angle);
                self.stand_still();
                self.begin_loops();
                None
            }
            Step::Failed => {
                self.fail(Fault::Encoder);
                None
            }
        }
    }

    /// A period of the measurement of the motor.
    fn measure(&mut self, counts: &Counts) -> Option<Widths> {
        let step = self.tuning.as_mut()?.run(&tuning::Seen {
            currents: self.interrupt.sense.amperes(counts.currents),
            bus: self.interrupt.volts(counts),
            timer: counts.timer,
        });
        let measured = match step {
            tuning::Step::Widths(widths) => return Some(widths),
            tuning::Step::Done(measured) => Ok(measured),
            tuning::Step::Failed(failure) => Err(failure),
        };
        self.work = Work::Measured;
        self.measured = Some(measured);
        if let Err(Failure::Tripped(trip)) = measured {
            self.fail(trip.into());
        }
        None
    }

    /// The observer stands where the encoder is.
    pub(super) fn stand_still(&mut self) {
        let angle = self.interrupt.encoder.angle();
        self.interrupt.observer.stand_at(angle);
    }
}

/// For the loops.
impl Current {
    /// Current in the motor, or none. Ends a fault.
    pub(super) fn energise(&mut self, on: bool) {
        self.is_on = on;
        self.fault = None;
        self.tuning = None;
        self.begin_loops();
        self.sensor.align();
        if !on {
            self.work = Work::Nothing;
        } else if !self.is_ideal {
            self.interrupt.sense.restart();
            self.work = Work::Sensors;
        }
    }

    /// They begin without a current.
    pub(super) fn begin_loops(&mut self) {
        self.interrupt.current.start();
        self.interrupt.order(Rotor::ZERO, 0);
        self.work = Work::Loops;
    }

    /// Ends everything: no widths from now on.
    pub(super) fn fail(&mut self, fault: Fault) {
        self.fault.get_or_insert(fault);
        self.work = Work::Nothing;
    }

    /// The index of the encoder was passed with its timer at this count. One that does not come whole turns after the first is a fault: counts were lost. That stays
    /// one at each index, as the magnet is not where the counts say any more.
    pub fn index(&mut self, timer: u16) {
        if let Err(fault) = self.interrupt.encoder.index(timer)
            && self.is_on
        {
            self.fail(fault.into());
        }
    }

    /// The motor is measured from the next period on.
    pub(super) fn begin_measurement(&mut self, tuning: Tuning) {
        self.tuning = Some(tuning);
        self.work = Work::Measurement;
    }

    /// What has come of it, if it has ended by itself; it ends in any case, and the loops begin.
    pub(super) fn take_measured(&mut self) -> Option<Result<Measured, Failure>> {
        self.tuning = None;
        if matches!(self.work, Work::Measurement | Work::Measured) {
            self.begin_loops();
        }
        self.measured.take()
    }

    /// Another motor, while there is no power.
    pub(super) fn set_motor(&mut self, motor: &Motor, current: CurrentLoop) {
        self.interrupt.current = current;
        self.motor = *motor;
        self.interrupt.encoder.set_pole_pairs(motor.pole_pairs);
        self.sensor.restart();
        // The magnet that is still to be found is that of this motor.
        if let Some(search) = &mut self.search
            && let Ok(anew) = Commutation::new(motor, motor.rated_current, self.period)
        {
            *search = anew;
        }
    }
}
