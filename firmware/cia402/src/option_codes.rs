//! The option codes of CiA 402-2: how the motor is stopped on each occasion, and where the state machine goes afterwards.
//!
//! "Current limit" and "voltage limit" in these codes mean the hardest stop that the motor can follow. An open-loop stepper that is
//! asked for more torque than it has loses steps instead of slipping, so for it that is the quick stop ramp.

/// A ramp to stop on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopRamp {
    /// The slow down ramp: profile deceleration 6084h; in the velocity mode 6049h.
    SlowDown,
    /// The quick stop ramp: 6085h; in the velocity mode 604Ah.
    QuickStop,
    /// At the current limit: for a stepper the quick stop ramp.
    CurrentLimit,
    /// At the voltage limit: for a stepper the quick stop ramp too.
    VoltageLimit,
}

impl StopRamp {
    /// What a code of the halt option 605Dh asks for: 1 to 4.
    pub const fn on_halt(code: i16) -> Option<Self> {
        match code {
            1 => Some(Self::SlowDown),
            2 => Some(Self::QuickStop),
            3 => Some(Self::CurrentLimit),
            4 => Some(Self::VoltageLimit),
            _ => None,
        }
    }
}

/// How operation ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// The power goes off at once; the motor is free to turn.
    PowerOff,
    /// The motor slows down first.
    Ramp(StopRamp),
}

impl Stop {
    /// What a code of the shutdown option 605Bh or of the disable operation option 605Ch asks for: 0 or 1.
    pub const fn on_leaving(code: i16) -> Option<Self> {
        match code {
            0 => Some(Self::PowerOff),
            1 => Some(Self::Ramp(StopRamp::SlowDown)),
            _ => None,
        }
    }

    /// What a code of the fault reaction option 605Eh asks for: 0 to 4.
    pub const fn on_fault(code: i16) -> Option<Self> {
        match (code, StopRamp::on_halt(code)) {
            (0, _) => Some(Self::PowerOff),
            (_, Some(ramp)) => Some(Self::Ramp(ramp)),
            _ => None,
        }
    }
}

/// The quick stop option 605Ah.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i16)]
pub enum QuickStopOption {
    /// 0: the power goes off at once, then switch on disabled.
    DisableDrive = 0,
    /// 1: slow down on the slow down ramp, then switch on disabled.
    SlowDownRamp = 1,
    /// 2: slow down on the quick stop ramp, then switch on disabled.
    QuickStopRamp = 2,
    /// 3: slow down at the current limit, then switch on disabled.
    CurrentLimit = 3,
    /// 4: slow down at the voltage limit, then switch on disabled.
    VoltageLimit = 4,
    /// 5: slow down on the slow down ramp and stay in quick stop active.
    SlowDownRampAndStay = 5,
    /// 6: slow down on the quick stop ramp and stay in quick stop active.
    QuickStopRampAndStay = 6,
    /// 7: slow down at the current limit and stay in quick stop active.
    CurrentLimitAndStay = 7,
    /// 8: slow down at the voltage limit and stay in quick stop active.
    VoltageLimitAndStay = 8,
}

impl QuickStopOption {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::DisableDrive,
        Self::SlowDownRamp,
        Self::QuickStopRamp,
        Self::CurrentLimit,
        Self::VoltageLimit,
        Self::SlowDownRampAndStay,
        Self::QuickStopRampAndStay,
        Self::CurrentLimitAndStay,
        Self::VoltageLimitAndStay,
    ];

    /// The option with this code; `None` if it is not supported.
    pub const fn from_code(code: i16) -> Option<Self> {
        let mut options: &[Self] = &Self::ALL;
        while let [option, rest @ ..] = options {
            if *option as i16 == code {
                return Some(*option);
            }
            options = rest;
        }
        None
    }

    /// How the motor is stopped.
    pub const fn stop(self) -> Stop {
        match self {
            Self::DisableDrive => Stop::PowerOff,
            Self::SlowDownRamp | Self::SlowDownRampAndStay => Stop::Ramp(StopRamp::SlowDown),
            Self::QuickStopRamp | Self::QuickStopRampAndStay => Stop::Ramp(StopRamp::QuickStop),
            Self::CurrentLimit | Self::CurrentLimitAndStay => Stop::Ramp(StopRamp::CurrentLimit),
            Self::VoltageLimit | Self::VoltageLimitAndStay => Stop::Ramp(StopRamp::VoltageLimit),
        }
    }

    /// Whether the drive stays in quick stop active once the motor stands.
    pub const fn stays(self) -> bool {
        matches!(
            self,
            Self::SlowDownRampAndStay
                | Self::QuickStopRampAndStay
                | Self::CurrentLimitAndStay
                | Self::VoltageLimitAndStay
        )
    }
}

/// The abort connection option 6007h: what the loss of the network does to a drive that has power.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i16)]
pub enum AbortConnectionOption {
    /// 0: nothing; the motor goes on with what it does.
    NoAction = 0,
    /// 1: a fault, with the reaction of 605Eh.
    FaultSignal = 1,
    /// 2: as the command "disable voltage".
    DisableVoltage = 2,
    /// 3: as the command "quick stop" with 605Ah = 2, whatever 605Ah is: the power goes off at the end.
    QuickStop = 3,
}

impl AbortConnectionOption {
    /// The option with this code; `None` if it is not supported.
    pub const fn from_code(code: i16) -> Option<Self> {
        match code {
            0 => Some(Self::NoAction),
            1 => Some(Self::FaultSignal),
            2 => Some(Self::DisableVoltage),
            3 => Some(Self::QuickStop),
            _ => None,
        }
    }
}
