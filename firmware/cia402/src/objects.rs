//! The drive objects as the firmware sees them. `od-gen` implements this trait for a dictionary from its data sheet: a type
//! that differs from the one here is a compile error, and an object the data sheet leaves out takes the value here. With a
//! binding (`*.bind.toml`) the values come from other objects, in other units; the drive does not notice.

use canopen::cia301::sdo::AbortCode;
use canopen::od::Entry;

use crate::parameters::Parameter;

/// Typed access to the CiA 402 objects of a dictionary. Getters read what a master wrote; setters publish what the
/// drive does. Units are the user units of CiA 402-2 ([`crate::units`]); with no factor group they are increments (steps), steps/s and
/// steps/s².
pub trait Objects {
    /// 2030h:1: readings of the homing methods, see [`crate::configuration::HomingConfiguration`].
    fn homing_options(&self) -> u16 {
        0
    }
    /// 2030h:2; 0 is no bound.
    fn homing_longest_way(&self) -> u32 {
        0
    }
    /// 2030h:3 in milliseconds; 0 is no bound.
    fn homing_longest_time(&self) -> u32 {
        0
    }
    /// 2030h:4; 0 is no bound.
    fn homing_longest_way_to_index(&self) -> u32 {
        0
    }
    /// 2030h:5 in milliseconds.
    fn homing_block_time(&self) -> u16 {
        50
    }
    /// 2030h:6; 0: a following error does not tell of a hard stop.
    fn homing_block_window(&self) -> u32 {
        0
    }
    /// 2030h:7.
    fn homing_back_off(&self) -> u32 {
        0
    }
    /// 2031h:1: see [`crate::inputs::InputFunction`].
    fn input_1_function(&self) -> u8 {
        0
    }
    /// 2031h:2: see [`crate::inputs::InputFunction`].
    fn input_2_function(&self) -> u8 {
        0
    }
    /// 2031h:3: see [`crate::inputs::InputFunction`].
    fn input_3_function(&self) -> u8 {
        0
    }
    /// 2031h:4: see [`crate::inputs::InputFunction`].
    fn input_4_function(&self) -> u8 {
        0
    }
    /// 2031h:5: see [`crate::inputs::InputFunction`].
    fn input_5_function(&self) -> u8 {
        0
    }
    /// 2031h:6: see [`crate::inputs::InputFunction`].
    fn input_6_function(&self) -> u8 {
        0
    }
    /// 2032h: the inputs that are active while they are low; input `n` is bit `n − 1`.
    fn inputs_inverted(&self) -> u8 {
        0
    }
    /// 2033h in milliseconds.
    fn input_debounce(&self) -> u8 {
        0
    }
    /// 2034h:1: 1 while the home position is known.
    fn set_homing_referenced(&mut self, value: u8) {
        let _ = value;
    }
    /// 2034h:2: why homing failed last.
    fn set_homing_failure(&mut self, value: u8) {
        let _ = value;
    }
    /// 2040h:1 in milliseconds.
    fn brake_release_time(&self) -> u16 {
        0
    }
    /// 2040h:2 in milliseconds.
    fn brake_engage_time(&self) -> u16 {
        0
    }
    /// 20E0h: how 607Dh is read, see [`crate::configuration::PositionLimitOptions`].
    fn position_limit_options(&self) -> u8 {
        0
    }
    /// 6007h: 3, quick stop.
    fn abort_connection_option_code(&self) -> i16 {
        3
    }
    /// 603Fh: code of the last fault.
    fn set_error_code(&mut self, value: u16) {
        let _ = value;
    }
    /// 6040h.
    fn controlword(&self) -> u16 {
        0
    }
    /// 6041h.
    fn set_statusword(&mut self, value: u16) {
        let _ = value;
    }
    /// 6042h.
    fn vl_target_velocity(&self) -> i16 {
        0
    }
    /// 6043h.
    fn set_vl_velocity_demand(&mut self, value: i16) {
        let _ = value;
    }
    /// 6044h.
    fn set_vl_velocity_actual_value(&mut self, value: i16) {
        let _ = value;
    }
    /// 6046h:1.
    fn vl_velocity_min_amount(&self) -> u32 {
        0
    }
    /// 6046h:2.
    fn vl_velocity_max_amount(&self) -> u32 {
        u32::MAX
    }
    /// 6048h:1: the speed that is gained or lost in the time of 6048h:2.
    fn vl_acceleration_speed(&self) -> u32 {
        1
    }
    /// 6048h:2 in seconds.
    fn vl_acceleration_time(&self) -> u16 {
        1
    }
    /// 6049h:1: the speed that is gained or lost in the time of 6049h:2.
    fn vl_deceleration_speed(&self) -> u32 {
        1
    }
    /// 6049h:2 in seconds.
    fn vl_deceleration_time(&self) -> u16 {
        1
    }
    /// 604Ah:1: the speed that is gained or lost in the time of 604Ah:2.
    fn vl_quick_stop_speed(&self) -> u32 {
        1
    }
    /// 604Ah:2 in seconds.
    fn vl_quick_stop_time(&self) -> u16 {
        1
    }
    /// 604Ch:1.
    fn vl_dimension_numerator(&self) -> i32 {
        1
    }
    /// 604Ch:2.
    fn vl_dimension_denominator(&self) -> i32 {
        1
    }
    /// 605Ah: 2, slow down on the quick stop ramp and stay in switch on disabled.
    fn quick_stop_option_code(&self) -> i16 {
        2
    }
    /// 605Bh: 0, power off.
    fn shutdown_option_code(&self) -> i16 {
        0
    }
    /// 605Ch: 1, slow down on the slow down ramp.
    fn disable_operation_option_code(&self) -> i16 {
        1
    }
    /// 605Dh: 1, slow down on the slow down ramp.
    fn halt_option_code(&self) -> i16 {
        1
    }
    /// 605Eh: 2, slow down on the quick stop ramp.
    fn fault_reaction_option_code(&self) -> i16 {
        2
    }
    /// 6060h.
    fn modes_of_operation(&self) -> i8 {
        0
    }
    /// 6061h.
    fn set_modes_of_operation_display(&mut self, value: i8) {
        let _ = value;
    }
    /// 6062h.
    fn set_position_demand_value(&mut self, value: i32) {
        let _ = value;
    }
    /// 6063h, in increments.
    fn set_position_actual_internal_value(&mut self, value: i32) {
        let _ = value;
    }
    /// 6064h.
    fn set_position_actual_value(&mut self, value: i32) {
        let _ = value;
    }
    /// 6065h; FFFFFFFFh switches the window off.
    fn following_error_window(&self) -> u32 {
        u32::MAX
    }
    /// 6066h in milliseconds.
    fn following_error_time_out(&self) -> u16 {
        0
    }
    /// 6067h; FFFFFFFFh switches the window off.
    fn position_window(&self) -> u32 {
        u32::MAX
    }
    /// 6068h in milliseconds.
    fn position_window_time(&self) -> u16 {
        0
    }
    /// 606Bh.
    fn set_velocity_demand_value(&mut self, value: i32) {
        let _ = value;
    }
    /// 606Ch.
    fn set_velocity_actual_value(&mut self, value: i32) {
        let _ = value;
    }
    /// 606Dh.
    fn velocity_window(&self) -> u16 {
        0
    }
    /// 606Eh in milliseconds.
    fn velocity_window_time(&self) -> u16 {
        0
    }
    /// 606Fh.
    fn velocity_threshold(&self) -> u16 {
        0
    }
    /// 6070h in milliseconds.
    fn velocity_threshold_time(&self) -> u16 {
        0
    }
    /// 607Ah.
    fn target_position(&self) -> i32 {
        0
    }
    /// 607Bh:1. Positions wrap at the ends of 32 bits while minimum is not below maximum.
    fn min_position_range_limit(&self) -> i32 {
        i32::MIN
    }
    /// 607Bh:2.
    fn max_position_range_limit(&self) -> i32 {
        i32::MAX
    }
    /// 607Ch.
    fn home_offset(&self) -> i32 {
        0
    }
    /// 607Dh:1. The limits are off while minimum is not below maximum.
    fn min_position_limit(&self) -> i32 {
        i32::MIN
    }
    /// 607Dh:2.
    fn max_position_limit(&self) -> i32 {
        i32::MAX
    }
    /// 607Eh: bit 7 turns positions around, bit 6 velocities.
    fn polarity(&self) -> u8 {
        0
    }
    /// 607Fh.
    fn max_profile_velocity(&self) -> u32 {
        u32::MAX
    }
    /// 6080h.
    fn max_motor_speed(&self) -> u32 {
        u32::MAX
    }
    /// 6081h.
    fn profile_velocity(&self) -> u32 {
        0
    }
    /// 6082h.
    fn end_velocity(&self) -> u32 {
        0
    }
    /// 6083h.
    fn profile_acceleration(&self) -> u32 {
        0
    }
    /// 6084h.
    fn profile_deceleration(&self) -> u32 {
        0
    }
    /// 6085h.
    fn quick_stop_deceleration(&self) -> u32 {
        self.profile_deceleration()
    }
    /// 60A8h, see [`crate::units::SiUnit`].
    fn si_unit_position(&self) -> u32 {
        0
    }
    /// 60A9h.
    fn si_unit_velocity(&self) -> u32 {
        0
    }
    /// 60AAh.
    fn si_unit_acceleration(&self) -> u32 {
        0
    }
    /// 60ABh.
    fn si_unit_jerk(&self) -> u32 {
        0
    }
    /// 60C5h.
    fn max_acceleration(&self) -> u32 {
        u32::MAX
    }
    /// 60C6h.
    fn max_deceleration(&self) -> u32 {
        u32::MAX
    }
    /// 60F2h: 0, relative set-points count from the previous target.
    fn positioning_option_code(&self) -> u16 {
        0
    }
    /// 60F4h.
    fn set_following_error_actual_value(&mut self, value: i32) {
        let _ = value;
    }
    /// 60F8h.
    fn max_slippage(&self) -> i32 {
        i32::MAX
    }
    /// 60FFh.
    fn target_velocity(&self) -> i32 {
        0
    }
    /// 608Fh:1; 0 where there is no such object: a unit of position is then an increment of the motor.
    fn position_encoder_increments(&self) -> u32 {
        0
    }
    /// 608Fh:2.
    fn position_encoder_revolutions(&self) -> u32 {
        1
    }
    /// 6090h:1; 0: as 608Fh.
    fn velocity_encoder_increments(&self) -> u32 {
        0
    }
    /// 6090h:2.
    fn velocity_encoder_revolutions(&self) -> u32 {
        1
    }
    /// 6091h:1.
    fn gear_motor_revolutions(&self) -> u32 {
        1
    }
    /// 6091h:2.
    fn gear_shaft_revolutions(&self) -> u32 {
        1
    }
    /// 6092h:1.
    fn feed(&self) -> u32 {
        1
    }
    /// 6092h:2.
    fn feed_shaft_revolutions(&self) -> u32 {
        1
    }
    /// 6096h:1.
    fn velocity_factor_numerator(&self) -> u32 {
        1
    }
    /// 6096h:2.
    fn velocity_factor_divisor(&self) -> u32 {
        1
    }
    /// 6097h:1.
    fn acceleration_factor_numerator(&self) -> u32 {
        1
    }
    /// 6097h:2.
    fn acceleration_factor_divisor(&self) -> u32 {
        1
    }
    /// 6098h; 0 is no method.
    fn homing_method(&self) -> i8 {
        0
    }
    /// 6099h:1.
    fn homing_search_speed(&self) -> u32 {
        0
    }
    /// 6099h:2.
    fn homing_zero_speed(&self) -> u32 {
        0
    }
    /// 609Ah.
    fn homing_acceleration(&self) -> u32 {
        self.profile_acceleration()
    }
    /// 60FDh.
    fn set_digital_inputs(&mut self, value: u32) {
        let _ = value;
    }
    /// 6502h.
    fn supported_drive_modes(&self) -> u32 {
        0
    }

    /// The parameter that an object sets or shows.
    fn parameter(entry: &Entry) -> Option<Parameter> {
        Parameter::in_profile(entry.index, entry.sub)
    }

    /// What `number`, written to an object of a parameter, means to the drive.
    ///
    /// # Errors
    /// A number that means nothing to the drive, or too much or too little.
    fn converted(entry: &Entry, number: i64) -> Result<i64, AbortCode> {
        let _ = entry;
        Ok(number)
    }

    /// An object was written. The others that stand for the same parameter follow.
    fn carry_over(&mut self, entry: &Entry) {
        let _ = entry;
    }

    /// Values were loaded: objects that stand for the same parameter follow the one the drive reads.
    fn agree(&mut self) {}
}
