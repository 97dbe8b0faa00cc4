//! Code that runs in RAM: the current interrupt of a servo with its loops. It is longer than what the accelerator of the flash keeps, so each
//! of its lines would be fetched anew in each period.
//!
//! The RAM at 2000_0000h is mapped to 0 too, where the core fetches by its bus for instructions, without a wait. At its own address it would by
//! the system bus, a clock late. Stack and variables of the interrupt lie in the core-coupled memory: in the RAM they would take turns with
//! the instructions. A reset of the chip takes the mapping back, and the start sets it again.

use core::ptr::{addr_of, addr_of_mut};

use cortex_m::asm;
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc};

unsafe extern "C" {
    /// Of memory.x: where the section lies in flash, and its room in RAM.
    static __current_load: u32;
    static mut __current_room: u32;
    static __current_end: u32;
}

/// SYSCFG_MEMRMP: SRAM1 at 0 (RM0090, 9.2.1).
const RAM_AT_0: u32 = 3;

/// It may be called from now on. Vectors are fetched from flash all the same: the start has said where they are (VTOR).
pub fn start(syscfg: &pac::SYSCFG, rcc: &mut Rcc) {
    let room = addr_of_mut!(__current_room);
    let words = (addr_of!(__current_end) as usize - room as usize) / size_of::<u32>();
    // SAFETY: the linker has so many words at both, aligned; nobody else has the room, and nothing has run there yet.
    unsafe { room.copy_from_nonoverlapping(addr_of!(__current_load), words) };
    pac::SYSCFG::enable(rcc);
    // SAFETY: bits of the register. What lies at 0 until then, the flash, is used where it is linked, at 0800_0000h.
    unsafe { syscfg.memrmp().write(|w| w.bits(RAM_AT_0)) };
    asm::dsb();
    asm::isb();
}
