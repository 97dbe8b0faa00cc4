//! The cases of process data, each under its number.

mod configuration;
mod deadlines;
mod device;
mod multiplexed;
pub(crate) mod objects;
mod properties;
mod receiving;
mod requests;
mod transmitting;
