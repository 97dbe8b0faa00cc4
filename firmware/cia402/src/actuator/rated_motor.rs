//! What is known of a motor, for its axis.

/// The motor that a board is built for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RatedMotor {
    /// In mA.
    pub current: u32,
    /// The torque of that current, in mN·m.
    pub torque: u32,
    /// With what is fixed to it, in g·mm².
    pub inertia: u32,
    /// Positions in a turn.
    pub counts: u32,
}

impl RatedMotor {
    /// Nothing is known of it.
    pub const NONE: Self = Self {
        current: 0,
        torque: 0,
        inertia: 0,
        counts: 0,
    };

    /// This, with the other's numbers where it has none.
    pub(super) const fn or(self, other: Self) -> Self {
        const fn number(own: u32, other: u32) -> u32 {
            if own == 0 { other } else { own }
        }
        Self {
            current: number(self.current, other.current),
            torque: number(self.torque, other.torque),
            inertia: number(self.inertia, other.inertia),
            counts: number(self.counts, other.counts),
        }
    }
}
