//! How the digital outputs are set up (2060h to 2063h).

use crate::objects::Objects;

/// How many outputs there may be.
pub const COUNT: usize = 4;

/// The bits of all outputs.
pub(crate) const ALL: u8 = (1 << COUNT) - 1;
/// What an output shows, 2060h.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum OutputFunction {
    /// 0: what the master sets in 60FEh.
    Manual = 0,
    /// 1: there is a fault (states fault reaction active and fault).
    Fault = 1,
    /// 2: there is a warning, statusword bit 7.
    Warning = 2,
    /// 3: operation enabled.
    OperationEnabled = 3,
    /// 4: target reached, statusword bit 10.
    TargetReached = 4,
    /// 5: the home position is known.
    Referenced = 5,
    /// 6: the motor moves.
    Moving = 6,
    /// 7: an internal limit is active, statusword bit 11.
    Limit = 7,
    /// 8: the holding brake is open.
    BrakeReleased = 8,
}

impl OutputFunction {
    /// Every function.
    pub const ALL: [Self; 9] = [
        Self::Manual,
        Self::Fault,
        Self::Warning,
        Self::OperationEnabled,
        Self::TargetReached,
        Self::Referenced,
        Self::Moving,
        Self::Limit,
        Self::BrakeReleased,
    ];

    /// The function with this number; `None` if there is none.
    #[inline(never)]
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|function| *function as u8 == code)
    }
}

/// How the outputs are set up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OutputConfiguration {
    /// 2060h: what outputs 1 to 4 show.
    pub functions: [OutputFunction; COUNT],
    /// 2061h: these outputs are low where they would be high.
    pub inverted: u8,
    /// 2062h: these outputs stay as they are when the network is lost.
    pub kept: u8,
    /// 2063h: 60FEh may move the brake.
    pub is_brake_manual: bool,
}

impl OutputConfiguration {
    /// What holds before anything is set up: the outputs are the master's.
    pub const NONE: Self = Self {
        functions: [OutputFunction::Manual; COUNT],
        inverted: 0,
        kept: 0,
        is_brake_manual: false,
    };

    /// What the objects say. A number that is no function counts as the master's.
    pub(crate) fn of<D: Objects>(dictionary: &D) -> Self {
        let functions = [
            dictionary.output_1_function(),
            dictionary.output_2_function(),
            dictionary.output_3_function(),
            dictionary.output_4_function(),
        ];
        Self {
            functions: functions
                .map(|code| OutputFunction::from_code(code).unwrap_or(OutputFunction::Manual)),
            inverted: dictionary.outputs_inverted() & ALL,
            kept: dictionary.outputs_kept() & ALL,
            is_brake_manual: dictionary.brake_control() == 1,
        }
    }
}
