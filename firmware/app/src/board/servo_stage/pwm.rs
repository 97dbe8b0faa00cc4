//! TIM1: the half bridges of the motor, and the moment at which the currents are converted.
//!
//! It counts up and down; an upper switch is on below its compare value, so the lower ones are on
//! around the top. There the converters are started. What they lead to is written before the
//! bottom, where the timer takes it over.

use core::sync::atomic::{AtomicBool, Ordering};

use servo::stage::Counter;
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use crate::board::chip::CORE_HZ;
use crate::board::own::{gates_off, gates_on, DEAD, TOP};
use crate::board::{Board, Selected};
use crate::control::RATE_HZ;

/// The period of the modulation, in clocks.
pub const PERIOD: f32 = 2.0 * TOP as f32;

/// Periods in a second.
pub const HZ: u32 = CORE_HZ / (2 * TOP as u32);

/// Periods in one of the loops above the current, which run as often as refills come.
pub const CONTROL: u8 = (HZ / (RATE_HZ * Selected::REFILLS)) as u8;

const _: () = assert!(
    HZ == RATE_HZ * Selected::REFILLS * CONTROL as u32,
    "a refill in each period of the loops above the current"
);

/// Its compare values.
pub const COUNTER: Counter = Counter::new(TOP);

/// Bits of the registers (RM0090, 17.4 and 18.4).
pub mod bits {
    /// CR1: on, only overflows are updates, up and down, preload.
    pub const CEN: u32 = 1;
    pub const URS: u32 = 1 << 2;
    pub const UP_AND_DOWN: u32 = 1 << 5;
    pub const ARPE: u32 = 1 << 7;
    /// CCMR1 and CCMR2: PWM mode 1 with preload.
    pub const BELOW: u32 = 6 << 4 | 1 << 3;
    /// BDTR: outputs that are off are low.
    pub const OSSI: u32 = 1 << 10;
    pub const OSSR: u32 = 1 << 11;
    pub const MOE: u32 = 1 << 15;
    /// EGR.
    pub const UG: u32 = 1;
}

/// BDTR without [`bits::MOE`].
const OUTPUTS: u32 = bits::OSSI | bits::OSSR | DEAD as u32;

/// What boards have differently.
pub struct Settings {
    /// CR2: what the trigger of the timer is.
    pub trigger: u32,
    /// What of CCMR2 channel 4 has, and its compare value.
    pub fourth: (u32, u16),
    /// CCER: the outputs that are on.
    pub outputs: u32,
}

/// The bridges have a fault, and have not yet been asked why.
static TRIPPED: AtomicBool = AtomicBool::new(false);

/// The timer. The interrupt of the currents has it, and what cuts off looks past it.
pub struct Motor {
    timer: pac::TIM1,
    /// Compare values are on their way.
    is_armed: bool,
}

impl Motor {
    /// It runs, with all switches off.
    pub fn new(timer: pac::TIM1, settings: &Settings, rcc: &mut Rcc) -> Self {
        pac::TIM1::enable(rcc);
        pac::TIM1::reset(rcc);
        let (mode, compare) = settings.fourth;
        // SAFETY: bits and values of these registers. MOE is 0, so no switch of the motor is on.
        unsafe {
            timer.cr2().write(|w| w.bits(settings.trigger));
            timer
                .ccmr1_output()
                .write(|w| w.bits(bits::BELOW | bits::BELOW << 8));
            timer
                .ccmr2_output()
                .write(|w| w.bits(bits::BELOW | mode << 8));
            timer.ccer().write(|w| w.bits(settings.outputs));
            timer.bdtr().write(|w| w.bits(OUTPUTS));
            timer.arr().write(|w| w.bits(TOP.into()));
            timer.ccr4().write(|w| w.bits(compare.into()));
            let cr1 = bits::URS | bits::UP_AND_DOWN | bits::ARPE;
            timer.cr1().write(|w| w.bits(cr1));
            timer.egr().write(|w| w.bits(bits::UG));
            timer.cr1().write(|w| w.bits(cr1 | bits::CEN));
        }
        Self {
            timer,
            is_armed: false,
        }
    }

    /// Widths act from the bottom on, by `write` to the compare values.
    #[inline]
    pub fn put(&mut self, write: impl FnOnce(&pac::TIM1)) {
        write(&self.timer);
        // Those of the period before act.
        if core::mem::replace(&mut self.is_armed, true) && !has_tripped() {
            gates_on();
        }
        // A trip between the look at it and the switch is seen here, one that comes later switches
        // off itself.
        if has_tripped() {
            self.off();
        }
    }

    /// All switches are off until there are widths.
    #[cold]
    #[inline(never)]
    pub fn off(&mut self) {
        self.is_armed = false;
        gates_off();
    }
}

/// The outputs are the timer's. For the interrupt of the currents.
pub fn outputs_on() {
    // SAFETY: the interrupt that calls this is the only one that sets the bit, the others are as they
    // were; who clears it meanwhile is looked for behind it.
    unsafe {
        (*pac::TIM1::ptr())
            .bdtr()
            .write(|w| w.bits(OUTPUTS | bits::MOE))
    };
}

/// All outputs are low, and so is the next period.
#[inline(always)]
pub fn outputs_off() {
    // SAFETY: one bit of a register of which nobody changes another; without it all outputs are
    // low.
    unsafe {
        (*pac::TIM1::ptr())
            .bdtr()
            .modify(|r, w| w.bits(r.bits() & !bits::MOE))
    };
}

/// Whether the outputs are the timer's.
pub fn are_outputs_on() -> bool {
    // SAFETY: reading the register has no effect.
    let bdtr = unsafe { (*pac::TIM1::ptr()).bdtr().read().bits() };
    bdtr & bits::MOE != 0
}

/// The bridges have a fault.
pub fn trip() {
    TRIPPED.store(true, Ordering::Relaxed);
    gates_off();
}

/// Whether they had one since [`go_on`].
pub fn has_tripped() -> bool {
    TRIPPED.load(Ordering::Relaxed)
}

/// It is over.
pub fn go_on() {
    TRIPPED.store(false, Ordering::Relaxed);
}
