//! The state machine of a drive (CiA 402-2, power drive system FSA): states as the statusword tells them, and the commands that lead on.

use serde::{Deserialize, Serialize};

use crate::message::LegalTransition;

/// A state of the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DriveState {
    /// It starts.
    NotReady,
    /// No power may be switched on.
    SwitchOnDisabled,
    /// Power may be switched on.
    ReadyToSwitchOn,
    /// Power is on, the motor is not.
    SwitchedOn,
    /// The motor follows commands.
    OperationEnabled,
    /// A quick stop is under way, or done.
    QuickStopActive,
    /// It stops because of a fault.
    FaultReactionActive,
    /// It has a fault.
    Fault,
}

impl DriveState {
    /// The state in a statusword; `None` for a word that has none.
    pub fn of(statusword: u16) -> Option<Self> {
        Some(match (statusword & 0x6F, statusword & 0x4F) {
            (0x21, _) => Self::ReadyToSwitchOn,
            (0x23, _) => Self::SwitchedOn,
            (0x27, _) => Self::OperationEnabled,
            (0x07, _) => Self::QuickStopActive,
            (_, 0x00) => Self::NotReady,
            (_, 0x40) => Self::SwitchOnDisabled,
            (_, 0x0F) => Self::FaultReactionActive,
            (_, 0x08) => Self::Fault,
            _ => return None,
        })
    }

    /// Whether the motor may have power.
    pub fn has_power(self) -> bool {
        matches!(
            self,
            Self::OperationEnabled | Self::QuickStopActive | Self::FaultReactionActive
        )
    }

    /// What a master may command here.
    pub fn transitions(self) -> Vec<LegalTransition> {
        use DriveState::*;
        use Transition::*;
        let ways: &[(Transition, DriveState, u8)] = match self {
            SwitchOnDisabled => &[(Shutdown, ReadyToSwitchOn, 2)],
            ReadyToSwitchOn => &[
                (SwitchOn, SwitchedOn, 3),
                (DisableVoltage, SwitchOnDisabled, 7),
            ],
            SwitchedOn => &[
                (EnableOperation, OperationEnabled, 4),
                (Shutdown, ReadyToSwitchOn, 6),
                (DisableVoltage, SwitchOnDisabled, 10),
            ],
            OperationEnabled => &[
                (DisableOperation, SwitchedOn, 5),
                (Shutdown, ReadyToSwitchOn, 8),
                (DisableVoltage, SwitchOnDisabled, 9),
                (QuickStop, QuickStopActive, 11),
            ],
            QuickStopActive => &[
                (DisableVoltage, SwitchOnDisabled, 12),
                (EnableOperation, OperationEnabled, 16),
            ],
            Fault => &[(FaultReset, SwitchOnDisabled, 15)],
            NotReady | FaultReactionActive => &[],
        };
        let legal = ways
            .iter()
            .map(|&(transition, to, number)| LegalTransition {
                transition,
                to,
                label: transition.label(),
                number,
            });
        legal.collect()
    }

    /// The next command on the way to Operation enabled; `None` when it is there, or where a command leads nowhere.
    pub fn towards_enabled(self) -> Option<Transition> {
        match self {
            Self::SwitchOnDisabled => Some(Transition::Shutdown),
            Self::ReadyToSwitchOn => Some(Transition::SwitchOn),
            Self::SwitchedOn => Some(Transition::EnableOperation),
            _ => None,
        }
    }
}

/// A command to the state machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Transition {
    /// Transitions 2, 6 and 8.
    Shutdown,
    /// Transition 3.
    SwitchOn,
    /// Transitions 4 and 16.
    EnableOperation,
    /// Transition 5.
    DisableOperation,
    /// Transitions 7, 9, 10 and 12.
    DisableVoltage,
    /// Transition 11.
    QuickStop,
    /// Transition 15.
    FaultReset,
}

impl Transition {
    /// The controlword that commands it.
    pub fn controlword(self) -> u16 {
        match self {
            Self::Shutdown => 0x06,
            Self::SwitchOn | Self::DisableOperation => 0x07,
            Self::EnableOperation => 0x0F,
            Self::DisableVoltage => 0x00,
            Self::QuickStop => 0x02,
            Self::FaultReset => 0x80,
        }
    }

    /// What a person calls it, in the words of the standard.
    pub fn label(self) -> &'static str {
        match self {
            Self::Shutdown => "Shutdown",
            Self::SwitchOn => "Switch on",
            Self::EnableOperation => "Enable operation",
            Self::DisableOperation => "Disable operation",
            Self::DisableVoltage => "Disable voltage",
            Self::QuickStop => "Quick stop",
            Self::FaultReset => "Fault reset",
        }
    }
}

/// The modes of CiA 402 by their number in 6060h, and their names; bit `number - 1` of 6502h says that a drive knows one.
pub const MODES: [(i8, &str); 10] = [
    (1, "Profile position"),
    (2, "Velocity"),
    (3, "Profile velocity"),
    (4, "Torque profile"),
    (6, "Homing"),
    (7, "Interpolated position"),
    (8, "Cyclic synchronous position"),
    (9, "Cyclic synchronous velocity"),
    (10, "Cyclic synchronous torque"),
    (11, "Cyclic synchronous torque with commutation angle"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_state_is_told_by_its_statusword() {
        let states = [
            (0x0000, DriveState::NotReady),
            (0x0250, DriveState::SwitchOnDisabled),
            (0x0231, DriveState::ReadyToSwitchOn),
            (0x0233, DriveState::SwitchedOn),
            (0x1637, DriveState::OperationEnabled),
            (0x0217, DriveState::QuickStopActive),
            (0x021F, DriveState::FaultReactionActive),
            (0x0218, DriveState::Fault),
        ];
        for (word, state) in states {
            assert_eq!(DriveState::of(word), Some(state), "{word:04X}");
        }
        assert_eq!(DriveState::of(0x004F), None);
    }

    #[test]
    fn the_way_to_enabled_is_made_of_legal_transitions() {
        let mut state = DriveState::SwitchOnDisabled;
        let mut steps = 0;
        while let Some(next) = state.towards_enabled() {
            let legal = state.transitions();
            let way = legal.iter().find(|way| way.transition == next).unwrap();
            state = way.to;
            steps += 1;
        }
        assert_eq!((state, steps), (DriveState::OperationEnabled, 3));
    }
}
