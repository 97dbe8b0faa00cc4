//! The encoder: TIM3 at PB4 and PB5.

use stm32f4xx_hal::gpio::{Alternate, PB4, PB5, PC9};
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

/// The index at PC9 too: the timer captures its count at each rising edge, behind the same filter.
#[cfg_attr(
    feature = "stepper405",
    allow(dead_code, reason = "its index is at no channel of the timer")
)]
pub fn start_index(timer: &pac::TIM3, _line: PC9<Alternate<2>>) {
    const FOURTH_WITH_FILTER: u32 = 0x2100;
    const FOURTH: u32 = 1 << 12;
    // SAFETY: bits of the registers (RM0090, 18.4.8 and 18.4.9).
    unsafe {
        timer.ccmr2_input().write(|w| w.bits(FOURTH_WITH_FILTER));
        timer.ccer().write(|w| w.bits(FOURTH));
    }
}

/// What it had counted where the index came, if that was since the last call. For the interrupt of the loops.
#[cfg_attr(
    feature = "stepper405",
    allow(dead_code, reason = "its index is at no channel of the timer")
)]
pub fn index() -> Option<u16> {
    // SAFETY: the interrupt that calls this is the only one that looks at the capture, which reading ends.
    let timer = unsafe { &*pac::TIM3::ptr() };
    let is_captured = timer.sr().read().cc4if().bit_is_set();
    is_captured.then(|| timer.ccr4().read().bits() as u16)
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
