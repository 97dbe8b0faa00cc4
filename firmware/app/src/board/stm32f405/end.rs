//! The end of a run: a panic, a fault of the processor, an interrupt that nobody has, a crystal or a supply that fails.
//!
//! [`cut`] comes first, whatever has happened: no current, the brake closed, no pulse. Then a log line, and the watchdog starts the board anew.

use core::panic::PanicInfo;

use cortex_m_rt::exception;
use stm32f4xx_hal::pac;

/// Where a stack may lie.
const RAM: core::ops::RangeInclusive<u32> = 0x2000_0000..=0x2001_FFE0;

/// Bits of the registers: the clocks of GPIOA and GPIOC, the clock of TIM1, the pins PA2 and PC2.
const PORTS: u32 = 1 << 0 | 1 << 2;
const TIM1: u32 = 1 << 0;
const ENABLE_HIGH: u32 = 1 << 2;
const BRAKE_LOW: u32 = 1 << (16 + 2);

/// Takes the current from the motor, closes the brake and ends the pulses, whoever owns the pins. Nothing runs after it but a log line.
#[inline(always)]
fn cut() {
    // SAFETY: the owners of these registers never run again. The clocks come first, as this may be before they were set up; a pin that is no
    // output yet is held by the resistors around the chip. BDTR without MOE drives both outputs low, or leaves them to their resistors.
    unsafe {
        let rcc = &*pac::RCC::ptr();
        rcc.ahb1enr().modify(|r, w| w.bits(r.bits() | PORTS));
        rcc.apb2enr().modify(|r, w| w.bits(r.bits() | TIM1));
        (*pac::GPIOA::ptr()).bsrr().write(|w| w.bits(ENABLE_HIGH));
        (*pac::GPIOC::ptr()).bsrr().write(|w| w.bits(BRAKE_LOW));
        (*pac::TIM1::ptr())
            .bdtr()
            .modify(|_, w| w.moe().clear_bit());
    }
}

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
    if RAM.contains(&frame) && frame.is_multiple_of(4) {
        // SAFETY: eight words from there on lie in RAM, and any bits are a number.
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
