//! The chip STM32F405 with a crystal of 8 MHz: what its boards share, and what of it is at each of them the same.
//!
//! Core 168 MHz, APB1 42 MHz (CAN), its timers 84 MHz. TIM5 is the time and the deadlines of the node, of the flash sectors 2 and 3 hold the parameters.
//! What a board has of its own here it gives as [`own`](super::own): whether there is current in the motor, and how all is cut off.

pub mod can;
pub mod clocks;
pub mod flash;
#[cfg(not(feature = "odrive36"))]
pub mod lights;
pub mod output_pins;
#[cfg(not(feature = "stm32f405"))]
pub mod ram_code;
#[cfg(not(feature = "odrive36"))]
pub mod switches;
pub mod watchdog;

mod bit_timing;
mod end;
mod mailboxes;

use canopen::cia301::serial_number::fold;
use cortex_m::register::control::{self, Fpca};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};
use stm32f4xx_hal::signature::Uid;

/// Clock of the core.
pub const CORE_HZ: u32 = 168_000_000;

/// Clock of the timers on APB1.
pub const TIMERS_HZ: u32 = 84_000_000;

/// Counts of [`ticks`] in a microsecond.
pub const TICKS_PER_MICROSECOND: u32 = TIMERS_HZ / 1_000_000;

/// Time without a sign of life after which the board starts anew. Erasing a flash sector stops the core for 0.5 s at most, and each operation
/// of the flash begins with a sign of life; the watchdog's oscillator has 17 to 47 kHz instead of its nominal 32 kHz, so it bites after 0.68
/// to 1.9 s. The ring of step pulses is silent for longer than that.
pub const WATCHDOG_MS: u16 = 1_000;

/// Starts TIM5, which counts the time.
pub fn start_time(timer: pac::TIM5, rcc: &mut Rcc) {
    pac::TIM5::enable(rcc);
    pac::TIM5::reset(rcc);
    timer.cr1().write(|w| w.cen().set_bit());
}

/// Sleeps. What ran before has used the FPU, but nothing is left in its registers: without this each interrupt that uses it would stack them.
pub fn idle() {
    let mut control = control::read();
    control.set_fpca(Fpca::NotActive);
    // SAFETY: who sleeps in a loop has no number in a register of the FPU.
    unsafe { control::write(control) };
    cortex_m::asm::wfi();
}

/// The count of TIM5.
pub fn ticks() -> u32 {
    // SAFETY: reading the counter of TIM5 has no effect, and nobody writes it once it runs.
    unsafe { (*pac::TIM5::ptr()).cnt().read().bits() }
}

/// See [`super::Board::wake_in`].
pub fn wake_in(microseconds: u32) {
    let at = ticks().wrapping_add(microseconds * TICKS_PER_MICROSECOND);
    // SAFETY: the node task alone writes these registers, which have the compare interrupt of TIM5 and nothing of its counter. A
    // moment that has passed before it is written is missed, and the next control tick runs the task.
    unsafe {
        let timer = &*pac::TIM5::ptr();
        timer.ccr1().write(|w| w.bits(at));
        timer.sr().write(|w| w.cc1if().clear_bit());
        timer.dier().write(|w| w.cc1ie().set_bit());
    }
}

/// See [`super::Board::woken`].
pub fn woken() {
    // SAFETY: as in `wake_in`; the interrupt has the priority of the node task.
    unsafe {
        let timer = &*pac::TIM5::ptr();
        timer.dier().write(|w| w.cc1ie().clear_bit());
        timer.sr().write(|w| w.cc1if().clear_bit());
        // The write is through before the interrupt is left, or it would come once more.
        let _ = timer.sr().read();
    }
}

/// The 96 bits that ST gives each chip, folded to 32: place on the wafer, number of the wafer, lot (RM0090, 39.1).
pub fn serial_number() -> u32 {
    let uid = Uid::get();
    let [x, y] = [uid.x().to_le_bytes(), uid.y().to_le_bytes()];
    let wafer = [uid.waf_num()];
    let bytes = x
        .into_iter()
        .chain(y)
        .chain(wafer)
        .chain(uid.lot_num().bytes());
    fold(bytes)
}
