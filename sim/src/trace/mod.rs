//! Frames for people: candump notation, and what a frame means.

pub mod candump;
mod condense;
mod lss;
mod meaning;
mod objects;
mod sdo;
mod words;

pub use condense::{Group, condense};
pub use meaning::Interpreter;
pub use words::{controlword, statusword};
