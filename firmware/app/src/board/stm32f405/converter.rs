//! The converter ADC1: the analogue input, PC4, and the temperature of the chip, in turn.
//!
//! Nobody waits for it. Each call takes the result of the conversion before and begins the next, so that either value is two calls
//! old at most.

use stm32f4xx_hal::gpio::{Analog, PC4};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc};
use stm32f4xx_hal::signature::{VtempCal110, VtempCal30};

/// The channel of PC4.
const INPUT: u8 = 14;
/// The channel of the temperature sensor.
const SENSOR: u8 = 16;

/// ADC1 at work.
pub struct Converter {
    adc: pac::ADC1,
    _pin: PC4<Analog>,
    is_sensor_next: bool,
    /// What the sensor reads at 30 °C and at 110 °C, measured by the maker (3.3 V).
    calibration: (u16, u16),
    /// The analogue input, 0 to 4095.
    pub input: Option<u16>,
    /// The temperature of the chip in tenths of a degree Celsius.
    pub temperature: Option<i16>,
}

impl Converter {
    /// Starts the converter.
    pub fn new(adc: pac::ADC1, common: &pac::ADC_COMMON, pin: PC4<Analog>, rcc: &mut Rcc) -> Self {
        pac::ADC1::enable(rcc);
        // 21 MHz of at most 36, and 480 clocks to sample: 23 µs, of which the sensor needs 10.
        common
            .ccr()
            .modify(|_, w| w.adcpre().div4().tsvrefe().enabled());
        adc.smpr1()
            .modify(|_, w| w.smp14().cycles480().smp16().cycles480());
        adc.cr2().modify(|_, w| w.adon().enabled());
        Self {
            adc,
            _pin: pin,
            is_sensor_next: false,
            calibration: (VtempCal30::get().read(), VtempCal110::get().read()),
            input: None,
            temperature: None,
        }
    }

    /// Takes what is there, and begins the next conversion. Called from the control tick.
    pub fn advance(&mut self) {
        if self.adc.sr().read().eoc().is_complete() {
            let raw = self.adc.dr().read().data().bits();
            // What was begun last is the other one of what is next.
            if self.is_sensor_next {
                self.input = Some(raw);
            } else {
                self.temperature = self.tenths(raw);
            }
        }
        let channel = if self.is_sensor_next { SENSOR } else { INPUT };
        self.is_sensor_next = !self.is_sensor_next;
        // SAFETY: both are channels of this converter.
        self.adc.sqr3().write(|w| unsafe { w.sq1().bits(channel) });
        self.adc.cr2().modify(|_, w| w.swstart().start());
    }

    /// A reading of the sensor in tenths of a degree; `None` if the maker has not measured it.
    fn tenths(&self, raw: u16) -> Option<i16> {
        let (low, high) = self.calibration;
        let above = 800 * (i32::from(raw) - i32::from(low));
        let tenths = above.checked_div(i32::from(high) - i32::from(low))? + 300;
        i16::try_from(tenths).ok()
    }
}
