//! What windows and the panel say to each other, typed once: JSON over a WebSocket.
//!
//! A window sends a [`Request`]. It hears an [`Event`]: first [`Event::Hello`], then each new [`State`] of the bus, the [`Event::Reply`] to each of
//! its requests, and frames while it wants to. The page shows what it is told; what CAN and the standards ask for is decided here.

use serde::{Deserialize, Serialize};

use crate::fsa::{DriveState, Transition};

/// What a window wants, with a number of its own that the reply carries.
#[derive(Clone, Debug, Deserialize)]
pub struct Request {
    /// Chosen by the window.
    pub id: u64,
    /// What it wants.
    #[serde(flatten)]
    pub order: Order,
}

/// What a window may want.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case")]
pub enum Order {
    /// Stop the drive, at once. Any window may.
    Stop,
    /// The jog button is held no longer, or the page is hidden.
    Release,
    /// The jog button is still held.
    Beat,
    /// This window becomes the one that may write.
    Take,
    /// Tell frames from now on, or no longer.
    Frames {
        /// Whether.
        on: bool,
    },
    /// Ask every node-ID who it is, and who has none.
    Scan,
    /// Number all devices that have no node-ID.
    Number {
        /// The lowest node-ID to give.
        first: u8,
        /// Whether they store it.
        store: bool,
    },
    /// Show this node on the page of the drive.
    Choose {
        /// Its node-ID.
        node: u8,
    },
    /// An NMT command.
    Nmt {
        /// Which one.
        command: NmtOrder,
        /// To whom; 0 is every node.
        node: u8,
    },
    /// 1010h.
    Save {
        /// Of which node.
        node: u8,
    },
    /// One transition of the state machine.
    Transition {
        /// Which one.
        transition: Transition,
    },
    /// All transitions to Operation enabled.
    Enable,
    /// 6060h.
    Mode {
        /// The mode.
        mode: i8,
    },
    /// A move in profile position mode.
    Move {
        /// 607Ah, in units of the user.
        target: i32,
        /// Whether it counts from where the drive is.
        relative: bool,
        /// 6081h; as it is if nothing is said.
        velocity: Option<u32>,
    },
    /// Run as long as beats come.
    Jog {
        /// 60FFh, in units of the user.
        velocity: i32,
    },
    /// Home with the method and velocities that are set up.
    Home,
    /// The dictionary of a node.
    Dictionary {
        /// Of which node.
        node: u8,
    },
    /// Read an object.
    Read {
        /// Of which node.
        node: u8,
        /// By number or name.
        object: String,
    },
    /// Write an object.
    Write {
        /// Of which node.
        node: u8,
        /// By number or name.
        object: String,
        /// As a data sheet writes it.
        value: String,
    },
}

impl Order {
    /// Whether it sends nothing but uploads, if the session may do no more.
    pub fn only_reads(&self) -> bool {
        matches!(
            self,
            Self::Scan | Self::Choose { .. } | Self::Dictionary { .. } | Self::Read { .. }
        )
    }

    /// Whether a window that only watches may want it: it changes nothing, for no other window either.
    pub fn is_for_watchers(&self) -> bool {
        matches!(self, Self::Dictionary { .. } | Self::Read { .. })
    }
}

/// The NMT commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NmtOrder {
    /// Start remote node.
    Start,
    /// Stop remote node.
    Stop,
    /// Enter pre-operational.
    PreOperational,
    /// Reset node.
    Reset,
    /// Reset communication.
    ResetCommunication,
}

impl From<NmtOrder> for master::NmtCommand {
    fn from(order: NmtOrder) -> Self {
        match order {
            NmtOrder::Start => Self::Start,
            NmtOrder::Stop => Self::Stop,
            NmtOrder::PreOperational => Self::EnterPreOperational,
            NmtOrder::Reset => Self::ResetNode,
            NmtOrder::ResetCommunication => Self::ResetCommunication,
        }
    }
}

/// What a window hears.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "is", rename_all = "snake_case")]
pub enum Event {
    /// The first word.
    Hello {
        /// The number of the window.
        window: u64,
        /// Whether nothing can be written at all.
        read_only: bool,
        /// The version of the panel.
        version: &'static str,
    },
    /// How everything is now.
    State(Box<State>),
    /// The answer to a request.
    Reply {
        /// Its number.
        id: u64,
        /// What came of it.
        #[serde(flatten)]
        outcome: Outcome,
    },
    /// What was on the bus.
    Frames {
        /// In their order.
        frames: Vec<LoggedFrame>,
        /// How many more there were for which there was no room.
        dropped: u64,
    },
    /// Which window may write.
    Writer {
        /// Its number.
        window: Option<u64>,
    },
}

/// What came of a request.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// It was done.
    Done(Answer),
    /// It was not, and why.
    Error(String),
}

/// What there is to tell of what was done.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Answer {
    /// Words for a person, or a value.
    Text(String),
    /// A dictionary.
    Dictionary {
        /// Where it is from.
        title: String,
        /// The entries, by index and sub-index.
        entries: Vec<DictionaryEntry>,
    },
}

/// An entry of a dictionary.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DictionaryEntry {
    /// `6064h:00`.
    pub address: String,
    /// The name of the object, and of the entry in it.
    pub name: String,
    /// The type, by its name in CiA 301.
    #[serde(rename = "type")]
    pub data_type: &'static str,
    /// Whether it can be read.
    pub readable: bool,
    /// Whether it can be written.
    pub writable: bool,
    /// The least value, where it is narrower than the type.
    pub low: Option<String>,
    /// The greatest.
    pub high: Option<String>,
    /// What it is after a reset to the factory's.
    pub default: Option<String>,
    /// Its unit, where the data sheet tells.
    pub unit: Option<String>,
}

/// How everything is.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct State {
    /// The bus.
    pub bus: BusState,
    /// The nodes that were heard or found, by node-ID.
    pub nodes: Vec<NodeState>,
    /// The drive that was chosen.
    pub drive: Option<Drive>,
    /// What the panel is at, when it takes longer.
    pub busy: Option<String>,
    /// Something that a person should know, until something else happens.
    pub notice: Option<String>,
}

/// The bus.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct BusState {
    /// What it is.
    pub title: String,
    /// How much of it is in use, in per cent of the last second; only where the bit rate is known.
    pub load: Option<u32>,
    /// Frames in the last second.
    pub rate: u32,
    /// Whether the last scan has found a device without a node-ID; `None` before the first.
    pub unnumbered: Option<bool>,
}

/// A node.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct NodeState {
    /// Its node-ID.
    pub id: u8,
    /// Its NMT state in words, where it tells.
    pub state: Option<&'static str>,
    /// When it was last heard, in tenths of a second.
    pub silent: Option<u64>,
    /// 1008h.
    pub name: Option<String>,
    /// What 1000h says it is.
    pub device: Option<String>,
    /// Whether it is a drive of CiA 402.
    pub is_drive: bool,
    /// 1018h: vendor, product, revision, serial number; hexadecimal.
    pub identity: Option<String>,
    /// Its last emergency messages in words, the newest last.
    pub emergencies: Vec<String>,
}

/// A drive.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Drive {
    /// Its node-ID.
    pub node: u8,
    /// What it is called.
    pub name: String,
    /// Whether it answers.
    pub answers: bool,
    /// Its state by the statusword.
    pub state: Option<DriveState>,
    /// What may come of it by a command.
    pub transitions: Vec<LegalTransition>,
    /// 6041h in words.
    pub statusword: Option<Word>,
    /// 6040h in words.
    pub controlword: Option<Word>,
    /// 6061h.
    pub mode: Option<i8>,
    /// The modes that it knows (6502h).
    pub modes: Vec<Mode>,
    /// 6064h.
    pub position: Option<i64>,
    /// 606Ch.
    pub velocity: Option<i64>,
    /// 607Ah.
    pub target: Option<i64>,
    /// 6081h.
    pub profile_velocity: Option<i64>,
    /// 60F4h.
    pub following_error: Option<i64>,
    /// 603Fh in words, where it is not 0.
    pub fault: Option<String>,
    /// The units of positions and of velocities (60A8h, 60A9h).
    pub units: [String; 2],
    /// The other values that it has, by their names.
    pub values: Vec<(&'static str, String)>,
    /// Whether it watches the heartbeat of the panel; if not, why.
    pub guard: Guard,
    /// Whether it is jogged.
    pub jogging: bool,
}

/// A word of bits.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Word {
    /// In hexadecimal.
    pub number: String,
    /// What it says.
    pub words: String,
}

/// A transition that is possible in the present state.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LegalTransition {
    /// Which one.
    pub transition: Transition,
    /// Where it leads.
    pub to: DriveState,
    /// What a person calls it.
    pub label: &'static str,
    /// Its number in CiA 402.
    pub number: u8,
}

/// A mode of operation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mode {
    /// Its number.
    pub number: i8,
    /// Its name.
    pub name: &'static str,
}

/// Whether a drive watches the heartbeat of the panel.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Guard {
    /// Not yet: the panel has not commanded it.
    #[default]
    Off,
    /// It does.
    On,
    /// It cannot; why.
    Impossible(String),
}

/// A frame in words.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LoggedFrame {
    /// Seconds.
    pub at: String,
    /// The identifier, hexadecimal.
    pub id: String,
    /// The bytes, hexadecimal.
    pub bytes: String,
    /// The service.
    pub kind: &'static str,
    /// What it means.
    pub meaning: String,
    /// Whether the panel has sent it.
    pub own: bool,
}
