//! What may be written to a parameter, in its own unit, and when not.

use canopen::cia301::sdo::AbortCode;
use motion::homing::Method;

use crate::inputs::{InputFunction, Source, probe_functions};
use crate::mode::Mode;
use crate::objects::Objects;
use crate::option_codes::{AbortConnectionOption, QuickStopOption, Stop, StopRamp};
use crate::outputs::OutputFunction;
use crate::profile;
use crate::pulse_timing::PulseTiming;
use crate::units::{Factors, SiUnit, Units};
use cia402_parameters::{Parameter, every_parameter};

/// 60F2h: what relative set-points count from, and in which direction a rotary axis goes.
const POSITIONING_OPTIONS: i64 = 0b1100_0011;
/// 607Eh: of positions and of velocities.
const POLARITIES: i64 = 0b1100_0000;

/// When a parameter cannot be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lock {
    /// While the power stage is on: what a position, a velocity or a torque means, what the motor is, and what its driver needs.
    Powered,
    /// While the motor moves: what a set-point in each period means.
    Moving,
}

/// Makes the rules of the table.
macro_rules! rules {
    ($($(#[$about:meta])* in $group:ident: $Group:ident {$(
        $(#[$doc:meta])* $role:ident $parameter:ident $method:ident $index:literal:$sub:literal
        $number:ident $(or $other:ident)? = $default:expr, $unit:literal
        $(from $least:literal)? $(only $only:tt)? $(locked $lock:ident)? $(=> $field:ident: $kind:tt)?;
    )*})*) => {
        /// Whether a number means something.
        fn has_meaning(parameter: Parameter, number: i64) -> bool {
            match parameter {
                $($(Parameter::$parameter => rule!(number, $(only $only)? $($kind)?),)*)*
            }
        }

        /// The least number.
        const fn least(parameter: Parameter) -> i64 {
            match parameter {
                $($($(Parameter::$parameter => $least,)?)*)*
                _ => i64::MIN,
            }
        }

        /// When it is locked.
        pub(crate) const fn lock(parameter: Parameter) -> Option<Lock> {
            match parameter {
                $($($(Parameter::$parameter => Some(Lock::$lock),)?)*)*
                _ => None,
            }
        }
    };
}

macro_rules! rule {
    ($number:ident, only ($($only:tt)+) $($kind:tt)?) => {
        matches!($number, $($only)+)
    };
    ($number:ident, only [$($meaning:tt)+] $($kind:tt)?) => {
        means($number, $($meaning)+)
    };
    ($number:ident, ($code:ident $meaning:ident)) => {
        means($number, $code::$meaning)
    };
    ($number:ident, $($kind:ident)?) => {
        true
    };
}

every_parameter!(rules);

/// What the drive says to a new number of a parameter.
pub(crate) fn check<D: Objects>(
    parameter: Parameter,
    number: i64,
    dictionary: &D,
    modes: u32,
) -> Result<(), AbortCode> {
    // A mode is there if this firmware, its actuator, the data sheet and 6502h have it.
    let modes = modes & D::DRIVE.modes & dictionary.supported_drive_modes();
    let is_offered = parameter != Parameter::ModesOfOperation
        || i8::try_from(number).is_ok_and(|code| Mode::among(modes, code).is_some());
    if !is_offered || !has_meaning(parameter, number) {
        return Err(AbortCode::InvalidValue);
    }
    if D::DRIVE.units && Factors::has(parameter) {
        return factor(parameter, number, dictionary);
    }
    if number < least(parameter) {
        return Err(AbortCode::ValueTooLow);
    }
    Ok(())
}

/// A factor is not 0, and the factors make ratios that can be represented.
fn factor<D: Objects>(parameter: Parameter, number: i64, dictionary: &D) -> Result<(), AbortCode> {
    let number = u32::try_from(number)
        .ok()
        .filter(|number| i64::from(*number) >= least(parameter))
        .ok_or(AbortCode::InvalidValue)?;
    Units::new(Factors::of(dictionary).with(parameter, number))
        .map(|_| ())
        .ok_or(AbortCode::ParameterIncompatible)
}

/// Whether a number is a code that means something.
fn means<N: TryFrom<i64>, T>(number: i64, meaning: fn(N) -> Option<T>) -> bool {
    N::try_from(number).ok().and_then(meaning).is_some()
}

/// Whether a name of a unit is one of its kind.
fn is_named(number: i64, unit: SiUnit) -> bool {
    u32::try_from(number).is_ok_and(|value| unit.is_named_by(value))
}
