//! The virtual drive: the firmware's own core on a PC, with a simulated motor and real CAN frames.
//!
//! - [`drive`]: the virtual drive; [`products`]: those of other makers; [`plant`]: its motor; [`machine`]: what its firmware serves beside the drive; [`flash`]: where it keeps its settings; [`settings`]: those of the factory.
//! - [`demo`], [`serve`] and [`mod@plan`]: what the command line does.
//!
//! The buses that it is on, the master of the demonstration and `sim scope` are the crate [`master`].
#![forbid(unsafe_code)]

pub mod cli;
pub mod demo;
pub mod drive;
pub mod flash;
pub mod machine;
pub mod plan;
pub mod plant;
pub mod products;
pub mod serve;
pub mod settings;

/// The object dictionary of the generic drive, made from `eds/axis402.eds`.
pub mod dictionary {
    include!(concat!(env!("OUT_DIR"), "/dictionary.rs"));
}

/// The object dictionary of the generic drive with a servo motor, made from `eds/servo.toml`.
pub mod servo_dictionary {
    include!(concat!(env!("OUT_DIR"), "/servo_dictionary.rs"));
}

/// The generic drive with a servo motor on a PC.
pub type ServoDrive = drive::VirtualDrive<servo_dictionary::Dictionary, cia402::ServoAxis>;

/// The generic drive on a PC.
pub type Axis402 = drive::VirtualDrive<dictionary::Dictionary>;
