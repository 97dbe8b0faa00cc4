//! Where the samples of the scope lie: on the chip in its core-coupled memory, beside the user memory; the emulator has none, so there
//! they lie in the memory of all.

use core::sync::atomic::AtomicU32;

use cia402::recorder::Memory;

use crate::machine::SCOPE_WORDS;

/// The memory of the scope. At the start of the chip it holds anything, and the recorder forgets that before anybody looks.
#[cfg_attr(not(feature = "qemu"), link_section = ".ccmram")]
pub static SCOPE_MEMORY: Memory<[AtomicU32; SCOPE_WORDS]> = Memory::new();
