//! The registers that pulse output touches, by the names of the reference manual (RM0090).

/// One register. `TIM1` makes the pulses, `TIM2` counts them, stream 5 of `DMA2` (channel 6, TIM1_UP) feeds them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Register {
    /// TIM1_CR1: control register 1.
    Cr1,
    /// TIM1_CR2: control register 2; what TIM1 shows to TIM2.
    Cr2,
    /// TIM1_SMCR: slave mode; none.
    Smcr,
    /// TIM1_DIER: DMA and interrupt enable.
    Dier,
    /// TIM1_SR: status; a flag is cleared by writing 0 to it.
    Sr,
    /// TIM1_EGR: event generation.
    Egr,
    /// TIM1_CCMR1: modes of channels 1 and 2.
    Ccmr1,
    /// TIM1_CCER: outputs of the channels.
    Ccer,
    /// TIM1_PSC: prescaler, preloaded.
    Psc,
    /// TIM1_ARR: period less one, preloaded.
    Arr,
    /// TIM1_RCR: periods of a run less one, preloaded.
    Rcr,
    /// TIM1_CCR1: width of a pulse, preloaded.
    Ccr1,
    /// TIM1_CCR2: direction, preloaded: 0 is low, more than ARR is high.
    Ccr2,
    /// TIM1_BDTR: break input and main output enable.
    Bdtr,
    /// TIM1_DCR: where a DMA burst begins and how long it is.
    Dcr,
    /// DMA2_S5CR: the stream.
    StreamCr,
    /// DMA2_S5PAR: where the stream writes, [`bits::TIM1_DMAR`].
    StreamPar,
    /// DMA2_S5M0AR: where it reads, the ring ([`Ring::address`](super::Ring::address)).
    StreamM0ar,
    /// DMA2_S5FCR: the FIFO of the stream; 0 is direct mode.
    StreamFcr,
    /// DMA2_S5NDTR: words left in this round.
    StreamNdtr,
    /// DMA2_HIFCR: clears the flags of the stream.
    StreamFlags,
    /// TIM2_CR1.
    CounterCr1,
    /// TIM2_SMCR: what TIM2 counts.
    CounterSmcr,
    /// TIM2_CCMR1: capture channels 1 and 2.
    CounterCcmr1,
    /// TIM2_CCMR2: capture channels 3 and 4.
    CounterCcmr2,
    /// TIM2_CCER: edges that capture.
    CounterCcer,
    /// TIM2_DIER: its interrupts and DMA requests; none.
    CounterDier,
    /// TIM2_EGR: event generation.
    CounterEgr,
    /// TIM2_PSC: prescaler, preloaded.
    CounterPsc,
    /// TIM2_ARR: where it begins anew, 32 bits.
    CounterArr,
    /// TIM2_CNT: pulses that left, 32 bits.
    CounterCnt,
    /// TIM2_SR: what was captured; a flag is cleared by writing 0 to it, or by reading what was captured.
    CounterSr,
    /// TIM2_CCR1: the count at an edge of channel 1.
    CounterCcr1,
    /// TIM2_CCR2: the same of channel 2.
    CounterCcr2,
    /// TIM2_CCR4: the same of channel 4.
    CounterCcr4,
}

/// A timer with its DMA stream, and the timer that counts its pulses.
pub trait Registers {
    /// Writes a register. Of the addresses of the stream, only those named at [`Register::StreamPar`] and [`Register::StreamM0ar`] are written.
    fn write(&mut self, register: Register, value: u32);

    /// Reads a register. It has no effect but in a capture register of the counter, where it clears the flag.
    fn read(&self, register: Register) -> u32;

    /// A free-running count in ticks of TIM1's clock, from the same oscillator; wraps after 32 bits.
    fn now(&self) -> u32;

    /// Resets TIM1, so that nothing is left of a burst that it wants; its registers have what they have after a reset, and its pins are not driven
    /// until they are written.
    fn reset(&mut self);
}

/// Bits of these registers.
pub mod bits {
    /// CR1: the counter runs.
    pub const CEN: u32 = 1 << 0;
    /// CR1: a generated update event ([`UG`]) asks for no DMA.
    pub const URS: u32 = 1 << 2;
    /// CR1: ARR is preloaded.
    pub const ARPE: u32 = 1 << 7;
    /// CR2: TRGO is OC1REF (MMS = 100).
    pub const TRGO_OC1REF: u32 = 0b100 << 4;
    /// DIER: an update event asks for DMA.
    pub const UDE: u32 = 1 << 8;
    /// DIER: the break input interrupts.
    pub const BIE: u32 = 1 << 7;
    /// SR: the break input was active.
    pub const BIF: u32 = 1 << 7;
    /// EGR: an update event now; the counter begins anew and preloaded values act.
    pub const UG: u32 = 1 << 0;
    /// CCMR1: mode of channel 1 (OC1M).
    pub const OC1M: u32 = 0b111 << 4;
    /// CCMR1: channel 1 in PWM mode 1, CCR1 preloaded.
    pub const CHANNEL_1_PWM: u32 = 0b110 << 4 | 1 << 3;
    /// CCMR1: channel 1 forced low.
    pub const CHANNEL_1_LOW: u32 = 0b100 << 4 | 1 << 3;
    /// CCMR1: channel 2 in PWM mode 1, CCR2 preloaded.
    pub const CHANNEL_2_PWM: u32 = 0b110 << 12 | 1 << 11;
    /// CCER: the outputs OC1N and OC2N (which follow OC1REF and OC2REF when OC1 and OC2 are off).
    pub const OUTPUTS: u32 = 1 << 2 | 1 << 6;
    /// BDTR: outputs are driven while they are off (OSSI, OSSR), low. The break input is on, low is active.
    pub const BREAK: u32 = 1 << 10 | 1 << 11 | 1 << 12;
    /// BDTR: main output enable. The break input clears it by hardware.
    pub const MOE: u32 = 1 << 15;
    /// DCR: a burst of five words from PSC on.
    pub const BURST_FROM_PSC: u32 = 4 << 8 | 10;
    /// DMA_SxPAR: TIM1_DMAR, which spreads a burst over the registers that DCR names.
    pub const TIM1_DMAR: u32 = 0x4001_004C;
    /// DMA_SxCR: channel 6, priority very high, words on both sides, memory address counts up, round and round, memory to
    /// peripheral; direct mode.
    pub const STREAM: u32 =
        6 << 25 | 0b11 << 16 | 0b10 << 13 | 0b10 << 11 | 1 << 10 | 1 << 8 | 1 << 6;
    /// DMA_SxCR: the stream is on.
    pub const STREAM_ON: u32 = 1 << 0;
    /// DMA_HIFCR: all flags of stream 5.
    pub const STREAM_5_FLAGS: u32 = 0b11_1101 << 6;
    /// SMCR: external clock mode 1 (SMS) from internal trigger 0 (TS), which is TIM1 for TIM2.
    pub const COUNT_TIM1: u32 = 0b111;
    /// CCMR of a capture pair: both channels are inputs of their own pins, with a filter of 8 samples (ICF = 3).
    pub const CAPTURE_PAIR: u32 = 0b01 | 3 << 4 | 0b01 << 8 | 3 << 12;
    /// SR of the counter: channel 1 has captured (CC1IF); the flags of the others follow.
    pub const CC1IF: u32 = 1 << 1;
    /// SR of the counter: channel 2 has captured.
    pub const CC2IF: u32 = 1 << 2;
    /// SR of the counter: channel 4 has captured.
    pub const CC4IF: u32 = 1 << 4;
    /// CCER: four channels capture both edges (CCxE, CCxP, CCxNP).
    pub const CAPTURE_BOTH_EDGES: u32 = 0xBBBB;
}
