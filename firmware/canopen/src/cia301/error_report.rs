//! Errors that a service sees come and go: a SYNC or a receive PDO of a wrong length, one that is missed.
//!
//! The consumer of a frame knows best when an error begins and ends. It tells each change once, and the emergency
//! producer turns it into a message.

use super::emergency::Emergency;

/// A change that the emergency producer has to hear of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorReport {
    /// This error has appeared.
    Appeared(Emergency),
    /// This error, as it was told, is gone.
    Gone(Emergency),
}
