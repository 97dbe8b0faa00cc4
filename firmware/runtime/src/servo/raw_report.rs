//! What the loops report beside the actual values, for the module of a product. The interrupt of the loops of a board publishes floats as it has them,
//! as it has little time; whole numbers with units are made of them where they are read.

use cia402::loops::{Found, LoopReport, ServoSettings};
use servo::transform::Rotor;
use servo::{Angle, Motor};

use super::data::ServoData;
use super::loops::hundredths;
use super::settings::{LoopSettings as _, config};

/// See the module.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RawReport {
    /// The motor and its pole pairs as they are set.
    pub(super) motor: ([u32; 6], u16),
    /// In counts/s.
    pub(super) velocity: f32,
    /// Of the encoder, from where it began.
    pub(super) counts: i64,
    /// The angle where the encoder is at 0, and what of that is the offset of the settings.
    pub(super) zero: Angle,
    pub(super) offset: u16,
    /// In full steps.
    pub(super) lead: f32,
    pub(super) current: Rotor,
    pub(super) angle: Angle,
    /// A share of its limit.
    pub(super) heat: f32,
    pub(super) is_limited: bool,
    pub(super) is_on: bool,
}

impl RawReport {
    /// Nothing is reported yet.
    pub(super) const NONE: Self = Self {
        motor: ([0; 6], 0),
        velocity: 0.0,
        counts: 0,
        zero: Angle::ZERO,
        offset: 0,
        lead: 0.0,
        current: Rotor::ZERO,
        angle: Angle::ZERO,
        heat: 0.0,
        is_limited: false,
        is_on: false,
    };

    /// The report of an axis with this data, with what a measurement has found.
    pub(super) fn report(&self, data: &ServoData, found: Found) -> LoopReport {
        let settings = ServoSettings {
            motor: self.motor.0,
            pole_pairs: self.motor.1,
            ..ServoSettings::NONE
        };
        let (motor, friction) = settings.motor(data);
        let own = ServoSettings::NONE.gains(data);
        let zero = (self.zero.bits() >> 16) as u16;
        LoopReport {
            found,
            motor: listed(&motor, friction),
            own_motor: listed(&data.motor, data.friction),
            own_pole_pairs: data.motor.pole_pairs,
            own_torque_constant: number(data.motor.torque_constant(), 1e-6),
            pole_pairs: motor.pole_pairs,
            torque_constant: number(motor.torque_constant(), 1e-6),
            own_gains: [own.velocity, own.integral, own.position].map(|gain| (gain + 0.5) as u16),
            own_share: (config(data).share * 1e3) as u16,
            own_learning: (config(data).learning * 1e3) as u16,
            speed: (self.velocity * 60_000.0 / motor.counts as f32) as i32,
            counts: self.counts,
            counts_of_turn: motor.counts,
            rated_current: number(motor.rated_current, 1e-3),
            peak_current: number(motor.peak_current, 1e-3),
            max_speed: data.speed,
            zero: zero.wrapping_sub(self.offset),
            lead: hundredths(self.lead),
            current: ((self.current.d * 1e3) as i32, (self.current.q * 1e3) as i32),
            angle: (self.angle.bits() >> 16) as u16,
            heat: (self.heat * 1e3) as u16,
            is_limited: self.is_limited,
            is_on: self.is_on,
        }
    }
}

/// A value as a whole number of units.
fn number(value: f32, unit: f32) -> u32 {
    (value / unit + 0.5) as u32
}

/// A motor as 20C2h has it.
fn listed(motor: &Motor, friction: f32) -> [u32; 6] {
    [
        number(motor.resistance, 1e-6),
        number(motor.inductance_d, 1e-9),
        number(motor.inductance_q, 1e-9),
        number(motor.flux, 1e-9),
        number(motor.inertia, 1e-9),
        number(friction, 1e-6),
    ]
}
