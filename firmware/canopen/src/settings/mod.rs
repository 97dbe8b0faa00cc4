//! What a device must know before it can speak on a bus: its node-ID and the bit rate (CiA 305 keeps both).
//!
//! [`Settings`] are in force. [`Configuration`] is what somebody has configured: there the bit rate may be left to the device,
//! which finds it by listening ([`crate::cia305::Detection`]). At power-on several places may have a word in this: switches on
//! the board ([`Switches`]), what is stored, what was built in. [`Sources`] holds them and says which one counts.

mod sources;
mod switches;

pub use sources::{Chosen, PowerOn, Source, Sources, Wish};
pub use switches::{Field, Switches};

/// A node-ID as CiA 305 stores it: 1 to 127, or 255 for a device that has none yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(u8);

impl NodeId {
    /// The node-ID of a device that has not been configured; such a device answers LSS and nothing else.
    pub const UNCONFIGURED: Self = Self(255);

    /// No node at all: what the place of a node-ID holds before it has one.
    pub(crate) const NONE: Self = Self(0);

    /// A node-ID from its number: 1 to 127, or 255 (unconfigured). Anything else is `None`.
    pub const fn new(number: u8) -> Option<Self> {
        match number {
            1..=127 | 255 => Some(Self(number)),
            _ => None,
        }
    }

    /// The number: 1 to 127, or 255.
    pub const fn get(self) -> u8 {
        self.0
    }

    /// Whether the device takes part in CANopen (1 to 127).
    pub const fn is_configured(self) -> bool {
        self.0 <= 127
    }
}

/// The bit rates of CiA 301 table 1, with their index in the LSS bit timing table 0 (CiA 305), and 100 kbit/s.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum BitRate {
    /// 1 Mbit/s.
    Kbit1000 = 0,
    /// 800 kbit/s.
    Kbit800 = 1,
    /// 500 kbit/s.
    Kbit500 = 2,
    /// 250 kbit/s.
    Kbit250 = 3,
    /// 125 kbit/s.
    Kbit125 = 4,
    /// 100 kbit/s. Later editions of CiA 301 leave it out, and its index in table 0 is reserved, so nobody can configure it;
    /// but there are networks that run at it, and a device that finds its bit rate itself takes part in them.
    Kbit100 = 5,
    /// 50 kbit/s.
    Kbit50 = 6,
    /// 20 kbit/s.
    Kbit20 = 7,
    /// 10 kbit/s.
    Kbit10 = 8,
}

impl BitRate {
    /// All bit rates that can be configured (CiA 301, table 1), fastest first.
    pub const ALL: [Self; 8] = [
        Self::Kbit1000,
        Self::Kbit800,
        Self::Kbit500,
        Self::Kbit250,
        Self::Kbit125,
        Self::Kbit50,
        Self::Kbit20,
        Self::Kbit10,
    ];

    /// The bit rate at an index of the LSS bit timing table 0; `None` for 5 (reserved), 9 (automatic) and beyond.
    pub const fn from_table_index(index: u8) -> Option<Self> {
        match index {
            0 => Some(Self::Kbit1000),
            1 => Some(Self::Kbit800),
            2 => Some(Self::Kbit500),
            3 => Some(Self::Kbit250),
            4 => Some(Self::Kbit125),
            6 => Some(Self::Kbit50),
            7 => Some(Self::Kbit20),
            8 => Some(Self::Kbit10),
            _ => None,
        }
    }

    /// The index in the LSS bit timing table 0. That of 100 kbit/s, 5, is one that [`BitRate::from_table_index`] refuses.
    pub const fn table_index(self) -> u8 {
        self as u8
    }

    /// In kbit/s.
    pub const fn kbit_per_second(self) -> u32 {
        match self {
            Self::Kbit1000 => 1000,
            Self::Kbit800 => 800,
            Self::Kbit500 => 500,
            Self::Kbit250 => 250,
            Self::Kbit125 => 125,
            Self::Kbit100 => 100,
            Self::Kbit50 => 50,
            Self::Kbit20 => 20,
            Self::Kbit10 => 10,
        }
    }
}

/// A bit rate, or the order to find it. It is what an index of the LSS bit timing table 0 stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BitTiming {
    /// This bit rate.
    Fixed(BitRate),
    /// The device listens until it knows the bit rate of the network (index 9 of the table).
    Automatic,
}

impl BitTiming {
    /// The index of automatic detection in the LSS bit timing table 0.
    pub const AUTOMATIC_INDEX: u8 = 9;

    /// What an index of the LSS bit timing table 0 stands for; `None` for 5 (reserved), 10 and beyond.
    pub const fn from_table_index(index: u8) -> Option<Self> {
        match BitRate::from_table_index(index) {
            Some(bit_rate) => Some(Self::Fixed(bit_rate)),
            None if index == Self::AUTOMATIC_INDEX => Some(Self::Automatic),
            None => None,
        }
    }

    /// What an index of the table stands for where it was stored: 5 is 100 kbit/s then, from the time when it was that or from a device
    /// that still takes it.
    pub const fn from_stored_index(index: u8) -> Option<Self> {
        match index {
            5 => Some(Self::Fixed(BitRate::Kbit100)),
            _ => Self::from_table_index(index),
        }
    }

    /// The index in the LSS bit timing table 0.
    pub const fn table_index(self) -> u8 {
        match self {
            Self::Fixed(bit_rate) => bit_rate.table_index(),
            Self::Automatic => Self::AUTOMATIC_INDEX,
        }
    }

    /// The bit rate, if it need not be found.
    pub const fn bit_rate(self) -> Option<BitRate> {
        match self {
            Self::Fixed(bit_rate) => Some(bit_rate),
            Self::Automatic => None,
        }
    }
}

/// Node-ID and bit rate in force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// The node-ID, or [`NodeId::UNCONFIGURED`].
    pub node_id: NodeId,
    /// The bit rate.
    pub bit_rate: BitRate,
}

impl Settings {
    /// As a device leaves the factory: no node-ID, 1 Mbit/s.
    pub const FACTORY: Self = Self {
        node_id: NodeId::UNCONFIGURED,
        bit_rate: BitRate::Kbit1000,
    };

    /// The same, configured.
    pub const fn configuration(self) -> Configuration {
        Configuration {
            node_id: self.node_id,
            bit_timing: BitTiming::Fixed(self.bit_rate),
        }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self::FACTORY
    }
}

/// Node-ID and bit rate as they are configured and stored, by LSS or by an object of the manufacturer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Configuration {
    /// The node-ID, or [`NodeId::UNCONFIGURED`].
    pub node_id: NodeId,
    /// The bit rate, or the order to find it.
    pub bit_timing: BitTiming,
}

impl Default for Configuration {
    /// As a device leaves the factory: no node-ID, 1 Mbit/s.
    fn default() -> Self {
        Settings::default().into()
    }
}

impl From<Settings> for Configuration {
    fn from(settings: Settings) -> Self {
        settings.configuration()
    }
}

/// Why settings could not be stored (CiA 305, answer to 17h).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum StoreError {
    /// This device cannot store (01h).
    NotSupported,
    /// The storage medium failed (02h).
    Medium,
}
