//! The drive objects as the firmware sees them. `od-gen` implements this trait for a dictionary from its data sheet: a type
//! that differs from the one here is a compile error, and an object the data sheet leaves out takes the value here. With a
//! binding (`*.bind.toml`) the values come from other objects, in other units; the drive does not notice.

use canopen::cia301::sdo::AbortCode;
use canopen::od::Entry;

use cia402_parameters::{Features, Habits, Parameter, every_parameter};

/// Makes the trait of the table: a getter with the value that counts where a data sheet leaves the object out, or a setter that does
/// nothing there.
macro_rules! objects {
    ($($(#[$about:meta])* in $group:ident: $Group:ident {$(
        $(#[$doc:meta])* $role:ident $parameter:ident $method:ident $index:literal:$sub:literal
        $number:ident $(or $other:ident)? = $default:expr, $unit:literal
        $(from $least:literal)? $(only $only:tt)? $(locked $lock:ident)? $(=> $field:ident: $kind:tt)?;
    )*})*) => {
        /// Typed access to the CiA 402 objects of a dictionary. Getters read what a master wrote; setters publish what the
        /// drive does. Units are the user units of CiA 402-2 ([`crate::units`]); with no factor group they are increments (steps),
        /// steps/s and steps/s².
        pub trait Objects {
            /// What the drive has.
            const DRIVE: Features = Features::ALL;

            /// What the drive does otherwise than the standard says, as its manufacturer's drives do.
            const DRIVE_HABITS: Habits = Habits::STANDARD;

            /// The data sheet, which 1021h gives to whoever asks; empty where there is no such object.
            const DATA_SHEET: &'static [u8] = &[];

            /// What it does that is no data (a [`Behaviour`](crate::Behaviour)); `()` for nothing.
            type Behaviour;

            $($(object! {
                #[doc = concat!("Object ", stringify!($index), ":", $sub, ". ")]
                $(#[$doc])*
                $role $method $number $(or $other)? = $default
            })*)*

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

            /// Error codes that status words of the manufacturer show as bits, at most 32.
            const TOLD_ERRORS: &'static [u16] = &[];

            /// Writes the status words of the manufacturer from the present state of the drive.
            fn show_status(&mut self, status: &DriveStatus) {
                let _ = status;
            }

            /// Values were loaded: objects that stand for the same parameter follow the one the drive reads.
            fn agree(&mut self) {}
        }
    };
}

macro_rules! object {
    ($(#[$doc:meta])* $role:ident $getter:ident $number:ident or $other:ident = $default:expr) => {
        $(#[$doc])*
        fn $getter(&self) -> $number {
            self.$other()
        }
    };
    ($(#[$doc:meta])* shown $setter:ident $number:ident = $nothing:expr) => {
        $(#[$doc])*
        fn $setter(&mut self, value: $number) {
            let _ = value;
        }
    };
    ($(#[$doc:meta])* $role:ident $getter:ident $number:ident = $default:expr) => {
        $(#[$doc])*
        fn $getter(&self) -> $number {
            $default
        }
    };
}

every_parameter!(objects);

/// The state of the drive from which the bits of a manufacturer's status words are made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DriveStatus {
    /// 6041h.
    pub statusword: u16,
    /// 60FDh.
    pub inputs: u32,
    /// The motor has power.
    pub has_power: bool,
    /// The position is referenced.
    pub is_referenced: bool,
    /// The motor moves.
    pub is_moving: bool,
    /// The mode of operation at work.
    pub mode: i8,
    /// Which of [`Objects::TOLD_ERRORS`] stand, a bit for each.
    pub errors: u32,
}

/// The objects of a drive that has everything, for those who have no data sheet.
#[derive(Clone, Copy, Debug, Default)]
pub struct Everything;

impl Objects for Everything {
    type Behaviour = ();
}
