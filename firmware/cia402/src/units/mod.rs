//! Units of the user (CiA 402-2, "factor group"): what a number of a master is in increments, and back.
//!
//! The drive counts increments: steps, increments/s with 32 bits behind the point, increments/s². A master may count in units of its own:
//!
//! - positions: one unit is 608Fh · 6091h / 6092h increments (encoder resolution, gear ratio, feed constant);
//! - velocities: position units/s times 6096h. Where 6090h:1 is not 0, 6090h takes the place of 608Fh;
//! - accelerations: velocity units/s times 6097h; jerk: that per second;
//! - 6080h: revolutions of the motor per minute, where 608Fh is there; increments/s elsewhere;
//! - 607Eh: bit 7 turns the sign of positions around, bit 6 that of velocities. Homing looks for its switches in the directions
//!   of the increments all the same;
//! - 607Bh: the range in which positions are shown. Behind its end they go on at the other. The drive counts on.
//!
//! The contract:
//! - Conversions are exact rationals, rounded once to the nearest, halves away from zero. Nothing adds up.
//! - What is too large for the number it becomes stops at its end; a limit of the drive is met there, and bit 11 tells.
//! - An amount that is not 0 does not become 0: a velocity is at least 2⁻³² increments/s, a ramp one increment/s².
//! - The factors are multiplied and reduced when one of them is written. While a unit is an increment, a conversion is a comparison, and a
//!   shift for velocities.

mod frame;
mod range;
mod ratio;
mod si;

use motion::{SignedSpeed, Speed};

use crate::objects::Objects;
use crate::parameters::Parameter;
pub(crate) use frame::PositionFrame;
pub use range::{Range, Rotation};
pub use ratio::Ratio;
pub use si::SiUnit;

/// 607Eh: positions are turned around.
const POSITION_POLARITY: u8 = 1 << 7;
/// 607Eh: velocities are turned around.
pub(crate) const VELOCITY_POLARITY: u8 = 1 << 6;

/// A window that is off: FFFFFFFFh.
const OFF: u32 = u32::MAX;

/// The objects that units are made from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Factors {
    /// 608Fh: increments and motor revolutions; `None` where a data sheet has no such object.
    pub position_encoder: Option<(u32, u32)>,
    /// 6090h: the same for velocities; with 0 increments as 608Fh.
    pub velocity_encoder: (u32, u32),
    /// 6091h: motor and shaft revolutions.
    pub gear: (u32, u32),
    /// 6092h: feed and shaft revolutions.
    pub feed: (u32, u32),
    /// 6096h: numerator and divisor.
    pub velocity: (u32, u32),
    /// 6097h: numerator and divisor.
    pub acceleration: (u32, u32),
    /// 607Eh.
    pub polarity: u8,
    /// 607Bh: minimum and maximum.
    pub range: (i32, i32),
}

impl Factors {
    /// What the objects say.
    pub fn of<D: Objects>(dictionary: &D) -> Self {
        let encoder = (
            dictionary.position_encoder_increments(),
            dictionary.position_encoder_revolutions(),
        );
        Self {
            position_encoder: (encoder.0 != 0).then_some(encoder),
            velocity_encoder: (
                dictionary.velocity_encoder_increments(),
                dictionary.velocity_encoder_revolutions(),
            ),
            gear: (
                dictionary.gear_motor_revolutions(),
                dictionary.gear_shaft_revolutions(),
            ),
            feed: (dictionary.feed(), dictionary.feed_shaft_revolutions()),
            velocity: (
                dictionary.velocity_factor_numerator(),
                dictionary.velocity_factor_divisor(),
            ),
            acceleration: (
                dictionary.acceleration_factor_numerator(),
                dictionary.acceleration_factor_divisor(),
            ),
            polarity: dictionary.polarity(),
            range: (
                dictionary.min_position_range_limit(),
                dictionary.max_position_range_limit(),
            ),
        }
    }
}

impl Factors {
    /// Whether a parameter is a factor.
    pub(crate) const fn has(parameter: Parameter) -> bool {
        matches!(
            parameter,
            Parameter::PositionEncoderIncrements
                | Parameter::PositionEncoderRevolutions
                | Parameter::VelocityEncoderIncrements
                | Parameter::VelocityEncoderRevolutions
                | Parameter::GearMotorRevolutions
                | Parameter::GearShaftRevolutions
                | Parameter::Feed
                | Parameter::FeedShaftRevolutions
                | Parameter::VelocityFactorNumerator
                | Parameter::VelocityFactorDivisor
                | Parameter::AccelerationFactorNumerator
                | Parameter::AccelerationFactorDivisor
        )
    }

    /// The same with another number in one of the objects. An object that is no factor changes nothing.
    pub fn with(mut self, parameter: Parameter, number: u32) -> Self {
        let encoder = self.position_encoder.unwrap_or((1, 1));
        match parameter {
            Parameter::PositionEncoderIncrements => {
                self.position_encoder = Some((number, encoder.1));
            }
            Parameter::PositionEncoderRevolutions => {
                self.position_encoder = Some((encoder.0, number));
            }
            Parameter::VelocityEncoderIncrements => self.velocity_encoder.0 = number,
            Parameter::VelocityEncoderRevolutions => self.velocity_encoder.1 = number,
            Parameter::GearMotorRevolutions => self.gear.0 = number,
            Parameter::GearShaftRevolutions => self.gear.1 = number,
            Parameter::Feed => self.feed.0 = number,
            Parameter::FeedShaftRevolutions => self.feed.1 = number,
            Parameter::VelocityFactorNumerator => self.velocity.0 = number,
            Parameter::VelocityFactorDivisor => self.velocity.1 = number,
            Parameter::AccelerationFactorNumerator => self.acceleration.0 = number,
            Parameter::AccelerationFactorDivisor => self.acceleration.1 = number,
            _ => {}
        }
        self
    }
}

/// What the units of the user are in increments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Units {
    position: Ratio,
    velocity: Ratio,
    acceleration: Ratio,
    /// Increments/s of a revolution of the motor per minute.
    motor_speed: Ratio,
    polarity: u8,
    range: Range,
    /// Positions are increments, and are not turned around: most conversions are none.
    is_plain: bool,
}

impl Units {
    /// Units are increments.
    pub const NONE: Self = Self {
        position: Ratio::ONE,
        velocity: Ratio::ONE,
        acceleration: Ratio::ONE,
        motor_speed: Ratio::ONE,
        polarity: 0,
        range: Range::ALL,
        is_plain: true,
    };

    /// The units that these factors make. `None` if a factor is 0, or if a ratio in lowest terms has more than 64 bits.
    pub fn new(factors: Factors) -> Option<Self> {
        let position_encoder = factors.position_encoder.unwrap_or((1, 1));
        let velocity_encoder = match factors.velocity_encoder {
            (0, _) => position_encoder,
            given => given,
        };
        let (motor, shaft) = factors.gear;
        let (feed, turns) = factors.feed;
        let of_velocity = factors.velocity;
        let of_acceleration = factors.acceleration;
        let position = Ratio::of(
            [position_encoder.0, motor, turns],
            [position_encoder.1, shaft, feed],
        )?;
        Some(Self {
            position,
            velocity: Ratio::of(
                [velocity_encoder.0, motor, turns, of_velocity.1],
                [velocity_encoder.1, shaft, feed, of_velocity.0],
            )?,
            acceleration: Ratio::of(
                [
                    velocity_encoder.0,
                    motor,
                    turns,
                    of_velocity.1,
                    of_acceleration.1,
                ],
                [
                    velocity_encoder.1,
                    shaft,
                    feed,
                    of_velocity.0,
                    of_acceleration.0,
                ],
            )?,
            motor_speed: match factors.position_encoder {
                None => Ratio::ONE,
                Some((increments, revolutions)) => Ratio::of([increments, 1], [revolutions, 60])?,
            },
            polarity: factors.polarity,
            range: Range::new(factors.range),
            is_plain: position.is_one() && factors.polarity & POSITION_POLARITY == 0,
        })
    }

    /// The units of a dictionary. Its rules keep out factors that make none; those of a data sheet that do count as increments.
    pub fn of<D: Objects>(dictionary: &D) -> Self {
        if !D::DRIVE.units {
            return Self::NONE;
        }
        Self::new(Factors::of(dictionary)).unwrap_or(Self::NONE)
    }

    /// These, of a drive that has units; else increments, which the compiler knows.
    #[inline]
    pub(crate) const fn of_drive<D: Objects>(&self) -> &Self {
        if D::DRIVE.units { self } else { &Self::NONE }
    }

    /// Increments of a position, on the count that goes on behind the ends of 607Bh.
    #[inline]
    pub fn position(&self, user: i64) -> i64 {
        if self.is_plain {
            return user;
        }
        self.increments_of(user)
    }

    #[inline(never)]
    fn increments_of(&self, user: i64) -> i64 {
        self.with_position_polarity(self.position.to_increments(user))
    }

    /// The position in units of the user, on the count that goes on behind the ends of 607Bh.
    #[inline]
    pub fn position_in_units(&self, increments: i64) -> i64 {
        if self.is_plain {
            return increments;
        }
        self.units_of(increments)
    }

    #[inline(never)]
    fn units_of(&self, increments: i64) -> i64 {
        self.with_position_polarity(self.position.to_units(increments))
    }

    /// Whether positions are shown as they are counted, modulo 2³².
    #[inline]
    pub(super) const fn shows_increments(&self) -> bool {
        self.is_plain && !self.range.is_rotary()
    }

    /// Increments of a distance or an offset, with its sign (60B0h).
    #[inline]
    pub fn distance(&self, user: i32) -> i64 {
        self.position(user.into())
    }

    /// A distance in units of the user, with its sign (60F4h).
    pub fn distance_in_units(&self, increments: i32) -> i32 {
        nearest(self.position_in_units(increments.into()))
    }

    /// Increments of a window: 6065h, 6067h. FFFFFFFFh stays what it is, "off", and nothing else becomes that.
    pub fn window(&self, user: u32) -> u32 {
        if user == OFF {
            return OFF;
        }
        let increments = self.position.to_increments(user.into());
        u32::try_from(increments).unwrap_or(OFF).min(OFF - 1)
    }

    /// A velocity, with its sign (60FFh, 60B1h).
    #[inline(never)]
    pub fn velocity(&self, user: i32) -> SignedSpeed {
        let velocity = if self.velocity.is_one() {
            SignedSpeed::per_second(user)
        } else {
            self.speed(user.unsigned_abs()).signed(user < 0)
        };
        self.with_velocity_polarity(velocity)
    }

    /// A velocity in units of the user (606Bh, 606Ch).
    #[inline]
    pub fn velocity_in_units(&self, velocity: SignedSpeed) -> i32 {
        let velocity = self.with_velocity_polarity(velocity);
        if self.velocity.is_one() {
            return velocity.whole();
        }
        let amount = self.velocity.to_units_of_speed(velocity.unsigned_abs());
        let amount = i64::try_from(amount).unwrap_or(i64::MAX);
        nearest(turned(amount, velocity.bits() < 0))
    }

    /// An amount that is to be reached or not exceeded (6081h, 607Fh, 6099h): more than 0, unless it is 0.
    pub fn speed(&self, user: u32) -> Speed {
        amount_of_speed(self.velocity, user)
    }

    /// A velocity window or threshold (606Dh, 606Fh, 60F8h), to the nearest.
    pub fn speed_window(&self, user: u32) -> Speed {
        self.velocity.to_speed(user)
    }

    /// A speed of the motor (6080h).
    pub fn motor_speed(&self, user: u32) -> Speed {
        amount_of_speed(self.motor_speed, user)
    }

    /// Increments/s² of a ramp (6083h, 6084h, 60C5h): at least 1, unless it is 0.
    pub fn acceleration(&self, user: u32) -> u32 {
        amount(self.acceleration, user)
    }

    /// Increments/s³ of a jerk (60A4h), whose unit is that of the acceleration per second: at least 1, unless it is 0.
    pub fn jerk(&self, user: u32) -> u32 {
        amount(self.acceleration, user)
    }

    /// Increments of a unit of position.
    pub(crate) const fn of_positions(&self) -> Ratio {
        self.position
    }

    /// Whether positions are turned around.
    pub const fn has_position_polarity(&self) -> bool {
        self.polarity & POSITION_POLARITY != 0
    }

    /// Where positions wrap.
    pub const fn range(&self) -> Range {
        self.range
    }

    const fn with_position_polarity(&self, number: i64) -> i64 {
        turned(number, self.polarity & POSITION_POLARITY != 0)
    }

    const fn with_velocity_polarity(&self, velocity: SignedSpeed) -> SignedSpeed {
        if self.polarity & VELOCITY_POLARITY != 0 {
            velocity.reversed()
        } else {
            velocity
        }
    }
}

const fn turned(number: i64, is_turned: bool) -> i64 {
    if is_turned {
        number.saturating_neg()
    } else {
        number
    }
}

/// The nearest number of 32 bits.
#[inline]
fn nearest(number: i64) -> i32 {
    let end = if number < 0 { i32::MIN } else { i32::MAX };
    i32::try_from(number).unwrap_or(end)
}

/// A speed: more than 0, unless it is 0.
#[inline(never)]
fn amount_of_speed(ratio: Ratio, user: u32) -> Speed {
    let speed = ratio.to_speed(user);
    if user == 0 {
        speed
    } else {
        speed.max(Speed::LEAST)
    }
}

/// An amount in increments: at least 1, unless it is 0.
#[inline(never)]
fn amount(ratio: Ratio, user: u32) -> u32 {
    if ratio.is_one() || user == 0 {
        return user;
    }
    let increments = ratio.to_increments(user.into()).max(1);
    u32::try_from(increments).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests;
