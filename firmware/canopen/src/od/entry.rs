//! One line of the descriptor table.

/// A data type by its code in CiA 301 (object 0001h to 001Bh).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
#[allow(missing_docs, reason = "the names are the standard's own")]
pub enum DataType {
    Boolean = 0x01,
    Integer8 = 0x02,
    Integer16 = 0x03,
    Integer32 = 0x04,
    Unsigned8 = 0x05,
    Unsigned16 = 0x06,
    Unsigned32 = 0x07,
    Real32 = 0x08,
    VisibleString = 0x09,
    OctetString = 0x0A,
    UnicodeString = 0x0B,
    TimeOfDay = 0x0C,
    TimeDifference = 0x0D,
    Domain = 0x0F,
    Integer24 = 0x10,
    Real64 = 0x11,
    Integer40 = 0x12,
    Integer48 = 0x13,
    Integer56 = 0x14,
    Integer64 = 0x15,
    Unsigned24 = 0x16,
    Unsigned40 = 0x18,
    Unsigned48 = 0x19,
    Unsigned56 = 0x1A,
    Unsigned64 = 0x1B,
}

impl DataType {
    /// Whether values differ in length (strings and domains).
    pub const fn is_variable(self) -> bool {
        self.size() == 0
    }

    /// Length in bytes; 0 for what differs in length.
    pub const fn size(self) -> u16 {
        match self {
            Self::Boolean | Self::Integer8 | Self::Unsigned8 => 1,
            Self::Integer16 | Self::Unsigned16 => 2,
            Self::Integer24 | Self::Unsigned24 => 3,
            Self::Integer32 | Self::Unsigned32 | Self::Real32 => 4,
            Self::Integer40 | Self::Unsigned40 => 5,
            Self::TimeOfDay | Self::TimeDifference | Self::Integer48 | Self::Unsigned48 => 6,
            Self::Integer56 | Self::Unsigned56 => 7,
            Self::Integer64 | Self::Unsigned64 | Self::Real64 => 8,
            Self::VisibleString | Self::OctetString | Self::UnicodeString | Self::Domain => 0,
        }
    }

    /// Whether it is REAL32 or REAL64.
    pub const fn is_real(self) -> bool {
        matches!(self, Self::Real32 | Self::Real64)
    }

    /// Whether the number is signed.
    pub const fn is_signed(self) -> bool {
        matches!(
            self,
            Self::Integer8
                | Self::Integer16
                | Self::Integer24
                | Self::Integer32
                | Self::Integer40
                | Self::Integer48
                | Self::Integer56
                | Self::Integer64
        )
    }
}

/// Who may do what with an object over the bus (CiA 306: ro, wo, rw, rwr, rww, const).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Read only; the device changes it.
    ReadOnly,
    /// Write only.
    WriteOnly,
    /// Read and write.
    ReadWrite,
    /// Never changes.
    Constant,
}

/// Where the bytes of a value lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Location {
    /// At this offset of [`super::Dictionary::ram`].
    Ram(u16),
    /// At this offset of [`super::Table::rom`].
    Rom(u16),
    /// With the application ([`Attributes::STREAMED`]).
    Application,
}

/// The attributes of an entry, as bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Attributes(pub u16);

impl Attributes {
    /// Can be read over the bus.
    pub const READ: u16 = 1 << 0;
    /// Can be written over the bus.
    pub const WRITE: u16 = 1 << 1;
    /// May be mapped into a transmit PDO.
    pub const TPDO: u16 = 1 << 2;
    /// May be mapped into a receive PDO.
    pub const RPDO: u16 = 1 << 3;
    /// The node-ID is added to the default.
    pub const NODE_ID: u16 = 1 << 4;
    /// The value lies in flash.
    pub const ROM: u16 = 1 << 5;
    /// Const in the data sheet.
    pub const CONSTANT: u16 = 1 << 6;
    /// The application has the value: it lies neither in RAM nor in flash. A number (an element of a large array) comes and goes
    /// whole; a DOMAIN or a string comes and goes piece by piece ([`Entry::is_streamed`]), and [`Entry::size`] is the most bytes it may have, 0
    /// for no bound.
    pub const STREAMED: u16 = 1 << 7;
    /// The bits of the storage group, [`StorageGroup`] as a number; 0 for what is not stored.
    pub const STORAGE: u16 = 3 << Self::STORAGE_SHIFT;
    /// Where the bits of the storage group begin.
    pub const STORAGE_SHIFT: u32 = 8;
    /// Stored with [`StorageGroup::Communication`].
    pub const COMMUNICATION: u16 = (StorageGroup::Communication as u16) << Self::STORAGE_SHIFT;
    /// Stored with [`StorageGroup::Application`].
    pub const APPLICATION: u16 = (StorageGroup::Application as u16) << Self::STORAGE_SHIFT;
    /// Stored with [`StorageGroup::Manufacturer`].
    pub const MANUFACTURER: u16 = (StorageGroup::Manufacturer as u16) << Self::STORAGE_SHIFT;

    /// Where the length of a number begins, in bytes ([`DataType::size`]); 0 for what differs in length. [`Entry::new`] puts it there.
    const SIZE_SHIFT: u32 = 12;

    /// Whether all of these bits are set.
    pub const fn has(self, bits: u16) -> bool {
        self.0 & bits == bits
    }
}

/// Which sub-index of 1010h and 1011h stores and restores an object (CiA 301, 7.5.2.13 and 7.5.2.14).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum StorageGroup {
    /// Communication parameters, sub-index 2.
    Communication = 1,
    /// Application parameters of the device profile, sub-index 3.
    Application = 2,
    /// Parameters of the manufacturer, sub-index 4.
    Manufacturer = 3,
}

/// One sub-index of one object: 10 bytes of flash.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct Entry {
    // These three are one word of memory, the index its high half: a look-up loads it at once.
    /// Data type.
    pub data_type: DataType,
    /// Sub-index, 0 for an object without any.
    pub sub: u8,
    /// Index, 0001h to FFFFh.
    pub index: u16,
    /// Offset in RAM, or in flash with [`Attributes::ROM`].
    pub offset: u16,
    /// What there is beside: of a number the place of its limits, of everything else its length.
    detail: u16,
    /// Access, mapping and default rules.
    pub attributes: Attributes,
}

const _: () = assert!(size_of::<Entry>() == 10);

impl Entry {
    /// No limits beside those of the type.
    pub const NO_LIMITS: u16 = u16::MAX;

    /// A line of the table. Of a number `detail` is the place of its limits in [`super::Table::limits`], counted in pairs of bytes, or
    /// [`Entry::NO_LIMITS`]. Of what differs in length it is the length in bytes; for a string that can be written, its capacity.
    pub const fn new(
        (index, sub): (u16, u8),
        data_type: DataType,
        offset: u16,
        detail: u16,
        attributes: u16,
    ) -> Self {
        Self {
            data_type,
            sub,
            index,
            offset,
            detail,
            attributes: Attributes(attributes | data_type.size() << Attributes::SIZE_SHIFT),
        }
    }

    /// Length of a number in bytes; 0 for what differs in length.
    #[inline]
    pub(super) const fn width(&self) -> u16 {
        self.attributes.0 >> Attributes::SIZE_SHIFT
    }

    /// Whether it is a number that may have every value of its length.
    #[inline]
    pub(super) fn takes_all(&self) -> bool {
        self.detail == Self::NO_LIMITS && self.data_type != DataType::Boolean
    }

    /// Length in bytes; for a string that can be written, its capacity.
    #[inline]
    pub const fn size(&self) -> u16 {
        match self.width() {
            0 => self.detail,
            size => size,
        }
    }

    /// Whether values differ in length: [`DataType::is_variable`].
    #[inline]
    pub const fn is_variable(&self) -> bool {
        self.attributes.0 < 1 << Attributes::SIZE_SHIFT
    }

    /// Whether a number has limits beside those of its type.
    #[inline]
    pub const fn has_limits(&self) -> bool {
        !self.is_variable() && self.detail != Self::NO_LIMITS
    }

    /// Where the limits of a number begin, in bytes of [`super::Table::limits`]; `None` where there are none.
    #[inline]
    pub(super) const fn limits(&self) -> Option<usize> {
        if self.has_limits() {
            Some(self.detail as usize * 2)
        } else {
            None
        }
    }

    /// Index and sub-index as one number; the table is sorted by it.
    pub const fn key(&self) -> u32 {
        key(self.index, self.sub)
    }

    /// Where the value lies.
    pub const fn location(&self) -> Location {
        if self.attributes.has(Attributes::STREAMED) {
            Location::Application
        } else if self.attributes.has(Attributes::ROM) {
            Location::Rom(self.offset)
        } else {
            Location::Ram(self.offset)
        }
    }

    /// Whether it comes and goes piece by piece.
    pub const fn is_streamed(&self) -> bool {
        self.attributes.has(Attributes::STREAMED) && self.is_variable()
    }

    /// The group that stores it; `None` for what is lost at power-off.
    pub const fn storage_group(&self) -> Option<StorageGroup> {
        match (self.attributes.0 & Attributes::STORAGE) >> Attributes::STORAGE_SHIFT {
            1 => Some(StorageGroup::Communication),
            2 => Some(StorageGroup::Application),
            3 => Some(StorageGroup::Manufacturer),
            _ => None,
        }
    }

    /// The access of the data sheet.
    pub const fn access(&self) -> Access {
        let a = self.attributes;
        if a.has(Attributes::CONSTANT) {
            Access::Constant
        } else if a.has(Attributes::READ | Attributes::WRITE) {
            Access::ReadWrite
        } else if a.has(Attributes::WRITE) {
            Access::WriteOnly
        } else {
            Access::ReadOnly
        }
    }
}

/// Index and sub-index as one sortable number.
pub const fn key(index: u16, sub: u8) -> u32 {
    (index as u32) << 8 | sub as u32
}
