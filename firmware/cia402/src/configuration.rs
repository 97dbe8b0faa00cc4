//! What a master sets up, in contrast to what it commands: how the drive stops, what it may do, and when something counts as
//! reached.
//!
//! It changes seldom, so it passes from the communication task to the control tick apart from the commands, and only when an
//! object of it was written. Codes are decoded on the way: a tick never sees one that means nothing.

use motion::{SignedSpeed, Speed, homing};

use crate::copied::copy_fields;
use crate::cyclic::CyclicConfiguration;
use crate::inputs::{InputConfiguration, Source};
use crate::objects::Objects;
use crate::option_codes::{AbortConnectionOption, QuickStopOption, Stop, StopRamp};
use crate::outputs::OutputConfiguration;
use crate::profile::ProfileConfiguration;
use crate::pulse_timing::PulseTiming;
use crate::units::{Ratio, Units, VELOCITY_POLARITY};
use cia402_parameters::every_parameter;

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
        let mut dimension = (
            dictionary.vl_dimension_numerator(),
            dictionary.vl_dimension_denominator(),
        );
        if D::DRIVE_HABITS.velocity_in_rpm {
            dimension = in_steps(dictionary, dimension);
        }
        if D::DRIVE_HABITS.velocity_has_polarity && dictionary.polarity() & VELOCITY_POLARITY != 0 {
            dimension.0 = dimension.0.wrapping_neg();
        }
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

/// A dimension that makes revolutions per minute of a unit, as one that makes steps/s of it.
fn in_steps<D: Objects>(dictionary: &D, (numerator, denominator): (i32, i32)) -> (i32, i32) {
    let increments = dictionary.position_encoder_increments();
    let revolutions = dictionary.position_encoder_revolutions();
    let mut numerator = i128::from(numerator).saturating_mul(increments.into());
    let mut denominator = i128::from(denominator).saturating_mul(60 * i128::from(revolutions));
    loop {
        if let (Ok(numerator), Ok(denominator)) =
            (i32::try_from(numerator), i32::try_from(denominator))
        {
            return (numerator, denominator);
        }
        // Within 96 halvings either is small enough.
        numerator /= 2;
        denominator /= 2;
    }
}

/// A speed that is gained in so many seconds, in steps/s²: at least 1, so that every ramp ends.
#[inline(never)]
fn ramp(speed: u32, seconds: u16, dimension: (i32, i32)) -> u32 {
    let gained = u64::from(speed).saturating_mul(dimension.0.unsigned_abs().into());
    let divisor = u64::from(seconds).saturating_mul(dimension.1.unsigned_abs().into());
    let ramp = gained.checked_div(divisor).unwrap_or(u64::MAX);
    u32::try_from(ramp).unwrap_or(u32::MAX).max(1)
}

/// Makes [`Configuration`] and its groups of the table, with what several objects make together.
macro_rules! configuration {
    (
        $(#[$about:meta])* in drive: Configuration {$(
            $(#[$doc:meta])* $role:ident $parameter:ident $method:ident $index:literal:$sub:literal
            $number:ident $(or $other:ident)? = $default:expr, $unit:literal
            $(from $least:literal)? $(only $only:tt)? $(locked $lock:ident)? $(=> $field:ident: $kind:tt)?;
        )*}
        $($(#[$about_group:meta])* in $group:ident: $Group:ident {$(
            $(#[$group_doc:meta])* $group_role:ident $group_parameter:ident $group_method:ident
            $group_index:literal:$group_sub:literal
            $group_number:ident $(or $group_other:ident)? = $group_default:expr, $group_unit:literal
            $(from $group_least:literal)? $(only $group_only:tt)? $(locked $group_lock:ident)?
            $(=> $group_field:ident: $group_kind:tt)?;
        )*})*
    ) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct Configuration {
            /// 607Bh, 607Eh, 608Fh to 6092h, 6096h and 6097h. All else here is in increments, unless it says otherwise.
            pub units: Units,
            /// 20B0h.
            pub pulse_timing: PulseTiming,
            /// 607Dh:1 and :2 in user units. They are off while the first is not below the second.
            pub position_limits: (i32, i32),
            /// 20E0h.
            pub position_limit_options: PositionLimitOptions,
            /// The smaller of 607Fh and 6080h.
            pub max_velocity: Speed,
            /// 6086h, 60A4h and 20A0h.
            pub profile: ProfileConfiguration,
            /// What belongs to the velocity mode alone.
            pub velocity: VelocityConfiguration,
            /// 2031h to 2033h.
            pub inputs: InputConfiguration,
            /// 60D0h: what probes 1 and 2 look at if 60B8h asks for it.
            pub touch_probe_sources: [Source; 2],
            /// 2060h to 2063h.
            pub outputs: OutputConfiguration,
            /// 1006h, 2051h, 60C0h, 60C2h and 60C4h.
            pub cyclic: CyclicConfiguration,
            $($(
                #[doc = concat!("Of [`Objects::", stringify!($method), "`].")]
                pub $field: field!($kind $number),
            )?)*
            $($(#[$about_group])* pub $group: $Group,)*
        }

        impl Configuration {
            /// What holds before anything is set up: what CiA 402-2 says.
            pub const NONE: Self = Self {
                units: Units::NONE,
                pulse_timing: PulseTiming::AsBuilt,
                position_limits: (i32::MIN, i32::MAX),
                position_limit_options: PositionLimitOptions::NONE,
                max_velocity: Speed::MAX,
                profile: ProfileConfiguration::NONE,
                velocity: VelocityConfiguration::NONE,
                inputs: InputConfiguration::NONE,
                touch_probe_sources: [Source::Probe1, Source::Probe2],
                outputs: OutputConfiguration::NONE,
                cyclic: CyclicConfiguration::NONE,
                $($($field: plain!($kind $default),)?)*
                $($group: $Group::NONE,)*
            };

            /// Copies field by field.
            #[inline]
            pub(crate) fn assign(&mut self, from: &Self) {
                copy_fields!(Self {
                    units, pulse_timing, position_limits, position_limit_options, max_velocity, profile, velocity, inputs,
                    touch_probe_sources, outputs, cyclic, $($($field,)?)* $($group,)*
                }, from => self);
            }

            /// What the objects of a dictionary say. A code that means nothing (only a data sheet can hold one) counts as the default
            /// of the standard.
            pub fn of<D: Objects>(dictionary: &D) -> Self {
                let units = Units::of(dictionary);
                Self {
                    units,
                    pulse_timing: PulseTiming::of(dictionary),
                    position_limits: (dictionary.min_position_limit(), dictionary.max_position_limit()),
                    position_limit_options: PositionLimitOptions::of(dictionary.position_limit_options()),
                    max_velocity: units
                        .speed(dictionary.max_profile_velocity())
                        .min(units.motor_speed(dictionary.max_motor_speed())),
                    profile: ProfileConfiguration::of(dictionary, &units),
                    velocity: VelocityConfiguration::of(dictionary),
                    inputs: InputConfiguration::of(dictionary),
                    touch_probe_sources: [
                        Source::from_code(dictionary.touch_probe_1_source()).unwrap_or(Source::Probe1),
                        Source::from_code(dictionary.touch_probe_2_source()).unwrap_or(Source::Probe2),
                    ],
                    outputs: OutputConfiguration::of(dictionary),
                    cyclic: CyclicConfiguration::of(dictionary),
                    $($($field: read!($kind, dictionary.$method(), units, Self::NONE.$field),)?)*
                    $($group: $Group::of(dictionary, &units),)*
                }
            }
        }

        $(
            $(#[$about_group])*
            #[derive(Clone, Copy, Debug, PartialEq, Eq)]
            pub struct $Group {
                $($(
                    #[doc = concat!("Of [`Objects::", stringify!($group_method), "`].")]
                    pub $group_field: field!($group_kind $group_number),
                )?)*
            }

            impl $Group {
                /// What holds before anything is set up.
                pub const NONE: Self = Self {
                    $($($group_field: plain!($group_kind $group_default),)?)*
                };

                /// What the objects of a dictionary say.
                #[allow(unused_variables, reason = "few groups have units")]
                fn of<D: Objects>(dictionary: &D, units: &Units) -> Self {
                    Self {
                        $($($group_field: read!($group_kind, dictionary.$group_method(), units, Self::NONE.$group_field),)?)*
                    }
                }
            }
        )*
    };
}

/// The type of a field.
macro_rules! field {
    (plain $number:ident) => {
        $number
    };
    (flag $number:ident) => {
        bool
    };
    (acceleration $number:ident) => {
        u32
    };
    (window $number:ident) => {
        u32
    };
    (($code:ident $meaning:ident) $number:ident) => {
        $code
    };
    ($speed:ident $number:ident) => {
        Speed
    };
}

/// What a default makes, known to the compiler: with it a unit is an increment.
macro_rules! plain {
    (flag $number:expr) => {
        $number == 1
    };
    (speed $number:expr) => {
        Speed::per_second($number)
    };
    (nearest_speed $number:expr) => {
        Speed::per_second($number as u32)
    };
    (($code:ident $meaning:ident) $number:expr) => {
        known($code::$meaning($number))
    };
    ($same:ident $number:expr) => {
        $number
    };
}

/// What a number of a dictionary makes.
macro_rules! read {
    (plain, $number:expr, $units:ident, $default:expr) => {
        $number
    };
    (flag, $number:expr, $units:ident, $default:expr) => {
        $number == 1
    };
    (nearest_speed, $number:expr, $units:ident, $default:expr) => {
        $units.speed_window(u32::try_from($number).unwrap_or(0))
    };
    (($code:ident $meaning:ident), $number:expr, $units:ident, $default:expr) => {
        $code::$meaning($number).unwrap_or($default)
    };
    ($of_units:ident, $number:expr, $units:ident, $default:expr) => {
        $units.$of_units($number)
    };
}

every_parameter!(configuration);

/// A default of the table, which means something.
#[allow(clippy::panic, reason = "only the compiler meets it")]
const fn known<T: Copy>(meaning: Option<T>) -> T {
    match meaning {
        Some(meaning) => meaning,
        None => panic!("a default that means nothing"),
    }
}

impl HomingConfiguration {
    /// What 6064h shows at the home position, in user units: 2030h:1 bit 0 makes it −607Ch instead of +607Ch.
    pub const fn position_at_home(&self) -> i32 {
        if self.has(0) {
            self.offset.wrapping_neg()
        } else {
            self.offset
        }
    }

    /// 2030h:1 bit 8: the position goes on counting behind a search for home, which only makes it known.
    pub const fn keeps_count(&self) -> bool {
        self.has(8)
    }

    /// 2030h:1 bit 7: statusword bit 12 is 0 when the mode is entered, even while the home position is known.
    pub const fn starts_afresh(&self) -> bool {
        self.has(7)
    }

    /// 2030h:1 bit 9: home is the zero of an absolute encoder, and known from power-up.
    pub const fn is_encoder_zero(&self) -> bool {
        self.has(9)
    }

    /// 2030h:1 bits 1 to 6, and the bounds.
    pub const fn settings(&self) -> homing::Settings {
        homing::Settings {
            turns_at_limit: self.has(1),
            is_direct: self.has(2),
            returns: self.has(3),
            last_move_is_fast: self.has(4),
            other_block_signs: self.has(5),
            home_is_backed_off: self.has(6),
            longest_distance: self.longest_distance,
            longest_time: self.longest_time,
            longest_distance_to_index: self.longest_distance_to_index,
            block_time: self.block_time,
            back_off: self.back_off,
        }
    }

    /// An option of 2030h:1. They tell where vendors read the standard in different ways; with 0 in it the drive does what most masters
    /// expect.
    const fn has(&self, option: u32) -> bool {
        self.options & 1 << option != 0
    }
}
