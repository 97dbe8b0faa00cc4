//! The power stage: what its timer, its converter and its gate driver are told and say, as numbers. Who writes them to registers is the board's.

pub mod bridge_driver;
pub mod compare;
pub mod drv8301;
pub mod sensors;
pub mod thermistor;

pub use bridge_driver::BridgeDriver;
pub use compare::Counter;
pub use drv8301::GateDriver;
