//! What belongs to the maker of the machine: object 2020h "User memory", as in the firmware.

use canopen::Domain;

use crate::dictionary::{Hooked, Hooks, Streams};

/// The longest value of 2020h, in bytes.
const USER_MEMORY: usize = 20_480;

/// The application of the virtual drive: no rules of its own, and the user memory, which lasts as long as the power.
#[derive(Debug)]
pub struct Machine {
    user_memory: Domain<Vec<u8>>,
}

impl Default for Hooked<Machine> {
    fn default() -> Self {
        let room = || vec![0; USER_MEMORY];
        Self(Machine {
            user_memory: Domain::new(room(), room()),
        })
    }
}

impl Hooks for Machine {}

impl Streams for Machine {
    type UserMemory = Domain<Vec<u8>>;

    fn user_memory(&mut self) -> &mut Domain<Vec<u8>> {
        &mut self.user_memory
    }
}
