//! The drive objects as the firmware sees them. `od-gen` implements this trait for a dictionary from its data sheet: a type
//! that differs from the one here is a compile error, and an object the data sheet leaves out takes the value here. With a
//! binding (`*.bind.toml`) the values come from other objects, in other units; the drive does not notice.

use canopen::cia301::sdo::AbortCode;
use canopen::od::Entry;

use crate::parameters::Parameter;

/// The methods of the trait: a getter with the value that counts where a data sheet leaves the object out, or a setter that does
/// nothing there.
macro_rules! objects {
    ($($(#[$doc:meta])* $name:ident: $number:ident $(= $default:expr)?;)*) => {
        $(object! { $(#[$doc])* $name: $number $(= $default)? })*
    };
}

macro_rules! object {
    ($(#[$doc:meta])* $getter:ident: $number:ident = $default:expr) => {
        $(#[$doc])*
        fn $getter(&self) -> $number {
            $default
        }
    };
    ($(#[$doc:meta])* $setter:ident: $number:ident) => {
        $(#[$doc])*
        fn $setter(&mut self, value: $number) {
            let _ = value;
        }
    };
}

/// Typed access to the CiA 402 objects of a dictionary. Getters read what a master wrote; setters publish what the
/// drive does. Units are the user units of CiA 402-2 ([`crate::units`]); with no factor group they are increments (steps), steps/s and
/// steps/s².
pub trait Objects {
    objects! {
        /// 2030h:1: readings of the homing methods, see [`crate::configuration::HomingConfiguration`].
        homing_options: u16 = 0;
        /// 2030h:2; 0 is no bound.
        homing_longest_way: u32 = 0;
        /// 2030h:3 in milliseconds; 0 is no bound.
        homing_longest_time: u32 = 0;
        /// 2030h:4; 0 is no bound.
        homing_longest_way_to_index: u32 = 0;
        /// 2030h:5 in milliseconds.
        homing_block_time: u16 = 50;
        /// 2030h:6; 0: a following error does not tell of a hard stop.
        homing_block_window: u32 = 0;
        /// 2030h:7.
        homing_back_off: u32 = 0;
        /// 2031h:1: see [`crate::inputs::InputFunction`].
        input_1_function: u8 = 0;
        /// 2031h:2: see [`crate::inputs::InputFunction`].
        input_2_function: u8 = 0;
        /// 2031h:3: see [`crate::inputs::InputFunction`].
        input_3_function: u8 = 0;
        /// 2031h:4: see [`crate::inputs::InputFunction`].
        input_4_function: u8 = 0;
        /// 2031h:5: see [`crate::inputs::InputFunction`].
        input_5_function: u8 = 0;
        /// 2031h:6: see [`crate::inputs::InputFunction`].
        input_6_function: u8 = 0;
        /// 2032h: the inputs that are active while they are low; input `n` is bit `n − 1`.
        inputs_inverted: u8 = 0;
        /// 2033h in milliseconds.
        input_debounce: u8 = 0;
        /// 2034h:1: 1 while the home position is known.
        set_homing_referenced: u8;
        /// 2034h:2: why homing failed last.
        set_homing_failure: u8;
        /// 2040h:1 in milliseconds.
        brake_release_time: u16 = 0;
        /// 2040h:2 in milliseconds.
        brake_engage_time: u16 = 0;
        /// 20B0h:1: see [`crate::pulse_timing::PulseTiming`].
        pulse_driver: u8 = 0;
        /// 20B0h:2 in nanoseconds.
        pulse_high: u32 = 2_500;
        /// 20B0h:3 in nanoseconds.
        pulse_low: u32 = 2_500;
        /// 20B0h:4 in nanoseconds.
        pulse_direction_setup: u32 = 5_000;
        /// 20B0h:5 in nanoseconds.
        pulse_direction_hold: u32 = 5_000;
        /// 20E0h: how 607Dh is read, see [`crate::configuration::PositionLimitOptions`].
        position_limit_options: u8 = 0;
        /// 2060h:1: see [`crate::periphery::digital_outputs::OutputFunction`].
        output_1_function: u8 = 0;
        /// 2060h:2: see [`crate::periphery::digital_outputs::OutputFunction`].
        output_2_function: u8 = 0;
        /// 2060h:3: see [`crate::periphery::digital_outputs::OutputFunction`].
        output_3_function: u8 = 0;
        /// 2060h:4: see [`crate::periphery::digital_outputs::OutputFunction`].
        output_4_function: u8 = 0;
        /// 2061h: the outputs that are low where they would be high; output `n` is bit `n − 1`.
        outputs_inverted: u8 = 0;
        /// 2062h: the outputs that stay as they are when the network is lost; output `n` is bit `n − 1`.
        outputs_kept: u8 = 0;
        /// 2063h: 1 lets 60FEh move the brake.
        brake_control: u8 = 0;
        /// 2064h:1, 0 to 4095.
        set_analogue_input_raw: u16;
        /// 2064h:2 in millivolts.
        set_analogue_input_voltage: i32;
        /// 2064h:3 in millivolts.
        set_analogue_input_filtered: i32;
        /// 2064h:4 in millivolts.
        analogue_input_full_scale: i32 = 10_000;
        /// 2064h:5 in millivolts.
        analogue_input_offset: i32 = 0;
        /// 2064h:6 in milliseconds.
        analogue_input_filter_time: u16 = 0;
        /// 2070h:1 in milliamperes.
        run_current: u16 = 0;
        /// 2070h:2 in milliamperes.
        hold_current: u16 = 0;
        /// 2070h:3 in milliamperes; 0: as the run current.
        boost_current: u16 = 0;
        /// 2070h:4 in milliseconds.
        hold_delay: u16 = 0;
        /// 2071h: pulses of a full step, a power of two up to 256.
        microsteps: u16 = 1;
        /// 2072h: 1 turns the direction of the motor round.
        motor_direction: u8 = 0;
        /// 2073h:1 in millivolts; 0 is off.
        under_voltage_fault: u32 = 0;
        /// 2073h:2 in millivolts; 0 is off.
        under_voltage_warning: u32 = 0;
        /// 2073h:3 in millivolts; 0 is off.
        over_voltage_warning: u32 = 0;
        /// 2073h:4 in millivolts; 0 is off.
        over_voltage_fault: u32 = 0;
        /// 2073h:5 in millivolts.
        voltage_hysteresis: u32 = 0;
        /// 2074h:1 in tenths of a degree Celsius.
        set_temperature: i16;
        /// 2074h:2 in tenths of a degree Celsius.
        temperature_warning: i16 = i16::MAX;
        /// 2074h:3 in tenths of a degree Celsius.
        over_temperature_fault: i16 = i16::MAX;
        /// 2074h:4 in tenths of a degree.
        temperature_hysteresis: u16 = 0;
        /// 6007h: 3, quick stop.
        abort_connection_option_code: i16 = 3;
        /// 603Fh: code of the last fault.
        set_error_code: u16;
        /// 6040h.
        controlword: u16 = 0;
        /// 6041h.
        set_statusword: u16;
        /// 6042h.
        vl_target_velocity: i16 = 0;
        /// 6043h.
        set_vl_velocity_demand: i16;
        /// 6044h.
        set_vl_velocity_actual_value: i16;
        /// 6046h:1.
        vl_velocity_min_amount: u32 = 0;
        /// 6046h:2.
        vl_velocity_max_amount: u32 = u32::MAX;
        /// 6048h:1: the speed that is gained or lost in the time of 6048h:2.
        vl_acceleration_speed: u32 = 1;
        /// 6048h:2 in seconds.
        vl_acceleration_time: u16 = 1;
        /// 6049h:1: the speed that is gained or lost in the time of 6049h:2.
        vl_deceleration_speed: u32 = 1;
        /// 6049h:2 in seconds.
        vl_deceleration_time: u16 = 1;
        /// 604Ah:1: the speed that is gained or lost in the time of 604Ah:2.
        vl_quick_stop_speed: u32 = 1;
        /// 604Ah:2 in seconds.
        vl_quick_stop_time: u16 = 1;
        /// 604Ch:1.
        vl_dimension_numerator: i32 = 1;
        /// 604Ch:2.
        vl_dimension_denominator: i32 = 1;
        /// 605Ah: 2, slow down on the quick stop ramp and stay in switch on disabled.
        quick_stop_option_code: i16 = 2;
        /// 605Bh: 0, power off.
        shutdown_option_code: i16 = 0;
        /// 605Ch: 1, slow down on the slow down ramp.
        disable_operation_option_code: i16 = 1;
        /// 605Dh: 1, slow down on the slow down ramp.
        halt_option_code: i16 = 1;
        /// 605Eh: 2, slow down on the quick stop ramp.
        fault_reaction_option_code: i16 = 2;
        /// 6060h.
        modes_of_operation: i8 = 0;
        /// 6061h.
        set_modes_of_operation_display: i8;
        /// 6062h.
        set_position_demand_value: i32;
        /// 6063h, in increments.
        set_position_actual_internal_value: i32;
        /// 6064h.
        set_position_actual_value: i32;
        /// 6065h; FFFFFFFFh switches the window off.
        following_error_window: u32 = u32::MAX;
        /// 6066h in milliseconds.
        following_error_time_out: u16 = 0;
        /// 6067h; FFFFFFFFh switches the window off.
        position_window: u32 = u32::MAX;
        /// 6068h in milliseconds.
        position_window_time: u16 = 0;
        /// 606Bh.
        set_velocity_demand_value: i32;
        /// 606Ch.
        set_velocity_actual_value: i32;
        /// 606Dh.
        velocity_window: u16 = 0;
        /// 606Eh in milliseconds.
        velocity_window_time: u16 = 0;
        /// 606Fh.
        velocity_threshold: u16 = 0;
        /// 6070h in milliseconds.
        velocity_threshold_time: u16 = 0;
        /// 607Ah.
        target_position: i32 = 0;
        /// 607Bh:1. Positions wrap at the ends of 32 bits while minimum is not below maximum.
        min_position_range_limit: i32 = i32::MIN;
        /// 607Bh:2.
        max_position_range_limit: i32 = i32::MAX;
        /// 607Ch.
        home_offset: i32 = 0;
        /// 607Dh:1. The limits are off while minimum is not below maximum.
        min_position_limit: i32 = i32::MIN;
        /// 607Dh:2.
        max_position_limit: i32 = i32::MAX;
        /// 607Eh: bit 7 turns positions around, bit 6 velocities.
        polarity: u8 = 0;
        /// 607Fh.
        max_profile_velocity: u32 = u32::MAX;
        /// 6080h.
        max_motor_speed: u32 = u32::MAX;
        /// 6081h.
        profile_velocity: u32 = 0;
        /// 6082h.
        end_velocity: u32 = 0;
        /// 6083h.
        profile_acceleration: u32 = 0;
        /// 6084h.
        profile_deceleration: u32 = 0;
        /// 20A0h.
        smooth_quick_stop: u8 = 0;
        /// 20A1h in milliseconds.
        longest_stop: u16 = 2_000;
        /// 6086h.
        motion_profile_type: i16 = 0;
        /// 60A4h:1.
        profile_jerk: u32 = 1_000_000;
        /// 60A8h, see [`crate::units::SiUnit`].
        si_unit_position: u32 = 0;
        /// 60A9h.
        si_unit_velocity: u32 = 0;
        /// 60AAh.
        si_unit_acceleration: u32 = 0;
        /// 60ABh.
        si_unit_jerk: u32 = 0;
        /// 60C5h.
        max_acceleration: u32 = u32::MAX;
        /// 60C6h.
        max_deceleration: u32 = u32::MAX;
        /// 60F2h: 0, relative set-points count from the previous target.
        positioning_option_code: u16 = 0;
        /// 60F4h.
        set_following_error_actual_value: i32;
        /// 60F8h.
        max_slippage: i32 = i32::MAX;
        /// 60FFh.
        target_velocity: i32 = 0;
        /// 608Fh:1; 0 where there is no such object: a unit of position is then an increment of the motor.
        position_encoder_increments: u32 = 0;
        /// 608Fh:2.
        position_encoder_revolutions: u32 = 1;
        /// 6090h:1; 0: as 608Fh.
        velocity_encoder_increments: u32 = 0;
        /// 6090h:2.
        velocity_encoder_revolutions: u32 = 1;
        /// 6091h:1.
        gear_motor_revolutions: u32 = 1;
        /// 6091h:2.
        gear_shaft_revolutions: u32 = 1;
        /// 6092h:1.
        feed: u32 = 1;
        /// 6092h:2.
        feed_shaft_revolutions: u32 = 1;
        /// 6096h:1.
        velocity_factor_numerator: u32 = 1;
        /// 6096h:2.
        velocity_factor_divisor: u32 = 1;
        /// 6097h:1.
        acceleration_factor_numerator: u32 = 1;
        /// 6097h:2.
        acceleration_factor_divisor: u32 = 1;
        /// 6098h; 0 is no method.
        homing_method: i8 = 0;
        /// 6099h:1.
        homing_search_speed: u32 = 0;
        /// 6099h:2.
        homing_zero_speed: u32 = 0;
        /// 60FDh.
        set_digital_inputs: u32;
        /// 6079h in millivolts.
        set_dc_link_voltage: u32;
        /// 60B8h.
        touch_probe_function: u16 = 0;
        /// 60B9h.
        set_touch_probe_status: u16;
        /// 60BAh.
        set_touch_probe_1_positive_edge: i32;
        /// 60BBh.
        set_touch_probe_1_negative_edge: i32;
        /// 60BCh.
        set_touch_probe_2_positive_edge: i32;
        /// 60BDh.
        set_touch_probe_2_negative_edge: i32;
        /// 60D0h:1: see [`crate::periphery::touch_probe::Source`].
        touch_probe_1_source: i16 = 1;
        /// 60D0h:2: see [`crate::periphery::touch_probe::Source`].
        touch_probe_2_source: i16 = 2;
        /// 60D1h in nanoseconds.
        set_touch_probe_1_positive_time: u32;
        /// 60D2h in nanoseconds.
        set_touch_probe_1_negative_time: u32;
        /// 60D3h in nanoseconds.
        set_touch_probe_2_positive_time: u32;
        /// 60D4h in nanoseconds.
        set_touch_probe_2_negative_time: u32;
        /// 60D5h.
        set_touch_probe_1_positive_count: u16;
        /// 60D6h.
        set_touch_probe_1_negative_count: u16;
        /// 60D7h.
        set_touch_probe_2_positive_count: u16;
        /// 60D8h.
        set_touch_probe_2_negative_count: u16;
        /// 60FEh:1.
        digital_outputs: u32 = 0;
        /// 60FEh:2. Without it every bit of 60FEh:1 counts.
        digital_outputs_mask: u32 = u32::MAX;
        /// 2050h:1: 0 no beat, 1 the loop is settling, 2 locked.
        set_sync_state: u8;
        /// 2050h:2 in nanoseconds.
        set_sync_period: u32;
        /// 2050h:3 in nanoseconds.
        set_sync_jitter: u32;
        /// 2050h:4.
        set_missed_syncs: u32;
        /// 2050h:5.
        set_rejected_syncs: u32;
        /// 2050h:6.
        set_lost_set_points: u32;
        /// 2050h:7 in microseconds.
        set_cyclic_latency: u32;
        /// 2051h:1.
        bridged_set_points: u8 = 2;
        /// 2051h:2: see [`crate::cyclic::LostSetPoints`].
        lost_set_point_reaction: u8 = 1;
        /// 60B0h.
        position_offset: i32 = 0;
        /// 60B1h.
        velocity_offset: i32 = 0;
        /// 60C0h: 0 linear, −1 cubic.
        interpolation_sub_mode: i16 = 0;
        /// 60C1h:1.
        interpolation_record: i32 = 0;
        /// 60C2h:1.
        interpolation_time_value: u8 = 1;
        /// 60C2h:2: the power of ten, in seconds.
        interpolation_time_index: i8 = -3;
        /// 60C4h:2.
        interpolation_buffer_size: u32 = 32;
        /// 60C4h:3.
        interpolation_buffer_organization: u8 = 0;
        /// 60C4h:6.
        interpolation_buffer_clear: u8 = 1;
        /// 60C4h:4.
        set_interpolation_buffer_position: u16;
        /// 6502h.
        supported_drive_modes: u32 = 0;
    }

    /// 6085h; without it that of 6084h.
    fn quick_stop_deceleration(&self) -> u32 {
        self.profile_deceleration()
    }

    /// 609Ah; without it that of 6083h.
    fn homing_acceleration(&self) -> u32 {
        self.profile_acceleration()
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
