//! What the drive offers to be commanded by and to show: its parameters by name.
//!
//! Each parameter has a home, the object that CiA 402-2 gives it, or one of the manufacturer (2030h to 2034h). A data sheet may have other objects
//! for it beside that one or instead of it: a binding (`*.bind.toml`) names the parameter, and `od-gen` checks it against
//! [`ALL`].

/// The first object of the drive profile. A parameter with a home below it is at home in a data sheet that has such an object with
/// the parameter's name, and in no other.
pub const PROFILE: u16 = 0x6000;

/// Which way a value goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// The drive reads it: a master sets it, or the data sheet does.
    Taken,
    /// The drive shows it.
    Shown,
}

/// The Rust type of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are those of the types")]
pub enum Type {
    I8,
    I16,
    I32,
    U8,
    U16,
    U32,
}

impl Type {
    /// The numbers it holds.
    pub const fn range(self) -> (i64, i64) {
        match self {
            Self::I8 => (i8::MIN as i64, i8::MAX as i64),
            Self::I16 => (i16::MIN as i64, i16::MAX as i64),
            Self::I32 => (i32::MIN as i64, i32::MAX as i64),
            Self::U8 => (0, u8::MAX as i64),
            Self::U16 => (0, u16::MAX as i64),
            Self::U32 => (0, u32::MAX as i64),
        }
    }

    /// Its name in Rust.
    pub const fn name(self) -> &'static str {
        match self {
            Self::I8 => "i8",
            Self::I16 => "i16",
            Self::I32 => "i32",
            Self::U8 => "u8",
            Self::U16 => "u16",
            Self::U32 => "u32",
        }
    }
}

/// What there is to know about a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Description {
    /// Which one.
    pub parameter: Parameter,
    /// Its name in bindings: that of the method of [`crate::Objects`], without `set_`.
    pub name: &'static str,
    /// Index and sub-index of its object.
    pub home: (u16, u8),
    /// The type of the method.
    pub number: Type,
    /// The unit of its numbers; empty for codes and bits.
    pub unit: &'static str,
    /// The least and the largest number that mean something to the drive.
    pub range: (i64, i64),
    /// Which way it goes.
    pub direction: Direction,
}

/// Makes the list: a parameter, its name in bindings, its home, its type, its direction, its unit, and its least number if
/// that is not the least of the type.
macro_rules! parameters {
    ($($parameter:ident $name:literal $index:literal $sub:literal $type:ident $direction:ident $unit:literal $(from $least:literal)?;)*) => {
        /// A value that the drive takes from the network or shows there.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[allow(missing_docs, reason = "the names are the standard's own")]
        pub enum Parameter {
            $($parameter,)*
        }

        /// Every parameter, by its home.
        pub const ALL: &[Description] = &[
            $(Description {
                parameter: Parameter::$parameter,
                name: $name,
                home: ($index, $sub),
                number: Type::$type,
                unit: $unit,
                range: from(Type::$type.range(), &[$($least)?]),
                direction: Direction::$direction,
            },)*
        ];

        impl Parameter {
            /// The parameter that is at home in this object.
            pub const fn at(index: u16, sub: u8) -> Option<Self> {
                match (index, sub) {
                    $(($index, $sub) => Some(Self::$parameter),)*
                    _ => None,
                }
            }
        }
    };
}

/// A range that begins at another number, if there is one.
const fn from(range: (i64, i64), least: &[i64]) -> (i64, i64) {
    match least {
        [least] => (*least, range.1),
        _ => range,
    }
}

parameters! {
    HomingOptions "homing_options" 0x2030 1 U16 Taken "";
    HomingLongestWay "homing_longest_way" 0x2030 2 U32 Taken "steps";
    HomingLongestTime "homing_longest_time" 0x2030 3 U32 Taken "ms";
    HomingLongestWayToIndex "homing_longest_way_to_index" 0x2030 4 U32 Taken "steps";
    HomingBlockTime "homing_block_time" 0x2030 5 U16 Taken "ms";
    HomingBlockWindow "homing_block_window" 0x2030 6 U32 Taken "steps";
    HomingBackOff "homing_back_off" 0x2030 7 U32 Taken "steps";
    Input1Function "input_1_function" 0x2031 1 U8 Taken "";
    Input2Function "input_2_function" 0x2031 2 U8 Taken "";
    Input3Function "input_3_function" 0x2031 3 U8 Taken "";
    Input4Function "input_4_function" 0x2031 4 U8 Taken "";
    Input5Function "input_5_function" 0x2031 5 U8 Taken "";
    Input6Function "input_6_function" 0x2031 6 U8 Taken "";
    InputsInverted "inputs_inverted" 0x2032 0 U8 Taken "";
    InputDebounce "input_debounce" 0x2033 0 U8 Taken "ms";
    HomingReferenced "homing_referenced" 0x2034 1 U8 Shown "";
    HomingFailure "homing_failure" 0x2034 2 U8 Shown "";
    BrakeReleaseTime "brake_release_time" 0x2040 1 U16 Taken "ms";
    BrakeEngageTime "brake_engage_time" 0x2040 2 U16 Taken "ms";
    SyncState "sync_state" 0x2050 1 U8 Shown "";
    SyncPeriod "sync_period" 0x2050 2 U32 Shown "ns";
    SyncJitter "sync_jitter" 0x2050 3 U32 Shown "ns";
    MissedSyncs "missed_syncs" 0x2050 4 U32 Shown "";
    RejectedSyncs "rejected_syncs" 0x2050 5 U32 Shown "";
    LostSetPoints "lost_set_points" 0x2050 6 U32 Shown "";
    CyclicLatency "cyclic_latency" 0x2050 7 U32 Shown "us";
    BridgedSetPoints "bridged_set_points" 0x2051 1 U8 Taken "";
    LostSetPointReaction "lost_set_point_reaction" 0x2051 2 U8 Taken "";
    Output1Function "output_1_function" 0x2060 1 U8 Taken "";
    Output2Function "output_2_function" 0x2060 2 U8 Taken "";
    Output3Function "output_3_function" 0x2060 3 U8 Taken "";
    Output4Function "output_4_function" 0x2060 4 U8 Taken "";
    OutputsInverted "outputs_inverted" 0x2061 0 U8 Taken "";
    OutputsKept "outputs_kept" 0x2062 0 U8 Taken "";
    BrakeControl "brake_control" 0x2063 0 U8 Taken "";
    AnalogueInputRaw "analogue_input_raw" 0x2064 1 U16 Shown "";
    AnalogueInputVoltage "analogue_input_voltage" 0x2064 2 I32 Shown "mV";
    AnalogueInputFiltered "analogue_input_filtered" 0x2064 3 I32 Shown "mV";
    AnalogueInputFullScale "analogue_input_full_scale" 0x2064 4 I32 Taken "mV";
    AnalogueInputOffset "analogue_input_offset" 0x2064 5 I32 Taken "mV";
    AnalogueInputFilterTime "analogue_input_filter_time" 0x2064 6 U16 Taken "ms";
    RunCurrent "run_current" 0x2070 1 U16 Taken "mA";
    HoldCurrent "hold_current" 0x2070 2 U16 Taken "mA";
    BoostCurrent "boost_current" 0x2070 3 U16 Taken "mA";
    HoldDelay "hold_delay" 0x2070 4 U16 Taken "ms";
    Microsteps "microsteps" 0x2071 0 U16 Taken "" from 1;
    MotorDirection "motor_direction" 0x2072 0 U8 Taken "";
    UnderVoltageFault "under_voltage_fault" 0x2073 1 U32 Taken "mV";
    UnderVoltageWarning "under_voltage_warning" 0x2073 2 U32 Taken "mV";
    OverVoltageWarning "over_voltage_warning" 0x2073 3 U32 Taken "mV";
    OverVoltageFault "over_voltage_fault" 0x2073 4 U32 Taken "mV";
    VoltageHysteresis "voltage_hysteresis" 0x2073 5 U32 Taken "mV";
    Temperature "temperature" 0x2074 1 I16 Shown "0.1 °C";
    TemperatureWarning "temperature_warning" 0x2074 2 I16 Taken "0.1 °C";
    OverTemperatureFault "over_temperature_fault" 0x2074 3 I16 Taken "0.1 °C";
    TemperatureHysteresis "temperature_hysteresis" 0x2074 4 U16 Taken "0.1 °C";
    SmoothQuickStop "smooth_quick_stop" 0x20A0 0 U8 Taken "";
    LongestStop "longest_stop" 0x20A1 0 U16 Taken "ms" from 1;
    PulseDriver "pulse_driver" 0x20B0 1 U8 Taken "";
    PulseHigh "pulse_high" 0x20B0 2 U32 Taken "ns";
    PulseLow "pulse_low" 0x20B0 3 U32 Taken "ns";
    PulseDirectionSetup "pulse_direction_setup" 0x20B0 4 U32 Taken "ns";
    PulseDirectionHold "pulse_direction_hold" 0x20B0 5 U32 Taken "ns";
    PositionLimitOptions "position_limit_options" 0x20E0 0 U8 Taken "";
    AbortConnectionOptionCode "abort_connection_option_code" 0x6007 0 I16 Taken "";
    ErrorCode "error_code" 0x603F 0 U16 Shown "";
    Controlword "controlword" 0x6040 0 U16 Taken "";
    Statusword "statusword" 0x6041 0 U16 Shown "";
    VlTargetVelocity "vl_target_velocity" 0x6042 0 I16 Taken "vl";
    VlVelocityDemand "vl_velocity_demand" 0x6043 0 I16 Shown "vl";
    VlVelocityActualValue "vl_velocity_actual_value" 0x6044 0 I16 Shown "vl";
    VlVelocityMinAmount "vl_velocity_min_amount" 0x6046 1 U32 Taken "vl";
    VlVelocityMaxAmount "vl_velocity_max_amount" 0x6046 2 U32 Taken "vl";
    VlAccelerationSpeed "vl_acceleration_speed" 0x6048 1 U32 Taken "vl" from 1;
    VlAccelerationTime "vl_acceleration_time" 0x6048 2 U16 Taken "s" from 1;
    VlDecelerationSpeed "vl_deceleration_speed" 0x6049 1 U32 Taken "vl" from 1;
    VlDecelerationTime "vl_deceleration_time" 0x6049 2 U16 Taken "s" from 1;
    VlQuickStopSpeed "vl_quick_stop_speed" 0x604A 1 U32 Taken "vl" from 1;
    VlQuickStopTime "vl_quick_stop_time" 0x604A 2 U16 Taken "s" from 1;
    VlDimensionNumerator "vl_dimension_numerator" 0x604C 1 I32 Taken "" from 1;
    VlDimensionDenominator "vl_dimension_denominator" 0x604C 2 I32 Taken "" from 1;
    QuickStopOptionCode "quick_stop_option_code" 0x605A 0 I16 Taken "";
    ShutdownOptionCode "shutdown_option_code" 0x605B 0 I16 Taken "";
    DisableOperationOptionCode "disable_operation_option_code" 0x605C 0 I16 Taken "";
    HaltOptionCode "halt_option_code" 0x605D 0 I16 Taken "";
    FaultReactionOptionCode "fault_reaction_option_code" 0x605E 0 I16 Taken "";
    ModesOfOperation "modes_of_operation" 0x6060 0 I8 Taken "";
    ModesOfOperationDisplay "modes_of_operation_display" 0x6061 0 I8 Shown "";
    PositionDemandValue "position_demand_value" 0x6062 0 I32 Shown "position units";
    PositionActualInternalValue "position_actual_internal_value" 0x6063 0 I32 Shown "increments";
    PositionActualValue "position_actual_value" 0x6064 0 I32 Shown "position units";
    FollowingErrorWindow "following_error_window" 0x6065 0 U32 Taken "position units";
    FollowingErrorTimeOut "following_error_time_out" 0x6066 0 U16 Taken "ms";
    PositionWindow "position_window" 0x6067 0 U32 Taken "position units";
    PositionWindowTime "position_window_time" 0x6068 0 U16 Taken "ms";
    VelocityDemandValue "velocity_demand_value" 0x606B 0 I32 Shown "velocity units";
    VelocityActualValue "velocity_actual_value" 0x606C 0 I32 Shown "velocity units";
    VelocityWindow "velocity_window" 0x606D 0 U16 Taken "velocity units";
    VelocityWindowTime "velocity_window_time" 0x606E 0 U16 Taken "ms";
    VelocityThreshold "velocity_threshold" 0x606F 0 U16 Taken "velocity units";
    VelocityThresholdTime "velocity_threshold_time" 0x6070 0 U16 Taken "ms";
    DcLinkVoltage "dc_link_voltage" 0x6079 0 U32 Shown "mV";
    TargetPosition "target_position" 0x607A 0 I32 Taken "position units";
    MinPositionRangeLimit "min_position_range_limit" 0x607B 1 I32 Taken "position units";
    MaxPositionRangeLimit "max_position_range_limit" 0x607B 2 I32 Taken "position units";
    HomeOffset "home_offset" 0x607C 0 I32 Taken "position units";
    MinPositionLimit "min_position_limit" 0x607D 1 I32 Taken "position units";
    MaxPositionLimit "max_position_limit" 0x607D 2 I32 Taken "position units";
    Polarity "polarity" 0x607E 0 U8 Taken "";
    MaxProfileVelocity "max_profile_velocity" 0x607F 0 U32 Taken "velocity units";
    MaxMotorSpeed "max_motor_speed" 0x6080 0 U32 Taken "1/min";
    ProfileVelocity "profile_velocity" 0x6081 0 U32 Taken "velocity units";
    EndVelocity "end_velocity" 0x6082 0 U32 Taken "velocity units";
    ProfileAcceleration "profile_acceleration" 0x6083 0 U32 Taken "acceleration units" from 1;
    ProfileDeceleration "profile_deceleration" 0x6084 0 U32 Taken "acceleration units" from 1;
    QuickStopDeceleration "quick_stop_deceleration" 0x6085 0 U32 Taken "acceleration units" from 1;
    MotionProfileType "motion_profile_type" 0x6086 0 I16 Taken "";
    PositionEncoderIncrements "position_encoder_increments" 0x608F 1 U32 Taken "increments" from 1;
    PositionEncoderRevolutions "position_encoder_revolutions" 0x608F 2 U32 Taken "revolutions" from 1;
    VelocityEncoderIncrements "velocity_encoder_increments" 0x6090 1 U32 Taken "increments/s";
    VelocityEncoderRevolutions "velocity_encoder_revolutions" 0x6090 2 U32 Taken "revolutions/s" from 1;
    GearMotorRevolutions "gear_motor_revolutions" 0x6091 1 U32 Taken "revolutions" from 1;
    GearShaftRevolutions "gear_shaft_revolutions" 0x6091 2 U32 Taken "revolutions" from 1;
    Feed "feed" 0x6092 1 U32 Taken "position units" from 1;
    FeedShaftRevolutions "feed_shaft_revolutions" 0x6092 2 U32 Taken "revolutions" from 1;
    VelocityFactorNumerator "velocity_factor_numerator" 0x6096 1 U32 Taken "" from 1;
    VelocityFactorDivisor "velocity_factor_divisor" 0x6096 2 U32 Taken "" from 1;
    AccelerationFactorNumerator "acceleration_factor_numerator" 0x6097 1 U32 Taken "" from 1;
    AccelerationFactorDivisor "acceleration_factor_divisor" 0x6097 2 U32 Taken "" from 1;
    HomingMethod "homing_method" 0x6098 0 I8 Taken "";
    HomingSearchSpeed "homing_search_speed" 0x6099 1 U32 Taken "velocity units" from 1;
    HomingZeroSpeed "homing_zero_speed" 0x6099 2 U32 Taken "velocity units" from 1;
    HomingAcceleration "homing_acceleration" 0x609A 0 U32 Taken "acceleration units" from 1;
    ProfileJerk "profile_jerk" 0x60A4 1 U32 Taken "jerk units" from 1;
    SiUnitPosition "si_unit_position" 0x60A8 0 U32 Taken "";
    SiUnitVelocity "si_unit_velocity" 0x60A9 0 U32 Taken "";
    SiUnitAcceleration "si_unit_acceleration" 0x60AA 0 U32 Taken "";
    SiUnitJerk "si_unit_jerk" 0x60AB 0 U32 Taken "";
    PositionOffset "position_offset" 0x60B0 0 I32 Taken "position units";
    VelocityOffset "velocity_offset" 0x60B1 0 I32 Taken "velocity units";
    TouchProbeFunction "touch_probe_function" 0x60B8 0 U16 Taken "";
    TouchProbeStatus "touch_probe_status" 0x60B9 0 U16 Shown "";
    TouchProbe1PositiveEdge "touch_probe_1_positive_edge" 0x60BA 0 I32 Shown "position units";
    TouchProbe1NegativeEdge "touch_probe_1_negative_edge" 0x60BB 0 I32 Shown "position units";
    TouchProbe2PositiveEdge "touch_probe_2_positive_edge" 0x60BC 0 I32 Shown "position units";
    TouchProbe2NegativeEdge "touch_probe_2_negative_edge" 0x60BD 0 I32 Shown "position units";
    InterpolationSubMode "interpolation_sub_mode" 0x60C0 0 I16 Taken "";
    InterpolationRecord "interpolation_record" 0x60C1 1 I32 Taken "position units";
    InterpolationTimeValue "interpolation_time_value" 0x60C2 1 U8 Taken "" from 1;
    InterpolationTimeIndex "interpolation_time_index" 0x60C2 2 I8 Taken "";
    InterpolationBufferSize "interpolation_buffer_size" 0x60C4 2 U32 Taken "" from 1;
    InterpolationBufferOrganization "interpolation_buffer_organization" 0x60C4 3 U8 Taken "";
    InterpolationBufferPosition "interpolation_buffer_position" 0x60C4 4 U16 Shown "";
    InterpolationBufferClear "interpolation_buffer_clear" 0x60C4 6 U8 Taken "";
    MaxAcceleration "max_acceleration" 0x60C5 0 U32 Taken "acceleration units" from 1;
    MaxDeceleration "max_deceleration" 0x60C6 0 U32 Taken "acceleration units" from 1;
    TouchProbe1Source "touch_probe_1_source" 0x60D0 1 I16 Taken "";
    TouchProbe2Source "touch_probe_2_source" 0x60D0 2 I16 Taken "";
    TouchProbe1PositiveTime "touch_probe_1_positive_time" 0x60D1 0 U32 Shown "ns";
    TouchProbe1NegativeTime "touch_probe_1_negative_time" 0x60D2 0 U32 Shown "ns";
    TouchProbe2PositiveTime "touch_probe_2_positive_time" 0x60D3 0 U32 Shown "ns";
    TouchProbe2NegativeTime "touch_probe_2_negative_time" 0x60D4 0 U32 Shown "ns";
    TouchProbe1PositiveCount "touch_probe_1_positive_count" 0x60D5 0 U16 Shown "";
    TouchProbe1NegativeCount "touch_probe_1_negative_count" 0x60D6 0 U16 Shown "";
    TouchProbe2PositiveCount "touch_probe_2_positive_count" 0x60D7 0 U16 Shown "";
    TouchProbe2NegativeCount "touch_probe_2_negative_count" 0x60D8 0 U16 Shown "";
    PositioningOptionCode "positioning_option_code" 0x60F2 0 U16 Taken "";
    FollowingErrorActualValue "following_error_actual_value" 0x60F4 0 I32 Shown "position units";
    MaxSlippage "max_slippage" 0x60F8 0 I32 Taken "velocity units";
    DigitalInputs "digital_inputs" 0x60FD 0 U32 Shown "";
    DigitalOutputs "digital_outputs" 0x60FE 1 U32 Taken "";
    DigitalOutputsMask "digital_outputs_mask" 0x60FE 2 U32 Taken "";
    TargetVelocity "target_velocity" 0x60FF 0 I32 Taken "velocity units";
    SupportedDriveModes "supported_drive_modes" 0x6502 0 U32 Taken "";
}

impl Parameter {
    /// The parameter that is at home in this object of the drive profile. Objects of the manufacturer mean something else in
    /// every device.
    pub const fn in_profile(index: u16, sub: u8) -> Option<Self> {
        if index < PROFILE {
            None
        } else {
            Self::at(index, sub)
        }
    }

    /// Whether it commands the drive, and is not something that is set up ([`crate::Configuration`]).
    pub(crate) const fn is_command(self) -> bool {
        matches!(
            self,
            Self::Controlword
                | Self::ModesOfOperation
                | Self::TargetPosition
                | Self::ProfileVelocity
                | Self::EndVelocity
                | Self::PositioningOptionCode
                | Self::ProfileAcceleration
                | Self::ProfileDeceleration
                | Self::TargetVelocity
                | Self::VlTargetVelocity
                | Self::PositionOffset
                | Self::VelocityOffset
                | Self::InterpolationRecord
                | Self::TouchProbeFunction
                | Self::DigitalOutputs
                | Self::DigitalOutputsMask
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_list_and_the_homes_agree() {
        assert!(ALL.is_sorted_by_key(|description| description.home));
        for description in ALL {
            let (index, sub) = description.home;
            assert_eq!(Parameter::at(index, sub), Some(description.parameter));
            let (low, high) = description.number.range();
            assert!(low <= description.range.0 && description.range.1 <= high);
        }
        let homes = (0x2000..=0x67FF).flat_map(|index| (0..=8).map(move |sub| (index, sub)));
        let found = homes.filter(|(index, sub)| Parameter::at(*index, *sub).is_some());
        assert_eq!(found.count(), ALL.len());
    }

    #[test]
    fn each_name_is_there_once() {
        for (position, description) in ALL.iter().enumerate() {
            let is_same = |other: &Description| other.name == description.name;
            assert_eq!(ALL.iter().position(is_same), Some(position));
        }
    }
}
