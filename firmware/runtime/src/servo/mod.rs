//! The loops of a servo, between the axis of the drive and a power stage: on a board and in the plant alike.
//!
//! | here | runs | does | the host gives |
//! |---|---|---|---|
//! | [`Current`] (`current.rs`, `feedback.rs`) | in the current interrupt, in each period of the modulation | counts in, pulse widths out; before that offsets, magnet, measurement | the counts |
//! | [`Loops`] (`loops.rs`, `measurement.rs`) | in the interrupt of the loops, in one of so many periods | position, velocity, field, limits, what is watched, settings | time, a [`CurrentLock`] |
//! | [`LinkedLoops`] (`linked_loops.rs`) | there, on a board | the loops at one end of the link | the same |
//! | [`Link`] | | what the loops and the tasks of a board copy from one to the other | |
//! | [`Port`] | in the control tick, on a board | the port of the axis, at the other end of the link | time |
//! | [`ServoObjects`] | in the task of the dictionary | what masters set and ask for, and what was found | the dictionary |
//!
//! The contract: [`Current::period`] is called in the middle of the pulses, its widths act half a period later for a whole one. Where [`Current::is_due`] says so
//! [`Loops::run`] follows, in its own interrupt; what it asks for acts from the next period on. The gates are on while there are widths; where
//! [`Current::is_off`] behind a lock they go off at once.
//!
//! What the two share is copied: up a [`CurrentState`], down a current or a field, and rarely what is set, begun or ended. The loops mask the current interrupt for a copy and
//! no more, so its widths are there in time; it never waits for what it finds locked, as it finds nothing locked.

mod current;
mod data;
mod feedback;
mod link;
mod linked_loops;
mod loops;
mod measurement;
mod objects;
mod orders;
mod port;
mod raw_report;
mod settings;

pub use cia402::loops::{Found, LoopReport, Request, ServoSettings, StepperSettings};
pub use current::{Current, CurrentLock, CurrentState};
pub use data::{Feedback, ServoData, StageData};
pub use link::Link;
pub use linked_loops::LinkedLoops;
pub use loops::Loops;
pub use objects::ServoObjects;
pub use orders::error_code;
pub use port::Port;

#[cfg(test)]
mod tests;
