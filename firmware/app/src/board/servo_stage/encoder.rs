//! The encoder: TIM3 at PB4 and PB5.

use stm32f4xx_hal::gpio::{Alternate, PB4, PB5};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use crate::board::Steps;

/// TIM3 counts each edge of both lines, those that stand for 4 clocks of 84 MHz.
pub fn start(timer: &pac::TIM3, _lines: (PB4<Alternate<2>>, PB5<Alternate<2>>), rcc: &mut Rcc) {
    const BOTH_WITH_FILTER: u32 = 0x2121;
    const BOTH_EDGES: u32 = 3;
    pac::TIM3::enable(rcc);
    pac::TIM3::reset(rcc);
    // SAFETY: bits of the registers (RM0090, 18.4.3 and 18.4.7).
    unsafe {
        timer.ccmr1_input().write(|w| w.bits(BOTH_WITH_FILTER));
        timer.smcr().write(|w| w.bits(BOTH_EDGES));
        timer.cr1().write(|w| w.bits(1));
    }
}

/// Its count.
#[inline]
pub fn count() -> u16 {
    // SAFETY: reading the counter has no effect, and nobody writes it once it runs.
    unsafe { (*pac::TIM3::ptr()).cnt().read().cnt().bits() }
}

/// An edge of an input is where the encoder is.
pub struct EncoderEdges;

impl Steps for EncoderEdges {
    fn on_interrupt(&mut self) {}

    fn count(&mut self, _input: usize) -> u32 {
        count().into()
    }
}
