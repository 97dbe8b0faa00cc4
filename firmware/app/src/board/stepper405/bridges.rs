//! The two full bridges: TIM1's four channels, a half bridge each, and the driver behind them with
//! its enable and its fault line.
//!
//! All four channels make pulses, so none is left to start the converters just before the top: each
//! update event does, at the top and at the bottom, and what is converted at the bottom, where the
//! upper switches are on and the widths have just been taken over, is not looked at. An odd
//! repetition counter would bring an event at one end alone, but the widths would be taken over at
//! that end alone too, half a period late.
//!
//! An input that is low turns the lower switch on, so the enable alone takes the current:
//! it is what the gates are here.

use servo::modulation::Widths;
use servo::stage::BridgeDriver;
use stm32f4xx_hal::gpio::{Input, Output, PA3, PB13};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::Rcc;

use crate::board::chip::CORE_HZ;
use crate::board::servo_stage::pwm::{self, bits, Motor, Settings, COUNTER};
use crate::board::servo_stage::{self, stage};

const SETTINGS: Settings = Settings {
    // The update event.
    trigger: 2 << 4,
    fourth: (bits::BELOW, 0),
    // Channels 1 to 4, without complements.
    outputs: 0x1111,
};

/// Half a period, 20 kHz.
pub const TOP: u16 = 4_200;

/// Clocks between the switches of a half bridge: the driver has its own.
pub const DEAD: u8 = 0;

/// CR1 of TIM1: it counts down.
const DIR: u32 = 1 << 4;

/// The pin of the enable, PB13, in BSRR.
const ENABLE_HIGH: u32 = 1 << 13;
const ENABLE_LOW: u32 = 1 << (16 + 13);

/// The timer. The interrupt of the currents has it.
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
    /// Behind the top it counts down.
    #[inline]
    fn is_sampled(&self) -> bool {
        // SAFETY: reading the register has no effect.
        let cr1 = unsafe { (*pac::TIM1::ptr()).cr1().read().bits() };
        cr1 & DIR != 0
    }

    #[inline]
    fn put(&mut self, [a, b, _]: Widths) {
        self.motor.put(|timer| {
            let [a, back_a] = COUNTER.full_bridge(a).map(u32::from);
            let [b, back_b] = COUNTER.full_bridge(b).map(u32::from);
            // SAFETY: compare values up to the top.
            unsafe {
                timer.ccr1().write(|w| w.bits(a));
                timer.ccr2().write(|w| w.bits(back_a));
                timer.ccr3().write(|w| w.bits(b));
                timer.ccr4().write(|w| w.bits(back_b));
            }
        });
    }

    fn off(&mut self) {
        self.motor.off();
    }
}

/// There is no brake resistor.
pub struct Brake;

impl servo_stage::Brake for Brake {
    fn burn(&mut self, _share: f32) {}
}

#[inline(always)]
fn set_enable(bit: u32) {
    // SAFETY: a bit of a register that changes no other pin.
    unsafe { (*pac::GPIOB::ptr()).bsrr().write(|w| w.bits(bit)) };
}

/// The bridges follow the timer. For the interrupt of the currents.
pub fn gates_on() {
    pwm::outputs_on();
    set_enable(ENABLE_HIGH);
}

/// All switches are off.
#[inline(always)]
pub fn gates_off() {
    set_enable(ENABLE_LOW);
    pwm::outputs_off();
}

/// Whether the gates may be on.
pub fn has_power() -> bool {
    pwm::are_outputs_on()
}

/// The driver for the control tick.
pub struct Driver {
    driver: BridgeDriver,
    enable: PB13<Output>,
    fault: PA3<Input>,
}

impl Driver {
    /// Its enable is low.
    pub fn new(enable: PB13<Output>, fault: PA3<Input>) -> Self {
        Self {
            driver: BridgeDriver::new(),
            enable,
            fault,
        }
    }
}

impl stage::Driver for Driver {
    fn tick(&mut self, is_fed: bool) {
        if !self.driver.is_set_up() {
            pwm::go_on();
        }
        // What was shorter than a tick has taken the current too.
        let is_well = self.fault.is_high() && !pwm::has_tripped();
        self.driver.tick(is_well, is_fed);
    }

    fn is_set_up(&self) -> bool {
        self.driver.is_set_up()
    }

    fn is_ready(&self) -> bool {
        self.driver.is_ready()
    }

    fn fault(&self) -> Option<u16> {
        self.driver.fault()
    }

    /// The rising edge clears what has latched. For the microsecond behind it the lower switches
    /// are on.
    fn mend(&mut self) {
        self.enable.set_high();
        cortex_m::asm::delay(CORE_HZ / 1_000_000);
        self.enable.set_low();
        pwm::go_on();
        self.driver.mend();
    }
}

/// Bits of the registers: the clocks of GPIOB and GPIOC, that of TIM1, the pin PC2.
const PORTS: u32 = 1 << 1 | 1 << 2;
const TIM1: u32 = 1 << 0;
const BRAKE_LOW: u32 = 1 << (16 + 2);

/// Takes the current from the motor and closes the brake, whoever owns the pins. Nothing runs after
/// it but a log line.
#[inline(always)]
pub fn cut() {
    // SAFETY: the owners of these registers never run again. The clocks come first, as this may be
    // before they were set up; a pin that is no output yet is held by the resistors around the
    // chip.
    unsafe {
        let rcc = &*pac::RCC::ptr();
        rcc.ahb1enr().modify(|r, w| w.bits(r.bits() | PORTS));
        rcc.apb2enr().modify(|r, w| w.bits(r.bits() | TIM1));
        (*pac::GPIOC::ptr()).bsrr().write(|w| w.bits(BRAKE_LOW));
    }
    gates_off();
}
