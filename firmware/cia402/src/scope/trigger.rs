//! What begins a recording: an edge of a value.
//!
//! Without a mask the value is a number, and the edge lies where it crosses the level. With one it is a set of bits, and the edge
//! lies where the first of them is set, or the last one is cleared.

use super::Signal;

/// The direction in which the value passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Edge {
    /// From below the level to the level or above it.
    Rising,
    /// From the level or above it to below the level.
    Falling,
    /// Both.
    Either,
}

impl Edge {
    /// What 20D2h:2 says.
    pub const fn from_code(code: u8) -> Option<Self> {
        match code {
            1 => Some(Self::Rising),
            2 => Some(Self::Falling),
            3 => Some(Self::Either),
            _ => None,
        }
    }
}

/// An edge to wait for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Trigger {
    /// The value to look at; `None` waits for an order alone.
    pub signal: Option<Signal>,
    /// Which edge of it.
    pub edge: Edge,
    /// The level, in the unit of the value. Without meaning beside a mask.
    pub level: i32,
    /// The bits to look at; 0 for the whole value as a number.
    pub mask: u32,
}

impl Trigger {
    /// An order alone.
    pub const NONE: Self = Self {
        signal: None,
        edge: Edge::Rising,
        level: 0,
        mask: 0,
    };

    /// Whether the value is on the upper side.
    pub(crate) fn is_high(&self, signal: Signal, bits: u32) -> bool {
        if self.mask == 0 {
            signal.number(bits) >= self.level.into()
        } else {
            bits & self.mask != 0
        }
    }

    /// Whether this is the edge.
    pub(crate) const fn is_edge(&self, was_high: bool, is_high: bool) -> bool {
        match self.edge {
            Edge::Rising => !was_high && is_high,
            Edge::Falling => was_high && !is_high,
            Edge::Either => was_high != is_high,
        }
    }
}
