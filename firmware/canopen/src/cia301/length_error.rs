//! Frames of a wrong length: a receive PDO shorter or longer than its mapping, a SYNC with bytes that nobody asked for.
//!
//! The consumer of such a frame knows best when an error begins and ends. It tells each change once, and the emergency
//! producer turns it into a message.

use super::emergency::Emergency;

/// A change that the emergency producer has to hear of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LengthReport {
    /// This error has appeared.
    Appeared(Emergency),
    /// This error, as it was told, is gone.
    Gone(Emergency),
}
