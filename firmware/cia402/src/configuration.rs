//! What a master sets up, in contrast to what it commands: how the drive stops, what it may do, and when something counts as
//! reached.
//!
//! It changes seldom, so it passes from the communication task to the control tick apart from the commands, and only when an
//! object of it was written. Codes are decoded on the way: a tick never sees one that means nothing.

use motion::{SignedSpeed, Speed, homing};

use crate::brake::BrakeTimes;
use crate::copied::copy_fields;
use crate::cyclic::CyclicConfiguration;
use crate::inputs::InputConfiguration;
use crate::objects::Objects;
use crate::option_codes::{AbortConnectionOption, QuickStopOption, Stop, StopRamp};
use crate::periphery::analogue_input::AnalogueConfiguration;
use crate::periphery::digital_outputs::OutputConfiguration;
use crate::periphery::motor_current::MotorCurrents;
use crate::periphery::power_stage::Thresholds;
use crate::periphery::touch_probe::Source;
use crate::profile::{self, ProfileConfiguration};
use crate::pulse_timing::PulseTiming;
use crate::units::{Ratio, Units};

/// Everything that is set up, as the objects say it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Configuration {
    /// 607Bh, 607Eh, 608Fh to 6092h, 6096h and 6097h. All else here is in increments, unless it says otherwise.
    pub units: Units,
    /// 2040h.
    pub brake: BrakeTimes,
    /// 20B0h.
    pub pulse_timing: PulseTiming,
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
    /// 20A1h in milliseconds: how long a stop may take that the drive makes on its own.
    pub longest_stop: u16,
    /// 6085h in steps/s².
    pub quick_stop_deceleration: u32,
    /// 607Dh:1 and :2 in user units. They are off while the first is not below the second.
    pub position_limits: (i32, i32),
    /// 20E0h.
    pub position_limit_options: PositionLimitOptions,
    /// 6065h in steps; FFFFFFFFh is off.
    pub following_error_window: u32,
    /// 6066h in milliseconds.
    pub following_error_time_out: u16,
    /// 6067h in steps; FFFFFFFFh is off.
    pub position_window: u32,
    /// 6068h in milliseconds.
    pub position_window_time: u16,
    /// 606Dh.
    pub velocity_window: Speed,
    /// 606Eh in milliseconds.
    pub velocity_window_time: u16,
    /// 606Fh.
    pub velocity_threshold: Speed,
    /// 6070h in milliseconds.
    pub velocity_threshold_time: u16,
    /// 60F8h; a negative one counts as 0.
    pub max_slippage: Speed,
    /// The smaller of 607Fh and 6080h.
    pub max_velocity: Speed,
    /// 60C5h in steps/s².
    pub max_acceleration: u32,
    /// 60C6h in steps/s².
    pub max_deceleration: u32,
    /// 6086h, 60A4h and 20A0h.
    pub profile: ProfileConfiguration,
    /// What belongs to the velocity mode alone.
    pub velocity: VelocityConfiguration,
    /// 2031h to 2033h.
    pub inputs: InputConfiguration,
    /// 607Ch, 6098h, 6099h, 609Ah and 2030h.
    pub homing: HomingConfiguration,
    /// 60D0h: what probes 1 and 2 look at if 60B8h asks for it.
    pub touch_probe_sources: [Source; 2],
    /// 2060h to 2063h.
    pub outputs: OutputConfiguration,
    /// 2064h.
    pub analogue: AnalogueConfiguration,
    /// 2070h.
    pub currents: MotorCurrents,
    /// 2071h: pulses of a full step.
    pub microsteps: u16,
    /// 2072h: the motor turns the other way.
    pub is_reversed: bool,
    /// 2073h and 2074h.
    pub power_stage: Thresholds,
    /// 1006h, 2051h, 60C0h, 60C2h and 60C4h.
    pub cyclic: CyclicConfiguration,
}

/// How 607Dh is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PositionLimitOptions {
    /// 20E0h bit 0: the limits are off until the home position is known.
    pub need_home: bool,
    /// 20E0h bit 1: they are positions as 6064h shows them. Else they count from the home position, as CiA 402-2 says: they
    /// lie where they lie whatever 607Ch calls that.
    pub are_as_shown: bool,
}

impl PositionLimitOptions {
    /// As CiA 402-2 says.
    pub const NONE: Self = Self {
        need_home: false,
        are_as_shown: false,
    };

    const fn of(options: u8) -> Self {
        Self {
            need_home: options & 1 << 0 != 0,
            are_as_shown: options & 1 << 1 != 0,
        }
    }
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

    /// The velocity of an amount of the mode, rounded once to the nearest.
    pub fn speed(&self, amount: u32, reverse: bool) -> SignedSpeed {
        let (numerator, denominator) = self.dimension;
        let reverse = reverse != self.turns_round();
        let ratio = Ratio::between(numerator.unsigned_abs(), denominator.unsigned_abs());
        ratio.map_or(SignedSpeed::ZERO, |ratio| {
            ratio.to_speed(amount).signed(reverse)
        })
    }

    /// A velocity as the mode shows it, rounded once to the nearest.
    pub fn shown(&self, velocity: SignedSpeed) -> i16 {
        let (numerator, denominator) = self.dimension;
        let shown = if numerator == denominator {
            velocity.whole()
        } else {
            let ratio = Ratio::between(numerator.unsigned_abs(), denominator.unsigned_abs());
            let amount = ratio.map_or(0, |ratio| ratio.to_units_of_speed(velocity.unsigned_abs()));
            let amount = i32::try_from(amount).unwrap_or(i32::MAX);
            if (velocity.bits() < 0) != self.turns_round() {
                amount.wrapping_neg()
            } else {
                amount
            }
        };
        let end = if shown < 0 { i16::MIN } else { i16::MAX };
        i16::try_from(shown).unwrap_or(end)
    }

    /// A unit of the mode is a velocity backwards.
    const fn turns_round(&self) -> bool {
        (self.dimension.0 < 0) != (self.dimension.1 < 0)
    }
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
        units: Units::NONE,
        brake: BrakeTimes {
            release: 0,
            engage: 0,
        },
        pulse_timing: PulseTiming::AsBuilt,
        abort_connection: AbortConnectionOption::QuickStop,
        quick_stop: QuickStopOption::QuickStopRamp,
        shutdown: Stop::PowerOff,
        disable_operation: Stop::Ramp(StopRamp::SlowDown),
        halt: StopRamp::SlowDown,
        fault_reaction: Stop::Ramp(StopRamp::QuickStop),
        longest_stop: 2_000,
        quick_stop_deceleration: 0,
        position_limits: (i32::MIN, i32::MAX),
        position_limit_options: PositionLimitOptions::NONE,
        following_error_window: u32::MAX,
        following_error_time_out: 0,
        position_window: u32::MAX,
        position_window_time: 0,
        velocity_window: Speed::ZERO,
        velocity_window_time: 0,
        velocity_threshold: Speed::ZERO,
        velocity_threshold_time: 0,
        max_slippage: Speed::MAX,
        max_velocity: Speed::MAX,
        max_acceleration: u32::MAX,
        max_deceleration: u32::MAX,
        profile: ProfileConfiguration::NONE,
        velocity: VelocityConfiguration::NONE,
        inputs: InputConfiguration::NONE,
        homing: HomingConfiguration::NONE,
        touch_probe_sources: [Source::Probe1, Source::Probe2],
        outputs: OutputConfiguration::NONE,
        analogue: AnalogueConfiguration::NONE,
        currents: MotorCurrents::NONE,
        microsteps: 1,
        is_reversed: false,
        power_stage: Thresholds::NONE,
        cyclic: CyclicConfiguration::NONE,
    };

    /// Takes over all of another one, field by field.
    #[inline]
    pub(crate) fn assign(&mut self, from: &Self) {
        copy_fields!(Self { units, brake, pulse_timing, abort_connection, quick_stop, shutdown, disable_operation, halt, fault_reaction, longest_stop, quick_stop_deceleration, position_limits, position_limit_options, following_error_window, following_error_time_out, position_window, position_window_time, velocity_window, velocity_window_time, velocity_threshold, velocity_threshold_time, max_slippage, max_velocity, max_acceleration, max_deceleration, profile, velocity, inputs, homing, touch_probe_sources, outputs, analogue, currents, microsteps, is_reversed, power_stage, cyclic }, from => self);
    }

    /// What the objects of a dictionary say. A code that means nothing (only a data sheet can hold one) counts as the default
    /// of the standard.
    pub fn of<D: Objects>(dictionary: &D) -> Self {
        let units = Units::of(dictionary);
        Self {
            units,
            brake: BrakeTimes {
                release: dictionary.brake_release_time(),
                engage: dictionary.brake_engage_time(),
            },
            pulse_timing: PulseTiming::of(dictionary),
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
            longest_stop: dictionary.longest_stop(),
            quick_stop_deceleration: units.acceleration(dictionary.quick_stop_deceleration()),
            position_limits: (
                dictionary.min_position_limit(),
                dictionary.max_position_limit(),
            ),
            position_limit_options: PositionLimitOptions::of(dictionary.position_limit_options()),
            following_error_window: units.window(dictionary.following_error_window()),
            following_error_time_out: dictionary.following_error_time_out(),
            position_window: units.window(dictionary.position_window()),
            position_window_time: dictionary.position_window_time(),
            velocity_window: units.speed_window(dictionary.velocity_window().into()),
            velocity_window_time: dictionary.velocity_window_time(),
            velocity_threshold: units.speed_window(dictionary.velocity_threshold().into()),
            velocity_threshold_time: dictionary.velocity_threshold_time(),
            max_slippage: units.speed_window(dictionary.max_slippage().max(0).unsigned_abs()),
            max_velocity: units
                .speed(dictionary.max_profile_velocity())
                .min(units.motor_speed(dictionary.max_motor_speed())),
            max_acceleration: units.acceleration(dictionary.max_acceleration()),
            max_deceleration: units.acceleration(dictionary.max_deceleration()),
            profile: ProfileConfiguration {
                ramps: profile::ramps(
                    dictionary.motion_profile_type(),
                    units.jerk(dictionary.profile_jerk()),
                )
                .unwrap_or(Self::NONE.profile.ramps),
                has_smooth_quick_stop: dictionary.smooth_quick_stop() == 1,
            },
            velocity: VelocityConfiguration::of(dictionary),
            inputs: InputConfiguration::new(
                [
                    dictionary.input_1_function(),
                    dictionary.input_2_function(),
                    dictionary.input_3_function(),
                    dictionary.input_4_function(),
                    dictionary.input_5_function(),
                    dictionary.input_6_function(),
                ],
                dictionary.inputs_inverted(),
                dictionary.input_debounce(),
            ),
            homing: HomingConfiguration::of(dictionary, &units),
            touch_probe_sources: [
                Source::from_code(dictionary.touch_probe_1_source()).unwrap_or(Source::Probe1),
                Source::from_code(dictionary.touch_probe_2_source()).unwrap_or(Source::Probe2),
            ],
            outputs: OutputConfiguration::of(dictionary),
            analogue: AnalogueConfiguration::of(dictionary),
            currents: MotorCurrents::of(dictionary),
            microsteps: dictionary.microsteps(),
            is_reversed: dictionary.motor_direction() == 1,
            power_stage: Thresholds::of(dictionary),
            cyclic: CyclicConfiguration::of(dictionary),
        }
    }
}

/// How homing is set up. 2030h:1 tells where vendors read the standard in different ways; with 0 in it the drive does what most
/// masters expect. The options are its bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HomingConfiguration {
    /// 6098h; 0 is no method.
    pub method: i8,
    /// 6099h:1.
    pub search_speed: Speed,
    /// 6099h:2.
    pub zero_speed: Speed,
    /// 609Ah in steps/s².
    pub acceleration: u32,
    /// 607Ch in user units.
    pub offset: i32,
    /// Bit 0: 6064h is −607Ch at the home position, and not +607Ch.
    pub is_offset_subtracted: bool,
    /// Bit 7: statusword bit 12 is 0 when the mode is entered, even while the home position is known.
    pub starts_afresh: bool,
    /// Bit 1: [`homing::Settings::turns_at_limit`]; bit 2: `is_direct`; bit 3: `returns`; bit 4: `last_move_is_fast`; bit 5:
    /// `other_block_signs`; bit 6: `home_is_backed_off`. 2030h:2 to :5 and :7: the bounds and the hard stop.
    pub settings: homing::Settings,
    /// 2030h:6: the following error in steps from which on the motor counts as blocked; 0: it does not tell.
    pub block_window: u32,
}

impl HomingConfiguration {
    /// What holds before anything is set up: no method.
    pub const NONE: Self = Self {
        method: 0,
        search_speed: Speed::ZERO,
        zero_speed: Speed::ZERO,
        acceleration: 0,
        offset: 0,
        is_offset_subtracted: false,
        starts_afresh: false,
        settings: homing::Settings {
            turns_at_limit: false,
            is_direct: false,
            returns: false,
            last_move_is_fast: false,
            other_block_signs: false,
            home_is_backed_off: false,
            longest_way: 0,
            longest_time: 0,
            longest_way_to_index: 0,
            block_time: 0,
            back_off: 0,
        },
        block_window: 0,
    };

    fn of<D: Objects>(dictionary: &D, units: &Units) -> Self {
        let options = dictionary.homing_options();
        let has = |bit: u16| options & 1 << bit != 0;
        Self {
            method: dictionary.homing_method(),
            search_speed: units.speed(dictionary.homing_search_speed()),
            zero_speed: units.speed(dictionary.homing_zero_speed()),
            acceleration: units.acceleration(dictionary.homing_acceleration()),
            offset: dictionary.home_offset(),
            is_offset_subtracted: has(0),
            starts_afresh: has(7),
            settings: homing::Settings {
                turns_at_limit: has(1),
                is_direct: has(2),
                returns: has(3),
                last_move_is_fast: has(4),
                other_block_signs: has(5),
                home_is_backed_off: has(6),
                longest_way: dictionary.homing_longest_way(),
                longest_time: dictionary.homing_longest_time(),
                longest_way_to_index: dictionary.homing_longest_way_to_index(),
                block_time: dictionary.homing_block_time(),
                back_off: dictionary.homing_back_off(),
            },
            block_window: dictionary.homing_block_window(),
        }
    }

    /// What 6064h shows at the home position, in user units.
    pub const fn position_at_home(&self) -> i32 {
        if self.is_offset_subtracted {
            self.offset.wrapping_neg()
        } else {
            self.offset
        }
    }
}
