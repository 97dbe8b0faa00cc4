//! What the drive offers to be commanded by and to show: its parameters by name.
//!
//! Each parameter has a home, the object that CiA 402-2 gives it, or one of the manufacturer (2030h to 2034h). A data sheet may have other objects
//! for it beside that one or instead of it: a binding (`*.bind.toml`) names the parameter, and `od-gen` checks it against
//! [`ALL`].
//!
//! The crate has nothing but this list and what follows from it, so that `od-gen` reads it without building a drive.
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::indexing_slicing,
        clippy::unreachable
    )
)]

#[cfg(test)]
extern crate std;

mod conversion;
mod features;
mod habits;
mod list;

pub use conversion::Conversion;
pub use features::{Features, TORQUE_MODES};
pub use habits::{Habits, NetworkObjects};

/// The first object of the drive profile. A parameter with a home below it is at home in a data sheet that has such an object with
/// the parameter's name, and in no other.
pub const PROFILE: u16 = 0x6000;

/// Who gives a value.
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

    /// The type with this name in Rust.
    const fn of(name: &str) -> Self {
        match name.as_bytes() {
            b"i8" => Self::I8,
            b"i16" => Self::I16,
            b"i32" => Self::I32,
            b"u8" => Self::U8,
            b"u16" => Self::U16,
            _ => Self::U32,
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
    /// Its name in bindings: that of the method of `cia402::Objects`, without `set_`.
    pub name: &'static str,
    /// Index and sub-index of its object.
    pub home: (u16, u8),
    /// The type of the method.
    pub number: Type,
    /// The unit of its numbers; empty for codes and bits.
    pub unit: &'static str,
    /// The least and the largest number that mean something to the drive.
    pub range: (i64, i64),
    /// Who gives it.
    pub direction: Direction,
}

impl Description {
    const fn is_before(&self, other: &Self) -> bool {
        let ((index, sub), (others_index, others_sub)) = (self.home, other.home);
        index < others_index || index == others_index && sub < others_sub
    }
}

/// Makes [`Parameter`] and [`ALL`] of the table.
macro_rules! parameters {
    ($($(#[$about:meta])* in $group:ident: $Group:ident {$(
        $(#[$doc:meta])* $role:ident $parameter:ident $method:ident $index:literal:$sub:literal
        $number:ident $(or $other:ident)? = $default:expr, $unit:literal
        $(from $least:literal)? $(only $only:tt)? $(locked $lock:ident)? $(=> $field:ident: $kind:tt)?;
    )*})*) => {
        /// A value that the drive takes from the network or shows there.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[allow(missing_docs, reason = "the names are the standard's own")]
        pub enum Parameter {
            $($($parameter,)*)*
        }

        /// Every parameter, by its home.
        pub const ALL: &[Description] = &by_home([
            $($(Description {
                parameter: Parameter::$parameter,
                name: without_set(stringify!($method)),
                home: ($index, $sub),
                number: Type::of(stringify!($number)),
                unit: $unit,
                range: from(Type::of(stringify!($number)).range(), &[$($least)?]),
                direction: direction!($role),
            },)*)*
        ]);

        impl Parameter {
            /// Whether it commands the drive, and is not something that is set up (`cia402::Configuration`).
            pub const fn is_command(self) -> bool {
                match self {
                    $($(Self::$parameter => is_command!($role),)*)*
                }
            }
        }
    };
}

macro_rules! direction {
    (shown) => {
        Direction::Shown
    };
    ($taken:ident) => {
        Direction::Taken
    };
}

macro_rules! is_command {
    (command) => {
        true
    };
    ($other:ident) => {
        false
    };
}

every_parameter!(parameters);

/// The name in bindings of a method.
const fn without_set(method: &str) -> &str {
    match method.as_bytes() {
        [b's', b'e', b't', b'_', ..] => method.split_at(4).1,
        _ => method,
    }
}

/// A range that begins at another number, if there is one.
const fn from(range: (i64, i64), least: &[i64]) -> (i64, i64) {
    match least {
        [least] => (*least, range.1),
        _ => range,
    }
}

/// The same in the order of their homes.
#[allow(clippy::indexing_slicing, reason = "it runs in the compiler")]
const fn by_home<const N: usize>(mut all: [Description; N]) -> [Description; N] {
    let mut sorted = 1;
    while sorted < N {
        let mut place = sorted;
        while place > 0 && all[place].is_before(&all[place - 1]) {
            all.swap(place, place - 1);
            place -= 1;
        }
        sorted += 1;
    }
    all
}

/// Where each parameter is at home, in this order.
#[allow(clippy::indexing_slicing, reason = "it runs in the compiler")]
static HOMES: [(u16, u8, Parameter); ALL.len()] = {
    let mut homes = [(0, 0, Parameter::Controlword); ALL.len()];
    let mut place = 0;
    while place < ALL.len() {
        let Description {
            home: (index, sub),
            parameter,
            ..
        } = ALL[place];
        homes[place] = (index, sub, parameter);
        place += 1;
    }
    homes
};

impl Parameter {
    /// The parameter that is at home in this object.
    pub fn at(index: u16, sub: u8) -> Option<Self> {
        let place = HOMES.binary_search_by_key(&(index, sub), |(index, sub, _)| (*index, *sub));
        Some(HOMES.get(place.ok()?)?.2)
    }

    /// The parameter that is at home in this object of the drive profile. Objects of the manufacturer mean something else in
    /// every device.
    pub fn in_profile(index: u16, sub: u8) -> Option<Self> {
        if index < PROFILE {
            None
        } else {
            Self::at(index, sub)
        }
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
