//! The data types of CiA 301 that a dictionary can hold.

/// A data type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are the standard's own")]
pub enum DataType {
    Boolean,
    Integer8,
    Integer16,
    Integer32,
    Integer64,
    Unsigned8,
    Unsigned16,
    Unsigned32,
    Unsigned64,
    VisibleString,
    OctetString,
}

impl DataType {
    /// All of them.
    pub const ALL: [Self; 11] = [
        Self::Boolean,
        Self::Integer8,
        Self::Integer16,
        Self::Integer32,
        Self::Integer64,
        Self::Unsigned8,
        Self::Unsigned16,
        Self::Unsigned32,
        Self::Unsigned64,
        Self::VisibleString,
        Self::OctetString,
    ];

    /// The type with this number in the object dictionary (CiA 301, table 44).
    pub fn from_code(code: i128) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|data_type| i128::from(data_type.code()) == code)
    }

    /// Its number in the object dictionary.
    pub fn code(self) -> u16 {
        match self {
            Self::Boolean => 0x01,
            Self::Integer8 => 0x02,
            Self::Integer16 => 0x03,
            Self::Integer32 => 0x04,
            Self::Unsigned8 => 0x05,
            Self::Unsigned16 => 0x06,
            Self::Unsigned32 => 0x07,
            Self::VisibleString => 0x09,
            Self::OctetString => 0x0A,
            Self::Integer64 => 0x15,
            Self::Unsigned64 => 0x1B,
        }
    }

    /// The name the standard gives it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Boolean => "BOOLEAN",
            Self::Integer8 => "INTEGER8",
            Self::Integer16 => "INTEGER16",
            Self::Integer32 => "INTEGER32",
            Self::Integer64 => "INTEGER64",
            Self::Unsigned8 => "UNSIGNED8",
            Self::Unsigned16 => "UNSIGNED16",
            Self::Unsigned32 => "UNSIGNED32",
            Self::Unsigned64 => "UNSIGNED64",
            Self::VisibleString => "VISIBLE_STRING",
            Self::OctetString => "OCTET_STRING",
        }
    }

    /// Length in bytes; `None` for strings.
    pub fn size(self) -> Option<u16> {
        match self {
            Self::Boolean | Self::Integer8 | Self::Unsigned8 => Some(1),
            Self::Integer16 | Self::Unsigned16 => Some(2),
            Self::Integer32 | Self::Unsigned32 => Some(4),
            Self::Integer64 | Self::Unsigned64 => Some(8),
            Self::VisibleString | Self::OctetString => None,
        }
    }

    /// The numbers the type can hold; `None` for strings.
    pub fn range(self) -> Option<(i128, i128)> {
        let bits = u32::from(self.size()?) * 8;
        Some(match self {
            Self::Boolean => (0, 1),
            _ if self.is_signed() => (-(1 << (bits - 1)), (1 << (bits - 1)) - 1),
            _ => (0, (1 << bits) - 1),
        })
    }

    /// Whether it holds negative numbers.
    pub fn is_signed(self) -> bool {
        matches!(
            self,
            Self::Integer8 | Self::Integer16 | Self::Integer32 | Self::Integer64
        )
    }
}
