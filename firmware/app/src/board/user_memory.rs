//! Where the bytes of object 2020h lie: in the section `.uninit.streamed`, which no DMA has to reach. The STM32F405 has its core-coupled memory for it,
//! as its `memory.x` says; where that says nothing, it is part of the memory of all.

use crate::machine::{Room, USER_MEMORY};

/// Room for two values. At the start it holds anything.
#[link_section = ".uninit.streamed"]
static mut ROOMS: [[u8; USER_MEMORY]; 2] = [[0; USER_MEMORY]; 2];

/// Both rooms, cleared.
///
/// # Safety
/// It is called once.
pub unsafe fn take() -> [Room; 2] {
    let rooms = &raw mut ROOMS;
    // SAFETY: there is one call, so nobody else has a reference, and zeros are bytes as good as any. The clock of the core-coupled
    // memory is on after a reset.
    let [value, spare] = unsafe {
        rooms.write_bytes(0, 1);
        &mut *rooms
    };
    [value, spare]
}
