//! What limit switches forbid.

use motion::Direction;

/// The directions in which a limit switch is active: no motion goes on there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct ActiveLimits {
    pub(crate) reverse: bool,
    pub(crate) forward: bool,
}

impl ActiveLimits {
    pub(crate) const fn block(self, direction: Direction) -> bool {
        match direction {
            Direction::Forward => self.forward,
            Direction::Reverse => self.reverse,
        }
    }
}
