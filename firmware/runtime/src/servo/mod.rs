//! The loops of a servo, between the axis of the drive and a power stage: on a board and in the plant alike.
//!
//! | here | does | the host gives |
//! |---|---|---|
//! | [`Loops`] | a period of the modulation, and the loops above it: counts in, pulse widths out | the counts |
//! | [`ServoObjects`] | what masters set and ask for, and what was found | the dictionary |
//! | [`Link`] | what the tasks of a board copy from one to the other | |
//! | [`Current`] | the loops in the current interrupt, at one end of the link | counts, time |
//! | [`Port`] | the port of the axis, at its other end | time |
//!
//! The contract: [`Loops::period`] is called in the middle of the pulses, its widths act half a period later for a whole one; [`Loops::control`] behind it in
//! each period. The gates are on while there are widths and [`Loops::fault`] is none.

mod current;
mod data;
mod feedback;
mod link;
mod measurement;
mod objects;
mod orders;
mod port;
mod raw_report;
mod settings;

use core::hint::cold_path;

use cia402::{ServoOrder, ServoReport};
use servo::control::{Fault, Report, Seen};
use servo::feedback::commutation::Step;
use servo::feedback::{Commutation, Incremental, Observer};
use servo::interrupt::Counts;
use servo::modulation::Widths;
use servo::offsets::{Calibration, CurrentSense};
use servo::transform::Rotor;
use servo::{Angle, Control, CurrentInterrupt, Implausible, Motor, Wiring};

pub use cia402::loops::{Found, LoopReport, Request, ServoSettings, StepperSettings};
pub use current::Current;
pub use data::{Feedback, ServoData, StageData};
use feedback::Sensor;
pub use link::Link;
use measurement::{Ending, Measurement};
pub use objects::ServoObjects;
pub use orders::error_code;
pub use port::Port;
use raw_report::RawReport;
use settings::loops;

/// Of the observer, in rad/s.
const OBSERVER: f32 = 3_000.0;

/// What is done with the power on before the loops run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Begin {
    /// The gates are off, and what the sensors say is no current.
    Sensors,
    /// The magnet is looked for.
    Magnet,
    /// Nothing.
    Over,
}

/// See the module.
#[derive(Clone, Debug)]
pub struct Loops {
    data: ServoData,
    motor: Motor,
    interrupt: CurrentInterrupt,
    control: Control,
    /// Where the magnet and the sensors are is known from the start.
    is_ideal: bool,
    begin: Begin,
    /// What is beside the encoder, or in its place.
    sensor: Sensor,
    /// Until the magnet is found for the first time.
    search: Option<Commutation>,
    /// Periods since the loops above ran.
    periods: u8,
    is_on: bool,
    /// What the axis has ordered.
    order: Option<ServoOrder>,
    fault: Option<Fault>,
    settings: ServoSettings,
    measurement: Measurement,
}

impl Loops {
    /// At rest, with the timer of the encoder at `timer`; 0 with [`Feedback::Absolute`]. Where the magnet stands may be known, in a plant; then nothing is to
    /// be found and the sensors are right, too.
    ///
    /// # Errors
    /// With data that cannot be.
    pub fn new(data: &ServoData, timer: u16, magnet: Option<Angle>) -> Result<Self, Implausible> {
        let stage = &data.stage;
        let motor = data.motor.checked()?;
        let settings = ServoSettings::default();
        let (current, control) = loops(data, &motor, &settings)?;
        let mut encoder = Incremental::new(&motor, timer, 2);
        encoder.set_counts(data.encoder_counts(0));
        if let Some(angle) = magnet {
            encoder.set_angle(angle);
        }
        let mut observer = Observer::new(OBSERVER, stage.period)?;
        observer.stand_at(encoder.angle());
        let (middle, spread) = stage.middle;
        let sense = CurrentSense::new(stage.current, middle, spread)?;
        let search = Commutation::new(&motor, motor.rated_current, stage.period)?;
        let is_found = magnet.is_some() || data.feedback != Feedback::Incremental;
        Ok(Self {
            data: *data,
            motor,
            interrupt: CurrentInterrupt::new(sense, encoder, observer, current, stage.bus)?,
            control,
            is_ideal: magnet.is_some(),
            begin: Begin::Over,
            sensor: Sensor::new(data, &motor)?,
            search: (!is_found).then_some(search),
            periods: 0,
            is_on: false,
            order: None,
            fault: None,
            settings,
            measurement: Measurement::default(),
        })
    }

    /// The motor as its loops know it.
    pub fn motor(&self) -> &Motor {
        &self.motor
    }

    /// Of the encoder, from where it began; from its zero, if it is absolute.
    pub fn position(&self) -> i64 {
        self.interrupt.encoder.position()
    }

    /// Whether the loops may put current into the motor.
    pub fn energise(&mut self, on: bool) {
        if on == self.is_on {
            return;
        }
        self.is_on = on;
        self.fault = None;
        self.begin_anew();
        self.sensor.align();
        if !on {
            self.end_measurement(Ending::PowerOff);
        } else if !self.is_ideal {
            self.interrupt.sense.restart();
            self.begin = Begin::Sensors;
        }
    }

    /// The loops begin without a current.
    fn begin_anew(&mut self) {
        self.begin = Begin::Over;
        self.interrupt.current.start();
        self.interrupt.order(Rotor::ZERO, 0);
        self.control.start();
    }

    /// Why the motor has no current though it is to have some.
    pub fn fault(&self) -> Option<Fault> {
        self.fault
    }

    /// Ends everything: no widths from now on.
    fn fail(&mut self, fault: Fault) {
        self.control.fail(fault);
        self.fault = self.control.fault();
    }

    /// The bus in V.
    pub fn bus(&self, counts: &Counts) -> f32 {
        f32::from(counts.bus) * self.data.stage.bus
    }

    /// Whether a brake chopper is to be on.
    pub fn chops(&mut self, counts: &Counts) -> bool {
        let bus = self.bus(counts);
        self.control.chops(bus)
    }

    /// The share of the time for which a brake chopper is to be on, 0 to 1, if it can be on for a part of it.
    pub fn chopping(&self, counts: &Counts) -> f32 {
        self.control.chopping(self.bus(counts))
    }

    /// What the axis has ordered.
    pub fn take(&mut self, order: Option<ServoOrder>) {
        self.order = order;
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

    /// A period of the modulation, with the stage so hot, in 0.1 °C: the pulse widths; without any the gates are to be off.
    #[inline]
    pub fn period(&mut self, counts: &Counts, hot: i16) -> Option<Widths> {
        let runs = self.runs() && self.fault.is_none();
        if !runs || self.is_measuring() && self.measures() {
            cold_path();
            return self.period_beside(counts, hot);
        }
        match self.interrupt.run(counts) {
            Ok(widths) => Some(widths),
            Err(trip) => {
                cold_path();
                self.fail(trip.into());
                None
            }
        }
    }

    /// Whether the loops may run: there is power, and nothing comes before them.
    #[inline]
    fn runs(&self) -> bool {
        self.is_on && !self.settings.is_barred && self.begin == Begin::Over
    }

    /// A period in which they do not.
    #[inline(never)]
    fn period_beside(&mut self, counts: &Counts, hot: i16) -> Option<Widths> {
        let widths = if !self.is_on || self.settings.is_barred || self.fault.is_some() {
            self.look(counts);
            None
        } else if self.begin != Begin::Over {
            self.look(counts);
            self.get_ready(counts)
        } else {
            self.measure(counts, hot)
        };
        self.fault = self.control.fault();
        widths
    }

    /// What is above the current, where it is due; `since` is the time from when the order was given, in s, and its positions count from `origin` on.
    #[inline]
    pub fn control(&mut self, counts: &Counts, since: f32, origin: i64, hot: i16) {
        let is_due = self.periods == 0;
        self.periods += 1;
        if self.periods >= self.data.stage.control {
            self.periods = 0;
        }
        if is_due && self.runs() && !self.is_measured() {
            self.run_control(counts, since, origin, hot);
        }
    }

    #[inline(never)]
    fn run_control(&mut self, counts: &Counts, since: f32, origin: i64, hot: i16) {
        if let Some(order) = &self.order {
            let held = self.held_at();
            let order = orders::order(order, &self.motor, origin, held, self.settings.ahead);
            self.control.order(order, since);
        }
        let seen = Seen {
            bus: self.bus(counts),
            temperature: f32::from(hot) / 10.0,
            sum: match self.motor.wiring {
                Wiring::TwoPhase => 0.0,
                Wiring::ThreePhase => {
                    let currents = self.interrupt.sense.amperes(counts.currents);
                    currents.iter().sum()
                }
            },
        };
        // The control goes on where the interrupt has ended: it tells the fault.
        if let Ok(current) = self.control.run(&self.interrupt, &seen) {
            match self.control.field() {
                Some((from, speed)) => self.interrupt.order_field(current, from, speed),
                // Most motors have none, and are spared its sine.
                None if self.settings.lead == 0 => self.interrupt.order(current, 0),
                None => {
                    let lead = u32::from(self.settings.lead.cast_unsigned()) << 16;
                    let lead = Angle::from_bits(lead).sine_cosine();
                    self.interrupt.order(current.turned(lead), 0);
                }
            }
        }
        self.fault = self.control.fault();
    }

    /// The encoder goes on, and nothing else.
    fn look(&mut self, counts: &Counts) {
        self.interrupt.encoder.look(counts.timer);
        let angle = self.interrupt.encoder.angle();
        self.interrupt.observer.look(angle);
    }

    /// A period before the loops run.
    fn get_ready(&mut self, counts: &Counts) -> Option<Widths> {
        if self.begin == Begin::Sensors {
            match self.interrupt.sense.learn(counts.currents) {
                Calibration::Running => {}
                Calibration::Done if self.search.is_some() => self.begin = Begin::Magnet,
                Calibration::Done => self.begin = Begin::Over,
                Calibration::Failed => self.control.fail(Fault::CurrentSensor),
            }
            return None;
        }
        let (position, speed) = (self.position(), self.interrupt.observer.speed());
        match self.search.as_mut()?.run(position, speed) {
            Step::Hold { angle, current } => {
                let widths = self.interrupt.hold(counts, angle, current);
                widths.map_err(|trip| self.control.fail(trip.into())).ok()
            }
            Step::Found(angle) => {
                self.search = None;
                let offset = Angle::from_bits(u32::from(self.settings.offset) << 16);
                self.interrupt.encoder.set_angle(angle.plus(offset));
                let angle = self.interrupt.encoder.angle();
                self.interrupt.observer.stand_at(angle);
                self.begin_anew();
                None
            }
            Step::Failed => {
                self.control.fail(Fault::Encoder);
                None
            }
        }
    }

    fn control_report(&self) -> Report {
        self.control.report(&self.interrupt)
    }

    /// What has become of the orders, in counts from `origin` on.
    pub fn report(&self, origin: i64) -> ServoReport {
        self.reported(&self.control_report(), origin)
    }

    fn reported(&self, report: &Report, origin: i64) -> ServoReport {
        let counts = self.position().wrapping_sub(origin);
        // What has failed does not begin any more, and is not waited for.
        let begins = self.begin != Begin::Over && self.fault.is_none();
        let wants_free = self.is_measuring() || begins;
        orders::report(report, counts, wants_free)
    }

    /// What the loops report beside the actual values.
    pub fn loop_report(&self) -> LoopReport {
        self.raw_report().report(&self.data, *self.found())
    }

    /// What of it the loops alone know.
    fn raw_report(&self) -> RawReport {
        let report = self.control_report();
        RawReport {
            motor: (self.settings.motor, self.settings.pole_pairs),
            velocity: report.velocity,
            counts: self.position(),
            zero: self.interrupt.encoder.offset(),
            offset: self.settings.offset,
            lead: report.lead,
            current: self.interrupt.current.current(),
            angle: self.interrupt.observer.angle(),
            heat: self.control.heat(),
            is_limited: report.is_limited,
            is_on: self.is_on && self.fault.is_none() && self.begin == Begin::Over,
        }
    }

    /// The current that is asked of its loop.
    pub fn demand(&self) -> Rotor {
        self.interrupt.current.demand()
    }

    /// The lead of a stepper's field in hundredths of a full step.
    pub fn lead(&self) -> u16 {
        leads(&self.control_report())
    }

    /// How far the rotor may be from where it is held at rest, in counts: a stepper that is only supervised has no more than its field, and loses
    /// four full steps at a time. Of anything else its following error tells.
    pub fn position_tolerance(&self) -> u32 {
        let four_steps = self.motor.counts / u32::from(self.motor.pole_pairs).max(1);
        match self.settings.stepper.mode {
            1 => four_steps * 5 / 8,
            _ => i32::MAX.unsigned_abs(),
        }
    }

    /// The rotor stands against a limit of the torque.
    pub fn is_stalled(&self) -> bool {
        self.stalls(&self.control_report())
    }

    fn stalls(&self, report: &Report) -> bool {
        report.is_limited && report.velocity.abs() < 0.02 * self.motor.counts as f32
    }

    /// The heat of motor and stage has come near its bound.
    pub fn is_hot(&self) -> bool {
        self.control_report().is_hot
    }
}

fn leads(report: &Report) -> u16 {
    hundredths(report.lead)
}

/// The lead of a field in hundredths of a full step.
fn hundredths(lead: f32) -> u16 {
    (lead.abs() * 100.0 + 0.5) as u16
}

#[cfg(test)]
mod tests;
