//! The streamed objects of the drive: 2020h "User memory" and 20D3h "Scope data".
//!
//! The user memory belongs to the maker of the machine, a DOMAIN of up to 20,480 bytes. The drive does not look at it. It is empty after power-on, outlives every reset by NMT, and changes only as a whole: a transfer
//! that ends early leaves the old bytes.

use canopen::Domain;
use cia402::recorder::{Memory, Recording};

use crate::dictionary::{Hooks, Streams};

/// The longest value of 2020h, in bytes.
pub const USER_MEMORY: usize = 20_480;

/// Room for one value of 2020h.
pub type Room = &'static mut [u8; USER_MEMORY];

/// The application of the firmware: no rules of its own, the user memory, and what the scope has recorded.
pub struct Machine {
    user_memory: Domain<Room>,
    scope_data: Recording<&'static Memory>,
}

impl Machine {
    /// With an empty user memory, and with the memory of the scope.
    pub const fn new([value, spare]: [Room; 2], scope: &'static Memory) -> Self {
        Self {
            user_memory: Domain::new(value, spare),
            scope_data: Recording::new(scope),
        }
    }
}

impl Hooks for Machine {}

impl Streams for Machine {
    type UserMemory = Domain<Room>;
    type ScopeData = Recording<&'static Memory>;

    fn user_memory(&mut self) -> &mut Domain<Room> {
        &mut self.user_memory
    }

    fn scope_data(&mut self) -> &mut Recording<&'static Memory> {
        &mut self.scope_data
    }
}
