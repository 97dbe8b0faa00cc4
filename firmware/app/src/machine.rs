//! What belongs to the maker of the machine: object 2020h "User memory", a DOMAIN of up to 20,480 bytes.
//!
//! The drive does not look at it. It is empty after power-on, outlives every reset by NMT, and changes only as a whole: a transfer
//! that ends early leaves the old bytes.

use canopen::Domain;

use crate::dictionary::{Hooks, Streams};

/// The longest value of 2020h, in bytes.
pub const USER_MEMORY: usize = 20_480;

/// Room for one value of 2020h.
pub type Room = &'static mut [u8; USER_MEMORY];

/// The application of the firmware: no rules of its own, and the user memory.
pub struct Machine {
    user_memory: Domain<Room>,
}

impl Machine {
    /// With an empty user memory.
    pub const fn new([value, spare]: [Room; 2]) -> Self {
        Self {
            user_memory: Domain::new(value, spare),
        }
    }
}

impl Hooks for Machine {}

impl Streams for Machine {
    type UserMemory = Domain<Room>;

    fn user_memory(&mut self) -> &mut Domain<Room> {
        &mut self.user_memory
    }
}
