//! Frames for people: candump notation, and what a frame means.

mod abort;
pub mod candump;
mod condense;
mod lss;
mod meaning;
mod objects;
mod sdo;
mod sdo_block;
mod words;

pub use abort::{abort_code, abort_words};
pub use condense::{Group, condense};
pub use meaning::Interpreter;
pub use words::{controlword, node_state, statusword};
