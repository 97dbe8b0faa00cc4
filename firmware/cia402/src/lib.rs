//! The CiA 402 drive: state machine, modes of operation and statusword, bound to an object dictionary and to motion.
//!
//! It comes in two halves that run at different priorities. [`Device`] lives in the communication task: CANopen node,
//! dictionary, hooks of the drive objects. [`Drive`] lives in the control tick: state machine, mode, planner. All they
//! share is an [`Exchange`]: commands one way, actual values the other, each copied whole.
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
    Actuator, AtPort, Emitter, EmitterLock, ServoAxis, ServoGoal, ServoOrder, ServoPort,
    ServoReport, StepAxis,
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
pub use objects::{Everything, Facts, Objects};
pub use option_codes::QuickStopOption;
pub use state_machine::{State, StateMachine};
pub use units::Units;
