//! What every host of the drive does, on a board, in the emulator and on a PC.
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::indexing_slicing,
        clippy::unreachable
    )
)]

#[cfg(test)]
extern crate std;

mod machine;

pub use machine::{Machine, SCOPE_DATA, USER_MEMORY, is_listed};
