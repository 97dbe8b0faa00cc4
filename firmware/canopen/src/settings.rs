//! What a device must know before it can speak on a bus: its node-ID and the bit rate (CiA 305 keeps both).

/// A node-ID as CiA 305 stores it: 1 to 127, or 255 for a device that has none yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(u8);

impl NodeId {
    /// The node-ID of a device that has not been configured; such a device answers LSS and nothing else.
    pub const UNCONFIGURED: Self = Self(255);

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

/// The bit rates of CiA 301 table 1, with their index in the LSS bit timing table 0 (CiA 305).
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
    /// 50 kbit/s (index 5, 100 kbit/s, is reserved in table 0).
    Kbit50 = 6,
    /// 20 kbit/s.
    Kbit20 = 7,
    /// 10 kbit/s.
    Kbit10 = 8,
}

impl BitRate {
    /// All bit rates, fastest first.
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

    /// The index in the LSS bit timing table 0.
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
            Self::Kbit50 => 50,
            Self::Kbit20 => 20,
            Self::Kbit10 => 10,
        }
    }
}

/// Node-ID and bit rate together: what LSS configures and stores.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// The node-ID, or [`NodeId::UNCONFIGURED`].
    pub node_id: NodeId,
    /// The bit rate.
    pub bit_rate: BitRate,
}

impl Default for Settings {
    /// As a drive leaves the factory: no node-ID, 1 Mbit/s.
    fn default() -> Self {
        Self {
            node_id: NodeId::UNCONFIGURED,
            bit_rate: BitRate::Kbit1000,
        }
    }
}
