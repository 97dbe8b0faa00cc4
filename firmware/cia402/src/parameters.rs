//! What the drive offers to be commanded by and to show: its parameters by name.
//!
//! Each parameter has a home in the drive profile, the object that CiA 402-2 gives it. A data sheet may have other objects
//! for it beside that one or instead of it: a binding (`*.bind.toml`) names the parameter, and `od-gen` checks it against
//! [`ALL`].

/// A value that the drive takes from the network or shows there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are the standard's own")]
pub enum Parameter {
    ErrorCode,
    Controlword,
    Statusword,
    QuickStopOptionCode,
    ModesOfOperation,
    ModesOfOperationDisplay,
    PositionDemandValue,
    PositionActualInternalValue,
    PositionActualValue,
    PositionWindow,
    PositionWindowTime,
    TargetPosition,
    MinPositionLimit,
    MaxPositionLimit,
    ProfileVelocity,
    ProfileAcceleration,
    ProfileDeceleration,
    QuickStopDeceleration,
    SupportedDriveModes,
}

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
    /// Index and sub-index in the drive profile.
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

impl Description {
    const fn taken(
        parameter: Parameter,
        name: &'static str,
        home: (u16, u8),
        number: Type,
    ) -> Self {
        Self {
            parameter,
            name,
            home,
            number,
            unit: "",
            range: number.range(),
            direction: Direction::Taken,
        }
    }

    const fn shown(
        parameter: Parameter,
        name: &'static str,
        home: (u16, u8),
        number: Type,
    ) -> Self {
        Self {
            direction: Direction::Shown,
            ..Self::taken(parameter, name, home, number)
        }
    }

    const fn unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// From 1 on: 0 is refused, as a ramp that never gets anywhere.
    const fn positive(self) -> Self {
        Self {
            range: (1, self.range.1),
            ..self
        }
    }
}

/// Every parameter, by its home.
pub const ALL: [Description; 19] = {
    use Parameter as P;
    use Type::{I8, I16, I32, U16, U32};
    type D = Description;
    [
        D::shown(P::ErrorCode, "error_code", (0x603F, 0), U16),
        D::taken(P::Controlword, "controlword", (0x6040, 0), U16),
        D::shown(P::Statusword, "statusword", (0x6041, 0), U16),
        D::taken(
            P::QuickStopOptionCode,
            "quick_stop_option_code",
            (0x605A, 0),
            I16,
        ),
        D::taken(P::ModesOfOperation, "modes_of_operation", (0x6060, 0), I8),
        D::shown(
            P::ModesOfOperationDisplay,
            "modes_of_operation_display",
            (0x6061, 0),
            I8,
        ),
        D::shown(
            P::PositionDemandValue,
            "position_demand_value",
            (0x6062, 0),
            I32,
        )
        .unit("steps"),
        D::shown(
            P::PositionActualInternalValue,
            "position_actual_internal_value",
            (0x6063, 0),
            I32,
        )
        .unit("increments"),
        D::shown(
            P::PositionActualValue,
            "position_actual_value",
            (0x6064, 0),
            I32,
        )
        .unit("steps"),
        D::taken(P::PositionWindow, "position_window", (0x6067, 0), U32).unit("steps"),
        D::taken(
            P::PositionWindowTime,
            "position_window_time",
            (0x6068, 0),
            U16,
        )
        .unit("ms"),
        D::taken(P::TargetPosition, "target_position", (0x607A, 0), I32).unit("steps"),
        D::taken(P::MinPositionLimit, "min_position_limit", (0x607D, 1), I32).unit("steps"),
        D::taken(P::MaxPositionLimit, "max_position_limit", (0x607D, 2), I32).unit("steps"),
        D::taken(P::ProfileVelocity, "profile_velocity", (0x6081, 0), U32).unit("steps/s"),
        D::taken(
            P::ProfileAcceleration,
            "profile_acceleration",
            (0x6083, 0),
            U32,
        )
        .unit("steps/s²")
        .positive(),
        D::taken(
            P::ProfileDeceleration,
            "profile_deceleration",
            (0x6084, 0),
            U32,
        )
        .unit("steps/s²")
        .positive(),
        D::taken(
            P::QuickStopDeceleration,
            "quick_stop_deceleration",
            (0x6085, 0),
            U32,
        )
        .unit("steps/s²")
        .positive(),
        D::taken(
            P::SupportedDriveModes,
            "supported_drive_modes",
            (0x6502, 0),
            U32,
        ),
    ]
};

impl Parameter {
    /// The parameter that is at home in this object of the drive profile.
    pub const fn at(index: u16, sub: u8) -> Option<Self> {
        Some(match (index, sub) {
            (0x603F, 0) => Self::ErrorCode,
            (0x6040, 0) => Self::Controlword,
            (0x6041, 0) => Self::Statusword,
            (0x605A, 0) => Self::QuickStopOptionCode,
            (0x6060, 0) => Self::ModesOfOperation,
            (0x6061, 0) => Self::ModesOfOperationDisplay,
            (0x6062, 0) => Self::PositionDemandValue,
            (0x6063, 0) => Self::PositionActualInternalValue,
            (0x6064, 0) => Self::PositionActualValue,
            (0x6067, 0) => Self::PositionWindow,
            (0x6068, 0) => Self::PositionWindowTime,
            (0x607A, 0) => Self::TargetPosition,
            (0x607D, 1) => Self::MinPositionLimit,
            (0x607D, 2) => Self::MaxPositionLimit,
            (0x6081, 0) => Self::ProfileVelocity,
            (0x6083, 0) => Self::ProfileAcceleration,
            (0x6084, 0) => Self::ProfileDeceleration,
            (0x6085, 0) => Self::QuickStopDeceleration,
            (0x6502, 0) => Self::SupportedDriveModes,
            _ => return None,
        })
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
        let homes = (0x6000..=0x67FF).flat_map(|index| (0..=8).map(move |sub| (index, sub)));
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
