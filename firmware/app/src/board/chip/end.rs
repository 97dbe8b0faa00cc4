//! The end of a run: a panic, a fault of the processor, an interrupt that nobody has, a crystal or a supply that fails.
//!
//! [`cut`] of the board comes first, whatever has happened: no current, the brake closed, no pulse. Then a log line, and the watchdog starts the board anew.

use core::panic::PanicInfo;

use cortex_m_rt::exception;

use crate::board::own::cut;

/// Where the stack lies, as `memory.x` has it, but for the last frame.
const STACK: core::ops::RangeInclusive<u32> = 0x1000_0000..=0x1000_BFE0;

/// Until the watchdog bites.
fn wait() -> ! {
    loop {
        cortex_m::asm::nop();
    }
}

/// A bug was found. Only what needs no formatting is told, as that could be a second one.
#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    cortex_m::interrupt::disable();
    cut();
    if let Some(place) = info.location() {
        defmt::error!("panic at {=str}:{=u32}", place.file(), place.line());
    }
    wait()
}

/// A fault of the processor. The stack may be what is wrong, so this begins with another one: that of the main program, which never runs again.
#[unsafe(naked)]
#[export_name = "HardFault"]
unsafe extern "C" fn hard_fault() -> ! {
    core::arch::naked_asm!(
        "mov r0, sp",
        "movw r1, :lower16:_stack_start",
        "movt r1, :upper16:_stack_start",
        "mov sp, r1",
        "b {told}",
        told = sym fault,
    )
}

/// `frame`: where the processor has put what it saved, if it could.
extern "C" fn fault(frame: u32) -> ! {
    cut();
    if STACK.contains(&frame) && frame.is_multiple_of(4) {
        // SAFETY: eight words from there on lie in memory, and any bits are a number.
        let address = unsafe { (frame as *const u32).add(6).read_volatile() };
        defmt::error!("hard fault at {=u32:#010x}", address);
    }
    wait()
}

/// Every other exception and interrupt that nobody has bound: NMI when the crystal dies, the supervisor of the supply, and what should not come.
#[exception]
unsafe fn DefaultHandler(number: i16) -> ! {
    cut();
    defmt::error!("exception {=i16} ends the run", number);
    wait()
}
