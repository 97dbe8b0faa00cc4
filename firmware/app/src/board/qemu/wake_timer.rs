//! The deadline of the node task, by the emulated TIM4: an alarm as in [`super::step_timer`], which is taken once.

use stm32f4xx_hal::pac;

/// No alarm.
pub fn start(timer: &pac::TIM4) {
    timer.cr1().write(|w| w.cen().set_bit());
}

/// An interrupt after so many nanoseconds.
pub fn wake_in(nanoseconds: u32) {
    // SAFETY: nothing else touches the timer once it runs. The chip's register has 16 bits, the emulated one 32, and any value is a time.
    unsafe {
        let timer = &*pac::TIM4::ptr();
        timer.dier().write(|w| w.uie().set_bit());
        timer.arr().write(|w| w.bits(nanoseconds));
    }
}

/// The interrupt has been served.
pub fn woken() {
    // SAFETY: nothing else touches the timer once it runs; without its interrupt enabled, the alarm sets the flag no more.
    unsafe {
        let timer = &*pac::TIM4::ptr();
        timer.dier().reset();
        timer.sr().write(|w| w.uif().clear_bit());
    }
}
