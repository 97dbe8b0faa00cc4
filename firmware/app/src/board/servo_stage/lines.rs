//! The lines of the interrupt controller: input 6, the index of the encoder, each edge of which
//! reads the timer of the encoder; and nFAULT, which takes the current at once.

use stm32f4xx_hal::gpio::{Edge, ExtiPin, PinExt};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::syscfg::SysCfg;

use crate::board::{own, InputLines};

/// The index among the inputs.
pub const INPUT_6: u8 = 1 << 5;

/// The line of the index.
pub struct Lines {
    exti: pac::EXTI,
    index: u32,
}

impl Lines {
    /// Both edges of the index raise an interrupt from now on, and the falling one of nFAULT.
    pub fn new(
        index: &mut (impl ExtiPin + PinExt),
        fault: &mut impl ExtiPin,
        syscfg: &mut SysCfg,
        mut exti: pac::EXTI,
    ) -> Self {
        index.make_interrupt_source(syscfg);
        index.trigger_on_edge(&mut exti, Edge::RisingFalling);
        index.enable_interrupt(&mut exti);
        fault.make_interrupt_source(syscfg);
        fault.trigger_on_edge(&mut exti, Edge::Falling);
        fault.enable_interrupt(&mut exti);
        Self {
            exti,
            index: 1 << index.pin_id(),
        }
    }
}

impl InputLines for Lines {
    fn take(&mut self) -> u8 {
        // SAFETY: a 1 clears the bit of its line and a 0 does nothing.
        self.exti.pr().write(|w| unsafe { w.bits(self.index) });
        INPUT_6
    }
}

/// The edge of nFAULT is served.
pub fn fault_seen() {
    // SAFETY: as in `take`.
    unsafe { (*pac::EXTI::ptr()).pr().write(|w| w.bits(own::FAULT_LINE)) };
}
