//! The dictionaries of the data sheets in `eds` that this firmware is to stand in for, one module each.
//!
//! They are here to be compiled: on the PC, where the tests look at them, and for the target, where they must fit.
#![no_std]
#![forbid(unsafe_code)]

/// The compact drive.
pub mod compact {
    include!(concat!(env!("OUT_DIR"), "/compact.rs"));
}

/// Lexium MDrive and Liberty MDrive.
pub mod lmd {
    include!(concat!(env!("OUT_DIR"), "/lmd.rs"));
}

/// Nanotec SMCI and PD.
pub mod nanotec {
    include!(concat!(env!("OUT_DIR"), "/nanotec.rs"));
}

/// Danaher Motion S200.
pub mod s200 {
    include!(concat!(env!("OUT_DIR"), "/s200.rs"));
}

/// TC1.
pub mod tc1 {
    include!(concat!(env!("OUT_DIR"), "/tc1.rs"));
}

pub mod hooks;
