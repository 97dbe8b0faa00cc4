//! What the drives of a maker do in their own way where CiA 402-2 says otherwise or leaves it open, known when the drive is compiled.

/// The ways of a drive: [`Habits::STANDARD`], unless the binding of its data sheet says otherwise. The rule that a habit changes
/// asks for it, and costs nothing where it is the standard's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Habits {
    /// Bit 4 of the statusword is 1 from switched on on, and not as soon as there is a supply.
    pub voltage_needs_power: bool,
    /// Bit 5 of the statusword is 1 in switch on disabled: no quick stop is active. CiA 402-2 leaves it open there.
    pub quick_stop_bit_while_disabled: bool,
}

impl Habits {
    /// As CiA 402-2 says.
    pub const STANDARD: Self = Self {
        voltage_needs_power: false,
        quick_stop_bit_while_disabled: false,
    };
}
