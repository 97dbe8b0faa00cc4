//! How everything is: the bus, its nodes, the drive that was chosen.

use serde::Serialize;

use super::scope::Recorder;
use super::tuning::TuningProgress;
use crate::fsa::{DriveState, Transition};
use crate::homing::Method;

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
    /// What the recorder is at, while it is at something.
    pub recorder: Option<Recorder>,
    /// How many recordings there have been.
    pub recordings: u64,
    /// How far a measurement of the motor is, while there is one.
    pub tuning: Option<TuningProgress>,
    /// How often what is known of the motor has changed.
    pub tunings: u64,
}

/// The bus.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct BusState {
    /// What it is.
    pub title: String,
    /// Whether its drive is the virtual one of this program: any distance is fine there.
    pub is_virtual: bool,
    /// How much of it is in use, in per cent of the last second; only where the bit rate is known.
    pub load: Option<u32>,
    /// Frames in the last second.
    pub rate: u32,
    /// The bit rate in kbit/s, where it is known.
    pub kbit: Option<u32>,
    /// Emergency messages so far, of all nodes.
    pub errors: u64,
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
    /// When its last heartbeat came, in tenths of a second; `None` where it has sent none.
    pub heartbeat: Option<u64>,
    /// Whether its heartbeats have ended.
    pub is_lost: bool,
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
    /// 6062h.
    pub demand: Option<i64>,
    /// 6081h.
    pub profile_velocity: Option<i64>,
    /// 6083h.
    pub profile_acceleration: Option<i64>,
    /// 6084h.
    pub profile_deceleration: Option<i64>,
    /// The set-point of the mode at work, where it is a velocity or a torque.
    pub set_point: Option<SetPoint>,
    /// Whether it records what it does (20D0h).
    pub has_recorder: bool,
    /// Whether it measures its motor (20C0h).
    pub can_tune: bool,
    /// 60F4h.
    pub following_error: Option<i64>,
    /// 603Fh in words, where it is not 0.
    pub fault: Option<String>,
    /// The units of positions, velocities and accelerations (60A8h, 60A9h, 60AAh).
    pub units: [String; 3],
    /// The other values that it has, by their names.
    pub values: Vec<(&'static str, String)>,
    /// How it homes, where it knows homing.
    pub homing: Option<Homing>,
    /// Whether it watches the heartbeat of the panel; if not, why.
    pub guard: Guard,
    /// Whether it is jogged.
    pub jogging: bool,
}

/// How a drive homes.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Homing {
    /// 6098h.
    pub method: i8,
    /// 6099h:1.
    pub fast: i64,
    /// 6099h:2.
    pub slow: i64,
    /// 609Ah.
    pub acceleration: i64,
    /// What can be chosen, by 60E3h where the drive has it.
    pub methods: Vec<Method>,
}

/// A set-point that a person gives by itself: that of a position is a move.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct SetPoint {
    /// What it is called.
    pub name: &'static str,
    /// Its unit.
    pub unit: String,
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
