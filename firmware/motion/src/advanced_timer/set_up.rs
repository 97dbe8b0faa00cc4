//! What the timers and the stream are before the first train. Every register counts that what follows relies on: a boot loader or a debugger may have
//! left anything there.

use super::registers::{Register, Registers, bits};
use super::ring::Ring;

/// TIM1 and the stream: they stand still, the outputs are not driven until BDTR has MOE, and a break is seen.
pub(super) fn timer(registers: &mut impl Registers, ring: &Ring) {
    use Register as Reg;
    for (register, value) in [
        (Reg::Sr, 0),
        (Reg::Bdtr, bits::BREAK),
        (Reg::StreamCr, 0),
        (Reg::StreamFcr, 0),
        (Reg::StreamPar, bits::TIM1_DMAR),
        (Reg::StreamM0ar, ring.address()),
        (Reg::Cr1, bits::URS | bits::ARPE),
        (Reg::Cr2, bits::TRGO_OC1REF),
        (Reg::Smcr, 0),
        (Reg::Dier, 0),
        (Reg::Psc, 0),
        (Reg::Ccr1, 0),
        (Reg::Ccr2, 0),
        (Reg::Ccmr1, bits::CHANNEL_1_LOW | bits::CHANNEL_2_PWM),
        (Reg::Ccer, bits::OUTPUTS),
        (Reg::Dcr, bits::BURST_FROM_PSC),
    ] {
        registers.write(register, value);
    }
}

/// TIM2: it counts from 0, all 32 bits, and captures.
pub(super) fn counter(registers: &mut impl Registers) {
    use Register as Reg;
    for (register, value) in [
        (Reg::CounterCr1, 0),
        (Reg::CounterDier, 0),
        (Reg::CounterSmcr, bits::COUNT_TIM1),
        (Reg::CounterCcer, 0),
        (Reg::CounterCcmr1, bits::CAPTURE_PAIR),
        (Reg::CounterCcmr2, bits::CAPTURE_PAIR),
        (Reg::CounterCcer, bits::CAPTURE_BOTH_EDGES),
        (Reg::CounterPsc, 0),
        (Reg::CounterArr, u32::MAX),
        // The prescaler acts from an update event on.
        (Reg::CounterEgr, bits::UG),
        (Reg::CounterCnt, 0),
        (Reg::CounterCr1, bits::CEN),
        // A pin that was high when its channel was switched on is no edge.
        (Reg::CounterSr, 0),
    ] {
        registers.write(register, value);
    }
}
