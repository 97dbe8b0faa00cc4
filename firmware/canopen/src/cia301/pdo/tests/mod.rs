//! The cases of process data, each under its number.

mod configuration;
mod deadlines;
mod device;
mod multiplexed;
mod multiplexed_properties;
pub(crate) mod objects;
mod properties;
mod receiving;
mod requests;
mod transmitting;
