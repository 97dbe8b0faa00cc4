//! What a master sets up, in contrast to what it commands: how the drive stops, what it may do, and when something counts as
//! reached.
//!
//! It changes seldom, so it passes from the communication task to the control tick apart from the commands, and only when an
//! object of it was written. Codes are decoded on the way: a tick never sees one that means nothing.

use crate::objects::Objects;
use crate::option_codes::{AbortConnectionOption, QuickStopOption, Stop, StopRamp};

/// Everything that is set up, as the objects say it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Configuration {
    /// 6007h.
    pub abort_connection: AbortConnectionOption,
    /// 605Ah.
    pub quick_stop: QuickStopOption,
    /// 605Bh.
    pub shutdown: Stop,
    /// 605Ch.
    pub disable_operation: Stop,
    /// 605Dh.
    pub halt: StopRamp,
    /// 605Eh.
    pub fault_reaction: Stop,
    /// 6085h in steps/s².
    pub quick_stop_deceleration: u32,
    /// 607Dh:1 and :2 in user units (steps). They are off while the first is not below the second.
    pub position_limits: (i32, i32),
    /// 6065h in user units (steps); FFFFFFFFh is off.
    pub following_error_window: u32,
    /// 6066h in milliseconds.
    pub following_error_time_out: u16,
    /// 6067h in user units (steps).
    pub position_window: u32,
    /// 6068h in milliseconds.
    pub position_window_time: u16,
    /// 606Dh in steps/s.
    pub velocity_window: u16,
    /// 606Eh in milliseconds.
    pub velocity_window_time: u16,
    /// 606Fh in steps/s.
    pub velocity_threshold: u16,
    /// 6070h in milliseconds.
    pub velocity_threshold_time: u16,
    /// 60F8h in steps/s; a negative one counts as 0.
    pub max_slippage: u32,
    /// The smaller of 607Fh and 6080h, in steps/s.
    pub max_velocity: u32,
    /// 60C5h in steps/s².
    pub max_acceleration: u32,
    /// 60C6h in steps/s².
    pub max_deceleration: u32,
    /// What belongs to the velocity mode alone.
    pub velocity: VelocityConfiguration,
}

/// What is set up of the velocity mode ("vl").
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VelocityConfiguration {
    /// 6046h:1 in units of the mode.
    pub min_amount: u32,
    /// 6046h:2 in units of the mode.
    pub max_amount: u32,
    /// 604Ch: how many steps/s a unit of the mode is, numerator and denominator.
    pub dimension: (i32, i32),
    /// 6048h in steps/s².
    pub acceleration: u32,
    /// 6049h in steps/s².
    pub deceleration: u32,
    /// 604Ah in steps/s².
    pub quick_stop: u32,
}

impl VelocityConfiguration {
    /// What holds before anything is set up.
    pub const NONE: Self = Self {
        min_amount: 0,
        max_amount: u32::MAX,
        dimension: (1, 1),
        acceleration: 1,
        deceleration: 1,
        quick_stop: 1,
    };

    fn of<D: Objects>(dictionary: &D) -> Self {
        let dimension = (
            dictionary.vl_dimension_numerator(),
            dictionary.vl_dimension_denominator(),
        );
        let ramp = |speed, time| ramp(speed, time, dimension);
        Self {
            min_amount: dictionary.vl_velocity_min_amount(),
            max_amount: dictionary.vl_velocity_max_amount(),
            dimension,
            acceleration: ramp(
                dictionary.vl_acceleration_speed(),
                dictionary.vl_acceleration_time(),
            ),
            deceleration: ramp(
                dictionary.vl_deceleration_speed(),
                dictionary.vl_deceleration_time(),
            ),
            quick_stop: ramp(
                dictionary.vl_quick_stop_speed(),
                dictionary.vl_quick_stop_time(),
            ),
        }
    }

    /// A velocity of the mode in steps/s, rounded towards zero.
    pub fn steps_per_second(&self, velocity: i32) -> i32 {
        let (numerator, denominator) = self.dimension;
        scaled(velocity, numerator, denominator)
    }

    /// A velocity in steps/s as the mode shows it, rounded towards zero.
    pub fn shown(&self, steps_per_second: i32) -> i16 {
        let (numerator, denominator) = self.dimension;
        let velocity = if numerator == denominator {
            steps_per_second
        } else {
            scaled(steps_per_second, denominator, numerator)
        };
        let end = if velocity < 0 { i16::MIN } else { i16::MAX };
        i16::try_from(velocity).unwrap_or(end)
    }
}

/// `velocity * numerator / denominator`; 0 where nothing is to be divided by.
fn scaled(velocity: i32, numerator: i32, denominator: i32) -> i32 {
    let product = i64::from(velocity).saturating_mul(numerator.into());
    let quotient = product.checked_div(denominator.into()).unwrap_or(0);
    let end = if quotient < 0 { i32::MIN } else { i32::MAX };
    i32::try_from(quotient).unwrap_or(end)
}

/// A speed that is gained in so many seconds, in steps/s²: at least 1, so that every ramp ends.
fn ramp(speed: u32, seconds: u16, dimension: (i32, i32)) -> u32 {
    let gained = u64::from(speed).saturating_mul(dimension.0.unsigned_abs().into());
    let divisor = u64::from(seconds).saturating_mul(dimension.1.unsigned_abs().into());
    let ramp = gained.checked_div(divisor).unwrap_or(u64::MAX);
    u32::try_from(ramp).unwrap_or(u32::MAX).max(1)
}

impl Configuration {
    /// What holds before anything is set up.
    pub const NONE: Self = Self {
        abort_connection: AbortConnectionOption::QuickStop,
        quick_stop: QuickStopOption::QuickStopRamp,
        shutdown: Stop::PowerOff,
        disable_operation: Stop::Ramp(StopRamp::SlowDown),
        halt: StopRamp::SlowDown,
        fault_reaction: Stop::Ramp(StopRamp::QuickStop),
        quick_stop_deceleration: 0,
        position_limits: (i32::MIN, i32::MAX),
        following_error_window: u32::MAX,
        following_error_time_out: 0,
        position_window: u32::MAX,
        position_window_time: 0,
        velocity_window: 0,
        velocity_window_time: 0,
        velocity_threshold: 0,
        velocity_threshold_time: 0,
        max_slippage: u32::MAX,
        max_velocity: u32::MAX,
        max_acceleration: u32::MAX,
        max_deceleration: u32::MAX,
        velocity: VelocityConfiguration::NONE,
    };

    /// What the objects of a dictionary say. A code that means nothing (only a data sheet can hold one) counts as the default
    /// of the standard.
    pub fn of<D: Objects>(dictionary: &D) -> Self {
        Self {
            abort_connection: AbortConnectionOption::from_code(
                dictionary.abort_connection_option_code(),
            )
            .unwrap_or(Self::NONE.abort_connection),
            quick_stop: QuickStopOption::from_code(dictionary.quick_stop_option_code())
                .unwrap_or(Self::NONE.quick_stop),
            shutdown: Stop::on_leaving(dictionary.shutdown_option_code())
                .unwrap_or(Self::NONE.shutdown),
            disable_operation: Stop::on_leaving(dictionary.disable_operation_option_code())
                .unwrap_or(Self::NONE.disable_operation),
            halt: StopRamp::on_halt(dictionary.halt_option_code()).unwrap_or(Self::NONE.halt),
            fault_reaction: Stop::on_fault(dictionary.fault_reaction_option_code())
                .unwrap_or(Self::NONE.fault_reaction),
            quick_stop_deceleration: dictionary.quick_stop_deceleration(),
            position_limits: (
                dictionary.min_position_limit(),
                dictionary.max_position_limit(),
            ),
            following_error_window: dictionary.following_error_window(),
            following_error_time_out: dictionary.following_error_time_out(),
            position_window: dictionary.position_window(),
            position_window_time: dictionary.position_window_time(),
            velocity_window: dictionary.velocity_window(),
            velocity_window_time: dictionary.velocity_window_time(),
            velocity_threshold: dictionary.velocity_threshold(),
            velocity_threshold_time: dictionary.velocity_threshold_time(),
            max_slippage: dictionary.max_slippage().max(0).unsigned_abs(),
            max_velocity: dictionary
                .max_profile_velocity()
                .min(dictionary.max_motor_speed()),
            max_acceleration: dictionary.max_acceleration(),
            max_deceleration: dictionary.max_deceleration(),
            velocity: VelocityConfiguration::of(dictionary),
        }
    }
}
