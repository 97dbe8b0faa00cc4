//! The command line of `axis402`.

use std::ffi::OsString;
use std::path::PathBuf;

use canopen::{BitRate, NodeId};
use clap::{Args, Parser, Subcommand, ValueEnum};
use od_gen::DataType;
use slcan::AdapterBitRate;

use super::Group;
use crate::command_line;
use crate::data_sheet::value;
use crate::{Identity, NmtCommand};

/// A CANopen master for real buses: find devices, number them by LSS, read and write their objects, watch the traffic.
#[derive(Debug, Parser)]
#[command(name = "axis402", version)]
pub(super) struct CommandLine {
    #[command(flatten)]
    pub(super) bus: Bus,
    #[command(subcommand)]
    pub(super) command: Command,
}

/// How to get on the bus.
#[derive(Debug, Args)]
pub struct Bus {
    /// An SLCAN adapter: a serial port (/dev/ttyACM0, COM3), or a TCP address of an adapter or a virtual drive
    #[arg(long, value_name = "PORT or ADDRESS:PORT", global = true)]
    pub(super) slcan: Option<String>,
    /// A CAN interface (Linux); its bit rate is set outside
    #[arg(long, value_name = "INTERFACE", global = true)]
    pub(super) socketcan: Option<String>,
    /// The bit rate of the SLCAN adapter in kbit/s (1000, 800, 500, 250, 125, 100, 50, 20 or 10)
    #[arg(long, value_name = "KBIT", global = true, default_value = "1000", value_parser = adapter_bit_rate)]
    pub(super) bitrate: AdapterBitRate,
    /// The baud rate of the serial port; adapters on USB ignore it
    #[arg(long, value_name = "BAUD", global = true, default_value_t = 115_200)]
    pub(super) baud: u32,
    /// How long an answer may take, in milliseconds
    #[arg(long, value_name = "MS", global = true, default_value_t = 1_000, value_parser = clap::value_parser!(u32).range(1..=60_000))]
    pub(super) timeout: u32,
}

impl Bus {
    /// The bus behind an SLCAN adapter, such as a virtual drive on TCP.
    pub fn slcan(address: &str) -> Self {
        Self {
            slcan: Some(address.to_owned()),
            socketcan: None,
            bitrate: BitRate::Kbit1000.into(),
            baud: 115_200,
            timeout: 1_000,
        }
    }

    /// Whether one is named.
    pub fn is_named(&self) -> bool {
        self.slcan.is_some() || self.socketcan.is_some()
    }

    /// What a person calls it.
    pub fn title(&self) -> String {
        match (&self.slcan, &self.socketcan) {
            (Some(slcan), _) => format!("SLCAN {slcan}"),
            (None, Some(interface)) => format!("SocketCAN {interface}"),
            (None, None) => String::new(),
        }
    }

    /// The bit rate in bit/s, where this program sets it.
    pub fn bit_rate(&self) -> Option<u32> {
        (self.slcan.is_some()).then(|| self.bitrate.kbit_per_second() * 1_000)
    }
}

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Ask every node-ID who it is
    Scan,
    /// Find devices without a node-ID, number them, set node-ID and bit rate
    #[command(subcommand)]
    Lss(Lss),
    /// Read and write the object dictionary of a node
    #[command(subcommand)]
    Od(Od),
    /// Let a node save its parameters (1010h)
    Save {
        /// The node-ID of the device
        #[arg(value_parser = node)]
        node: u8,
        /// Which of them
        #[arg(long, value_enum, default_value_t)]
        group: Group,
    },
    /// Start, stop or reset a node; 0 is every node
    Nmt {
        command: Nmt,
        #[arg(value_parser = clap::value_parser!(u8).range(0..=127))]
        node: u8,
    },
    /// See a drive and move it in the browser; `axis402 panel --help` tells more
    #[command(disable_help_flag = true)]
    Panel {
        #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
        arguments: Vec<OsString>,
    },
    /// Let a drive with a servo measure its motor, which moves: data of the motor, gains, frequency response
    Tune {
        #[arg(value_parser = node)]
        node: u8,
        /// The current that it may take, in percent of the rated one
        #[arg(long, value_name = "PERCENT", value_parser = clap::value_parser!(u8).range(1..=100))]
        current: Option<u8>,
        /// The bandwidth that the velocity loop shall have, in 1/s
        #[arg(long, value_name = "1/s", value_parser = clap::value_parser!(u16).range(10..=5_000))]
        bandwidth: Option<u16>,
        /// Without the frequency response
        #[arg(long, conflicts_with = "plot")]
        no_response: bool,
        /// Write what was found to the drive; else nothing is changed
        #[arg(long)]
        write: bool,
        /// Draw the frequency response as SVG
        #[arg(long, value_name = "FILE")]
        plot: Option<PathBuf>,
        /// Move by a hundredth of a turn at once, and draw that as SVG
        #[arg(long, value_name = "FILE")]
        step: Option<PathBuf>,
        /// For programs
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        sheet: Sheet,
    },
    /// Show the traffic with its meaning; of the nodes that are named, PDOs by name
    Monitor {
        /// Node-IDs of devices whose PDOs are told by name
        #[arg(value_parser = node)]
        nodes: Vec<u8>,
        #[command(flatten)]
        sheet: Sheet,
        /// End after so many frames
        #[arg(long, short = 'n', value_name = "N")]
        count: Option<usize>,
    },
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum Nmt {
    Start,
    Stop,
    PreOperational,
    Reset,
    ResetCommunication,
}

impl From<Nmt> for NmtCommand {
    fn from(command: Nmt) -> Self {
        match command {
            Nmt::Start => Self::Start,
            Nmt::Stop => Self::Stop,
            Nmt::PreOperational => Self::EnterPreOperational,
            Nmt::Reset => Self::ResetNode,
            Nmt::ResetCommunication => Self::ResetCommunication,
        }
    }
}

/// Whose objects they are.
#[derive(Debug, Args)]
pub(crate) struct Sheet {
    /// The data sheet of the device: EDS, DCF or XDD
    #[arg(long, value_name = "FILE")]
    pub(super) eds: Option<PathBuf>,
}

#[derive(Debug, Subcommand)]
pub(super) enum Lss {
    /// Find every device without a node-ID
    Find(Scan),
    /// Give each of them the lowest node-ID that nobody has
    Number {
        /// The lowest node-ID to give
        #[arg(long, value_name = "N", default_value_t = 1, value_parser = node)]
        first: u8,
        #[command(flatten)]
        store: Store,
        #[command(flatten)]
        scan: Scan,
    },
    /// Set node-ID or bit rate of one device: the only one on the bus, or that with an identity
    Set {
        /// The new node-ID, 1 to 127
        #[arg(long, value_name = "N", value_parser = node_id, required_unless_present = "rate")]
        node_id: Option<NodeId>,
        /// The bit rate from the next power-on, in kbit/s
        #[arg(long, value_name = "KBIT", value_parser = command_line::bit_rate)]
        rate: Option<BitRate>,
        /// Vendor-ID, product code, revision and serial number, as `scan` and `lss find` tell them
        #[arg(long, value_name = "VENDOR:PRODUCT:REVISION:SERIAL", value_parser = identity)]
        identity: Option<Identity>,
        #[command(flatten)]
        store: Store,
    },
    /// Switch all devices, and this adapter, to another bit rate
    Bitrate {
        /// In kbit/s
        #[arg(value_name = "KBIT", value_parser = command_line::bit_rate)]
        rate: BitRate,
        /// The silence before and after the switch, in milliseconds
        #[arg(long, value_name = "MS", default_value_t = 500, value_parser = clap::value_parser!(u16).range(10..))]
        delay: u16,
        #[command(flatten)]
        store: Store,
    },
    /// Let all devices store node-ID and bit rate as they have been set
    Store,
}

#[derive(Debug, Args)]
pub(super) struct Store {
    /// The devices shall forget it at power-off
    #[arg(long)]
    pub(super) no_store: bool,
}

#[derive(Debug, Args)]
pub(super) struct Scan {
    /// How long each of the 133 steps of a fastscan waits for answers, in milliseconds
    #[arg(long, value_name = "MS", default_value_t = 20, value_parser = clap::value_parser!(u16).range(1..))]
    pub(super) step: u16,
}

#[derive(Debug, Subcommand)]
pub(super) enum Od {
    /// Read objects
    Read {
        /// The node-ID of the device
        #[arg(value_parser = node)]
        node: u8,
        /// INDEX, INDEX:SUB in hexadecimal, or a name of the data sheet
        #[arg(required = true, value_name = "OBJECT")]
        objects: Vec<String>,
        /// The type, where no data sheet knows it: u8, i16, u32, f32, string, bytes, ...
        #[arg(long = "type", value_name = "TYPE", value_parser = value::data_type)]
        data_type: Option<DataType>,
        /// Values only
        #[arg(long, short)]
        bare: bool,
        /// Write the bytes of the one object into this file, such as those of a DOMAIN
        #[arg(long, short, value_name = "FILE", conflicts_with_all = ["bare", "data_type"])]
        output: Option<PathBuf>,
        #[command(flatten)]
        sheet: Sheet,
    },
    /// Write an object
    Write {
        /// The node-ID of the device
        #[arg(value_parser = node)]
        node: u8,
        /// INDEX, INDEX:SUB in hexadecimal, or a name of the data sheet
        #[arg(value_name = "OBJECT")]
        object: String,
        /// Decimal, hexadecimal with 0x, or text
        #[arg(allow_hyphen_values = true, required_unless_present = "file")]
        value: Option<String>,
        /// Write the bytes of this file, such as those of a DOMAIN
        #[arg(long, value_name = "FILE", conflicts_with_all = ["value", "data_type"])]
        file: Option<PathBuf>,
        /// The type, where no data sheet knows it: u8, i16, u32, f32, string, bytes, ...
        #[arg(long = "type", value_name = "TYPE", value_parser = value::data_type)]
        data_type: Option<DataType>,
        #[command(flatten)]
        sheet: Sheet,
    },
    /// Read every object of the data sheet
    Dump {
        /// The node-ID of the device
        #[arg(value_parser = node)]
        node: u8,
        /// Write the configuration into this file instead, for `od load`
        #[arg(long, short, value_name = "FILE.dcf")]
        output: Option<PathBuf>,
        #[command(flatten)]
        sheet: Sheet,
    },
    /// Write the configuration that a DCF holds
    Load {
        /// The node-ID of the device
        #[arg(value_parser = node)]
        node: u8,
        #[arg(value_name = "FILE.dcf")]
        file: PathBuf,
    },
}

fn node(text: &str) -> Result<u8, String> {
    let number = text
        .parse()
        .ok()
        .filter(|number| (1..=127).contains(number));
    number.ok_or_else(|| "a node-ID is 1 to 127".to_owned())
}

fn node_id(text: &str) -> Result<NodeId, String> {
    let found = node(text).map(NodeId::new)?;
    found.ok_or_else(|| "a node-ID is 1 to 127".to_owned())
}

fn adapter_bit_rate(text: &str) -> Result<AdapterBitRate, String> {
    let number = text.parse::<u32>().ok();
    let mut rates = (0..=8).rev().filter_map(AdapterBitRate::from_digit);
    let found = rates.find(|rate| Some(rate.kbit_per_second()) == number);
    found.ok_or_else(|| "not one of 1000, 800, 500, 250, 125, 100, 50, 20, 10".to_owned())
}

fn identity(text: &str) -> Result<Identity, String> {
    let hexadecimal = |part: &str| u32::from_str_radix(part.trim_end_matches(['h', 'H']), 16).ok();
    let words: Option<Vec<u32>> = text.split(':').map(hexadecimal).collect();
    let words = words.and_then(|words| <[u32; 4]>::try_from(words).ok());
    let wanted = "four hexadecimal numbers with colons between, such as 0:402:10000:1";
    words.map(Identity::from).ok_or_else(|| wanted.to_owned())
}
