//! The table: one line for each parameter. Everything else is made from it.
//!
//! | makes | what |
//! |---|---|
//! | this crate | [`crate::Parameter`], its home, and what `od-gen` and bindings know of it |
//! | `cia402::objects` | the methods of `cia402::Objects` |
//! | `cia402::configuration` | `cia402::Configuration` and its groups, read from a dictionary |
//! | `cia402::rules` | what may be written, and when not |
//!
//! A line: `command` (passes with each write), `setting` (lies in the configuration) or `shown`; its name; the method of
//! `cia402::Objects`; its object and type; what counts where a data sheet leaves the object out (`or`: that of another one; `_`: nothing); its unit.
//! Then what applies of: the least number (`from`), the numbers that mean something (`only`: a pattern, or a function from a
//! code), when it is locked (`locked`), and where
//! it lies in the configuration (`=>`): the field, and how the number becomes what the drive reckons with:
//!
//! | | |
//! |---|---|
//! | `plain` | the number |
//! | `flag` | whether it is 1 |
//! | `speed`, `nearest_speed` | increments/s; not 0 unless the number is 0, or to the nearest |
//! | `acceleration` | increments/s² |
//! | `window` | increments; FFFFFFFFh is off |
//! | `(Code function)` | a code; others mean nothing and are refused |
//!
//! A setting without a place is part of something that several objects make: `cia402::Configuration::of` has these.

/// Hands the table to the macro of this name. What a line names beyond the parameter itself is looked up where the table is used.
#[doc(hidden)]
#[macro_export]
macro_rules! every_parameter {
    ($make:ident) => {
        $make! {
            /// Everything that is set up, as the objects say it.
            in drive: Configuration {
                /// See [`crate::inputs::InputFunction`].
                setting Input1Function input_1_function 0x2031:1 u8 = 0, "" only [InputFunction::from_code];
                setting Input2Function input_2_function 0x2031:2 u8 = 0, "" only [InputFunction::from_code];
                setting Input3Function input_3_function 0x2031:3 u8 = 0, "" only [InputFunction::from_code];
                setting Input4Function input_4_function 0x2031:4 u8 = 0, "" only [InputFunction::from_code];
                setting Input5Function input_5_function 0x2031:5 u8 = 0, "" only [InputFunction::from_code];
                setting Input6Function input_6_function 0x2031:6 u8 = 0, "" only [InputFunction::from_code];
                /// The inputs that are active while they are low; input `n` is bit `n − 1`.
                setting InputsInverted inputs_inverted 0x2032:0 u8 = 0, "";
                setting InputDebounce input_debounce 0x2033:0 u8 = 0, "ms";
                /// Touch probes pass over an edge whose level does not last so long.
                setting CaptureFilter capture_filter 0x2033:1 u16 = 0, "ns" => capture_filter: plain;
                /// 0 no sync events, 1 the loop is settling, 2 locked.
                shown SyncState set_sync_state 0x2050:1 u8 = _, "";
                shown SyncPeriod set_sync_period 0x2050:2 u32 = _, "ns";
                shown SyncJitter set_sync_jitter 0x2050:3 u32 = _, "ns";
                shown MissedSyncs set_missed_syncs 0x2050:4 u32 = _, "";
                shown RejectedSyncs set_rejected_syncs 0x2050:5 u32 = _, "";
                shown LostSetPoints set_lost_set_points 0x2050:6 u32 = _, "";
                shown CyclicLatency set_cyclic_latency 0x2050:7 u32 = _, "us";
                setting BridgedSetPoints bridged_set_points 0x2051:1 u8 = 2, "";
                /// See [`crate::cyclic::LostSetPoints`].
                setting LostSetPointReaction lost_set_point_reaction 0x2051:2 u8 = 1, "";
                /// See [`crate::outputs::OutputFunction`].
                setting Output1Function output_1_function 0x2060:1 u8 = 0, "" only [OutputFunction::from_code];
                setting Output2Function output_2_function 0x2060:2 u8 = 0, "" only [OutputFunction::from_code];
                setting Output3Function output_3_function 0x2060:3 u8 = 0, "" only [OutputFunction::from_code];
                setting Output4Function output_4_function 0x2060:4 u8 = 0, "" only [OutputFunction::from_code];
                /// The outputs that are low where they would be high; output `n` is bit `n − 1`.
                setting OutputsInverted outputs_inverted 0x2061:0 u8 = 0, "";
                /// The outputs that stay as they are when the network is lost; output `n` is bit `n − 1`.
                setting OutputsKept outputs_kept 0x2062:0 u8 = 0, "";
                /// 1 lets 60FEh move the brake.
                setting BrakeControl brake_control 0x2063:0 u8 = 0, "";
                /// Pulses of a full step, a power of two up to 256.
                setting Microsteps microsteps 0x2071:0 u16 = 1, "" from 1 only (1 | 2 | 4 | 8 | 16 | 32 | 64 | 128 | 256) locked Powered => microsteps: plain;
                /// 1 turns the direction of the motor round.
                setting MotorDirection motor_direction 0x2072:0 u8 = 0, "" locked Powered => is_reversed: flag;
                setting SmoothQuickStop smooth_quick_stop 0x20A0:0 u8 = 0, "" only (0 | 1);
                /// How long a stop may take that the drive makes on its own.
                setting LongestStop longest_stop 0x20A1:0 u16 = 2_000, "ms" from 1 => longest_stop: plain;
                /// 0: pulses that come too late are told; 1: they are a fault.
                setting LatePulseReaction late_pulse_reaction 0x20A2:0 u8 = 1, "" only (0 | 1) => late_is_fault: flag;
                /// See [`crate::pulse_timing::PulseTiming`].
                setting PulseDriver pulse_driver 0x20B0:1 u8 = 0, "" only [PulseTiming::from_code] locked Powered;
                setting PulseHigh pulse_high 0x20B0:2 u32 = 2_500, "ns" locked Powered;
                setting PulseLow pulse_low 0x20B0:3 u32 = 2_500, "ns" locked Powered;
                setting PulseDirectionSetup pulse_direction_setup 0x20B0:4 u32 = 5_000, "ns" locked Powered;
                setting PulseDirectionHold pulse_direction_hold 0x20B0:5 u32 = 5_000, "ns" locked Powered;
                /// How 607Dh is read, see [`crate::configuration::PositionLimitOptions`].
                setting PositionLimitOptions position_limit_options 0x20E0:0 u8 = 0, "" only (0..=3);
                setting AbortConnectionOptionCode abort_connection_option_code 0x6007:0 i16 = 3, "" => abort_connection: (AbortConnectionOption from_code);
                /// Code of the last fault.
                shown ErrorCode set_error_code 0x603F:0 u16 = _, "";
                command Controlword controlword 0x6040:0 u16 = 0, "";
                shown Statusword set_statusword 0x6041:0 u16 = _, "";
                command VlTargetVelocity vl_target_velocity 0x6042:0 i16 = 0, "vl";
                shown VlVelocityDemand set_vl_velocity_demand 0x6043:0 i16 = _, "vl";
                shown VlVelocityActualValue set_vl_velocity_actual_value 0x6044:0 i16 = _, "vl";
                setting VlVelocityMinAmount vl_velocity_min_amount 0x6046:1 u32 = 0, "vl";
                setting VlVelocityMaxAmount vl_velocity_max_amount 0x6046:2 u32 = u32::MAX, "vl";
                /// The speed that is gained or lost in the time of the next one.
                setting VlAccelerationSpeed vl_acceleration_speed 0x6048:1 u32 = 1, "vl" from 1;
                setting VlAccelerationTime vl_acceleration_time 0x6048:2 u16 = 1, "s" from 1;
                setting VlDecelerationSpeed vl_deceleration_speed 0x6049:1 u32 = 1, "vl" from 1;
                setting VlDecelerationTime vl_deceleration_time 0x6049:2 u16 = 1, "s" from 1;
                setting VlQuickStopSpeed vl_quick_stop_speed 0x604A:1 u32 = 1, "vl" from 1;
                setting VlQuickStopTime vl_quick_stop_time 0x604A:2 u16 = 1, "s" from 1;
                setting VlDimensionNumerator vl_dimension_numerator 0x604C:1 i32 = 1, "" from 1;
                setting VlDimensionDenominator vl_dimension_denominator 0x604C:2 i32 = 1, "" from 1;
                setting QuickStopOptionCode quick_stop_option_code 0x605A:0 i16 = 2, "" => quick_stop: (QuickStopOption from_code);
                setting ShutdownOptionCode shutdown_option_code 0x605B:0 i16 = 0, "" => shutdown: (Stop on_leaving);
                setting DisableOperationOptionCode disable_operation_option_code 0x605C:0 i16 = 1, "" => disable_operation: (Stop on_leaving);
                setting HaltOptionCode halt_option_code 0x605D:0 i16 = 1, "" => halt: (StopRamp on_halt);
                setting FaultReactionOptionCode fault_reaction_option_code 0x605E:0 i16 = 2, "" => fault_reaction: (Stop on_fault);
                command ModesOfOperation modes_of_operation 0x6060:0 i8 = 0, "";
                shown ModesOfOperationDisplay set_modes_of_operation_display 0x6061:0 i8 = _, "";
                shown PositionDemandValue set_position_demand_value 0x6062:0 i32 = _, "position units";
                shown PositionActualInternalValue set_position_actual_internal_value 0x6063:0 i32 = _, "increments";
                shown PositionActualValue set_position_actual_value 0x6064:0 i32 = _, "position units";
                /// FFFFFFFFh switches the window off; so it does in 6067h.
                setting FollowingErrorWindow following_error_window 0x6065:0 u32 = u32::MAX, "position units" => following_error_window: window;
                setting FollowingErrorTimeOut following_error_time_out 0x6066:0 u16 = 0, "ms" => following_error_time_out: plain;
                setting PositionWindow position_window 0x6067:0 u32 = u32::MAX, "position units" => position_window: window;
                setting PositionWindowTime position_window_time 0x6068:0 u16 = 0, "ms" => position_window_time: plain;
                shown VelocityDemandValue set_velocity_demand_value 0x606B:0 i32 = _, "velocity units";
                shown VelocityActualValue set_velocity_actual_value 0x606C:0 i32 = _, "velocity units";
                setting VelocityWindow velocity_window 0x606D:0 u16 = 0, "velocity units" => velocity_window: nearest_speed;
                setting VelocityWindowTime velocity_window_time 0x606E:0 u16 = 0, "ms" => velocity_window_time: plain;
                setting VelocityThreshold velocity_threshold 0x606F:0 u16 = 0, "velocity units" => velocity_threshold: nearest_speed;
                setting VelocityThresholdTime velocity_threshold_time 0x6070:0 u16 = 0, "ms" => velocity_threshold_time: plain;
                shown DcLinkVoltage set_dc_link_voltage 0x6079:0 u32 = _, "mV";
                command TargetPosition target_position 0x607A:0 i32 = 0, "position units";
                /// Positions wrap at the ends of 32 bits while minimum is not below maximum.
                setting MinPositionRangeLimit min_position_range_limit 0x607B:1 i32 = i32::MIN, "position units" locked Powered;
                setting MaxPositionRangeLimit max_position_range_limit 0x607B:2 i32 = i32::MAX, "position units" locked Powered;
                /// The limits are off while minimum is not below maximum.
                setting MinPositionLimit min_position_limit 0x607D:1 i32 = i32::MIN, "position units";
                setting MaxPositionLimit max_position_limit 0x607D:2 i32 = i32::MAX, "position units";
                /// Bit 7 turns positions around, bit 6 velocities.
                setting Polarity polarity 0x607E:0 u8 = 0, "" only (n if n & !POLARITIES == 0) locked Powered;
                setting MaxProfileVelocity max_profile_velocity 0x607F:0 u32 = u32::MAX, "velocity units";
                setting MaxMotorSpeed max_motor_speed 0x6080:0 u32 = u32::MAX, "1/min";
                command ProfileVelocity profile_velocity 0x6081:0 u32 = 0, "velocity units";
                command EndVelocity end_velocity 0x6082:0 u32 = 0, "velocity units";
                command ProfileAcceleration profile_acceleration 0x6083:0 u32 = 0, "acceleration units" from 1;
                command ProfileDeceleration profile_deceleration 0x6084:0 u32 = 0, "acceleration units" from 1;
                setting QuickStopDeceleration quick_stop_deceleration 0x6085:0 u32 or profile_deceleration = 0, "acceleration units" from 1 => quick_stop_deceleration: acceleration;
                setting MotionProfileType motion_profile_type 0x6086:0 i16 = 0, "" only (n if means(n, |code| profile::ramps(code, 1)));
                /// 0 where there is no such object: a unit of position is then an increment of the motor.
                setting PositionEncoderIncrements position_encoder_increments 0x608F:1 u32 = 0, "increments" from 1 locked Powered;
                setting PositionEncoderRevolutions position_encoder_revolutions 0x608F:2 u32 = 1, "revolutions" from 1 locked Powered;
                /// 0: as 608Fh.
                setting VelocityEncoderIncrements velocity_encoder_increments 0x6090:1 u32 = 0, "increments/s" locked Powered;
                setting VelocityEncoderRevolutions velocity_encoder_revolutions 0x6090:2 u32 = 1, "revolutions/s" from 1 locked Powered;
                setting GearMotorRevolutions gear_motor_revolutions 0x6091:1 u32 = 1, "revolutions" from 1 locked Powered;
                setting GearShaftRevolutions gear_shaft_revolutions 0x6091:2 u32 = 1, "revolutions" from 1 locked Powered;
                setting Feed feed 0x6092:1 u32 = 1, "position units" from 1 locked Powered;
                setting FeedShaftRevolutions feed_shaft_revolutions 0x6092:2 u32 = 1, "revolutions" from 1 locked Powered;
                setting VelocityFactorNumerator velocity_factor_numerator 0x6096:1 u32 = 1, "" from 1 locked Powered;
                setting VelocityFactorDivisor velocity_factor_divisor 0x6096:2 u32 = 1, "" from 1 locked Powered;
                setting AccelerationFactorNumerator acceleration_factor_numerator 0x6097:1 u32 = 1, "" from 1 locked Powered;
                setting AccelerationFactorDivisor acceleration_factor_divisor 0x6097:2 u32 = 1, "" from 1 locked Powered;
                setting ProfileJerk profile_jerk 0x60A4:1 u32 = 1_000_000, "jerk units" from 1;
                /// See [`crate::units::SiUnit`].
                setting SiUnitPosition si_unit_position 0x60A8:0 u32 = 0, "" only (n if is_named(n, SiUnit::Position)) locked Powered;
                setting SiUnitVelocity si_unit_velocity 0x60A9:0 u32 = 0, "" only (n if is_named(n, SiUnit::Velocity)) locked Powered;
                setting SiUnitAcceleration si_unit_acceleration 0x60AA:0 u32 = 0, "" only (n if is_named(n, SiUnit::Acceleration)) locked Powered;
                setting SiUnitJerk si_unit_jerk 0x60AB:0 u32 = 0, "" only (n if is_named(n, SiUnit::Jerk)) locked Powered;
                command PositionOffset position_offset 0x60B0:0 i32 = 0, "position units";
                command VelocityOffset velocity_offset 0x60B1:0 i32 = 0, "velocity units";
                command TouchProbeFunction touch_probe_function 0x60B8:0 u16 = 0, "" only [probe_functions];
                shown TouchProbeStatus set_touch_probe_status 0x60B9:0 u16 = _, "";
                shown TouchProbe1PositiveEdge set_touch_probe_1_positive_edge 0x60BA:0 i32 = _, "position units";
                shown TouchProbe1NegativeEdge set_touch_probe_1_negative_edge 0x60BB:0 i32 = _, "position units";
                shown TouchProbe2PositiveEdge set_touch_probe_2_positive_edge 0x60BC:0 i32 = _, "position units";
                shown TouchProbe2NegativeEdge set_touch_probe_2_negative_edge 0x60BD:0 i32 = _, "position units";
                /// 0 linear, −1 cubic.
                setting InterpolationSubMode interpolation_sub_mode 0x60C0:0 i16 = 0, "" only (-1 | 0) locked Moving;
                command InterpolationRecord interpolation_record 0x60C1:1 i32 = 0, "position units";
                setting InterpolationTimeValue interpolation_time_value 0x60C2:1 u8 = 1, "" from 1 locked Moving;
                /// The power of ten, in seconds.
                setting InterpolationTimeIndex interpolation_time_index 0x60C2:2 i8 = -3, "" locked Moving;
                setting InterpolationBufferSize interpolation_buffer_size 0x60C4:2 u32 = 32, "" from 1;
                setting InterpolationBufferOrganization interpolation_buffer_organization 0x60C4:3 u8 = 0, "";
                shown InterpolationBufferPosition set_interpolation_buffer_position 0x60C4:4 u16 = _, "";
                setting InterpolationBufferClear interpolation_buffer_clear 0x60C4:6 u8 = 1, "";
                setting MaxAcceleration max_acceleration 0x60C5:0 u32 = u32::MAX, "acceleration units" from 1 => max_acceleration: acceleration;
                setting MaxDeceleration max_deceleration 0x60C6:0 u32 = u32::MAX, "acceleration units" from 1 => max_deceleration: acceleration;
                /// See [`crate::inputs::Source`].
                setting TouchProbe1Source touch_probe_1_source 0x60D0:1 i16 = 1, "" only [Source::from_code];
                setting TouchProbe2Source touch_probe_2_source 0x60D0:2 i16 = 2, "" only [Source::from_code];
                shown TouchProbe1PositiveTime set_touch_probe_1_positive_time 0x60D1:0 u32 = _, "ns";
                shown TouchProbe1NegativeTime set_touch_probe_1_negative_time 0x60D2:0 u32 = _, "ns";
                shown TouchProbe2PositiveTime set_touch_probe_2_positive_time 0x60D3:0 u32 = _, "ns";
                shown TouchProbe2NegativeTime set_touch_probe_2_negative_time 0x60D4:0 u32 = _, "ns";
                shown TouchProbe1PositiveCount set_touch_probe_1_positive_count 0x60D5:0 u16 = _, "";
                shown TouchProbe1NegativeCount set_touch_probe_1_negative_count 0x60D6:0 u16 = _, "";
                shown TouchProbe2PositiveCount set_touch_probe_2_positive_count 0x60D7:0 u16 = _, "";
                shown TouchProbe2NegativeCount set_touch_probe_2_negative_count 0x60D8:0 u16 = _, "";
                /// 0, relative set-points count from the previous target.
                command PositioningOptionCode positioning_option_code 0x60F2:0 u16 = 0, "" only (n if n & !POSITIONING_OPTIONS == 0 && n & 3 != 3);
                shown FollowingErrorActualValue set_following_error_actual_value 0x60F4:0 i32 = _, "position units";
                setting MaxSlippage max_slippage 0x60F8:0 i32 = i32::MAX, "velocity units" => max_slippage: nearest_speed;
                shown DigitalInputs set_digital_inputs 0x60FD:0 u32 = _, "";
                command DigitalOutputs digital_outputs 0x60FE:1 u32 = 0, "";
                /// Without it every bit of 60FEh:1 counts.
                command DigitalOutputsMask digital_outputs_mask 0x60FE:2 u32 = u32::MAX, "";
                command TargetVelocity target_velocity 0x60FF:0 i32 = 0, "velocity units";
                setting SupportedDriveModes supported_drive_modes 0x6502:0 u32 = 0, "";
            }
            /// How long the brake takes.
            in brake: BrakeTimes {
                setting BrakeReleaseTime brake_release_time 0x2040:1 u16 = 0, "ms" => release: plain;
                setting BrakeEngageTime brake_engage_time 0x2040:2 u16 = 0, "ms" => engage: plain;
                /// From power to the release.
                setting BrakePowerTime brake_power_time 0x2040:3 u16 = 0, "ms" => power: plain;
            }
            /// How homing is set up.
            in homing: HomingConfiguration {
                /// Readings of the homing methods: see [`crate::configuration::HomingConfiguration`].
                setting HomingOptions homing_options 0x2030:1 u16 = 0, "" => options: plain;
                /// 0 is no bound, as for the two that follow.
                setting HomingLongestDistance homing_longest_distance 0x2030:2 u32 = 0, "steps" => longest_distance: plain;
                setting HomingLongestTime homing_longest_time 0x2030:3 u32 = 0, "ms" => longest_time: plain;
                setting HomingLongestDistanceToIndex homing_longest_distance_to_index 0x2030:4 u32 = 0, "steps" => longest_distance_to_index: plain;
                setting HomingBlockTime homing_block_time 0x2030:5 u16 = 50, "ms" => block_time: plain;
                /// 0: a following error does not tell of a hard stop.
                setting HomingBlockWindow homing_block_window 0x2030:6 u32 = 0, "steps" => block_window: plain;
                setting HomingBackOff homing_back_off 0x2030:7 u32 = 0, "steps" => back_off: plain;
                /// 1 while the home position is known.
                shown HomingReferenced set_homing_referenced 0x2034:1 u8 = _, "";
                /// Why homing failed last.
                shown HomingFailure set_homing_failure 0x2034:2 u8 = _, "";
                setting HomeOffset home_offset 0x607C:0 i32 = 0, "position units" => offset: plain;
                /// 0 is no method.
                setting HomingMethod homing_method 0x6098:0 i8 = 0, "" only (n if n == 0 || means(n, Method::from_code)) => method: plain;
                setting HomingSearchSpeed homing_search_speed 0x6099:1 u32 = 0, "velocity units" from 1 => search_speed: speed;
                setting HomingZeroSpeed homing_zero_speed 0x6099:2 u32 = 0, "velocity units" from 1 => zero_speed: speed;
                setting HomingAcceleration homing_acceleration 0x609A:0 u32 or profile_acceleration = 0, "acceleration units" from 1 => acceleration: acceleration;
            }
            /// What may be asked of a motor whose current is measured, and what it is. Where a data sheet has no limit, the motor's own holds.
            in torque: TorqueConfiguration {
                command TargetTorque target_torque 0x6071:0 i16 = 0, "0.1 %";
                setting MaxTorque max_torque 0x6072:0 u16 = u16::MAX, "0.1 %" => max: plain;
                setting MaxCurrent max_current 0x6073:0 u16 = u16::MAX, "0.1 %" => max_current: plain;
                shown TorqueDemand set_torque_demand 0x6074:0 i16 = _, "0.1 %";
                /// The motor's own, with 0, as its torque.
                setting MotorRatedCurrent motor_rated_current 0x6075:0 u32 = 0, "mA" => rated_current: plain;
                setting MotorRatedTorque motor_rated_torque 0x6076:0 u32 = 0, "mNm" => rated: plain;
                /// The motor's own, with 0.
                setting MotorInertia motor_inertia 0x20C2:5 u32 = 0, "g mm2" => inertia: plain;
                shown TorqueActualValue set_torque_actual_value 0x6077:0 i16 = _, "0.1 %";
                shown CurrentActualValue set_current_actual_value 0x6078:0 i16 = _, "0.1 %";
                setting TorqueSlope torque_slope 0x6087:0 u32 = u32::MAX, "0.1 %/s" from 1 => slope: plain;
                /// Linear ramps.
                setting TorqueProfileType torque_profile_type 0x6088:0 i16 = 0, "" only (0);
                command TorqueOffset torque_offset 0x60B2:0 i16 = 0, "0.1 %";
                setting PositiveTorqueLimit positive_torque_limit 0x60E0:0 u16 = u16::MAX, "0.1 %" => positive: plain;
                setting NegativeTorqueLimit negative_torque_limit 0x60E1:0 u16 = u16::MAX, "0.1 %" => negative: plain;
            }
            /// How the analogue input is set up.
            in analogue: AnalogueConfiguration {
                /// 0 to 4095.
                shown AnalogueInputRaw set_analogue_input_raw 0x2064:1 u16 = _, "";
                shown AnalogueInputVoltage set_analogue_input_voltage 0x2064:2 i32 = _, "mV";
                shown AnalogueInputFiltered set_analogue_input_filtered 0x2064:3 i32 = _, "mV";
                setting AnalogueInputFullScale analogue_input_full_scale 0x2064:4 i32 = 10_000, "mV" => full_scale: plain;
                setting AnalogueInputOffset analogue_input_offset 0x2064:5 i32 = 0, "mV" => offset: plain;
                setting AnalogueInputFilterTime analogue_input_filter_time 0x2064:6 u16 = 0, "ms" => filter: plain;
            }
            /// The currents of the motor, and when it counts as holding.
            in currents: MotorCurrents {
                setting RunCurrent run_current 0x2070:1 u16 = 0, "mA" => run: plain;
                setting HoldCurrent hold_current 0x2070:2 u16 = 0, "mA" => hold: plain;
                /// 0: as the run current.
                setting BoostCurrent boost_current 0x2070:3 u16 = 0, "mA" => boost: plain;
                setting HoldDelay hold_delay 0x2070:4 u16 = 0, "ms" => hold_delay: plain;
            }
            /// Where supply and temperature become warnings and faults.
            in power_stage: Thresholds {
                /// 0 is off, as for the other voltages.
                setting UnderVoltageFault under_voltage_fault 0x2073:1 u32 = 0, "mV" => under_voltage: plain;
                setting UnderVoltageWarning under_voltage_warning 0x2073:2 u32 = 0, "mV" => under_voltage_warning: plain;
                setting OverVoltageWarning over_voltage_warning 0x2073:3 u32 = 0, "mV" => over_voltage_warning: plain;
                setting OverVoltageFault over_voltage_fault 0x2073:4 u32 = 0, "mV" => over_voltage: plain;
                setting VoltageHysteresis voltage_hysteresis 0x2073:5 u32 = 0, "mV" => voltage_hysteresis: plain;
                /// The supply of the electronics, and the battery of an encoder.
                shown AuxiliaryVoltage set_auxiliary_voltage 0x2075:1 u32 = _, "mV";
                shown BatteryVoltage set_battery_voltage 0x2075:2 u32 = _, "mV";
                shown Temperature set_temperature 0x2074:1 i16 = _, "0.1 °C";
                setting TemperatureWarning temperature_warning 0x2074:2 i16 = i16::MAX, "0.1 °C" => temperature_warning: plain;
                setting OverTemperatureFault over_temperature_fault 0x2074:3 i16 = i16::MAX, "0.1 °C" => over_temperature: plain;
                setting TemperatureHysteresis temperature_hysteresis 0x2074:4 u16 = 0, "0.1 °C" => temperature_hysteresis: plain;
            }
        }
    };
}
