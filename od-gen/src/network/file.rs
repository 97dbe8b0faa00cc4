//! The description as its file has it.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use serde::Deserialize;
use toml::{Deserializer, Spanned, Value};

use super::yaml;
use crate::source::Source;

/// A description of a network.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    pub(super) network: Header,
    pub(super) sync: Option<Spanned<Sync>>,
    pub(super) master: Option<Spanned<Master>>,
    #[serde(default)]
    pub(super) node: Vec<Spanned<Node>>,
}

impl File {
    /// Reads YAML where the file is called so, else TOML; or says what is wrong, and where it is known, at which bytes.
    pub(super) fn read(source: &Source) -> Result<Self, (Option<Range<usize>>, String)> {
        let extension = Path::new(&*source.file).extension().unwrap_or_default();
        let is_yaml = ["yaml", "yml"]
            .iter()
            .any(|own| extension.eq_ignore_ascii_case(own));
        let text = source.text();
        let tree = match is_yaml {
            true => yaml::read(text)
                .map_err(|(place, message)| (Some(place), message))?
                .into(),
            false => Deserializer::parse(text).map_err(said)?,
        };
        Self::deserialize(tree).map_err(said)
    }
}

fn said(error: toml::de::Error) -> (Option<Range<usize>>, String) {
    (error.span(), error.message().into())
}

/// The table `[network]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Header {
    /// kbit/s.
    pub(super) bit_rate: Spanned<u16>,
    #[serde(default)]
    pub(super) name: String,
    #[serde(default)]
    pub(super) number: u32,
    /// How many heartbeats a consumer waits for one.
    pub(super) heartbeat_multiplier: Option<Spanned<f64>>,
}

/// The table `[sync]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Sync {
    /// The master where nobody is named.
    pub(super) producer: Option<Spanned<String>>,
    /// Microseconds.
    pub(super) period: u32,
    /// Microseconds.
    #[serde(default)]
    pub(super) window: u32,
    #[serde(default)]
    pub(super) overflow: u8,
    pub(super) cob_id: Option<Spanned<u16>>,
}

/// The table `[master]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Master {
    pub(super) node_id: Spanned<u8>,
    /// Milliseconds.
    #[serde(default)]
    pub(super) heartbeat: u16,
    #[serde(default)]
    pub(super) guarded_by: Vec<Spanned<String>>,
    #[serde(default)]
    pub(super) vendor_id: u32,
    #[serde(default)]
    pub(super) product_code: u32,
    #[serde(default)]
    pub(super) revision_number: u32,
    #[serde(default)]
    pub(super) serial_number: u32,
    #[serde(default = "yes")]
    pub(super) start: bool,
    #[serde(default = "yes")]
    pub(super) start_nodes: bool,
    #[serde(default)]
    pub(super) start_all_nodes: bool,
    #[serde(default)]
    pub(super) reset_all_nodes: bool,
    #[serde(default)]
    pub(super) stop_all_nodes: bool,
    /// Milliseconds.
    #[serde(default)]
    pub(super) boot_time: u32,
    /// Whether 1F20h names the DCF of each node beside the concise one.
    #[serde(default)]
    pub(super) store_dcf: bool,
}

/// A table `[[node]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Node {
    pub(super) name: Spanned<String>,
    pub(super) sheet: Spanned<String>,
    pub(super) node_id: Spanned<u8>,
    /// Milliseconds.
    pub(super) heartbeat: Option<Spanned<u16>>,
    /// Milliseconds. The master asks the node so often for its state, in place of heartbeats.
    pub(super) guard_time: Option<Spanned<u16>>,
    /// After so many guard times without a question the node takes the master for lost.
    pub(super) life_time_factor: Option<Spanned<u8>>,
    /// The master, where there is one and nobody is named.
    pub(super) guarded_by: Option<Vec<Spanned<String>>>,
    pub(super) revision_number: Option<u32>,
    pub(super) serial_number: Option<u32>,
    #[serde(default = "yes")]
    pub(super) boot: bool,
    #[serde(default)]
    pub(super) mandatory: bool,
    #[serde(default = "yes")]
    pub(super) reset_communication: bool,
    #[serde(default = "retries")]
    pub(super) retry_factor: u8,
    /// The sub-index of 1011h by which the master restores the defaults first; 0 for none.
    #[serde(default)]
    pub(super) restore_configuration: u8,
    #[serde(default)]
    pub(super) rpdo: BTreeMap<Spanned<String>, Spanned<Pdo>>,
    #[serde(default)]
    pub(super) tpdo: BTreeMap<Spanned<String>, Spanned<Pdo>>,
    #[serde(default)]
    pub(super) values: BTreeMap<Spanned<String>, Spanned<Value>>,
}

/// A table `[node.rpdo.N]` or `[node.tpdo.N]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Pdo {
    pub(super) name: Option<Spanned<String>>,
    #[serde(default = "yes")]
    pub(super) enabled: bool,
    /// An identifier, or `auto`.
    pub(super) cob_id: Option<Spanned<Value>>,
    /// The transmit PDO that a receive PDO hears.
    pub(super) from: Option<Spanned<String>>,
    pub(super) transmission: Option<u8>,
    /// 100 microseconds.
    pub(super) inhibit_time: Option<u16>,
    /// Milliseconds.
    pub(super) event_timer: Option<u16>,
    /// Milliseconds.
    pub(super) deadline: Option<u16>,
    pub(super) sync_start: Option<u8>,
    pub(super) map: Option<Vec<Spanned<String>>>,
}

fn yes() -> bool {
    true
}

fn retries() -> u8 {
    3
}
