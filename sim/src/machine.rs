//! The room for the streamed objects of the drive, as in the firmware: 2020h "User memory" and 20D3h "Scope data".

use std::sync::Arc;
use std::sync::atomic::AtomicU32;

use cia402::recorder::Memory;

/// The longest value of 2020h, in bytes.
const USER_MEMORY: usize = 20_480;

/// Words of samples.
const SCOPE_WORDS: usize = 5_120;

/// The application of the virtual drive.
pub type Machine = runtime::Machine<Vec<u8>, Arc<Memory>>;

/// An application with an empty user memory, which lasts as long as the power, and the memory that it shares with the recorder.
pub fn machine() -> (Machine, Arc<Memory>) {
    let room = || vec![0; USER_MEMORY];
    let scope: Arc<Memory> = Arc::new(Memory::<[AtomicU32; SCOPE_WORDS]>::new());
    (Machine::new(room(), room(), Arc::clone(&scope)), scope)
}
