//! The tool `axis402`: its commands on the simulated bus, against the generic drive and devices with data sheets of other vendors, and
//! the program itself through an adapter.

mod adapters;
mod bench;
mod bit_rate;
mod configuration;
mod liars;
mod monitoring;
mod numbering;
mod objects;
mod program;
mod scanning;
mod scope;
mod signals;
mod tuning;
mod two_masters;
mod vendors;
