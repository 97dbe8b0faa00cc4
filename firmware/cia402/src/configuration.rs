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
    /// 6067h in user units (steps).
    pub position_window: u32,
    /// 6068h in milliseconds.
    pub position_window_time: u16,
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
        position_window: u32::MAX,
        position_window_time: 0,
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
            position_window: dictionary.position_window(),
            position_window_time: dictionary.position_window_time(),
        }
    }
}
