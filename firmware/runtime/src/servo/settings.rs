//! What the drive is set to beside its orders, and the loops that come of it.

use cia402::loops::{ServoSettings, StepperSettings};
use servo::cascade::Gains;
use servo::control::ControlConfig;
use servo::current_loop::CurrentConfig;
use servo::filter::Filter;
use servo::modulation::Modulation;
use servo::motor::Implausible;
use servo::protection::{Bus, Derating};
use servo::stepper::{Beyond, StepperConfig};
use servo::{Control, CurrentLoop, Motor, Wiring};

use super::data::ServoData;

/// A stepper as the loops take it.
pub(super) trait StepperLoops {
    /// `None` for the loops.
    fn config(&self, data: &ServoData, motor: &Motor) -> Option<StepperConfig>;
}

impl StepperLoops for StepperSettings {
    fn config(&self, data: &ServoData, motor: &Motor) -> Option<StepperConfig> {
        let beyond = match self.mode {
            1 => Beyond::Reported,
            2 => Beyond::MadeUpAtRest,
            3 => Beyond::MadeUpAtOnce,
            4 => Beyond::Kept,
            _ => return None,
        };
        let current = f32::from(self.current) * 1e-3 * motor.rated_current;
        Some(StepperConfig {
            beyond,
            bound: f32::from(self.bound) * 1e-2,
            speed: self.speed.into(),
            max_speed: data.speed as f32 / 60.0 * 4.0 * f32::from(motor.pole_pairs),
            current: current.min(motor.peak_current),
            at_rest: f32::from(self.at_rest) * 1e-3,
            fall: f32::from(self.fall) * 1e-3,
        })
    }
}

/// Settings as the loops take them.
pub(super) trait LoopSettings {
    /// The motor that the loops go by, and the torque of its friction.
    fn motor(&self, data: &ServoData) -> (Motor, f32);
    /// How stiff they are.
    fn gains(&self, data: &ServoData) -> Gains;
    /// Low-pass and notch; a frequency of 0 is none. What cannot be is refused by the limits of 20C3h.
    fn filters(&self, data: &ServoData) -> (Filter, Filter);
    /// Speed in rad/s and time in s.
    fn blocked(&self) -> (f32, f32);
    /// The greatest current that weakens the field, in A: at most the peak.
    fn weakening(&self, motor: &Motor) -> f32;
}

impl LoopSettings for ServoSettings {
    fn motor(&self, data: &ServoData) -> (Motor, f32) {
        let own = data.motor;
        let or = |number: u32, unit: f32, own: f32| match number {
            0 => own,
            _ => number as f32 * unit,
        };
        let [resistance, along, across, flux, inertia, friction] = self.motor;
        let motor = Motor {
            resistance: or(resistance, 1e-6, own.resistance),
            inductance_d: or(along, 1e-9, own.inductance_d),
            inductance_q: or(across, 1e-9, own.inductance_q),
            flux: or(flux, 1e-9, own.flux),
            inertia: or(inertia, 1e-9, own.inertia),
            pole_pairs: match self.pole_pairs {
                0 => own.pole_pairs,
                pairs => pairs,
            },
            ..own
        };
        (motor, or(friction, 1e-6, data.friction))
    }

    fn gains(&self, data: &ServoData) -> Gains {
        let own = Gains::from_bandwidth(data.bandwidth);
        let or = |number: u16, own: f32| if number == 0 { own } else { number.into() };
        let [velocity, integral, position] = self.gains;
        Gains {
            position: or(position, own.position),
            velocity: or(velocity, own.velocity),
            integral: or(integral, own.integral),
        }
    }

    fn filters(&self, data: &ServoData) -> (Filter, Filter) {
        let period = data.control_period();
        let [low_pass, flatness, notch, narrowness] = self.filters.map(f32::from);
        let low_pass = if flatness > 0.0 {
            Filter::low_pass(low_pass, (flatness * 1e-3).max(0.1), period)
        } else {
            Filter::first_low_pass(low_pass, period)
        };
        let notch = Filter::notch(notch, narrowness * 1e-3, period);
        (
            low_pass.unwrap_or(Filter::NONE),
            notch.unwrap_or(Filter::NONE),
        )
    }

    fn blocked(&self) -> (f32, f32) {
        let (time, speed) = self.blocked;
        let turns = f32::from(speed) / 60.0;
        (turns * core::f32::consts::TAU, f32::from(time) * 1e-3)
    }

    fn weakening(&self, motor: &Motor) -> f32 {
        (self.weakening as f32 * 1e-3).min(motor.peak_current)
    }
}

pub(super) fn modulation(data: &ServoData) -> Result<Modulation, Implausible> {
    let stage = &data.stage;
    Modulation::new(
        data.motor.wiring,
        stage.dead_time,
        stage.ripple,
        stage.reach,
    )
}

pub(super) fn config(data: &ServoData) -> CurrentConfig {
    CurrentConfig::quick(&data.motor, data.stage.period, data.trip(), data.bounds())
}

pub(super) fn derating() -> Option<Derating> {
    Derating::new(80.0, 100.0).ok()
}

/// The speed at which the gates go off, in rad/s. A weakened field turns the motor faster than its bus would, and with the gates off its magnet feeds the bus
/// through the diodes: no further than to the bound of that.
fn over_speed(data: &ServoData, motor: &Motor, weakening: f32) -> f32 {
    let own = data.max_speed() * 1.2;
    if weakening <= 0.0 {
        return own;
    }
    let between_lines = match motor.wiring {
        Wiring::TwoPhase => 1.0,
        Wiring::ThreePhase => 1.732_050_8,
    };
    let (_, bound) = data.bounds();
    own.min(bound / (between_lines * motor.flux * f32::from(motor.pole_pairs)))
}

/// The current loop for a motor.
pub(super) fn current_loop(
    data: &ServoData,
    motor: &Motor,
    settings: &ServoSettings,
) -> Result<CurrentLoop, Implausible> {
    let config = CurrentConfig {
        weakening: settings.weakening(motor),
        ..config(data)
    };
    let mut current = CurrentLoop::new(motor, config, modulation(data)?)?;
    set_current_gains(&mut current, data, settings);
    Ok(current)
}

/// The gains of the current loop, which change without a bump. What is none was refused by the limits of its object.
pub(super) fn set_current_gains(
    current: &mut CurrentLoop,
    data: &ServoData,
    settings: &ServoSettings,
) {
    let own = config(data);
    let of = |thousandths: u16| (thousandths > 0).then(|| f32::from(thousandths) * 1e-3);
    let _ = current.set_share(of(settings.share).unwrap_or(own.share));
    let _ = current.set_learning(of(settings.learning).unwrap_or(own.learning));
    if let Some(along) = of(settings.share_along) {
        let _ = current.set_share_along(along);
    }
}

/// The loops above it.
pub(super) fn control(
    data: &ServoData,
    motor: &Motor,
    settings: &ServoSettings,
) -> Result<Control, Implausible> {
    let voltage = data.stage.voltage;
    let (_, friction) = settings.motor(data);
    let config = ControlConfig {
        period: data.control_period(),
        gains: settings.gains(data),
        friction: friction / motor.torque_constant(),
        peak_time: 2.0,
        stage: data.stage.bears,
        bus: Bus::new(1.03 * voltage, 1.05 * voltage, 1.2 * voltage)?,
        derating: derating().ok_or(Implausible)?,
        blocked: settings.blocked(),
        max_speed: over_speed(data, motor, settings.weakening(motor)),
    };
    let mut control = Control::new(motor, config)?;
    // What cannot be leaves the loops.
    let _ = control.set_stepper(settings.stepper.config(data, motor));
    let (low_pass, notch) = settings.filters(data);
    control.set_filters(low_pass, notch);
    Ok(control)
}
