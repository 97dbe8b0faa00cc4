//! Heartbeat (CiA 301, 7.2.8.3.2.2): one byte on identifier 700h + node-ID, the NMT state, again and again.
//!
//! A [`Producer`] sends it every so many milliseconds (object 1017h). [`Consumers`] watch other nodes (object 1016h): one that has
//! been heard once and then falls silent for longer than its time is lost.

mod consumer;
mod producer;

pub use consumer::{CONSUMER_INDEX, Consumer, Consumers, Heard, HeartbeatError};
pub use producer::{PRODUCER_INDEX, Producer};
