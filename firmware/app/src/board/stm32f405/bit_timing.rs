//! Bit timing of the CAN controller, from its clock of 42 MHz.
//!
//! The prescaler makes time quanta from the clock. A bit is the synchronisation quantum, segment 1, the sample, segment 2.
//! CiA 301 wants the sample at 87.5 % of the bit. From 42 MHz that is exact where the quanta of a bit can be a multiple of
//! 8; elsewhere it is 85.7 % (12 of 14) or 86.7 % (13 of 15), inside the range of the standard (85 % to 90 %).
//! 800 kbit/s cannot be made: it would take 52.5 clocks a bit.

use canopen::BitRate;

const CLOCK_KHZ: u32 = 42_000;

/// How a bit is made.
struct Timing {
    bit_rate: BitRate,
    /// Clocks in a quantum.
    prescaler: u32,
    /// Quanta between the synchronisation quantum and the sample.
    segment_1: u32,
    /// Quanta behind the sample. Resynchronisation may move the sample by as many.
    segment_2: u32,
}

const fn timing(bit_rate: BitRate, prescaler: u32, segment_1: u32, segment_2: u32) -> Timing {
    Timing {
        bit_rate,
        prescaler,
        segment_1,
        segment_2,
    }
}

/// What can be made from this clock: all of CiA 301 but 800 kbit/s.
const TIMINGS: [Timing; 7] = [
    timing(BitRate::Kbit1000, 3, 11, 2),
    timing(BitRate::Kbit500, 6, 11, 2),
    timing(BitRate::Kbit250, 21, 6, 1),
    timing(BitRate::Kbit125, 21, 13, 2),
    timing(BitRate::Kbit50, 105, 6, 1),
    timing(BitRate::Kbit20, 140, 12, 2),
    timing(BitRate::Kbit10, 525, 6, 1),
];

/// The bit rates that can be made.
pub const BIT_RATES: [BitRate; TIMINGS.len()] = {
    let mut bit_rates = [BitRate::Kbit1000; TIMINGS.len()];
    let mut i = 0;
    while i < TIMINGS.len() {
        bit_rates[i] = TIMINGS[i].bit_rate;
        i += 1;
    }
    bit_rates
};

/// The value of the bit timing register CAN_BTR (RM0090, 32.9.2); `None` for a bit rate that cannot be made.
pub fn register(bit_rate: BitRate) -> Option<u32> {
    TIMINGS
        .iter()
        .find(|timing| timing.bit_rate == bit_rate)
        .map(Timing::register)
}

impl Timing {
    /// Every field of the register is one less than what it means.
    const fn register(&self) -> u32 {
        let jump = self.segment_2;
        (jump - 1) << 24
            | (self.segment_2 - 1) << 20
            | (self.segment_1 - 1) << 16
            | (self.prescaler - 1)
    }

    /// Quanta in a bit.
    const fn quanta(&self) -> u32 {
        1 + self.segment_1 + self.segment_2
    }

    /// The sample point in thousandths of the bit.
    const fn sample_point(&self) -> u32 {
        (1 + self.segment_1) * 1000 / self.quanta()
    }
}

// Every bit rate is exact, sampled where the standard allows, and fits the fields of the register.
const _: () = {
    let registers = [
        0x011A_0002,
        0x011A_0005,
        0x0005_0014,
        0x011C_0014,
        0x0005_0068,
        0x011B_008B,
        0x0005_020C,
    ];
    let mut i = 0;
    while i < TIMINGS.len() {
        let timing = &TIMINGS[i];
        let clocks = timing.bit_rate.kbit_per_second() * timing.quanta() * timing.prescaler;
        assert!(clocks == CLOCK_KHZ);
        assert!(850 <= timing.sample_point() && timing.sample_point() <= 880);
        assert!(1 <= timing.segment_1 && timing.segment_1 <= 16);
        // As the jump it has to fit two bits.
        assert!(1 <= timing.segment_2 && timing.segment_2 <= 4);
        assert!(1 <= timing.prescaler && timing.prescaler <= 1024);
        assert!(timing.register() == registers[i]);
        i += 1;
    }
};
