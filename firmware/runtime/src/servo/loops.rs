//! What runs above the current: position and velocity, the field of a stepper, limits and what is watched, at the rate of the control.
//!
//! Of the current interrupt it copies a [`CurrentState`] at once, and behind its work it leaves there what the current is to be from the next period on.

use cia402::{ServoOrder, ServoReport};
use servo::control::{Fault, Report};
use servo::interrupt::Counts;
use servo::{Angle, Control, Implausible, Motor};

use super::current::{CurrentLock, CurrentState, Work};
use super::data::ServoData;
use super::measurement::{Ending, Measurement};
use super::raw_report::RawReport;
use super::settings::control;
use super::{LoopReport, ServoSettings, orders};

/// See the module.
#[derive(Clone, Debug)]
pub struct Loops {
    pub(super) data: ServoData,
    pub(super) motor: Motor,
    pub(super) control: Control,
    pub(super) is_on: bool,
    /// What the axis has ordered.
    pub(super) order: Option<ServoOrder>,
    pub(super) settings: ServoSettings,
    pub(super) measurement: Measurement,
}

impl Loops {
    /// Above a [`Current`](super::Current) with the same data.
    ///
    /// # Errors
    /// With data that cannot be.
    pub fn new(data: &ServoData) -> Result<Self, Implausible> {
        let motor = data.motor;
        motor.check()?;
        let settings = ServoSettings::default();
        Ok(Self {
            data: *data,
            control: control(data, &motor, &settings)?,
            motor,
            is_on: false,
            order: None,
            settings,
            measurement: Measurement::default(),
        })
    }

    /// The motor as its loops know it.
    pub fn motor(&self) -> &Motor {
        &self.motor
    }

    /// Whether the loops may put current into the motor.
    pub fn energise(&mut self, current: &mut impl CurrentLock, on: bool) {
        if on != self.is_on {
            self.end_measurement(current, Ending::PowerOff);
            self.is_on = on;
            self.switch(current);
        }
    }

    /// Power comes or goes: whoever has said so, all begins anew.
    pub(super) fn switch(&mut self, current: &mut impl CurrentLock) {
        self.control.start();
        let on = self.is_on && !self.settings.is_barred;
        current.lock(|current| current.energise(on));
    }

    /// Whether a brake chopper is to be on.
    pub fn chops(&mut self, counts: &Counts) -> bool {
        let bus = f32::from(counts.bus) * self.data.stage.bus;
        self.control.chops(bus)
    }

    /// The share of the time for which one is to be on, 0 to 1, if it can be on for a part of it.
    pub fn chopping(&self, state: &CurrentState) -> f32 {
        self.control.chopping(state.seen.bus)
    }

    /// What the axis has ordered.
    pub fn take(&mut self, order: Option<ServoOrder>) {
        self.order = order;
    }

    /// A period of the control, behind the one of the modulation in which it is due. `since` is the time from when the order was given, in s, and its positions
    /// count from `origin` on; the stage is so hot, in 0.1 °C. Returns what it has looked at.
    pub fn run(
        &mut self,
        current: &mut impl CurrentLock,
        since: f32,
        origin: i64,
        hot: i16,
    ) -> CurrentState {
        let temperature = f32::from(hot) / 10.0;
        let mut state = current.lock(|current| current.state());
        if self.is_measuring() {
            self.attend_measurement(current, &state, temperature);
            state = current.lock(|current| current.state());
        }
        if let Some(fault) = state.fault {
            self.control.fail(fault);
        }
        if state.work == Work::Loops && !self.is_measured() {
            self.run_control(current, &state, since, origin, temperature);
        }
        if let (Some(fault), None) = (self.control.fault(), state.fault) {
            current.lock(|current| current.fail(fault));
        }
        state
    }

    #[inline(never)]
    fn run_control(
        &mut self,
        current: &mut impl CurrentLock,
        state: &CurrentState,
        since: f32,
        origin: i64,
        temperature: f32,
    ) {
        if let Some(order) = &self.order {
            let held = self.held_at();
            let order = orders::order(order, &self.motor, origin, held, self.settings.ahead);
            self.control.order(order, since);
        }
        // The control goes on where the interrupt has ended: it tells the fault.
        let Ok(wanted) = self.control.run(&state.seen, temperature) else {
            return;
        };
        let field = self.control.field();
        // Most motors have none, and are spared its sine.
        let wanted = if field.is_some() || self.settings.lead == 0 {
            wanted
        } else {
            let lead = u32::from(self.settings.lead.cast_unsigned()) << 16;
            wanted.turned(Angle::from_bits(lead).sine_cosine())
        };
        let weakening = (self.settings.weakening != 0).then(|| self.control.weakening());
        current.lock(|current| {
            if let Some(most) = weakening {
                current.interrupt.current.weakening.limit(most);
            }
            match field {
                Some((from, speed)) => current.interrupt.order_field(wanted, from, speed),
                None => current.interrupt.order(wanted, 0),
            }
        });
    }

    /// Why the motor has no current though it is to have some.
    pub(super) fn fault(&self, state: &CurrentState) -> Option<Fault> {
        self.control.fault().or(state.fault)
    }

    /// What has become of the orders, in counts from `origin` on.
    pub fn report(&self, state: &CurrentState, origin: i64) -> ServoReport {
        self.reported(state, &self.control_report(state), origin)
    }

    /// Without current there is none to tell.
    pub(super) fn control_report(&self, state: &CurrentState) -> Report {
        let report = self.control.report(&state.seen);
        if self.fault(state).is_none() {
            return report;
        }
        Report {
            velocity: report.velocity,
            is_hot: report.is_hot,
            ..Report::default()
        }
    }

    pub(super) fn reported(
        &self,
        state: &CurrentState,
        report: &Report,
        origin: i64,
    ) -> ServoReport {
        let counts = state.seen.position.wrapping_sub(origin);
        // What has failed does not begin any more, and is not waited for.
        orders::report(report, counts, self.is_measuring() || begins(state))
    }

    /// What the loops report beside the actual values.
    pub fn loop_report(&self, current: &mut impl CurrentLock) -> LoopReport {
        let state = current.lock(|current| current.state());
        self.raw_report(current, &state)
            .report(&self.data, *self.found())
    }

    /// What of it the loops alone know.
    pub(super) fn raw_report(
        &self,
        current: &mut impl CurrentLock,
        state: &CurrentState,
    ) -> RawReport {
        let report = self.control_report(state);
        RawReport {
            motor: (self.settings.motor, self.settings.pole_pairs),
            velocity: report.velocity,
            counts: state.seen.position,
            zero: current.lock(|current| current.interrupt.encoder.offset()),
            offset: self.settings.offset,
            lead: report.lead,
            current: state.seen.current,
            angle: state.seen.angle,
            heat: self.control.heat(),
            is_limited: report.is_limited,
            is_on: self.is_on && self.fault(state).is_none() && !begins(state),
        }
    }

    /// The lead of a stepper's field in hundredths of a full step.
    pub fn lead(&self) -> u16 {
        hundredths(self.control.lead_angle())
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
    pub fn is_stalled(&self, state: &CurrentState) -> bool {
        self.stalls(&self.control_report(state))
    }

    pub(super) fn stalls(&self, report: &Report) -> bool {
        report.is_limited && report.velocity.abs() < 0.02 * self.motor.counts as f32
    }

    /// The heat of motor and stage has come near its bound.
    pub fn is_hot(&self) -> bool {
        self.control.is_hot()
    }
}

/// Something comes before the loops.
fn begins(state: &CurrentState) -> bool {
    matches!(state.work, Work::Sensors | Work::Magnet)
}

/// The lead of a field in hundredths of a full step.
pub(super) fn hundredths(lead: f32) -> u16 {
    (lead.abs() * 100.0 + 0.5) as u16
}
