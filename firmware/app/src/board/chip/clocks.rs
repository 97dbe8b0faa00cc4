//! The clock tree, and what watches it and the supply.

use cortex_m::peripheral::NVIC;
use stm32f4xx_hal::pac;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{Config, Enable, Rcc};

use super::CORE_HZ;

/// Looks at a bit of a clock that is ready, or off, within some microseconds.
const MOST_POLLS: u32 = 10_000;

/// The line of the supply's supervisor in EXTI.
const SUPERVISOR: u32 = 1 << 16;

/// 168 MHz from the crystal. Whoever ran before, a boot loader or a debugger, may have left any clock, and a PLL that runs cannot be set.
///
/// A crystal that does not start is waited for until the watchdog bites; the stage has no current then.
pub fn start(rcc: pac::RCC) -> Rcc {
    back_to_reset(&rcc);
    let clocks = Config::hse(8.MHz())
        .sysclk(CORE_HZ.Hz())
        .pclk1(42.MHz())
        .pclk2(84.MHz());
    let rcc = rcc.freeze(clocks);
    // From here on a crystal that dies raises NMI, and the break of TIM1.
    rcc.cr().modify(|_, w| w.csson().set_bit());
    rcc
}

/// The core on its own oscillator, all others off, as they are behind a reset.
fn back_to_reset(rcc: &pac::RCC) {
    rcc.cr().modify(|_, w| w.hsion().set_bit());
    let ready = || rcc.cr().read().hsirdy().bit_is_set();
    let _ = (0..MOST_POLLS).any(|_| ready());
    rcc.cfgr().modify(|_, w| w.sw().hsi());
    let switched = || rcc.cfgr().read().sws().is_hsi();
    let _ = (0..MOST_POLLS).any(|_| switched());
    rcc.cr().modify(|_, w| {
        w.csson().clear_bit();
        w.plli2son().clear_bit().pllon().clear_bit();
        w.hseon().clear_bit()
    });
    let off = || rcc.cr().read().pllrdy().bit_is_clear();
    let _ = (0..MOST_POLLS).any(|_| off());
}

/// Below 2.9 V the chip ends its run while it still can: flash is programmed from 2.7 V on, and what it holds back below 1.8 V comes too late.
pub fn watch_supply(pwr: &pac::PWR, exti: &pac::EXTI, rcc: &mut Rcc) {
    pac::PWR::enable(rcc);
    // SAFETY: level 7 is one of the supervisor.
    pwr.cr()
        .modify(|_, w| unsafe { w.pls().bits(7).pvde().set_bit() });
    // A supply that is still rising is waited for, until the watchdog bites.
    while pwr.csr().read().pvdo().bit_is_set() {}
    // SAFETY: the line is nobody else's. Its interrupt has no task: the handler of those is the one that ends the run.
    unsafe {
        exti.rtsr().modify(|r, w| w.bits(r.bits() | SUPERVISOR));
        exti.imr().modify(|r, w| w.bits(r.bits() | SUPERVISOR));
        NVIC::unmask(pac::Interrupt::PVD);
    }
}
