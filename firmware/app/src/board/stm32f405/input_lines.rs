//! The digital inputs, PA4 to PA9: their levels, and the interrupt of each edge.
//!
//! Input `n` is PA(3 + n), and its line of the interrupt controller has the same number, so that the six lie side by side in every
//! register.
//!
//! The interrupt has the highest priority, so a line that rattles could take the whole processor: above [`MOST`] interrupts in a control tick the
//! lines rest for [`REST`] ticks, in which the control tick sees levels alone.

use core::sync::atomic::{AtomicU32, Ordering};

use cia402::inputs::COUNT;
use stm32f4xx_hal::gpio::{Edge, ErasedPin, ExtiPin, Input};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::syscfg::SysCfg;

use crate::board::InputLines;

/// The bits of the inputs in the registers.
const FIRST: u32 = 4;
const ALL: u32 = ((1 << COUNT) - 1) << FIRST;

/// Interrupts of the lines in a control tick; more than a switch, a probe or an index pulse has.
const MOST: u32 = 64;

/// Control ticks without interrupts behind a tick that had more.
const REST: u32 = 10;

/// Interrupts since the last control tick.
static SERVED: AtomicU32 = AtomicU32::new(0);

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

/// Lets the lines rest and go on, once in a control tick.
#[derive(Default)]
pub struct Guard {
    /// Ticks until they go on.
    rest: u32,
    /// How often they had to rest; it wraps.
    rests: u32,
}

impl Guard {
    /// To be called in every control tick.
    pub fn tick(&mut self) {
        let served = SERVED.swap(0, Ordering::Relaxed);
        if served > MOST {
            self.rest = REST;
            self.rests = self.rests.wrapping_add(1);
            defmt::warn!("an input has too many edges, {=u32} times", self.rests);
        } else if let Some(rest) = self.rest.checked_sub(1) {
            self.rest = rest;
            if rest == 0 {
                go_on();
            }
        }
    }
}

/// The interrupts of the lines are on again. What came while they rested is void.
fn go_on() {
    // SAFETY: `Lines` owns the controller, but its interrupt, the only one that writes these registers otherwise, does not come while the lines
    // rest. A 1 clears a bit of PR and a 0 does nothing; the other lines of IMR stay as they are.
    unsafe {
        let exti = &*pac::EXTI::ptr();
        exti.pr().write(|w| w.bits(ALL));
        exti.imr().modify(|r, w| w.bits(r.bits() | ALL));
    }
}

impl InputLines for Lines {
    fn take(&mut self) -> u8 {
        if SERVED.fetch_add(1, Ordering::Relaxed) >= MOST {
            let imr = self.exti.imr();
            // SAFETY: the other lines stay as they are.
            imr.modify(|r, w| unsafe { w.bits(r.bits() & !ALL) });
        }
        let pending = self.exti.pr().read().bits() & ALL;
        // SAFETY: a 1 clears the bit of its line and a 0 does nothing, so only what was read above is cleared.
        self.exti.pr().write(|w| unsafe { w.bits(pending) });
        (pending >> FIRST) as u8
    }
}
