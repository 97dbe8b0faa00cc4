//! The power stage's pins and the watchdog.

use cia402::outputs::COUNT;
use cia402::Inputs;
use stm32f4xx_hal::gpio::{ErasedPin, Input, Output, PA2, PA3, PC0, PC2};
use stm32f4xx_hal::pac;

use super::converter::Converter;
use super::input_lines::Guard;
use crate::board::chip::output_pins::OutputPins;
use crate::board::chip::watchdog::Watchdog;
use crate::board::Stage;

/// Error code 5400h of CiA 402: the hardware of the power section.
const POWER_SECTION: u16 = 0x5400;

/// A step/direction driver.
pub struct StepStage {
    enable: PA2<Output>,
    fault: PA3<Input>,
    supply: PC0<Input>,
    brake: PC2<Output>,
    outputs: OutputPins<COUNT>,
    converter: Converter,
    watchdog: Watchdog,
    lines: Guard,
}

impl StepStage {
    /// The stage, off, and all outputs low.
    pub fn new(
        enable: PA2<Output>,
        fault: PA3<Input>,
        supply: PC0<Input>,
        brake: PC2<Output>,
        outputs: [ErasedPin<Output>; COUNT],
        converter: Converter,
        watchdog: Watchdog,
    ) -> Self {
        Self {
            enable,
            fault,
            supply,
            brake,
            outputs: OutputPins::new(outputs),
            converter,
            watchdog,
            lines: Guard::default(),
        }
    }
}

impl Stage for StepStage {
    fn supply(&self) -> bool {
        self.supply.is_high()
    }

    fn fault(&self) -> Option<u16> {
        // Without its supply a driver reports a fault that is none of its own.
        (self.supply() && self.fault.is_low()).then_some(POWER_SECTION)
    }

    fn set_power(&mut self, on: bool) {
        if on {
            self.enable.set_low();
        } else {
            self.enable.set_high();
        }
    }

    fn set_brake(&mut self, open: bool) {
        if open {
            self.brake.set_high();
        } else {
            self.brake.set_low();
        }
    }

    fn measure(&mut self, inputs: &mut Inputs) {
        self.lines.tick();
        self.converter.advance();
        inputs.analogue = self.converter.input;
        // There is no sensor at the stage; the chip beside it tells.
        inputs.temperature = self.converter.temperature;
    }

    fn set_outputs(&mut self, levels: u8) {
        self.outputs.set(levels);
    }

    fn feed_watchdog(&mut self) {
        self.watchdog.feed();
    }
}

/// Whether the stage has its supply and reports no fault.
pub fn is_well() -> bool {
    // SAFETY: reading the input registers of GPIOA and GPIOC has no effect.
    let (a, c) = unsafe {
        let (a, c) = (&*pac::GPIOA::ptr(), &*pac::GPIOC::ptr());
        (a.idr().read(), c.idr().read())
    };
    a.idr3().is_high() && c.idr0().is_high()
}

/// Bits of the registers: the clocks of GPIOA and GPIOC, the clock of TIM1, the pins PA2 and PC2.
const PORTS: u32 = 1 << 0 | 1 << 2;
const TIM1: u32 = 1 << 0;
const ENABLE_HIGH: u32 = 1 << 2;
const BRAKE_LOW: u32 = 1 << (16 + 2);

/// Takes the current from the motor, closes the brake and ends the pulses, whoever owns the pins. Nothing runs after it but a log line.
#[inline(always)]
pub fn cut() {
    // SAFETY: the owners of these registers never run again. The clocks come first, as this may be before they were set up; a pin that is no
    // output yet is held by the resistors around the chip. BDTR without MOE drives both outputs low, or leaves them to their resistors.
    unsafe {
        let rcc = &*pac::RCC::ptr();
        rcc.ahb1enr().modify(|r, w| w.bits(r.bits() | PORTS));
        rcc.apb2enr().modify(|r, w| w.bits(r.bits() | TIM1));
        (*pac::GPIOA::ptr()).bsrr().write(|w| w.bits(ENABLE_HIGH));
        (*pac::GPIOC::ptr()).bsrr().write(|w| w.bits(BRAKE_LOW));
        (*pac::TIM1::ptr())
            .bdtr()
            .modify(|_, w| w.moe().clear_bit());
    }
}

/// Whether the enable pin lets current into the motor.
pub fn has_power() -> bool {
    // SAFETY: reading the output register of GPIOA has no effect.
    unsafe { (*pac::GPIOA::ptr()).odr().read().odr2().is_low() }
}
