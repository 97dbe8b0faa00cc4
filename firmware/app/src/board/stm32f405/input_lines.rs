//! The digital inputs, PA4 to PA9: their levels, and the interrupt of each edge.
//!
//! Input `n` is PA(3 + n), and its line of the interrupt controller has the same number, so that the six lie side by side in every
//! register.

use cia402::inputs::COUNT;
use stm32f4xx_hal::gpio::{Edge, ErasedPin, ExtiPin, Input};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::syscfg::SysCfg;

use crate::board::InputLines;

/// The bits of the inputs in the registers.
const FIRST: u32 = 4;
const ALL: u32 = ((1 << COUNT) - 1) << FIRST;

/// The levels of the inputs, input 1 in bit 0.
pub fn levels() -> u8 {
    // SAFETY: reading the input register of GPIOA has no effect.
    let levels = unsafe { (*pac::GPIOA::ptr()).idr().read().bits() };
    ((levels & ALL) >> FIRST) as u8
}

/// The lines of the interrupt controller.
pub struct Lines {
    exti: pac::EXTI,
}

impl Lines {
    /// Every edge of these pins, PA4 to PA9, raises an interrupt from now on.
    pub fn new(
        mut pins: [ErasedPin<Input>; COUNT],
        syscfg: &mut SysCfg,
        mut exti: pac::EXTI,
    ) -> Self {
        for pin in &mut pins {
            pin.make_interrupt_source(syscfg);
            pin.trigger_on_edge(&mut exti, Edge::RisingFalling);
            pin.enable_interrupt(&mut exti);
        }
        Self { exti }
    }
}

impl InputLines for Lines {
    fn take(&mut self) -> u8 {
        let pending = self.exti.pr().read().bits() & ALL;
        // SAFETY: a 1 clears the bit of its line and a 0 does nothing, so only what was read above is cleared.
        self.exti.pr().write(|w| unsafe { w.bits(pending) });
        (pending >> FIRST) as u8
    }
}
