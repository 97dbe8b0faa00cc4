//! Defaults and limits.

use std::cmp::Ordering;
use std::fmt;

/// A value at power-on, or one that a DCF configures.
#[derive(Clone, Debug, PartialEq)]
pub enum DefaultValue {
    /// Of an integer, a BOOLEAN or a time (its 48 bits as a number).
    Number {
        /// The number in the data sheet.
        value: i128,
        /// Whether the node-ID is added to it.
        adds_node_id: bool,
    },
    /// Of a REAL32 or REAL64.
    Real(f64),
    /// Of a string: its bytes on the bus. A UNICODE_STRING has two bytes a letter, the low one first. Empty for a DOMAIN.
    Text(Vec<u8>),
}

impl DefaultValue {
    /// A number without the node-ID.
    pub fn number(value: i128) -> Self {
        Self::Number {
            value,
            adds_node_id: false,
        }
    }

    /// Whether the node-ID is added to it.
    pub fn adds_node_id(&self) -> bool {
        matches!(
            self,
            Self::Number {
                adds_node_id: true,
                ..
            }
        )
    }
}

/// LowLimit or HighLimit. Those of one kind have an order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// Of an integer.
    Integer(i128),
    /// Of an integer, with the node-ID added.
    NodeId(i128),
    /// Of a REAL32 or REAL64.
    Real(f64),
}

impl Limit {
    /// The limit of an integer, where it is the same for every node-ID.
    pub fn integer(self) -> Option<i128> {
        match self {
            Self::Integer(value) => Some(value),
            Self::NodeId(_) | Self::Real(_) => None,
        }
    }

    /// What it is in a node with this node-ID.
    pub fn of_node(self, node_id: u8) -> Self {
        match self {
            Self::NodeId(value) => Self::Integer(value.saturating_add(node_id.into())),
            other => other,
        }
    }
}

impl PartialOrd for Limit {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        match (self, other) {
            (Self::Integer(own), Self::Integer(other))
            | (Self::NodeId(own), Self::NodeId(other)) => own.partial_cmp(other),
            (Self::Real(own), Self::Real(other)) => own.partial_cmp(other),
            _ => None,
        }
    }
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Integer(value) => value.fmt(f),
            Self::NodeId(0) => f.write_str("node-ID"),
            Self::NodeId(value) => write!(f, "{value:X}h + node-ID"),
            Self::Real(value) => value.fmt(f),
        }
    }
}
