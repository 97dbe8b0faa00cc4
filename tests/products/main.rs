//! The drives of other makers: their motors move, the worked sequences of their manuals play, and each capability has what shows it.

mod bench;
mod capabilities;
mod moves;
mod objects;
mod scenes;
mod sequences;
