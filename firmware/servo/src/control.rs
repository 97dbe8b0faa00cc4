//! What is between a drive and the current interrupt: orders in, a current out, at the rate of the control.
//!
//! An order is a position that moves on, or a torque that is held. Between two orders the position goes on by its velocity and acceleration, so orders may
//! come at another rate than the control, and a little early or late. A torque is held up to a speed: there a limit of it falls that much with each rad/s that a
//! loop of the velocity would take.
//!
//! A position is held by the loops, or as a stepper by a field that leads the rotor ([`Stepper`]); a torque by the current alone.
//!
//! What may be asked of the motor is the least of what is ordered, of the heat ([`Thermal`], [`Derating`]) and of the bus ([`Bus`]). What cannot go on is a [`Fault`]: the
//! gates are to be off from then on, until [`Control::start`].

mod fault;
mod field;
mod limits;
mod order;
mod watch;

use crate::cascade::{Actual, Demand, Gains};
use crate::filter::Filter;
use crate::interrupt::Snapshot;
use crate::motor::Implausible;
use crate::number::{between, fade, lesser, limit, root};
use crate::protection::{Bus, Derating, Thermal};
use crate::stepper::{Stepper, StepperConfig};
use crate::transform::Rotor;
use crate::tuning::Chirp;
use crate::{Angle, Cascade, Motor};
pub use fault::Fault;
pub use order::{Goal, Order, Report};
use watch::Watch;

/// How the control is set up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlConfig {
    /// Of the control, in s.
    pub period: f32,
    /// How stiff the loops are.
    pub gains: Gains,
    /// The current that dry friction takes, in A.
    pub friction: f32,
    /// How long the motor bears its peak current, in s.
    pub peak_time: f32,
    /// The current that the stage bears for ever, in A, up to the peak of the motor, and how long it bears that, in s.
    pub stage: (f32, f32),
    /// The bus while the motor brakes.
    pub bus: Bus,
    /// The temperature.
    pub derating: Derating,
    /// A rotor that is slower than this, in rad/s, for so long, in s, though it is pushed as hard as may be, is blocked; 0 s is never.
    pub blocked: (f32, f32),
    /// The fastest that the motor may turn, in rad/s.
    pub max_speed: f32,
}

/// What is told of the current fades in this time, in s.
const SHOWN: f32 = 2e-3;

/// What holds the motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Holder {
    /// Nothing, or a torque.
    Current,
    Loops,
    Field,
}

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Control {
    motor: Motor,
    /// Of the motor, in N·m/A.
    torque_constant: f32,
    /// The same with the field as it is weakened: a salient motor has more of it then.
    weakened_constant: f32,
    /// The greatest current by the heat, in A.
    by_heat: f32,
    /// What is left of a difference to what is shown, a period later.
    shows: f32,
    /// Of the control, in s.
    period: f32,
    bus: Bus,
    derating: Derating,
    cascade: Cascade,
    /// Holds positions in place of the loops.
    stepper: Option<Stepper>,
    /// Of the motor, and of the stage.
    thermal: [Thermal; 2],
    watch: Watch,
    order: Option<Order>,
    /// What is added to the current that is asked for, in A.
    chirp: Option<Chirp>,
    /// Since the order, in s.
    since: f32,
    /// Gone on beyond the whole counts of the order, in counts.
    beyond: f32,
    /// What was wanted of the current last, in A.
    wanted: f32,
    /// How fast the rotor was then, in rad/s.
    velocity: f32,
    /// Where the rotor was then, and how fast the field of a stepper is to turn, in electrical rad/s.
    field: Option<(Angle, f32)>,
    holder: Holder,
    is_limited: bool,
    /// The current without the noise of its samples, for who is told of it.
    shown: Rotor,
    fault: Option<Fault>,
}

impl Control {
    /// For a motor that was checked.
    ///
    /// # Errors
    /// With what [`Cascade::new`], [`Thermal::new`], [`Blocked::new`](crate::protection::Blocked::new) and [`PhaseLoss::new`](crate::protection::PhaseLoss::new) refuse, or a greatest speed outside 1 to 10⁴ rad/s.
    pub fn new(motor: &Motor, config: ControlConfig) -> Result<Self, Implausible> {
        let period = config.period;
        let (rated, peak) = (motor.rated_current, motor.peak_current);
        let (stage, stage_time) = config.stage;
        Ok(Self {
            torque_constant: motor.torque_constant(),
            weakened_constant: motor.torque_constant(),
            by_heat: 0.0,
            shows: fade(1.0 / SHOWN, period),
            motor: *motor,
            period,
            bus: config.bus,
            derating: config.derating,
            cascade: Cascade::new(motor, config.gains, config.friction, period)?,
            stepper: None,
            thermal: [
                Thermal::new(rated, peak, config.peak_time, period)?,
                Thermal::new(stage, peak, stage_time, period)?,
            ],
            watch: Watch::new(motor, &config)?,
            order: None,
            chirp: None,
            since: 0.0,
            beyond: 0.0,
            wanted: 0.0,
            velocity: 0.0,
            field: None,
            holder: Holder::Current,
            is_limited: false,
            shown: Rotor::ZERO,
            fault: None,
        })
    }

    /// The gates are about to be on: no current flows, and nothing is ordered. Ends a fault.
    pub fn start(&mut self) {
        self.order = None;
        self.chirp = None;
        self.wanted = 0.0;
        self.field = None;
        self.holder = Holder::Current;
        self.is_limited = false;
        self.watch.start();
        self.shown = Rotor::ZERO;
        self.fault = None;
    }

    /// Goes on with the heat of `before`, which this one replaces: motor and stage are the same.
    pub fn take_heat(&mut self, before: &Self) {
        self.thermal = before.thermal;
    }

    /// Positions are held as a stepper from the next period on, or by the loops.
    ///
    /// # Errors
    /// With what [`Stepper::new`] refuses; what was before stays.
    pub fn set_stepper(&mut self, config: Option<StepperConfig>) -> Result<(), Implausible> {
        self.stepper = match config {
            Some(config) => Some(Stepper::new(&self.motor, config, self.period)?),
            None => None,
        };
        self.holder = Holder::Current;
        Ok(())
    }

    /// A stepper is held in another way from the next period on, where it is held as one; what is held back stays so.
    ///
    /// # Errors
    /// With what [`Stepper::new`] refuses; what was before stays.
    pub fn change_stepper(&mut self, config: StepperConfig) -> Result<(), Implausible> {
        if let Some(stepper) = &mut self.stepper {
            let mut next = Stepper::new(&self.motor, config, self.period)?;
            next.go_on_from(stepper);
            *stepper = next;
        }
        Ok(())
    }

    /// What a blocked rotor is from the next period on, as in [`ControlConfig::blocked`].
    ///
    /// # Errors
    /// With what [`Blocked::new`](crate::protection::Blocked::new) refuses; what was before stays.
    pub fn set_blocked(&mut self, blocked: (f32, f32)) -> Result<(), Implausible> {
        self.watch.set_blocked(blocked, self.period)
    }

    /// What is to be done from now on, as of so many s ago.
    pub fn order(&mut self, order: Order, since: f32) {
        self.order = Some(order);
        self.since = since;
    }

    /// Other gains, from the next period on.
    ///
    /// # Errors
    /// With what [`Cascade::set_gains`] refuses; those of before stay.
    pub fn set_gains(&mut self, gains: Gains) -> Result<(), Implausible> {
        self.cascade.set_gains(gains)
    }

    /// Another low-pass and notch of the current that the velocity loop asks for, from the next period on; they go on from what is asked for now.
    pub fn set_filters(&mut self, low_pass: Filter, notch: Filter) {
        self.cascade.set_filters(low_pass, notch, self.wanted);
    }

    /// Adds to what is asked of the motor, within its limits, from the next period on; `None` ends it.
    pub fn excite(&mut self, chirp: Option<Chirp>) {
        self.chirp = chirp;
    }

    /// Whether something is added to what is asked of the motor.
    pub fn is_excited(&self) -> bool {
        self.chirp.is_some()
    }

    /// Whether the brake chopper is to be on at this voltage of the bus.
    pub fn chops(&mut self, bus: f32) -> bool {
        self.bus.run(bus)
    }

    /// The share of the time for which a brake chopper is to be on, as [`Bus::chopping`].
    pub fn chopping(&self, bus: f32) -> f32 {
        self.bus.chopping(bus)
    }

    /// Ends everything: the gates are to be off.
    #[cold]
    #[inline(never)]
    pub fn fail(&mut self, fault: Fault) {
        self.fault.get_or_insert(fault);
    }

    /// Why the motor has no current.
    pub fn fault(&self) -> Option<Fault> {
        self.fault
    }

    /// A period, with the stage so hot, in °C: the current in d and q for the next, in A.
    ///
    /// # Errors
    /// The gates are to be off.
    pub fn run(&mut self, seen: &Snapshot, temperature: f32) -> Result<Rotor, Fault> {
        if let Some(fault) = self.fault {
            return Err(fault);
        }
        let actual = self.actual(seen);
        let velocity = actual.velocity;
        let gained = velocity - core::mem::replace(&mut self.velocity, velocity);
        let (pushes, share) = (self.pushes(), self.derating.share(temperature));
        let is_fed = !self.bus.is_sunk(seen.bus);
        let found = match share {
            _ if share <= 0.0 => Some(Fault::Temperature),
            _ => self.watch.run(&self.motor, seen, is_fed, pushes, velocity),
        };
        // What is held at rest by less than all is not blocked.
        let found = found.filter(|fault| *fault != Fault::Blocked || self.is_limited);
        if let Some(fault) = found {
            self.fail(fault);
            return Err(fault);
        }
        let current = seen.current;
        self.shown = self.shown.fading_to(current, self.shows);
        let [motor, stage] = &mut self.thermal;
        let square = current.square();
        let heat = lesser(motor.run(square), stage.run(square));
        self.by_heat = heat * share;
        let across = self.across(seen.weakening);
        let limits = self.limits(across, actual.velocity, seen.bus);
        let Some(order) = self.order else {
            return Ok(Rotor::ZERO);
        };
        let (mut demand, is_position) = self.demand(&order);
        if let Some(chirp) = &mut self.chirp {
            match chirp.run() {
                Some(current) => demand.current += current,
                None => self.chirp = None,
            }
        }
        let holder = match (is_position, &self.stepper, &self.chirp) {
            (false, ..) => Holder::Current,
            // A sine is added to a current: soft loops are about it.
            (true, Some(_), None) => Holder::Field,
            (true, ..) => Holder::Loops,
        };
        let is_new = core::mem::replace(&mut self.holder, holder) != holder;
        if is_new && holder == Holder::Loops {
            self.cascade.take_over(self.wanted, &demand, actual);
        }
        self.since += self.period;
        let mut along = 0.0;
        self.field = None;
        let wanted = match holder {
            Holder::Field => {
                let field = self.lead(&demand, seen, is_new, limits);
                along = field.d;
                field.q
            }
            Holder::Loops => {
                let wanted = self.cascade.run(&demand, actual, limits);
                self.is_limited = self.cascade.is_limited();
                wanted
            }
            Holder::Current => {
                let limits = self.below_speed(limits, order.speed, (actual.velocity, gained));
                let asked = limit(demand.current, 1e4);
                let given = between(asked, -limits.negative, limits.positive);
                self.is_limited = given != asked;
                given
            }
        };
        self.wanted = wanted;
        Ok(Rotor {
            d: along,
            q: wanted,
        })
    }

    /// Whether the current of the last period is a field that turns by itself, for [`CurrentInterrupt::order_field`](crate::CurrentInterrupt::order_field): from where it was seen, and its
    /// speed in electrical rad/s.
    pub fn field(&self) -> Option<(Angle, f32)> {
        self.field
    }

    /// How much of I²t is spent, of the motor or the stage, whichever is more: 0 to 1.
    #[inline(never)]
    pub fn heat(&self) -> f32 {
        let [motor, stage] = &self.thermal;
        motor.share().max(stage.share())
    }

    /// What there is to tell while the motor has current.
    pub fn report(&self, seen: &Snapshot) -> Report {
        let current = self.shown;
        let constant = self.torque_constant;
        let torque = constant * self.by_saliency(current.d) * current.q;
        let size = root(current.square());
        Report {
            demand: self.wanted * self.weakened_constant,
            torque,
            current: if current.q < 0.0 { -size } else { size },
            velocity: self.actual(seen).velocity / self.cascade.count,
            is_limited: self.is_limited,
            lead: self.lead_angle(),
            is_hot: self.is_hot(),
        }
    }

    /// By how many full steps the field of a stepper leads the rotor, where one holds it.
    fn field_lead(&self) -> Option<f32> {
        let stepper = self.stepper.as_ref()?;
        (self.holder == Holder::Field).then(|| stepper.lead())
    }

    /// By how many full steps the field of a stepper is to lead the rotor; 0 where none does.
    pub fn lead_angle(&self) -> f32 {
        let lead = self.field_lead().filter(|_| self.fault.is_none());
        lead.unwrap_or(0.0)
    }

    /// The heat has come near its bound.
    pub fn is_hot(&self) -> bool {
        self.heat() > 0.9
    }

    fn actual(&self, seen: &Snapshot) -> Actual {
        Actual {
            position: seen.position,
            velocity: seen.speed / f32::from(self.motor.pole_pairs),
        }
    }

    /// What the order says now, and whether it is a position.
    fn demand(&mut self, order: &Order) -> (Demand, bool) {
        let current = order.torque / self.weakened_constant;
        let Goal::Position {
            counts,
            part,
            velocity,
            acceleration,
        } = order.goal
        else {
            let demand = Demand {
                current,
                ..Demand::default()
            };
            return (demand, false);
        };
        // Where no order comes any more, the position stays.
        let since = between(self.since, 0.0, 4e-3);
        let on = (velocity + 0.5 * acceleration * since) * since;
        self.beyond = limit(part as f32 * (1.0 / 4_294_967_296.0) + on, 1e6);
        let whole = floor(self.beyond);
        let demand = Demand {
            position: Some(counts.saturating_add(whole.into())),
            part: self.beyond - whole as f32,
            velocity: (velocity + acceleration * since + order.velocity_ahead) * self.cascade.count,
            acceleration: acceleration * self.cascade.count,
            current,
        };
        (demand, true)
    }

    /// Whether the rotor is pushed as hard as it may be.
    fn pushes(&self) -> bool {
        match self.field_lead() {
            Some(lead) => lead.abs() >= 1.0,
            None => self.wanted.abs() > 0.9 * self.motor.rated_current,
        }
    }
}

/// The whole number below.
fn floor(value: f32) -> i32 {
    let whole = value as i32;
    if (whole as f32) > value {
        whole.saturating_sub(1)
    } else {
        whole
    }
}
