//! The quick stop option code 605Ah: how the motor is stopped, and where the state machine goes afterwards.

/// The supported values of 605Ah (CiA 402-2, "quick stop option code"). 3 and 7 (current limit), 4 and 8 (voltage
/// limit) make no sense for an open-loop stepper: writing them is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i16)]
pub enum QuickStopOption {
    /// 0: the power goes off at once, then switch on disabled.
    DisableDrive = 0,
    /// 1: slow down with 6084h, then switch on disabled.
    SlowDownRamp = 1,
    /// 2: slow down with 6085h, then switch on disabled.
    QuickStopRamp = 2,
    /// 5: slow down with 6084h and stay in quick stop active.
    SlowDownRampAndStay = 5,
    /// 6: slow down with 6085h and stay in quick stop active.
    QuickStopRampAndStay = 6,
}

/// The deceleration a stop uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopRamp {
    /// Profile deceleration 6084h.
    SlowDown,
    /// Quick stop deceleration 6085h.
    QuickStop,
}

impl QuickStopOption {
    /// The option with this code; `None` if it is not supported.
    pub const fn from_code(code: i16) -> Option<Self> {
        match code {
            0 => Some(Self::DisableDrive),
            1 => Some(Self::SlowDownRamp),
            2 => Some(Self::QuickStopRamp),
            5 => Some(Self::SlowDownRampAndStay),
            6 => Some(Self::QuickStopRampAndStay),
            _ => None,
        }
    }

    /// The ramp; `None` if the power goes off instead.
    pub const fn ramp(self) -> Option<StopRamp> {
        match self {
            Self::DisableDrive => None,
            Self::SlowDownRamp | Self::SlowDownRampAndStay => Some(StopRamp::SlowDown),
            Self::QuickStopRamp | Self::QuickStopRampAndStay => Some(StopRamp::QuickStop),
        }
    }

    /// Whether the drive stays in quick stop active once the motor stands.
    pub const fn stays(self) -> bool {
        matches!(self, Self::SlowDownRampAndStay | Self::QuickStopRampAndStay)
    }
}
