//! The three converters: by TIM1's trigger one each for the bus and two currents, together; between that the first has the analogue input and the thermistor of the stage
//! in turn, for the control tick.

use servo::interrupt::Counts;
use servo::stage::thermistor;
use stm32f4xx_hal::gpio::{Analog, PC4, PC5};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc};

use crate::board::own;

/// The channels of the injected conversions.
pub struct Channels {
    pub bus: u32,
    pub currents: [u32; 2],
}

/// Those of PC4 and PC5.
const INPUT: u8 = 14;
const THERMISTOR: u8 = 15;

/// Bits of the registers (RM0090, 13.13).
mod bits {
    pub const JEOC: u32 = 1 << 2;
    pub const JSTRT: u32 = 1 << 3;
    /// CR1: an interrupt at the end of the injected conversion.
    pub const JEOCIE: u32 = 1 << 7;
    /// CR2: on; injected conversions at the rising edge of TIM1's trigger output.
    pub const ADON: u32 = 1;
    pub const BY_TIM1: u32 = 1 << 20 | 1 << 16;
    /// JSQR: the channel of a group of one.
    pub const JSQ4: u32 = 15;
}

/// The pins of what changes slowly.
pub type Pins = (PC4<Analog>, PC5<Analog>);

/// What the interrupt reads of them.
pub struct Currents {
    bus: pac::ADC1,
    first: pac::ADC2,
    second: pac::ADC3,
}

/// What the control tick has of the first: its regular conversions.
pub struct Slow {
    is_thermistor_next: bool,
    /// The analogue input, 0 to 4095.
    pub input: Option<u16>,
    /// Of the stage, in tenths of a degree Celsius.
    pub temperature: Option<i16>,
}

/// Starts all three. Nothing is converted before TIM1 says so.
pub fn start(
    (bus, first, second): (pac::ADC1, pac::ADC2, pac::ADC3),
    common: &pac::ADC_COMMON,
    channels: &Channels,
    _pins: Pins,
    rcc: &mut Rcc,
) -> (Currents, Slow) {
    pac::ADC1::enable(rcc);
    pac::ADC2::enable(rcc);
    pac::ADC3::enable(rcc);
    // 21 MHz of at most 36. The currents have 3 clocks to be sampled, with 12 to convert 0.7 µs; what changes slowly 144, 7 µs: all of it lies between two triggers.
    common.ccr().modify(|_, w| w.adcpre().div4());
    bus.smpr1()
        .modify(|_, w| w.smp14().cycles144().smp15().cycles144());
    // SAFETY: bits of these registers, and channels of these converters.
    unsafe {
        let [one, other] = channels.currents;
        bus.jsqr().write(|w| w.bits(channels.bus << bits::JSQ4));
        first.jsqr().write(|w| w.bits(one << bits::JSQ4));
        second.jsqr().write(|w| w.bits(other << bits::JSQ4));
        // They end together.
        second.cr1().write(|w| w.bits(bits::JEOCIE));
        bus.cr2().write(|w| w.bits(bits::ADON | bits::BY_TIM1));
        first.cr2().write(|w| w.bits(bits::ADON | bits::BY_TIM1));
        second.cr2().write(|w| w.bits(bits::ADON | bits::BY_TIM1));
    }
    let slow = Slow {
        is_thermistor_next: false,
        input: None,
        temperature: None,
    };
    (Currents { bus, first, second }, slow)
}

impl Currents {
    /// What was converted, with the timer of the encoder beside it. The interrupt is served.
    #[inline]
    pub fn read(&mut self, timer: u16) -> Counts {
        let counts = Counts {
            currents: own::three_currents(
                self.first.jdr1().read().jdata().bits(),
                self.second.jdr1().read().jdata().bits(),
            ),
            bus: self.bus.jdr1().read().jdata().bits(),
            timer,
        };
        self.pass();
        counts
    }

    /// What was converted is not looked at. The interrupt is served.
    #[inline]
    pub fn pass(&mut self) {
        let served = !(bits::JEOC | bits::JSTRT) & 0x3F;
        // SAFETY: a 0 clears a flag of the register, and a 1 does nothing.
        unsafe { self.second.sr().write(|w| w.bits(served)) };
    }
}

impl Slow {
    /// Takes what is there, and begins the next conversion. Called from the control tick.
    pub fn advance(&mut self) {
        // SAFETY: of the converter the interrupt has the injected results alone, and its settings stay. These registers are for the regular conversions. One that makes way for an
        // injected one begins anew by itself.
        let adc = unsafe { &*pac::ADC1::ptr() };
        if adc.sr().read().eoc().is_complete() {
            let raw = adc.dr().read().data().bits();
            // What was begun last is the other one of what is next.
            if self.is_thermistor_next {
                self.input = Some(raw);
            } else {
                self.temperature = Some(thermistor::tenths(raw));
            }
        }
        let channel = if self.is_thermistor_next {
            THERMISTOR
        } else {
            INPUT
        };
        self.is_thermistor_next = !self.is_thermistor_next;
        // SAFETY: both are channels of this converter.
        adc.sqr3().write(|w| unsafe { w.sq1().bits(channel) });
        adc.cr2().modify(|_, w| w.swstart().start());
    }
}
