//! Where the bytes of object 2020h lie: on the chip in its core-coupled memory, which DMA cannot reach and nothing else uses; the
//! emulator has none, so there they lie in the memory of all.

use crate::machine::{Room, USER_MEMORY};

/// Room for two values. At the start of the chip it holds anything.
#[cfg_attr(not(feature = "qemu"), link_section = ".ccmram")]
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
