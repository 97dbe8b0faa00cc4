//! The command line of `axis402 panel`.

use std::path::PathBuf;

use clap::Parser;
use master::axis402::Bus;
use sim::cli::axis;
use sim::plant::ServoAxisData;

/// See a CANopen drive and move it, in the browser.
#[derive(Debug, Parser)]
#[command(name = "axis402 panel", version)]
pub struct Arguments {
    #[command(flatten)]
    pub bus: Bus,
    /// In place of a bus a virtual drive with a motor, fresh from the factory; other masters reach it by SLCAN
    #[arg(long = "virtual", conflicts_with_all = ["slcan", "socketcan"])]
    pub is_virtual: bool,
    /// What the virtual drive moves, in place of a belt (docs/plant.md)
    #[arg(long, value_name = "FILE.toml", requires = "is_virtual")]
    pub plant: Option<PathBuf>,
    /// The virtual drive has a motor that is moved by its current, on a ready axis (docs/servo.md)
    #[arg(long, value_name = "NAME", requires = "is_virtual", conflicts_with = "plant", value_parser = axis())]
    pub axis: Option<ServoAxisData>,
    /// Where the browser finds it. Beyond this computer a token is asked for, which is told at the start
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:8402")]
    pub listen: String,
    /// Send nothing but what reads objects
    #[arg(long)]
    pub read_only: bool,
    /// Data sheets (EDS, DCF, XDD) of devices on the bus; each is used for its own vendor-ID and product code
    #[arg(long, value_name = "FILE")]
    pub eds: Vec<PathBuf>,
    /// The node-ID of the panel, under which drives watch its heartbeat
    #[arg(long, value_name = "N", default_value_t = 127, value_parser = clap::value_parser!(u8).range(1..=127))]
    pub own_node: u8,
}
