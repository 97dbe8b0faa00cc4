//! Frames for people: candump notation, and what a frame means.

mod abort;
pub mod candump;
mod condense;
mod error_codes;
mod lss;
mod meaning;
mod objects;
mod sdo;
mod sdo_block;
mod words;

pub use abort::{abort_code, abort_words};
pub use condense::{Group, condense};
pub use error_codes::error_words;
pub use meaning::Interpreter;
pub use words::{controlword, controlword_in, node_state, statusword, statusword_in};
