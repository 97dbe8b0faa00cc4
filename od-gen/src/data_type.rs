//! The data types of CiA 301 that a value can have.

/// A data type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[allow(missing_docs, reason = "the names are the standard's own")]
pub enum DataType {
    Boolean,
    Integer8,
    Integer16,
    Integer24,
    Integer32,
    Integer40,
    Integer48,
    Integer56,
    Integer64,
    Unsigned8,
    Unsigned16,
    Unsigned24,
    Unsigned32,
    Unsigned40,
    Unsigned48,
    Unsigned56,
    Unsigned64,
    Real32,
    Real64,
    VisibleString,
    OctetString,
    UnicodeString,
    TimeOfDay,
    TimeDifference,
    Domain,
}

/// How the bytes of a type are to be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Boolean,
    Signed,
    Unsigned,
    Real,
    Text,
    Time,
    Domain,
}

/// Number in the object dictionary, name, kind and bytes (CiA 301, table 44).
const TYPES: [(DataType, u16, &str, Kind, u16); 25] = {
    use DataType as T;
    use Kind as K;
    [
        (T::Boolean, 0x01, "BOOLEAN", K::Boolean, 1),
        (T::Integer8, 0x02, "INTEGER8", K::Signed, 1),
        (T::Integer16, 0x03, "INTEGER16", K::Signed, 2),
        (T::Integer24, 0x10, "INTEGER24", K::Signed, 3),
        (T::Integer32, 0x04, "INTEGER32", K::Signed, 4),
        (T::Integer40, 0x12, "INTEGER40", K::Signed, 5),
        (T::Integer48, 0x13, "INTEGER48", K::Signed, 6),
        (T::Integer56, 0x14, "INTEGER56", K::Signed, 7),
        (T::Integer64, 0x15, "INTEGER64", K::Signed, 8),
        (T::Unsigned8, 0x05, "UNSIGNED8", K::Unsigned, 1),
        (T::Unsigned16, 0x06, "UNSIGNED16", K::Unsigned, 2),
        (T::Unsigned24, 0x16, "UNSIGNED24", K::Unsigned, 3),
        (T::Unsigned32, 0x07, "UNSIGNED32", K::Unsigned, 4),
        (T::Unsigned40, 0x18, "UNSIGNED40", K::Unsigned, 5),
        (T::Unsigned48, 0x19, "UNSIGNED48", K::Unsigned, 6),
        (T::Unsigned56, 0x1A, "UNSIGNED56", K::Unsigned, 7),
        (T::Unsigned64, 0x1B, "UNSIGNED64", K::Unsigned, 8),
        (T::Real32, 0x08, "REAL32", K::Real, 4),
        (T::Real64, 0x11, "REAL64", K::Real, 8),
        (T::VisibleString, 0x09, "VISIBLE_STRING", K::Text, 0),
        (T::OctetString, 0x0A, "OCTET_STRING", K::Text, 0),
        (T::UnicodeString, 0x0B, "UNICODE_STRING", K::Text, 0),
        (T::TimeOfDay, 0x0C, "TIME_OF_DAY", K::Time, 6),
        (T::TimeDifference, 0x0D, "TIME_DIFFERENCE", K::Time, 6),
        (T::Domain, 0x0F, "DOMAIN", K::Domain, 0),
    ]
};

impl DataType {
    /// All of them.
    pub const ALL: [Self; 25] = {
        let mut all = [Self::Boolean; 25];
        let mut at = 0;
        while at < all.len() {
            all[at] = TYPES[at].0;
            at += 1;
        }
        all
    };

    /// The type with this number in the object dictionary (CiA 301, table 44).
    pub fn from_code(code: i128) -> Option<Self> {
        let found = TYPES.iter().find(|row| i128::from(row.1) == code);
        found.map(|row| row.0)
    }

    /// The type with this name.
    pub fn from_name(name: &str) -> Option<Self> {
        let found = TYPES.iter().find(|row| row.2 == name);
        found.map(|row| row.0)
    }

    fn row(self) -> (u16, &'static str, Kind, u16) {
        // The rows stand in the order of the enumeration, which a test keeps so.
        let (_, code, name, kind, size) = TYPES[self as usize];
        (code, name, kind, size)
    }

    /// Its number in the object dictionary.
    pub fn code(self) -> u16 {
        self.row().0
    }

    /// The name the standard gives it.
    pub fn name(self) -> &'static str {
        self.row().1
    }

    /// Length in bytes; `None` for strings and domains.
    pub fn size(self) -> Option<u16> {
        Some(self.row().3).filter(|size| *size > 0)
    }

    /// The numbers the type can hold; `None` for what is no integer. A time is its 48 bits.
    pub fn range(self) -> Option<(i128, i128)> {
        let (_, _, kind, size) = self.row();
        let bits = u32::from(size) * 8;
        match kind {
            Kind::Boolean => Some((0, 1)),
            Kind::Signed => Some((-(1 << (bits - 1)), (1 << (bits - 1)) - 1)),
            Kind::Unsigned | Kind::Time => Some((0, (1 << bits) - 1)),
            Kind::Real | Kind::Text | Kind::Domain => None,
        }
    }

    /// Whether it is an integer that can be negative.
    pub fn is_signed(self) -> bool {
        self.row().2 == Kind::Signed
    }

    /// Whether it is REAL32 or REAL64.
    pub fn is_real(self) -> bool {
        self.row().2 == Kind::Real
    }

    /// Whether it is a string.
    pub fn is_text(self) -> bool {
        self.row().2 == Kind::Text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rows_stand_in_the_order_of_the_types() {
        for data_type in DataType::ALL {
            assert_eq!(TYPES[data_type as usize].0, data_type);
            assert_eq!(
                DataType::from_code(data_type.code().into()),
                Some(data_type)
            );
            assert_eq!(DataType::from_name(data_type.name()), Some(data_type));
        }
    }

    #[test]
    fn the_firmware_knows_the_same_types_by_the_same_numbers() {
        use canopen::od::DataType as Firmware;
        for (ours, theirs) in [
            (DataType::Boolean, Firmware::Boolean),
            (DataType::Unsigned24, Firmware::Unsigned24),
            (DataType::Integer56, Firmware::Integer56),
            (DataType::Real64, Firmware::Real64),
            (DataType::TimeDifference, Firmware::TimeDifference),
            (DataType::Domain, Firmware::Domain),
        ] {
            assert_eq!(u32::from(ours.code()), theirs as u32);
            assert_eq!(format!("{ours:?}"), format!("{theirs:?}"));
            assert_eq!(ours.size().unwrap_or_default(), theirs.size());
        }
    }

    #[test]
    fn ranges_are_as_wide_as_their_bytes() {
        assert_eq!(DataType::Integer24.range(), Some((-0x80_0000, 0x7F_FFFF)));
        assert_eq!(DataType::Unsigned56.range(), Some((0, (1 << 56) - 1)));
        assert_eq!(DataType::TimeOfDay.range(), Some((0, (1 << 48) - 1)));
        assert_eq!(DataType::Real32.range(), None);
        assert_eq!(DataType::Domain.size(), None);
    }
}
