//! The power stage of M0 for the control tick: its gate driver, its temperature, its brake and the watchdog. What the loops do is on the other side of the link.

use cia402::Inputs;
use runtime::servo::Link;
use servo::stage::GateDriver;
use stm32f4xx_hal::gpio::{Input, Output, PB12, PB2, PD2};
use stm32f4xx_hal::pac;

use super::converters::Slow;
use super::gates::Words;
use super::{motor, pwm};
use crate::board::chip::watchdog::Watchdog;
use crate::board::Stage;

/// 2350h, load level warning (I²t): the heat has come near its bound.
const HEAT: u16 = 0x2350;

/// The bus from which on there is something to drive a motor with, in mV.
const FED: u32 = (0.6 * 1_000.0 * motor::DATA.stage.voltage) as u32;

/// Ticks for which a fault of the gate driver is told before it is cleared.
const TOLD: u16 = 200;

/// See the module.
pub struct ServoStage {
    link: &'static Link,
    driver: GateDriver,
    words: Words,
    enable: PB12<Output>,
    fault: PD2<Input>,
    brake: PB2<Output>,
    slow: Slow,
    watchdog: Watchdog,
    is_fed: bool,
    /// Ticks without current since a fault of the gate driver.
    told: u16,
}

/// What the stage is made of.
pub struct Pieces {
    pub words: Words,
    pub enable: PB12<Output>,
    pub fault: PD2<Input>,
    pub brake: PB2<Output>,
    pub slow: Slow,
    pub watchdog: Watchdog,
}

impl ServoStage {
    /// The stage, off.
    pub fn new(link: &'static Link, pieces: Pieces) -> Self {
        let Pieces {
            words,
            enable,
            fault,
            brake,
            slow,
            watchdog,
        } = pieces;
        Self {
            link,
            driver: GateDriver::new(motor::GATES),
            words,
            enable,
            fault,
            brake,
            slow,
            watchdog,
            is_fed: false,
            told: 0,
        }
    }

    /// A word to the gate driver, and what it has said.
    fn attend_driver(&mut self) {
        let answer = self.words.take();
        let is_well = self.fault.is_high();
        let action = self.driver.tick(answer, is_well, self.is_fed);
        self.enable.set_state(action.enable.into());
        if let Some(word) = action.send {
            self.words.send(word);
        }
        if self.driver.is_ready() {
            pwm::go_on();
        }
    }
}

impl Stage for ServoStage {
    fn supply(&self) -> bool {
        self.is_fed && self.driver.is_set_up()
    }

    fn fault(&self) -> Option<u16> {
        self.link.told().fault.or(self.driver.fault())
    }

    fn measure(&mut self, inputs: &mut Inputs) {
        let told = self.link.told();
        self.is_fed = told.millivolts >= FED;
        self.attend_driver();
        self.slow.advance();
        let temperature = self.slow.temperature;
        inputs.temperature = temperature;
        inputs.analogue = self.slow.input;
        inputs.supply_voltage = Some(told.millivolts);
        inputs.warning = told.is_hot.then_some(HEAT);
        inputs.stall = Some(told.is_stalled);
        inputs.position_tolerance = told.position_tolerance;
        // Before the first reading there is no current.
        let hot = temperature.unwrap_or(0);
        let fault = self.driver.fault();
        let is_off = fault.is_some() || !self.driver.is_ready() || temperature.is_none();
        self.link.measured(hot, is_off);
    }

    fn set_power(&mut self, on: bool) {
        self.link.energise(on);
        if on || self.driver.fault().is_none() {
            self.told = 0;
            return;
        }
        self.told += 1;
        if self.told >= TOLD {
            self.told = 0;
            self.driver.mend();
        }
    }

    // No pin is left for them.
    fn set_outputs(&mut self, _levels: u8) {}

    fn set_brake(&mut self, open: bool) {
        self.brake.set_state(open.into());
    }

    fn feed_watchdog(&mut self) {
        self.watchdog.feed();
    }
}

/// Whether the gates let current into the motor.
pub fn has_power() -> bool {
    pwm::are_gates_on()
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
    pwm::gates_off();
    pwm::brake_off();
}
