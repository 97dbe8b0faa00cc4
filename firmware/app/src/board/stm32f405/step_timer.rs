//! Step pulses by the output compare of TIM2.
//!
//! The counter runs freely and pauses only where pulses are dropped; the step pin changes by hardware when the counter
//! meets the compare register. A compare that is not renewed does nothing for the 51 seconds the counter takes to come
//! round, and then only repeats the level that stands: no pulse leaves unless the interrupt asked for it.

use motion::Direction;
use stm32f4xx_hal::gpio::{Alternate, Output, PA0, PA1};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::pac::tim2::ccmr1_output::OC1M;

use motion::step_interrupt::{Edge, StepTimer};

/// TIM2 with the step pin on its channel 1, and the direction pin.
pub struct CompareTimer {
    timer: pac::TIM2,
    direction: PA1<Output>,
    _step: PA0<Alternate<1>>,
}

impl CompareTimer {
    /// The counter starts; the step pin is low.
    pub fn new(timer: pac::TIM2, step: PA0<Alternate<1>>, direction: PA1<Output>) -> Self {
        timer.ccmr1_output().write(|w| w.oc1m().force_inactive());
        timer.ccer().write(|w| w.cc1e().set_bit());
        timer.cr1().write(|w| w.cen().set_bit());
        Self {
            timer,
            direction,
            _step: step,
        }
    }

    fn set_mode(&mut self, mode: OC1M) {
        self.timer.ccmr1_output().write(|w| w.oc1m().variant(mode));
    }
}

impl StepTimer for CompareTimer {
    const FALLING_EDGES: bool = true;

    fn now() -> u32 {
        // SAFETY: reading the counter of TIM2 has no effect on it.
        unsafe { (*pac::TIM2::ptr()).cnt().read().bits() }
    }

    fn schedule(&mut self, time: u32, edge: Edge) -> u32 {
        let (on_match, at_once) = match edge {
            Edge::Rise => (OC1M::ActiveOnMatch, OC1M::ForceActive),
            Edge::Fall => (OC1M::InactiveOnMatch, OC1M::ForceInactive),
            Edge::None => (OC1M::Frozen, OC1M::Frozen),
        };
        self.set_mode(on_match);
        // The flag first: a match right after the new time is written must stay.
        self.timer.sr().write(|w| w.cc1if().clear_bit());
        self.timer.ccr1().write(|w| w.ccr().set(time));
        self.timer.dier().write(|w| w.cc1ie().set_bit());
        let passed = Self::now().wrapping_sub(time) <= u32::MAX / 2;
        if passed && self.timer.sr().read().cc1if().bit_is_clear() {
            // The counter was there before the time was written: do by hand what the match would have done.
            self.set_mode(at_once);
            self.timer.egr().write(|w| w.cc1g().set_bit());
            return Self::now();
        }
        time
    }

    fn stop(&mut self) -> bool {
        self.timer.dier().reset();
        // The counter pauses for these few instructions: between the look at the flag and the change of the mode no edge
        // can come.
        self.timer.cr1().write(|w| w.cen().clear_bit());
        let has_happened = self.timer.sr().read().cc1if().bit_is_set();
        self.set_mode(OC1M::ForceInactive);
        self.timer.sr().write(|w| w.cc1if().clear_bit());
        self.timer.cr1().write(|w| w.cen().set_bit());
        has_happened
    }

    fn set_direction(&mut self, direction: Direction) {
        match direction {
            Direction::Forward => self.direction.set_high(),
            Direction::Reverse => self.direction.set_low(),
        }
    }

    fn interrupt() {
        cortex_m::peripheral::NVIC::pend(pac::Interrupt::TIM2);
    }
}
