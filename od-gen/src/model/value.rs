//! Defaults and limits.

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

/// LowLimit or HighLimit.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub enum Limit {
    /// Of an integer.
    Integer(i128),
    /// Of a REAL32 or REAL64.
    Real(f64),
}

impl Limit {
    /// The limit of an integer.
    pub fn integer(self) -> Option<i128> {
        match self {
            Self::Integer(value) => Some(value),
            Self::Real(_) => None,
        }
    }
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Integer(value) => value.fmt(f),
            Self::Real(value) => value.fmt(f),
        }
    }
}
