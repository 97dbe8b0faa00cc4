//! The gate driver of M0: its enable and its fault line, and words over SPI3, one in a control tick. What they say is in [`servo::stage::drv8301`].

use servo::stage::GateDriver;
use stm32f4xx_hal::gpio::{Alternate, Input, Output, PB12, PC10, PC11, PC12, PC13, PD2};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use super::motor;
use crate::board::servo_stage::pwm;
use crate::board::servo_stage::stage::Driver;

/// Bits of CR1 (RM0090, 28.5.1): 16 bits, chip select by software, 42 MHz / 16, master; data are taken over at the second edge.
const CPHA: u16 = 1;
const MSTR: u16 = 1 << 2;
const BY_16: u16 = 3 << 3;
const SPE: u16 = 1 << 6;
const SSI: u16 = 1 << 8;
const SSM: u16 = 1 << 9;
const DFF: u16 = 1 << 11;

/// SPI3 with the gate driver.
pub struct Words {
    spi: pac::SPI3,
    select: PC13<Output>,
    is_sent: bool,
}

impl Words {
    /// Nothing is sent. `select` is high.
    pub fn new(
        spi: pac::SPI3,
        _pins: (PC10<Alternate<6>>, PC11<Alternate<6>>, PC12<Alternate<6>>),
        select: PC13<Output>,
        rcc: &mut Rcc,
    ) -> Self {
        pac::SPI3::enable(rcc);
        pac::SPI3::reset(rcc);
        let settings = CPHA | MSTR | BY_16 | SSI | SSM | DFF;
        // SAFETY: bits of the register.
        unsafe {
            spi.cr1().write(|w| w.bits(settings));
            spi.cr1().write(|w| w.bits(settings | SPE));
        }
        Self {
            spi,
            select,
            is_sent: false,
        }
    }

    /// What came with the word of the tick before, 6 µs of the millisecond since.
    pub fn take(&mut self) -> Option<u16> {
        if !core::mem::take(&mut self.is_sent) {
            return None;
        }
        self.select.set_high();
        let is_there = self.spi.sr().read().rxne().bit_is_set();
        is_there.then(|| self.spi.dr().read().dr().bits())
    }

    /// Sends a word; nobody waits for its end.
    pub fn send(&mut self, word: u16) {
        self.select.set_low();
        self.spi.dr().write(|w| w.dr().set(word));
        self.is_sent = true;
    }
}

/// See the module.
pub struct Gates {
    driver: GateDriver,
    words: Words,
    enable: PB12<Output>,
    fault: PD2<Input>,
}

impl Gates {
    /// It sleeps.
    pub fn new(words: Words, enable: PB12<Output>, fault: PD2<Input>) -> Self {
        Self {
            driver: GateDriver::new(motor::GATES),
            words,
            enable,
            fault,
        }
    }
}

impl Driver for Gates {
    fn tick(&mut self, is_fed: bool) {
        let answer = self.words.take();
        let is_well = self.fault.is_high();
        let action = self.driver.tick(answer, is_well, is_fed);
        self.enable.set_state(action.enable.into());
        if let Some(word) = action.send {
            self.words.send(word);
        }
        if self.driver.is_ready() {
            pwm::go_on();
        }
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

    fn mend(&mut self) {
        self.driver.mend();
    }
}
