//! The drive as a whole, on virtual time.

mod brake;
mod early;
mod faults;
mod handover;
mod limits;
mod network;
mod options;
mod pending;
mod states;
mod stops;
mod travel;
