//! TIM1 has the three half bridges of M0; TIM2 the half bridge of the brake resistor, AUX.

use servo::modulation::Widths;
use servo::stage::Counter;
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use crate::board::servo_stage::pwm::{bits, Motor, Settings, COUNTER};
use crate::board::servo_stage::{self, pwm};

/// Half a period of the motor's.
pub const TOP: u16 = if cfg!(feature = "pwm-40khz") {
    2_100
} else {
    4_200
};

/// Clocks between the switches of a half bridge: 0.12 µs, as the firmware of its maker has it; the gate driver adds 0.05 µs.
pub const DEAD: u8 = 20;

/// Half a period of the brake, 20 kHz, and clocks between its switches, 0.48 µs.
const BRAKE_TOP: u16 = 2_100;
const BRAKE_DEAD: u16 = 40;

const BRAKE: Counter = Counter::new(BRAKE_TOP);

/// CCMR2: PWM mode 2 with preload.
const ABOVE: u32 = 7 << 4 | 1 << 3;

const SETTINGS: Settings = Settings {
    // The signal of channel 4.
    trigger: 7 << 4,
    // Just before the top: at the top itself it would be no edge.
    fourth: (ABOVE, TOP - 1),
    // Channels 1 to 3 and their complements.
    outputs: 0x555,
};

/// CCER of TIM2: channels 3 and 4.
const BRAKE_OUTPUTS: u32 = 0x1100;

/// TIM1. The interrupt of the currents has it.
pub struct Bridges {
    motor: Motor,
}

impl Bridges {
    /// It runs, with all switches off.
    pub fn new(motor: pac::TIM1, rcc: &mut Rcc) -> Self {
        Self {
            motor: Motor::new(motor, &SETTINGS, rcc),
        }
    }
}

impl servo_stage::Bridges for Bridges {
    #[inline]
    fn put(&mut self, [a, b, c]: Widths) {
        self.motor.put(|timer| {
            let put = |width: i16| COUNTER.half_bridge(width).into();
            // SAFETY: compare values up to the top.
            unsafe {
                timer.ccr1().write(|w| w.bits(put(a)));
                timer.ccr2().write(|w| w.bits(put(b)));
                timer.ccr3().write(|w| w.bits(put(c)));
            }
        });
    }

    fn off(&mut self) {
        self.motor.off();
    }
}

/// TIM2. The interrupt of the loops has it.
pub struct Brake {
    timer: pac::TIM2,
}

impl Brake {
    /// It runs, with both switches off.
    pub fn new(timer: pac::TIM2, rcc: &mut Rcc) -> Self {
        pac::TIM2::enable(rcc);
        pac::TIM2::reset(rcc);
        // SAFETY: bits and values of these registers; the values are those with both switches off.
        unsafe {
            timer
                .ccmr2_output()
                .write(|w| w.bits(bits::BELOW | ABOVE << 8));
            timer.arr().write(|w| w.bits(BRAKE_TOP.into()));
            let [lower, upper] = BRAKE.chopper(0.0, BRAKE_DEAD);
            timer.ccr3().write(|w| w.bits(lower.into()));
            timer.ccr4().write(|w| w.bits(upper.into()));
            let cr1 = bits::URS | bits::UP_AND_DOWN | bits::ARPE;
            timer.cr1().write(|w| w.bits(cr1));
            timer.egr().write(|w| w.bits(bits::UG));
            timer.ccer().write(|w| w.bits(BRAKE_OUTPUTS));
            timer.cr1().write(|w| w.bits(cr1 | bits::CEN));
        }
        Self { timer }
    }
}

impl servo_stage::Brake for Brake {
    fn burn(&mut self, share: f32) {
        let [lower, upper] = BRAKE.chopper(share, BRAKE_DEAD);
        // SAFETY: compare values up to one beyond the top. Both are taken over at the same end of the counter, unless that comes between them: then one switch has the time of
        // before for half a period. Written off first, that is never both.
        unsafe {
            let off = u32::from(BRAKE_TOP) + 1;
            if self.timer.ccr4().read().bits() != u32::from(upper) {
                self.timer.ccr4().write(|w| w.bits(off));
                self.timer.ccr3().write(|w| w.bits(lower.into()));
                self.timer.ccr4().write(|w| w.bits(upper.into()));
            }
        }
    }
}

/// All switches of the brake are off.
#[inline(always)]
fn brake_off() {
    // SAFETY: without preload the value acts at once; with it both switches are off without their outputs.
    unsafe { (*pac::TIM2::ptr()).ccer().write(|w| w.bits(0)) };
}

/// Bits of the registers: the clock of GPIOB, those of TIM1 and TIM2, the pins PB12 and PB2.
const PORTS: u32 = 1 << 1;
const TIM1: u32 = 1 << 0;
const TIM2: u32 = 1 << 0;
const ENABLE_LOW: u32 = 1 << (16 + 12);
const BRAKE_LOW: u32 = 1 << (16 + 2);

/// Takes the current from the motor and the brake resistor and closes the brake, whoever owns the pins. Nothing runs after it but a log line.
#[inline(always)]
pub fn cut() {
    // SAFETY: the owners of these registers never run again. The clocks come first, as this may be before they were set up; a pin that is no
    // output yet is held by the resistors around the chip.
    unsafe {
        let rcc = &*pac::RCC::ptr();
        rcc.ahb1enr().modify(|r, w| w.bits(r.bits() | PORTS));
        rcc.apb2enr().modify(|r, w| w.bits(r.bits() | TIM1));
        rcc.apb1enr().modify(|r, w| w.bits(r.bits() | TIM2));
        (*pac::GPIOB::ptr())
            .bsrr()
            .write(|w| w.bits(ENABLE_LOW | BRAKE_LOW));
    }
    pwm::outputs_off();
    brake_off();
}
