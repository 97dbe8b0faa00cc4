//! PDOs as a table: what a window shows and edits (CiA 301, 7.5.2.33 to 7.5.2.38).

use serde::{Deserialize, Serialize};

/// A PDO as it is set up.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Pdo {
    /// Whether the node receives it.
    pub receive: bool,
    /// 1 to 512.
    pub number: u16,
    /// Whether it is in use (bit 31 of the COB-ID is 0).
    pub enabled: bool,
    /// Its identifier.
    pub cob_id: u32,
    /// Whether a remote request is answered (bit 30 of the COB-ID is 0).
    pub rtr: bool,
    /// Transmission type.
    #[serde(rename = "type")]
    pub kind: u8,
    /// In 100 µs; of a transmit PDO.
    pub inhibit_time: Option<u16>,
    /// In milliseconds.
    pub event_timer: Option<u16>,
    /// SYNC start value; of a transmit PDO.
    pub sync_start: Option<u8>,
    /// What it carries.
    pub mapped: Vec<Mapped>,
}

/// An entry of the dictionary in a PDO.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mapped {
    /// `6064h:00`.
    pub object: String,
    /// How many bits of the PDO it takes.
    pub bits: u8,
}

/// An entry of the dictionary that can be mapped.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Mappable {
    /// `6064h:00`.
    pub object: String,
    /// What it is called.
    pub name: String,
    /// Its length.
    pub bits: u8,
    /// Into receive PDOs.
    pub receive: bool,
    /// Into transmit PDOs.
    pub transmit: bool,
}

/// All PDOs of a node.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct PdoTable {
    /// Receive PDOs, then transmit PDOs.
    pub pdos: Vec<Pdo>,
    /// What can be mapped.
    pub mappable: Vec<Mappable>,
    /// 1006h in microseconds, where it is not 0.
    pub sync_period: Option<u32>,
}

/// What a table would mean, before anything is written.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct PdoPlan {
    /// What is wrong with it.
    pub problems: Vec<String>,
    /// For each PDO: what its transmission type means.
    pub kinds: Vec<String>,
    /// For each PDO: frames in a second at most; `None` where nothing bounds them, or nothing is sent by itself.
    pub rates: Vec<Option<u32>>,
    /// How much of the bus those take at most, in tenths of a per cent.
    pub load: Option<u32>,
    /// PDOs that are sent whenever something changes, without an inhibit time: they are not in the load.
    pub unbounded: usize,
}
