//! The CiA 402 drive: state machine, modes of operation and statusword, bound to an object dictionary and to motion.
//!
//! It comes in two halves that run at different priorities. [`Device`] lives in the communication task: CANopen node,
//! dictionary, hooks of the drive objects. [`Drive`] lives in the control tick: state machine, mode, planner. All they
//! share is an [`Exchange`]: commands one way, actual values the other, each copied whole.
//!
//! # Glossary
//!
//! Words of CiA 301 and CiA 402-2 mean what they mean there; those of motion are in the glossary of [`motion`].
//!
//! | word | what is meant |
//! |---|---|
//! | increment | the unit of all positions in the drive: a microstep of a step axis, a count of the encoder of a servo |
//! | unit of the user | what the factor group makes of an increment; only objects and commands are in it |
//! | count | how positions are numbered: the board's goes on from power-on, the master's from the home position |
//! | control tick | a call of [`Drive::tick`], in a fixed period |
//! | early tick | a call of [`Drive::early_tick`] between two control ticks, for a command to stop |
//! | refill | a commitment of pulses between two control ticks, by an interrupt above them |
//! | actuator | what moves the motor: [`StepAxis`] or [`ServoAxis`]; modes know the trait [`Actuator`] alone |
//! | port | what the board gives to an actuator: a sink of pulses, or the orders to the loops of a servo |
//! | loops | current, velocity and position control of a servo, which run outside of this crate |
//! | sync event | a SYNC, or a set-point that came where there is no SYNC |
//! | slot | a moment, evenly spaced by a phase-locked loop on the sync events, at which a set-point is due |
//! | latency | from a sync event to the moment at which the motor is at its set-point |
//! | travel | the positions between the software limits 607Dh |
//! | position frame | one position whose number in units of the user is known exactly, and the name of the home position |
//! | referenced | the home position is known |
//! | displaced | the motor stands elsewhere than its demands lead to: fault 8611h |
//! | held | by halt or a closed brake: the motor is not to move. A held torque is one that a mode of torque commands |
//! | restart | NMT reset node as the drive sees it: faults and state machine begin anew once the motor stands without power |
//! | scope, recorder | the oscilloscope objects 20D0h to 20D3h, and what records for them |
//! | data sheet | the EDS from which `od-gen` makes the dictionary; what it does not list is not compiled |
//! | binding | how objects of a manufacturer stand for those of the drive, in other units |
//! | habits | switches for what a manufacturer does otherwise than the standard says |
//! | behaviour, module | Rust code of a product for what is not data: its module implements [`Behaviour`] |
//! | fact | a state of the drive that a bit of a manufacturer's status word shows |
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(
        clippy::cast_lossless,
        clippy::cast_possible_truncation,
        clippy::cast_possible_wrap,
        clippy::cast_sign_loss,
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::indexing_slicing,
        clippy::unreachable
    )
)]

#[cfg(test)]
extern crate std;

mod actuator;
pub mod behaviour;
pub mod binding;
pub mod board;
pub mod brake;
pub mod commands;
pub mod configuration;
pub mod controlword;
mod copied;
pub mod cyclic;
pub mod device;
pub mod drive;
pub mod exchange;
pub mod faults;
pub mod gearing;
pub mod indicator;
pub mod inputs;
pub mod loops;
pub mod mode;
mod modes;
mod monitor;
mod motor;
pub mod objects;
pub mod option_codes;
pub mod outputs;
pub mod periphery;
pub mod profile;
mod protection;
pub mod pulse_timing;
pub mod recorder;
mod rules;
mod scope;
pub mod state_machine;
pub mod statusword;
#[cfg(test)]
mod testing;
mod travel;
pub mod units;
mod window_timer;

pub use actuator::{
    Actuator, AtPort, Emitter, EmitterLock, RatedMotor, ServoAxis, ServoGoal, ServoOrder,
    ServoPort, ServoReport, StepAxis,
};
pub use behaviour::{Behaves, Behaviour};
pub use board::{Compare, DriveConfig, Inputs, Outputs};
pub use cia402_parameters::{self as parameters, Features, Habits, NetworkObjects, Parameter};
pub use commands::{Commands, SetPoint};
pub use configuration::Configuration;
pub use controlword::Command;
pub use device::Device;
pub use drive::Drive;
pub use exchange::{Actuals, Exchange, Share};
pub use indicator::{DriveLight, DriveSignal};
pub use mode::Mode;
pub use objects::{DriveStatus, Everything, Objects};
pub use option_codes::QuickStopOption;
pub use state_machine::{State, StateMachine};
pub use units::Units;
