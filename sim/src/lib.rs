//! The virtual drive: the firmware's own core on a PC, with a simulated motor and real CAN frames.
//!
//! - [`drive`]: the virtual drive; [`plant`]: its motor; [`machine`]: what its firmware serves beside the drive; [`flash`]: where it keeps its settings; [`settings`]: those of the factory.
//! - [`timer_model`]: the timers of the board that make step pulses, register by register; [`exactness`]: what is measured on their pins.
//! - [`bus`]: where frames travel. An in-process bus on virtual time, SLCAN over TCP, SocketCAN.
//! - [`master`]: a CANopen master, on the in-process bus or on a real one.
//! - [`data_sheet`]: what the objects of a device are called.
//! - [`trace`]: frames in candump notation, with their meaning.
//! - [`demo`], [`serve`], [`mod@plan`] and [`scope`]: what the command line does.
//! - [`mod@axis402`]: a master's command line for real buses.
#![forbid(unsafe_code)]

pub mod axis402;
pub mod bus;
mod chart;
pub mod cli;
pub mod data_sheet;
pub mod demo;
pub mod drive;
pub mod exactness;
pub mod flash;
pub mod machine;
pub mod master;
pub mod plan;
pub mod plant;
pub mod scope;
pub mod serve;
pub mod settings;
mod system_error;
pub mod timer_model;
pub mod trace;

/// The object dictionary of the generic drive, made from `eds/axis402.eds`.
pub mod dictionary {
    include!(concat!(env!("OUT_DIR"), "/dictionary.rs"));
}

/// The generic drive on a PC.
pub type Axis402 =
    drive::VirtualDrive<dictionary::Dictionary, dictionary::Hooked<machine::Machine>>;
