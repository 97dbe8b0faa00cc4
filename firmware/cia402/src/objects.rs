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
    /// 20B0h:1: see [`crate::pulse_timing::PulseTiming`].
    fn pulse_driver(&self) -> u8 {
        0
    }
    /// 20B0h:2 in nanoseconds.
    fn pulse_high(&self) -> u32 {
        2_500
    }
    /// 20B0h:3 in nanoseconds.
    fn pulse_low(&self) -> u32 {
        2_500
    }
    /// 20B0h:4 in nanoseconds.
    fn pulse_direction_setup(&self) -> u32 {
        5_000
    }
    /// 20B0h:5 in nanoseconds.
    fn pulse_direction_hold(&self) -> u32 {
        5_000
    }
    /// 20E0h: how 607Dh is read, see [`crate::configuration::PositionLimitOptions`].
    fn position_limit_options(&self) -> u8 {
        0
    }
    /// 2060h:1: see [`crate::periphery::digital_outputs::OutputFunction`].
    fn output_1_function(&self) -> u8 {
        0
    }
    /// 2060h:2: see [`crate::periphery::digital_outputs::OutputFunction`].
    fn output_2_function(&self) -> u8 {
        0
    }
    /// 2060h:3: see [`crate::periphery::digital_outputs::OutputFunction`].
    fn output_3_function(&self) -> u8 {
        0
    }
    /// 2060h:4: see [`crate::periphery::digital_outputs::OutputFunction`].
    fn output_4_function(&self) -> u8 {
        0
    }
    /// 2061h: the outputs that are low where they would be high; output `n` is bit `n − 1`.
    fn outputs_inverted(&self) -> u8 {
        0
    }
    /// 2062h: the outputs that stay as they are when the network is lost; output `n` is bit `n − 1`.
    fn outputs_kept(&self) -> u8 {
        0
    }
    /// 2063h: 1 lets 60FEh move the brake.
    fn brake_control(&self) -> u8 {
        0
    }
    /// 2064h:1, 0 to 4095.
    fn set_analogue_input_raw(&mut self, value: u16) {
        let _ = value;
    }
    /// 2064h:2 in millivolts.
    fn set_analogue_input_voltage(&mut self, value: i32) {
        let _ = value;
    }
    /// 2064h:3 in millivolts.
    fn set_analogue_input_filtered(&mut self, value: i32) {
        let _ = value;
    }
    /// 2064h:4 in millivolts.
    fn analogue_input_full_scale(&self) -> i32 {
        10_000
    }
    /// 2064h:5 in millivolts.
    fn analogue_input_offset(&self) -> i32 {
        0
    }
    /// 2064h:6 in milliseconds.
    fn analogue_input_filter_time(&self) -> u16 {
        0
    }
    /// 2070h:1 in milliamperes.
    fn run_current(&self) -> u16 {
        0
    }
    /// 2070h:2 in milliamperes.
    fn hold_current(&self) -> u16 {
        0
    }
    /// 2070h:3 in milliamperes; 0: as the run current.
    fn boost_current(&self) -> u16 {
        0
    }
    /// 2070h:4 in milliseconds.
    fn hold_delay(&self) -> u16 {
        0
    }
    /// 2071h: pulses of a full step, a power of two up to 256.
    fn microsteps(&self) -> u16 {
        1
    }
    /// 2072h: 1 turns the direction of the motor round.
    fn motor_direction(&self) -> u8 {
        0
    }
    /// 2073h:1 in millivolts; 0 is off.
    fn under_voltage_fault(&self) -> u32 {
        0
    }
    /// 2073h:2 in millivolts; 0 is off.
    fn under_voltage_warning(&self) -> u32 {
        0
    }
    /// 2073h:3 in millivolts; 0 is off.
    fn over_voltage_warning(&self) -> u32 {
        0
    }
    /// 2073h:4 in millivolts; 0 is off.
    fn over_voltage_fault(&self) -> u32 {
        0
    }
    /// 2073h:5 in millivolts.
    fn voltage_hysteresis(&self) -> u32 {
        0
    }
    /// 2074h:1 in tenths of a degree Celsius.
    fn set_temperature(&mut self, value: i16) {
        let _ = value;
    }
    /// 2074h:2 in tenths of a degree Celsius.
    fn temperature_warning(&self) -> i16 {
        i16::MAX
    }
    /// 2074h:3 in tenths of a degree Celsius.
    fn over_temperature_fault(&self) -> i16 {
        i16::MAX
    }
    /// 2074h:4 in tenths of a degree.
    fn temperature_hysteresis(&self) -> u16 {
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
    /// 20A0h.
    fn smooth_quick_stop(&self) -> u8 {
        0
    }
    /// 6086h.
    fn motion_profile_type(&self) -> i16 {
        0
    }
    /// 60A4h:1.
    fn profile_jerk(&self) -> u32 {
        1_000_000
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
    /// 6079h in millivolts.
    fn set_dc_link_voltage(&mut self, value: u32) {
        let _ = value;
    }
    /// 60B8h.
    fn touch_probe_function(&self) -> u16 {
        0
    }
    /// 60B9h.
    fn set_touch_probe_status(&mut self, value: u16) {
        let _ = value;
    }
    /// 60BAh.
    fn set_touch_probe_1_positive_edge(&mut self, value: i32) {
        let _ = value;
    }
    /// 60BBh.
    fn set_touch_probe_1_negative_edge(&mut self, value: i32) {
        let _ = value;
    }
    /// 60BCh.
    fn set_touch_probe_2_positive_edge(&mut self, value: i32) {
        let _ = value;
    }
    /// 60BDh.
    fn set_touch_probe_2_negative_edge(&mut self, value: i32) {
        let _ = value;
    }
    /// 60D0h:1: see [`crate::periphery::touch_probe::Source`].
    fn touch_probe_1_source(&self) -> i16 {
        1
    }
    /// 60D0h:2: see [`crate::periphery::touch_probe::Source`].
    fn touch_probe_2_source(&self) -> i16 {
        2
    }
    /// 60D1h in nanoseconds.
    fn set_touch_probe_1_positive_time(&mut self, value: u32) {
        let _ = value;
    }
    /// 60D2h in nanoseconds.
    fn set_touch_probe_1_negative_time(&mut self, value: u32) {
        let _ = value;
    }
    /// 60D3h in nanoseconds.
    fn set_touch_probe_2_positive_time(&mut self, value: u32) {
        let _ = value;
    }
    /// 60D4h in nanoseconds.
    fn set_touch_probe_2_negative_time(&mut self, value: u32) {
        let _ = value;
    }
    /// 60D5h.
    fn set_touch_probe_1_positive_count(&mut self, value: u16) {
        let _ = value;
    }
    /// 60D6h.
    fn set_touch_probe_1_negative_count(&mut self, value: u16) {
        let _ = value;
    }
    /// 60D7h.
    fn set_touch_probe_2_positive_count(&mut self, value: u16) {
        let _ = value;
    }
    /// 60D8h.
    fn set_touch_probe_2_negative_count(&mut self, value: u16) {
        let _ = value;
    }
    /// 60FEh:1.
    fn digital_outputs(&self) -> u32 {
        0
    }
    /// 60FEh:2. Without it every bit of 60FEh:1 counts.
    fn digital_outputs_mask(&self) -> u32 {
        u32::MAX
    }
    /// 2050h:1: 0 no beat, 1 the loop is settling, 2 locked.
    fn set_sync_state(&mut self, value: u8) {
        let _ = value;
    }
    /// 2050h:2 in nanoseconds.
    fn set_sync_period(&mut self, value: u32) {
        let _ = value;
    }
    /// 2050h:3 in nanoseconds.
    fn set_sync_jitter(&mut self, value: u32) {
        let _ = value;
    }
    /// 2050h:4.
    fn set_missed_syncs(&mut self, value: u32) {
        let _ = value;
    }
    /// 2050h:5.
    fn set_rejected_syncs(&mut self, value: u32) {
        let _ = value;
    }
    /// 2050h:6.
    fn set_lost_set_points(&mut self, value: u32) {
        let _ = value;
    }
    /// 2050h:7 in microseconds.
    fn set_cyclic_latency(&mut self, value: u32) {
        let _ = value;
    }
    /// 2051h:1.
    fn bridged_set_points(&self) -> u8 {
        2
    }
    /// 2051h:2: see [`crate::cyclic::LostSetPoints`].
    fn lost_set_point_reaction(&self) -> u8 {
        1
    }
    /// 60B0h.
    fn position_offset(&self) -> i32 {
        0
    }
    /// 60B1h.
    fn velocity_offset(&self) -> i32 {
        0
    }
    /// 60C0h: 0 linear, −1 cubic.
    fn interpolation_sub_mode(&self) -> i16 {
        0
    }
    /// 60C1h:1.
    fn interpolation_record(&self) -> i32 {
        0
    }
    /// 60C2h:1.
    fn interpolation_time_value(&self) -> u8 {
        1
    }
    /// 60C2h:2: the power of ten, in seconds.
    fn interpolation_time_index(&self) -> i8 {
        -3
    }
    /// 60C4h:2.
    fn interpolation_buffer_size(&self) -> u32 {
        32
    }
    /// 60C4h:3.
    fn interpolation_buffer_organization(&self) -> u8 {
        0
    }
    /// 60C4h:6.
    fn interpolation_buffer_clear(&self) -> u8 {
        1
    }
    /// 60C4h:4.
    fn set_interpolation_buffer_position(&mut self, value: u16) {
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
