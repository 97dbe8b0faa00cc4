//! Where the samples of the scope lie: beside the user memory.

use core::sync::atomic::AtomicU32;

use cia402::recorder::Memory;

use crate::machine::SCOPE_WORDS;

/// The memory of the scope. At the start it holds anything, and the recorder forgets that before anybody looks.
#[link_section = ".uninit.streamed"]
pub static SCOPE_MEMORY: Memory<[AtomicU32; SCOPE_WORDS]> = Memory::new();
