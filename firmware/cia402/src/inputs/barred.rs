//! What limit switches leave of the directions.

use motion::Direction;

/// The directions that limit switches bar.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Barred {
    pub(crate) reverse: bool,
    pub(crate) forward: bool,
}

impl Barred {
    pub(crate) const fn bars(self, direction: Direction) -> bool {
        match direction {
            Direction::Forward => self.forward,
            Direction::Reverse => self.reverse,
        }
    }
}
