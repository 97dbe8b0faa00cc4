//! The power stage for the control tick: what drives its gates, its temperature, its brake, the
//! outputs and the watchdog. What the loops do is on the other side of the link.

use cia402::Inputs;
use stm32f4xx_hal::gpio::{ErasedPin, Output};

use super::converters::Slow;
use super::LINK;
use crate::board::chip::output_pins::OutputPins;
use crate::board::chip::watchdog::Watchdog;
use crate::board::{own, Stage};

/// 2350h, load level warning (I²t): the heat has come near its bound.
const HEAT: u16 = 0x2350;

/// The bus from which on there is something to drive a motor with, in mV.
const FED: u32 = (0.6 * 1_000.0 * own::DATA.stage.voltage) as u32;

/// Ticks for which a fault of the driver is told before it is cleared.
const TOLD: u16 = 200;

/// What drives the gates, for the control tick.
pub trait Driver {
    /// A tick; without the bus there is nothing to drive.
    fn tick(&mut self, is_fed: bool);

    /// It has what it needs, whatever has become of it since.
    fn is_set_up(&self) -> bool;

    /// The gates may be on.
    fn is_ready(&self) -> bool;

    /// A fault as an error code of CiA 402.
    fn fault(&self) -> Option<u16>;

    /// The fault was told, and there is no current: what has latched is cleared.
    fn mend(&mut self);
}

/// See the module.
pub struct ServoStage<D, const OUTPUTS: usize> {
    driver: D,
    brake: ErasedPin<Output>,
    outputs: OutputPins<OUTPUTS>,
    slow: Slow,
    watchdog: Watchdog,
    is_fed: bool,
    /// Ticks without current since a fault of the driver.
    told: u16,
}

impl<D: Driver, const OUTPUTS: usize> ServoStage<D, OUTPUTS> {
    /// The stage, off, the brake closed and all outputs low.
    pub fn new(
        driver: D,
        brake: ErasedPin<Output>,
        outputs: [ErasedPin<Output>; OUTPUTS],
        slow: Slow,
        watchdog: Watchdog,
    ) -> Self {
        Self {
            driver,
            brake,
            outputs: OutputPins::new(outputs),
            slow,
            watchdog,
            is_fed: false,
            told: 0,
        }
    }
}

impl<D: Driver, const OUTPUTS: usize> Stage for ServoStage<D, OUTPUTS> {
    fn supply(&self) -> bool {
        self.is_fed && self.driver.is_set_up()
    }

    fn fault(&self) -> Option<u16> {
        LINK.status().fault.or(self.driver.fault())
    }

    fn measure(&mut self, inputs: &mut Inputs) {
        let status = LINK.status();
        self.is_fed = status.millivolts >= FED;
        self.driver.tick(self.is_fed);
        self.slow.advance();
        let temperature = self.slow.temperature;
        inputs.temperature = temperature;
        inputs.analogue = self.slow.input;
        inputs.supply_voltage = Some(status.millivolts);
        inputs.warning = status.is_hot.then_some(HEAT);
        inputs.stall = Some(status.is_stalled);
        inputs.position_tolerance = status.position_tolerance;
        // Before the first reading there is no current.
        let hot = temperature.unwrap_or(0);
        let fault = self.driver.fault();
        let is_off = fault.is_some() || !self.driver.is_ready() || temperature.is_none();
        LINK.set_stage(hot, is_off);
    }

    fn set_power(&mut self, on: bool) {
        LINK.energise(on);
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

    fn set_outputs(&mut self, levels: u8) {
        self.outputs.set(levels);
    }

    fn set_brake(&mut self, open: bool) {
        self.brake.set_state(open.into());
    }

    fn feed_watchdog(&mut self) {
        self.watchdog.feed();
    }
}
