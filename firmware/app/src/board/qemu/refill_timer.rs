//! The interrupt between two control ticks, by the emulated TIM3: an alarm as in [`super::step_timer`], which repeats by itself.

use stm32f4xx_hal::pac;

/// An interrupt every so many nanoseconds from now on.
pub fn start(timer: pac::TIM3, nanoseconds: u32) {
    timer.dier().write(|w| w.uie().set_bit());
    timer.cr1().write(|w| w.cen().set_bit());
    // SAFETY: the chip's register has 16 bits, the emulated one 32, and any value is a time.
    timer.arr().write(|w| unsafe { w.bits(nanoseconds) });
}

/// The interrupt has been served.
pub fn done() {
    // SAFETY: writing 0 to the flag of TIM3 clears it, and nothing else touches the timer once it runs.
    unsafe { (*pac::TIM3::ptr()).sr().write(|w| w.uif().clear_bit()) };
}
