//! The statusword 6041h: what the drive says of itself (CiA 402-2, "statusword").
//!
//! Bits 0 to 3, 5 and 6 code the state ([`crate::State::statusword`]). The others are here. Bits 10, 12 and 13 belong to the
//! mode of operation and are 0 while no mode is at work.

/// Bit 4, voltage enabled: the power stage has its supply, in whatever state the drive is.
pub const VOLTAGE_ENABLED: u16 = 1 << 4;
/// Bit 5, quick stop: 0 while one is active.
pub const QUICK_STOP: u16 = 1 << 5;
/// Bit 7, warning.
pub const WARNING: u16 = 1 << 7;
/// Bit 8, manufacturer specific: the control tick is locked to SYNC, for a product that shows it there.
pub const LOCKED: u16 = 1 << 8;
/// Bit 9, remote: the controlword is obeyed. It is 1 in NMT states Pre-operational and Operational, so that a drive can be
/// commanded by SDO alone, and 0 in Stopped and while the device starts anew.
pub const REMOTE: u16 = 1 << 9;
/// Bit 10, target reached.
pub const TARGET_REACHED: u16 = 1 << 10;
/// Bit 11, internal limit active.
pub const INTERNAL_LIMIT: u16 = 1 << 11;
/// Bit 12 in profile position: set-point acknowledge.
pub const SET_POINT_ACKNOWLEDGE: u16 = 1 << 12;
/// Bit 12 in homing: homing attained.
pub const HOMING_ATTAINED: u16 = 1 << 12;
/// Bit 13 in homing: homing error.
pub const HOMING_ERROR: u16 = 1 << 13;
/// Bit 13 in profile position: following error.
pub const FOLLOWING_ERROR: u16 = 1 << 13;
/// Bit 12 in profile velocity: speed; 1 while the motor is as good as at rest.
pub const SPEED_ZERO: u16 = 1 << 12;
/// Bit 12 in the cyclic modes and in interpolated position: the motor follows the set-points.
pub const FOLLOWS: u16 = 1 << 12;
/// Bit 13 in profile velocity: max slippage error.
pub const SLIPPAGE: u16 = 1 << 13;
