//! The independent watchdog, with an oscillator of its own.

use stm32f4xx_hal::pac::{DBGMCU, IWDG};

use crate::board::own;

/// Keys of IWDG_KR (RM0090, 21.4.1).
const START: u16 = 0xCCCC;
const ACCESS: u16 = 0x5555;
const FEED: u16 = 0xAAAA;

/// A millisecond at the nominal 32 kHz: divided by 32.
const PRESCALER: u8 = 3;

/// Looks at the status, which changes within five clocks of the oscillator once that runs: 0.3 ms at the 17 kHz that it may be as slow as, and the
/// core has 16 MHz here.
const MOST_POLLS: u32 = 20_000;

/// The watchdog at work.
pub struct Watchdog(IWDG);

impl Watchdog {
    /// Starts it with this period. What is written to its registers acts only behind the start, which switches the oscillator on; until
    /// then the period is half a second.
    pub fn start(iwdg: IWDG, milliseconds: u16, debug: &DBGMCU) -> Self {
        debug.apb1_fz().modify(|_, w| w.dbg_iwdg_stop().set_bit());
        let mut watchdog = Self(iwdg);
        watchdog.write_key(START);
        watchdog.write_key(ACCESS);
        // SAFETY: values of these registers.
        unsafe {
            watchdog.0.pr().write(|w| w.pr().bits(PRESCALER));
            watchdog.0.rlr().write(|w| w.rl().bits(milliseconds - 1));
        }
        let taken = || watchdog.0.sr().read().bits() == 0;
        let _ = (0..MOST_POLLS).any(|_| taken());
        watchdog.feed();
        watchdog
    }

    /// It does not bite for another period.
    pub fn feed(&mut self) {
        self.write_key(FEED);
    }

    /// The same from who has something to do that takes longer, while the motor has no current: nothing is to be feared then.
    #[inline(never)]
    pub fn feed_at_rest() {
        if !own::has_power() {
            // SAFETY: a key of the register, which only feeds; the control tick writes no other one either.
            unsafe { (*IWDG::ptr()).kr().write(|w| w.key().bits(FEED)) };
        }
    }

    fn write_key(&mut self, key: u16) {
        // SAFETY: a key of the register.
        self.0.kr().write(|w| unsafe { w.key().bits(key) });
    }
}
