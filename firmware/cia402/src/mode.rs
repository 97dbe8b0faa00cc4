//! The modes of operation by name and number.

/// A mode of operation, with its number in 6060h and 6061h.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i8)]
pub enum Mode {
    /// No mode: the motor holds its position.
    NoMode = 0,
    /// Profile position: the motor goes to set-points, each on its own profile.
    ProfilePosition = 1,
    /// Velocity ("vl"): the motor keeps a velocity, as frequency converters do.
    Velocity = 2,
    /// Profile velocity: the motor keeps a velocity.
    ProfileVelocity = 3,
    /// Profile torque: the motor holds a torque.
    ProfileTorque = 4,
    /// Homing: the motor looks for where zero is.
    Homing = 6,
    /// Interpolated position: the motor goes through data records, one in each period.
    InterpolatedPosition = 7,
    /// Cyclic synchronous position: the master gives a position in each period.
    CyclicPosition = 8,
    /// Cyclic synchronous velocity: the master gives a velocity in each period.
    CyclicVelocity = 9,
    /// Cyclic synchronous torque: the master gives a torque in each period.
    CyclicTorque = 10,
}

impl Mode {
    /// Every mode of this firmware.
    pub const ALL: [Self; 10] = [
        Self::NoMode,
        Self::ProfilePosition,
        Self::Velocity,
        Self::ProfileVelocity,
        Self::ProfileTorque,
        Self::Homing,
        Self::InterpolatedPosition,
        Self::CyclicPosition,
        Self::CyclicVelocity,
        Self::CyclicTorque,
    ];

    /// The mode with this number; `None` if it is not supported.
    pub const fn from_code(code: i8) -> Option<Self> {
        match code {
            0 => Some(Self::NoMode),
            1 => Some(Self::ProfilePosition),
            2 => Some(Self::Velocity),
            3 => Some(Self::ProfileVelocity),
            4 => Some(Self::ProfileTorque),
            6 => Some(Self::Homing),
            7 => Some(Self::InterpolatedPosition),
            8 => Some(Self::CyclicPosition),
            9 => Some(Self::CyclicVelocity),
            10 => Some(Self::CyclicTorque),
            _ => None,
        }
    }

    /// The mode with this number that a drive with these modes (bits as in 6502h) has. No mode is always there.
    pub fn among(modes: u32, code: i8) -> Option<Self> {
        Self::from_code(code).filter(|mode| mode.is_among(modes))
    }

    /// Whether a drive with these modes has it.
    pub const fn is_among(self, modes: u32) -> bool {
        modes & self.supported_bit() == self.supported_bit()
    }

    /// Its number.
    pub const fn code(self) -> i8 {
        self as i8
    }

    /// Its bit in 6502h, "supported drive modes"; 0 for no mode, which every drive has.
    pub const fn supported_bit(self) -> u32 {
        match self {
            Self::NoMode => 0,
            Self::ProfilePosition => 1 << 0,
            Self::Velocity => 1 << 1,
            Self::ProfileVelocity => 1 << 2,
            Self::ProfileTorque => 1 << 3,
            Self::Homing => 1 << 5,
            Self::InterpolatedPosition => 1 << 6,
            Self::CyclicPosition => 1 << 7,
            Self::CyclicVelocity => 1 << 8,
            Self::CyclicTorque => 1 << 9,
        }
    }

    /// Whether 6086h counts in the mode.
    pub(crate) const fn has_profile(self) -> bool {
        matches!(
            self,
            Self::ProfilePosition | Self::Velocity | Self::ProfileVelocity
        )
    }

    /// Whether the mode may begin while the motor moves: it goes on from there.
    pub(crate) const fn begins_in_motion(self) -> bool {
        match self {
            Self::NoMode
            | Self::ProfilePosition
            | Self::Homing
            | Self::InterpolatedPosition
            | Self::CyclicPosition => false,
            Self::Velocity
            | Self::ProfileVelocity
            | Self::ProfileTorque
            | Self::CyclicVelocity
            | Self::CyclicTorque => true,
        }
    }

    /// Whether the mode goes by the sync events of the network.
    pub(crate) const fn is_cyclic(self) -> bool {
        matches!(
            self,
            Self::InterpolatedPosition
                | Self::CyclicPosition
                | Self::CyclicVelocity
                | Self::CyclicTorque
        )
    }

    /// Whether the mode follows positions, and so tells of a following error.
    pub(crate) const fn has_following_error(self) -> bool {
        matches!(
            self,
            Self::ProfilePosition | Self::InterpolatedPosition | Self::CyclicPosition
        )
    }
}
