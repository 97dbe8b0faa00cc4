//! The digital inputs: 1 to 4 are GPIO 1 to 4, PA0 to PA3, seen in the control tick; 6 is the index of the encoder, PC9, each edge of which is an interrupt that reads
//! the timer of the encoder.

use stm32f4xx_hal::gpio::{Edge, ErasedPin, ExtiPin, Input};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::syscfg::SysCfg;

use crate::board::{InputLines, Steps};

/// The bit of the index in the registers, and that of input 6.
const INDEX: u32 = 1 << 9;
const INPUT_6: u8 = 1 << 5;

/// The bits of inputs 1 to 4.
const PLAIN: u32 = 0xF;

/// The line of nFAULT, PD2.
const FAULT: u32 = 1 << 2;

/// The levels of the inputs, input 1 in bit 0.
pub fn levels() -> u8 {
    // SAFETY: reading the input registers has no effect.
    let (a, c) = unsafe {
        (
            (*pac::GPIOA::ptr()).idr().read().bits(),
            (*pac::GPIOC::ptr()).idr().read().bits(),
        )
    };
    let index = if c & INDEX != 0 { INPUT_6 } else { 0 };
    (a & PLAIN) as u8 | index
}

/// The line of the index.
pub struct Lines {
    exti: pac::EXTI,
}

impl Lines {
    /// Both edges of the index raise an interrupt from now on, and the falling one of nFAULT.
    pub fn new(
        mut index: ErasedPin<Input>,
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
        Self { exti }
    }
}

impl InputLines for Lines {
    fn take(&mut self) -> u8 {
        // SAFETY: a 1 clears the bit of its line and a 0 does nothing.
        self.exti.pr().write(|w| unsafe { w.bits(INDEX) });
        INPUT_6
    }
}

/// The edge of nFAULT is served.
pub fn fault_seen() {
    // SAFETY: as in `take`.
    unsafe { (*pac::EXTI::ptr()).pr().write(|w| w.bits(FAULT)) };
}

/// The timer of the encoder, TIM3.
pub fn encoder() -> u16 {
    // SAFETY: reading the counter has no effect, and nobody writes it once it runs.
    unsafe { (*pac::TIM3::ptr()).cnt().read().cnt().bits() }
}

/// An edge is where the encoder is.
pub struct EncoderEdges;

impl Steps for EncoderEdges {
    fn on_interrupt(&mut self) {}

    fn count(&mut self, _input: usize) -> u32 {
        encoder().into()
    }
}
