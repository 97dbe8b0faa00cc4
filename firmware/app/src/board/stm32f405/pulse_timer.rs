//! TIM1, stream 5 of DMA2 and TIM2: the registers of step pulses, and nothing else. What is written to them, and when, is in
//! [`motion::advanced_timer`], which is tested on the host.
//!
//! TIM1 makes step (channel 1, complementary output) and direction (channel 2, complementary output), and its break input cuts
//! both off. TIM2 counts the steps by the internal trigger, and three of its channels capture the count at edges of the digital inputs.
//! TIM5 gives the time: it runs from the same oscillator at half the clock of TIM1.

use cia402::faults::of_pulses;
use motion::advanced_timer::{
    count_at_edge, on_break, CaptureChannel, Output, Register, Registers, Ring,
};
use motion::{PulseSink, Record, Ticks};
use stm32f4xx_hal::gpio::{Alternate, PA0, PA1, PB11, PB12, PB13, PB14};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use crate::board::{Pulses, Steps};

/// What the DMA reads.
static RING: Ring = Ring::new();

/// Offsets of registers in a timer (RM0090, 17.4.21 and 18.4.21).
mod offset {
    pub const CR1: usize = 0x00;
    pub const CR2: usize = 0x04;
    pub const SMCR: usize = 0x08;
    pub const DIER: usize = 0x0C;
    pub const SR: usize = 0x10;
    pub const EGR: usize = 0x14;
    pub const CCMR1: usize = 0x18;
    pub const CCMR2: usize = 0x1C;
    pub const CCER: usize = 0x20;
    pub const CNT: usize = 0x24;
    pub const PSC: usize = 0x28;
    pub const ARR: usize = 0x2C;
    pub const RCR: usize = 0x30;
    pub const CCR1: usize = 0x34;
    pub const CCR2: usize = 0x38;
    pub const CCR4: usize = 0x40;
    pub const BDTR: usize = 0x44;
    pub const DCR: usize = 0x48;
    pub const DMAR: usize = 0x4C;
    /// Of DMA2 (RM0090, 10.5.11): the flags of streams 4 to 7, and stream 5.
    pub const HIFCR: usize = 0x0C;
    pub const S5CR: usize = 0x88;
    pub const S5NDTR: usize = 0x8C;
    pub const S5PAR: usize = 0x90;
    pub const S5M0AR: usize = 0x94;
    pub const S5FCR: usize = 0x9C;
}

/// The pins of the pulses: step, direction, and the break input.
pub type PulsePins = (PB13<Alternate<1>>, PB14<Alternate<1>>, PB12<Alternate<1>>);

/// The pins that capture the count of steps.
pub type CapturePins = (PA0<Alternate<1>>, PA1<Alternate<1>>, PB11<Alternate<1>>);

/// The registers of TIM1, TIM2 and stream 5 of DMA2. [`start`] makes one for the control tick and one for the interrupts above it, from
/// the peripherals themselves: nobody else has them.
pub struct Timers(());

/// Gives the peripherals their clocks: pulses for the control tick, and what the interrupts ask of them.
pub fn start(
    peripherals: (pac::TIM1, pac::TIM2, pac::DMA2),
    pins: (PulsePins, CapturePins),
    rcc: &mut Rcc,
) -> (TimerPulses, Interrupts) {
    let (timers, interrupts) = Timers::new(peripherals, pins, rcc);
    (
        TimerPulses(Output::new(timers, &RING)),
        Interrupts(interrupts),
    )
}

impl Timers {
    fn new(
        (_tim1, _tim2, _dma2): (pac::TIM1, pac::TIM2, pac::DMA2),
        _pins: (PulsePins, CapturePins),
        rcc: &mut Rcc,
    ) -> (Self, Self) {
        // Entered without a reset of the chip, by a boot loader or a debugger, a timer may run and a stream may be on.
        pac::TIM1::enable(rcc);
        pac::TIM1::reset(rcc);
        pac::TIM2::enable(rcc);
        pac::TIM2::reset(rcc);
        pac::DMA2::enable(rcc);
        pac::DMA2::reset(rcc);
        (Self(()), Self(()))
    }

    /// Whether the stream can do no harm by this: it may read the ring, which lives for ever and is made of atomics, and write TIM1_DMAR, and
    /// nothing else.
    #[inline(always)]
    fn is_harmless(register: Register, value: u32) -> bool {
        match register {
            Register::StreamPar => value as usize == pac::TIM1::ptr() as usize + offset::DMAR,
            Register::StreamM0ar => value == RING.address(),
            _ => true,
        }
    }

    /// Where a register lies.
    fn address(register: Register) -> *mut u32 {
        let tim1 = pac::TIM1::ptr() as usize;
        let tim2 = pac::TIM2::ptr() as usize;
        let dma2 = pac::DMA2::ptr() as usize;
        let address = match register {
            Register::Cr1 => tim1 + offset::CR1,
            Register::Cr2 => tim1 + offset::CR2,
            Register::Smcr => tim1 + offset::SMCR,
            Register::Dier => tim1 + offset::DIER,
            Register::Sr => tim1 + offset::SR,
            Register::Egr => tim1 + offset::EGR,
            Register::Ccmr1 => tim1 + offset::CCMR1,
            Register::Ccer => tim1 + offset::CCER,
            Register::Psc => tim1 + offset::PSC,
            Register::Arr => tim1 + offset::ARR,
            Register::Rcr => tim1 + offset::RCR,
            Register::Ccr1 => tim1 + offset::CCR1,
            Register::Ccr2 => tim1 + offset::CCR2,
            Register::Bdtr => tim1 + offset::BDTR,
            Register::Dcr => tim1 + offset::DCR,
            Register::StreamCr => dma2 + offset::S5CR,
            Register::StreamPar => dma2 + offset::S5PAR,
            Register::StreamM0ar => dma2 + offset::S5M0AR,
            Register::StreamFcr => dma2 + offset::S5FCR,
            Register::StreamNdtr => dma2 + offset::S5NDTR,
            Register::StreamFlags => dma2 + offset::HIFCR,
            Register::CounterCr1 => tim2 + offset::CR1,
            Register::CounterSmcr => tim2 + offset::SMCR,
            Register::CounterCcmr1 => tim2 + offset::CCMR1,
            Register::CounterCcmr2 => tim2 + offset::CCMR2,
            Register::CounterCcer => tim2 + offset::CCER,
            Register::CounterDier => tim2 + offset::DIER,
            Register::CounterEgr => tim2 + offset::EGR,
            Register::CounterPsc => tim2 + offset::PSC,
            Register::CounterArr => tim2 + offset::ARR,
            Register::CounterCnt => tim2 + offset::CNT,
            Register::CounterSr => tim2 + offset::SR,
            Register::CounterCcr1 => tim2 + offset::CCR1,
            Register::CounterCcr2 => tim2 + offset::CCR2,
            Register::CounterCcr4 => tim2 + offset::CCR4,
        };
        address as *mut u32
    }
}

impl Registers for Timers {
    #[inline(always)]
    fn write(&mut self, register: Register, value: u32) {
        if !Self::is_harmless(register, value) {
            // Without its addresses the stream has an error at once, which is told.
            return;
        }
        // SAFETY: the address is that of a register of 32 bits of a peripheral that is for this type alone. None of them changes memory
        // but by the stream, whose addresses are harmless. A word is written whole, so two priorities may write.
        unsafe { Self::address(register).write_volatile(value) }
    }

    #[inline(always)]
    fn read(&self, register: Register) -> u32 {
        // SAFETY: as in `write`; reading one of these registers has no effect but on the flag of a capture.
        unsafe { Self::address(register).read_volatile() }
    }

    #[inline(always)]
    fn now(&self) -> u32 {
        // SAFETY: reading the counter of TIM5 has no effect, and nobody writes the timer once it runs.
        let half = unsafe { (*pac::TIM5::ptr()).cnt().read().bits() };
        half.wrapping_mul(2)
    }

    fn reset(&mut self) {
        // SAFETY: TIM1 is for this type alone. Nobody else writes the register of resets once the board is set up.
        unsafe { pac::TIM1::reset_unchecked() }
    }
}

/// Pulses for the control tick.
pub struct TimerPulses(Output<'static, Timers>);

impl PulseSink for TimerPulses {
    #[inline(always)]
    fn push(&mut self, record: Record) -> Result<(), Record> {
        self.0.push(record)
    }

    #[inline(always)]
    fn push_all(&mut self, records: &[Record]) -> usize {
        self.0.push_all(records)
    }

    fn pending(&self) -> Ticks {
        self.0.pending()
    }

    fn free(&self) -> usize {
        self.0.free()
    }
}

impl Pulses for TimerPulses {
    fn service(&mut self) {
        self.0.service();
    }

    fn position(&mut self) -> i64 {
        self.0.position()
    }

    fn position_at(&self, count: u32) -> i32 {
        self.0.position_at(count) as i32
    }

    fn drop_all(&mut self) {
        self.0.drop_all();
    }

    fn fault(&self) -> Option<u16> {
        of_pulses(self.0.has_failed(), self.0.is_broken())
    }

    fn mend(&mut self) {
        self.0.mend();
    }
}

/// What the interrupts of the inputs and of the break ask of the timers.
pub struct Interrupts(Timers);

impl Steps for Interrupts {
    fn on_interrupt(&mut self) {
        on_break(&mut self.0);
    }

    fn count(&mut self, input: usize) -> u32 {
        // What is not wired to a channel has no capture, and the counter is read a microsecond late.
        let channel = match input {
            0 => Some(CaptureChannel::One),
            1 => Some(CaptureChannel::Two),
            2 => Some(CaptureChannel::Four),
            _ => None,
        };
        count_at_edge(&self.0, channel)
    }
}
