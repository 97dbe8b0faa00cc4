//! What windows and the panel say to each other, typed once: JSON over a WebSocket.
//!
//! A window sends a [`Request`]. It hears an [`Event`]: first [`Event::Hello`], then each new [`State`] of the bus, the [`Event::Reply`] to each of
//! its requests, and frames while it wants to. The page shows what it is told; what CAN and the standards ask for is decided here.

mod pdos;
mod scope;
mod state;
mod tuning;

use serde::{Deserialize, Serialize};

use crate::fsa::Transition;
pub use pdos::{Mappable, Mapped, Pdo, PdoPlan, PdoTable};
pub use scope::{LiveChannel, LiveValues, Recordable, Recorded, Recorder, Wish};
pub use state::{
    BusState, Drive, Guard, Homing, LegalTransition, Mode, NodeState, SetPoint, State, Word,
};
pub use tuning::{Response, Step, Tuned, TunedParameter, TuningProgress, TuningWish};

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
    /// Tell what transmit PDOs bring from now on, or no longer.
    Live {
        /// Whether.
        on: bool,
    },
    /// Ask every node-ID who it is, and who has none.
    Scan,
    /// Find the devices without a node-ID by LSS fastscan, and leave them as they are.
    Find,
    /// Switch the whole bus to another bit rate.
    BitRate {
        /// In kbit/s.
        kbit: u32,
        /// Whether all devices store it.
        store: bool,
    },
    /// Let all devices store node-ID and bit rate by LSS.
    StoreLss,
    /// Number all devices that have no node-ID.
    Number {
        /// The lowest node-ID to give.
        first: u8,
        /// Whether they store it.
        store: bool,
    },
    /// Give a device that has a node-ID another one.
    Renumber {
        /// The one that it has.
        node: u8,
        /// The one that it gets.
        to: u8,
        /// Whether it stores it.
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
    /// 1011h; it counts from the next reset.
    Restore {
        /// Of which node.
        node: u8,
    },
    /// The configuration of a node as a DCF.
    Dump {
        /// Of which node.
        node: u8,
    },
    /// Write the configuration in a DCF.
    Load {
        /// Into which node.
        node: u8,
        /// What the file is called.
        name: String,
        /// What is in it.
        text: String,
    },
    /// What of a node is not as a DCF says.
    Compare {
        /// Which node.
        node: u8,
        /// What the file is called.
        name: String,
        /// What is in it.
        text: String,
    },
    /// Use a data sheet that a person has at hand.
    Sheet {
        /// For which node.
        node: u8,
        /// What the file is called.
        name: String,
        /// What is in it.
        text: String,
    },
    /// All PDOs of a node.
    Pdos {
        /// Of which node.
        node: u8,
    },
    /// What a table of PDOs would mean; nothing is written.
    PlanPdos {
        /// Of which node.
        node: u8,
        /// The table.
        pdos: Vec<Pdo>,
        /// The time from SYNC to SYNC in microseconds.
        sync_period: u32,
    },
    /// Set PDOs up, all of them or none.
    SetPdos {
        /// Of which node.
        node: u8,
        /// The table.
        pdos: Vec<Pdo>,
    },
    /// What the transmit PDOs of the drive bring; from now on they are followed.
    Channels,
    /// What the recorder of the drive can record.
    Recordable,
    /// Arm the recorder of the drive.
    Record(Wish),
    /// Stop the recorder.
    StopRecorder,
    /// The last recording.
    Recording,
    /// Let the drive measure its motor; it moves.
    Tune(TuningWish),
    /// Write what it has measured.
    WriteTuning,
    /// What is known of its motor and its loops.
    Tuned,
    /// 6098h, 6099h, 609Ah.
    SetHoming {
        /// The method.
        method: i8,
        /// 6099h:1, to the switch.
        fast: u32,
        /// 6099h:2, over its edge.
        slow: u32,
        /// 609Ah.
        acceleration: u32,
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
        /// 6083h; as it is if nothing is said.
        #[serde(default)]
        acceleration: Option<u32>,
        /// 6084h; as it is if nothing is said.
        #[serde(default)]
        deceleration: Option<u32>,
    },
    /// The set-point of the mode at work, where it is a velocity or a torque.
    SetPoint {
        /// In units of the user.
        value: i32,
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
        self.is_for_watchers()
            || matches!(
                self,
                Self::Scan
                    | Self::Choose { .. }
                    | Self::Sheet { .. }
                    | Self::Dump { .. }
                    | Self::Compare { .. }
            )
    }

    /// Whether the motor moves by it, or gets its power.
    pub fn moves(&self) -> bool {
        matches!(
            self,
            Self::Transition {
                transition: Transition::SwitchOn | Transition::EnableOperation
            } | Self::Enable
                | Self::Mode { .. }
                | Self::Move { .. }
                | Self::SetPoint { .. }
                | Self::Jog { .. }
                | Self::Home
                | Self::Tune(_)
        )
    }

    /// Whether a window that only watches may want it: it changes nothing, for no other window either.
    pub fn is_for_watchers(&self) -> bool {
        matches!(
            self,
            Self::Dictionary { .. }
                | Self::Read { .. }
                | Self::Pdos { .. }
                | Self::PlanPdos { .. }
                | Self::Channels
                | Self::Recordable
                | Self::Recording
                | Self::Tuned
        )
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
    /// What transmit PDOs have brought.
    Live {
        /// Of each channel that has new values.
        values: Vec<LiveValues>,
        /// How many frames there was no room for.
        dropped: u64,
    },
    /// Frames or values that this window was too slow for.
    Missed {
        /// How many messages.
        messages: u64,
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
    /// A file to keep.
    File {
        /// What it is called.
        name: String,
        /// What is in it.
        text: String,
    },
    /// Where a node and a file differ.
    Differences(Vec<Difference>),
    /// The PDOs of a node.
    Pdos(PdoTable),
    /// What a table of PDOs would mean.
    Plan(PdoPlan),
    /// What transmit PDOs bring.
    Channels(Vec<LiveChannel>),
    /// What can be recorded.
    Recordable(Vec<Recordable>),
    /// A recording.
    Recording(Box<Recorded>),
    /// What is known of a motor and its loops.
    Tuned(Box<Tuned>),
}

/// A value that is not as in a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Difference {
    /// `6064h:00`.
    pub address: String,
    /// The name of the object, and of the entry in it.
    pub name: String,
    /// What the node has, or why it does not tell.
    pub here: String,
    /// What the file has.
    pub file: String,
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
    /// Whose identifier it is in the predefined connection set.
    pub node: Option<u8>,
    /// What it means.
    pub meaning: String,
    /// Whether the panel has sent it.
    pub own: bool,
}
