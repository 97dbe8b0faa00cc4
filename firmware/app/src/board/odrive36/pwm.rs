//! TIM1: the three half bridges of M0, and the moment at which the currents are converted; TIM2: the half bridge of the brake resistor, AUX.
//!
//! TIM1 counts up and down; an upper switch is on below its compare value, so the lower ones are on around the top. There the fourth channel starts the converters.
//! What they lead to is written before the bottom, where the timer takes it over.

use core::sync::atomic::{AtomicBool, Ordering};

use servo::stage::Counter;
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use crate::board::chip::CORE_HZ;

/// Half a period.
pub const TOP: u16 = 4_200;

/// Periods in a second.
pub const HZ: u32 = CORE_HZ / (2 * TOP as u32);

/// Clocks between the switches of a half bridge: 0.12 µs, as the firmware of its maker has it; the gate driver adds 0.05 µs.
pub const DEAD: u8 = 20;

/// Half a period of the brake, 20 kHz, and clocks between its switches, 0.48 µs.
const BRAKE_TOP: u16 = 2_100;
const BRAKE_DEAD: u16 = 40;

const BRIDGES: Counter = Counter::new(TOP);
const BRAKE: Counter = Counter::new(BRAKE_TOP);

/// Bits of the registers (RM0090, 17.4 and 18.4).
mod bits {
    /// CR1: on, only overflows are updates, up and down, preload.
    pub const CEN: u32 = 1;
    pub const URS: u32 = 1 << 2;
    pub const UP_AND_DOWN: u32 = 1 << 5;
    pub const ARPE: u32 = 1 << 7;
    /// CR2: the signal of channel 4 is the trigger.
    pub const OC4REF: u32 = 7 << 4;
    /// CCMR1 and CCMR2: PWM mode 1 or 2 with preload, in the lower and in the upper half.
    pub const BELOW: u32 = 6 << 4 | 1 << 3;
    pub const ABOVE: u32 = 7 << 4 | 1 << 3;
    /// CCER: channels 1 to 3 and their complements; channels 3 and 4.
    pub const BRIDGES: u32 = 0x555;
    pub const BRAKE: u32 = 0x1100;
    /// BDTR: outputs that are off are low.
    pub const OSSI: u32 = 1 << 10;
    pub const OSSR: u32 = 1 << 11;
    pub const MOE: u32 = 1 << 15;
    /// EGR.
    pub const UG: u32 = 1;
}

/// The gate driver has told of a fault, and has not yet been asked why.
static TRIPPED: AtomicBool = AtomicBool::new(false);

/// Both timers. The interrupt of the currents has them, and what cuts off looks past it.
pub struct Bridges {
    motor: pac::TIM1,
    brake: pac::TIM2,
    /// Compare values are on their way.
    is_armed: bool,
}

impl Bridges {
    /// Both run, with all switches off.
    pub fn new(motor: pac::TIM1, brake: pac::TIM2, rcc: &mut Rcc) -> Self {
        pac::TIM1::enable(rcc);
        pac::TIM1::reset(rcc);
        pac::TIM2::enable(rcc);
        pac::TIM2::reset(rcc);
        // SAFETY: bits and values of these registers. MOE is 0, so no switch of the motor is on, and the values of the brake are those with both off.
        unsafe {
            motor.cr2().write(|w| w.bits(bits::OC4REF));
            motor
                .ccmr1_output()
                .write(|w| w.bits(bits::BELOW | bits::BELOW << 8));
            motor
                .ccmr2_output()
                .write(|w| w.bits(bits::BELOW | bits::ABOVE << 8));
            motor.ccer().write(|w| w.bits(bits::BRIDGES));
            motor
                .bdtr()
                .write(|w| w.bits(bits::OSSI | bits::OSSR | u32::from(DEAD)));
            motor.arr().write(|w| w.bits(TOP.into()));
            // Just before the top: at the top itself it would be no edge.
            motor.ccr4().write(|w| w.bits(u32::from(TOP) - 1));
            let cr1 = bits::URS | bits::UP_AND_DOWN | bits::ARPE;
            motor.cr1().write(|w| w.bits(cr1));
            motor.egr().write(|w| w.bits(bits::UG));

            brake
                .ccmr2_output()
                .write(|w| w.bits(bits::BELOW | bits::ABOVE << 8));
            brake.arr().write(|w| w.bits(BRAKE_TOP.into()));
            let [lower, upper] = BRAKE.chopper(0.0, BRAKE_DEAD);
            brake.ccr3().write(|w| w.bits(lower.into()));
            brake.ccr4().write(|w| w.bits(upper.into()));
            brake.cr1().write(|w| w.bits(cr1));
            brake.egr().write(|w| w.bits(bits::UG));
            brake.ccer().write(|w| w.bits(bits::BRAKE));

            motor.cr1().write(|w| w.bits(cr1 | bits::CEN));
            brake.cr1().write(|w| w.bits(cr1 | bits::CEN));
        }
        Self {
            motor,
            brake,
            is_armed: false,
        }
    }

    /// The widths that act from the bottom on; without any all switches are off.
    #[inline]
    pub fn put(&mut self, widths: Option<[f32; 3]>) {
        let Some([a, b, c]) = widths else {
            self.is_armed = false;
            gates_off();
            return;
        };
        let put = |width: f32| BRIDGES.half_bridge(width).into();
        // SAFETY: compare values up to the top.
        unsafe {
            self.motor.ccr1().write(|w| w.bits(put(a)));
            self.motor.ccr2().write(|w| w.bits(put(b)));
            self.motor.ccr3().write(|w| w.bits(put(c)));
        }
        // Those of the period before act.
        if core::mem::replace(&mut self.is_armed, true) && !has_tripped() {
            gates_on();
        }
        // A trip between the look at it and the switch is seen here, one that comes later switches off itself.
        if has_tripped() {
            self.is_armed = false;
            gates_off();
        }
    }

    /// The share of the time for which the brake resistor burns.
    pub fn burn(&mut self, share: f32) {
        let [lower, upper] = BRAKE.chopper(share, BRAKE_DEAD);
        // SAFETY: compare values up to one beyond the top. Both are taken over at the same end of the counter, unless that comes between them: then one switch has the time of
        // before for half a period. Written off first, that is never both.
        unsafe {
            let off = u32::from(BRAKE_TOP) + 1;
            if self.brake.ccr4().read().bits() != u32::from(upper) {
                self.brake.ccr4().write(|w| w.bits(off));
                self.brake.ccr3().write(|w| w.bits(lower.into()));
                self.brake.ccr4().write(|w| w.bits(upper.into()));
            }
        }
    }
}

fn gates_on() {
    // SAFETY: the interrupt that calls this is the only one that sets the bit; who clears it meanwhile is looked for behind it.
    unsafe {
        (*pac::TIM1::ptr())
            .bdtr()
            .modify(|r, w| w.bits(r.bits() | bits::MOE))
    };
}

/// All switches of the motor are off, and so is the next period.
#[inline(always)]
pub fn gates_off() {
    // SAFETY: one bit of a register of which nobody changes another; without it all outputs are low.
    unsafe {
        (*pac::TIM1::ptr())
            .bdtr()
            .modify(|r, w| w.bits(r.bits() & !bits::MOE))
    };
}

/// All switches of the brake are off.
#[inline(always)]
pub fn brake_off() {
    // SAFETY: without preload the value acts at once; with it both switches are off without their outputs.
    unsafe { (*pac::TIM2::ptr()).ccer().write(|w| w.bits(0)) };
}

/// Whether the gates may be on.
pub fn are_gates_on() -> bool {
    // SAFETY: reading the register has no effect.
    let bdtr = unsafe { (*pac::TIM1::ptr()).bdtr().read().bits() };
    bdtr & bits::MOE != 0
}

/// The gate driver has a fault.
pub fn trip() {
    TRIPPED.store(true, Ordering::Relaxed);
    gates_off();
}

/// Whether it had one since [`go_on`].
pub fn has_tripped() -> bool {
    TRIPPED.load(Ordering::Relaxed)
}

/// It is over.
pub fn go_on() {
    TRIPPED.store(false, Ordering::Relaxed);
}
