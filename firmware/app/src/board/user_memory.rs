//! Where the bytes of object 2020h lie: in the section `.uninit.streamed`, which no DMA has to reach. The STM32F405 has its core-coupled memory for it,
//! as its `memory.x` says; where that says nothing, it is part of the memory of all.

use crate::machine::{UserMemory, USER_MEMORY};

/// Two values. At the start of the chip it holds anything.
#[link_section = ".uninit.streamed"]
static mut VALUES: [[u8; USER_MEMORY]; 2] = [[0; USER_MEMORY]; 2];

/// Both values, cleared.
///
/// # Safety
/// It is called once.
pub unsafe fn take() -> [UserMemory; 2] {
    let values = &raw mut VALUES;
    // SAFETY: there is one call, so nobody else has a reference, and zeros are bytes as good as any. The clock of the core-coupled
    // memory is on after a reset.
    let [value, spare] = unsafe {
        values.write_bytes(0, 1);
        &mut *values
    };
    [value, spare]
}
