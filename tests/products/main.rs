//! The drives of other makers: their motors move, the worked sequences of their manuals play, and each capability has what shows it.

mod behaviour;
mod bench;
mod bus;
mod capabilities;
mod motion;
mod moves;
mod objects;
mod periphery;
mod promises;
mod scenes;
mod sequences;
mod speeds;
