//! The streamed objects of the drive, as in the firmware: 2020h "User memory", which belongs to the maker of the machine, and 20D3h
//! "Scope data".

use std::sync::Arc;
use std::sync::atomic::AtomicU32;

use canopen::Domain;
use cia402::recorder::{Memory, Recording};

use crate::dictionary::{Hooked, Hooks, Streams};

/// The longest value of 2020h, in bytes.
const USER_MEMORY: usize = 20_480;

/// Words of samples.
const SCOPE_WORDS: usize = 5_120;

/// An application that shares a memory with the recorder of the drive.
pub trait ScopeMemory {
    /// That memory.
    fn scope_memory(&self) -> Arc<Memory>;
}

/// The application of the virtual drive: no rules of its own, the user memory, which lasts as long as the power, and what the scope
/// has recorded.
#[derive(Debug)]
pub struct Machine {
    user_memory: Domain<Vec<u8>>,
    scope_data: Recording<Arc<Memory>>,
}

impl Default for Hooked<Machine> {
    fn default() -> Self {
        let room = || vec![0; USER_MEMORY];
        let memory: Arc<Memory> = Arc::new(Memory::<[AtomicU32; SCOPE_WORDS]>::new());
        Self(Machine {
            user_memory: Domain::new(room(), room()),
            scope_data: Recording::new(memory),
        })
    }
}

impl ScopeMemory for Hooked<Machine> {
    fn scope_memory(&self) -> Arc<Memory> {
        Arc::clone(self.0.scope_data.memory())
    }
}

/// Nothing to record into.
impl ScopeMemory for () {
    fn scope_memory(&self) -> Arc<Memory> {
        Arc::new(Memory::<[AtomicU32; 0]>::new())
    }
}

impl Hooks for Machine {}

impl Streams for Machine {
    type UserMemory = Domain<Vec<u8>>;
    type ScopeData = Recording<Arc<Memory>>;

    fn user_memory(&mut self) -> &mut Domain<Vec<u8>> {
        &mut self.user_memory
    }

    fn scope_data(&mut self) -> &mut Recording<Arc<Memory>> {
        &mut self.scope_data
    }
}
