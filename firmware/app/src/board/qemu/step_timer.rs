//! Step timing by the emulated TIM2.
//!
//! The emulated timer is not quite the chip's: it counts nanoseconds, never returns to zero at the reload value, and has no
//! compare interrupts. Writing the reload register makes an alarm after so many nanoseconds, which repeats until the
//! register is written again. That holds only while event generation, counter and prescaler are never written.

use motion::Direction;
use stm32f4xx_hal::pac;

use super::virtual_nanoseconds;
use motion::step_interrupt::{Edge, StepTimer};

/// TIM2 as an alarm clock.
pub struct AlarmTimer {
    timer: pac::TIM2,
}

impl AlarmTimer {
    /// No alarm.
    pub fn new(timer: pac::TIM2) -> Self {
        timer.cr1().write(|w| {
            w.urs().set_bit();
            w.cen().set_bit()
        });
        Self { timer }
    }
}

impl StepTimer for AlarmTimer {
    const FALLING_EDGES: bool = false;

    fn now() -> u32 {
        virtual_nanoseconds()
    }

    fn schedule(&mut self, time: u32, _edge: Edge) -> u32 {
        let now = Self::now();
        let wait = time.wrapping_sub(now);
        let passed = wait > u32::MAX / 2;
        self.timer.sr().write(|w| w.uif().clear_bit());
        self.timer.dier().write(|w| w.uie().set_bit());
        self.timer
            .arr()
            .write(|w| w.arr().set(if passed { 1 } else { wait.max(1) }));
        if passed {
            now
        } else {
            time
        }
    }

    fn stop(&mut self) -> bool {
        // Without its interrupt enabled, the alarm sets the flag no more.
        self.timer.dier().reset();
        let has_happened = self.timer.sr().read().uif().bit_is_set();
        self.timer.sr().write(|w| w.uif().clear_bit());
        has_happened
    }

    fn set_direction(&mut self, _direction: Direction) {}

    fn interrupt() {
        cortex_m::peripheral::NVIC::pend(pac::Interrupt::TIM2);
    }
}
