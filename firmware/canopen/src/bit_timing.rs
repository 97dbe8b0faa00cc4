//! How a CAN controller makes a bit (ISO 11898-1), computed from its clock.
//!
//! The prescaler makes time quanta from the clock. A bit is the synchronisation quantum, segment 1, the sample, segment 2. CiA 301
//! wants the sample at 87.5 % of the bit, and allows 85 % to 90 %.
//!
//! ```text
//!   | sync |      segment 1       | segment 2 |
//!   0      1                      ▲
//!                            sample, 87.5 %
//! ```
//!
//! Only bit rates that the clock makes exactly count: a rate that is a little wrong works on the desk and fails on a long network.
//! Of what is left the sample nearest to 87.5 % is taken, and of equal ones that with the most quanta, as it can be resynchronised
//! in the finest steps.

use crate::settings::BitRate;

/// What a controller can be set to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Most clocks in a quantum; one is the least.
    pub prescaler: u32,
    /// Most quanta between the synchronisation quantum and the sample; one is the least.
    pub segment_1: u32,
    /// Most quanta behind the sample; one is the least.
    pub segment_2: u32,
    /// Most quanta by which resynchronisation may move the sample.
    pub jump: u32,
}

impl Limits {
    /// The bxCAN of ST's microcontrollers (RM0090, 32.9.2).
    pub const BXCAN: Self = Self {
        prescaler: 1024,
        segment_1: 16,
        segment_2: 8,
        jump: 4,
    };
}

/// How a bit is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Timing {
    /// Clocks in a quantum.
    pub prescaler: u32,
    /// Quanta between the synchronisation quantum and the sample.
    pub segment_1: u32,
    /// Quanta behind the sample.
    pub segment_2: u32,
    /// Quanta by which resynchronisation may move the sample.
    pub jump: u32,
}

/// Where CiA 301 wants the sample, in thousandths of the bit.
const SAMPLE: u32 = 875;
/// The earliest and the latest that it allows.
const EARLIEST: u32 = 850;
const LATEST: u32 = 900;

/// Quanta of a bit that ISO 11898-1 provides for.
const FEWEST_QUANTA: u32 = 8;
const MOST_QUANTA: u32 = 25;

impl Timing {
    /// How a controller makes a bit rate from its clock; `None` if it cannot.
    pub const fn new(clock_hz: u32, bit_rate: BitRate, limits: &Limits) -> Option<Self> {
        let bits_per_second = bit_rate.kbit_per_second() * 1_000;
        let mut best: Option<Self> = None;
        let mut quanta = MOST_QUANTA;
        while quanta >= FEWEST_QUANTA {
            if let Some(timing) =
                Self::of_quanta(clock_hz, bits_per_second * quanta, quanta, limits)
            {
                best = match best {
                    Some(other) if other.error() <= timing.error() => Some(other),
                    _ => Some(timing),
                };
            }
            quanta -= 1;
        }
        best
    }

    /// The best bit of so many quanta.
    const fn of_quanta(
        clock_hz: u32,
        quanta_per_second: u32,
        quanta: u32,
        limits: &Limits,
    ) -> Option<Self> {
        // The slowest rate has 10 000 bits of 8 quanta.
        let Some(rest) = clock_hz.checked_rem(quanta_per_second) else {
            return None;
        };
        let Some(prescaler) = clock_hz.checked_div(quanta_per_second) else {
            return None;
        };
        // To the nearest quantum.
        let before_sample = (quanta * SAMPLE + 500) / 1_000;
        let timing = Self {
            prescaler,
            segment_1: before_sample - 1,
            segment_2: quanta - before_sample,
            jump: if quanta - before_sample < limits.jump {
                quanta - before_sample
            } else {
                limits.jump
            },
        };
        let fits = rest == 0
            && prescaler >= 1
            && prescaler <= limits.prescaler
            && timing.segment_1 <= limits.segment_1
            && timing.segment_2 >= 1
            && timing.segment_2 <= limits.segment_2
            && timing.sample_point() >= EARLIEST
            && timing.sample_point() <= LATEST;
        if fits { Some(timing) } else { None }
    }

    /// Quanta in a bit.
    pub const fn quanta(&self) -> u32 {
        self.segment_1
            .saturating_add(self.segment_2)
            .saturating_add(1)
    }

    /// The sample point in thousandths of the bit, rounded to the nearest.
    pub const fn sample_point(&self) -> u32 {
        let quanta = self.quanta();
        let before = self.segment_1.saturating_add(1).saturating_mul(1_000);
        match before.saturating_add(quanta / 2).checked_div(quanta) {
            Some(point) => point,
            None => 0,
        }
    }

    /// The value of the register CAN_BTR of a bxCAN (RM0090, 32.9.2), where every field is one less than what it means.
    pub const fn bxcan_register(&self) -> u32 {
        self.jump.wrapping_sub(1) << 24
            | self.segment_2.wrapping_sub(1) << 20
            | self.segment_1.wrapping_sub(1) << 16
            | self.prescaler.wrapping_sub(1)
    }

    /// How far the sample is from where it should be.
    const fn error(&self) -> u32 {
        self.sample_point().abs_diff(SAMPLE)
    }
}

/// The bit rates of a list that a controller makes from its clock, in the order of the list, and how many there are. What lies
/// behind them in the array means nothing.
pub const fn reachable<const N: usize>(
    clock_hz: u32,
    limits: &Limits,
    list: [BitRate; N],
) -> ([BitRate; N], usize) {
    let mut reachable = list;
    let mut count = 0;
    let mut rest: &[BitRate] = &list;
    while let [bit_rate, others @ ..] = rest {
        if Timing::new(clock_hz, *bit_rate, limits).is_some()
            && let Some((_, free)) = reachable.split_at_mut_checked(count)
            && let Some(place) = free.first_mut()
        {
            *place = *bit_rate;
            count += 1;
        }
        rest = others;
    }
    (reachable, count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cia305::DETECTABLE;

    /// Prescaler, segment 1, segment 2, sample point in thousandths, register.
    type Row = (BitRate, Option<(u32, u32, u32, u32, u32)>);

    const AT_42_MHZ: [Row; 9] = [
        (BitRate::Kbit1000, Some((3, 11, 2, 857, 0x011A_0002))),
        (BitRate::Kbit800, None),
        (BitRate::Kbit500, Some((6, 11, 2, 857, 0x011A_0005))),
        (BitRate::Kbit250, Some((21, 6, 1, 875, 0x0005_0014))),
        (BitRate::Kbit125, Some((21, 13, 2, 875, 0x011C_0014))),
        (BitRate::Kbit100, Some((28, 12, 2, 867, 0x011B_001B))),
        (BitRate::Kbit50, Some((105, 6, 1, 875, 0x0005_0068))),
        (BitRate::Kbit20, Some((140, 12, 2, 867, 0x011B_008B))),
        (BitRate::Kbit10, Some((525, 6, 1, 875, 0x0005_020C))),
    ];

    const AT_36_MHZ: [Row; 9] = [
        (BitRate::Kbit1000, Some((2, 15, 2, 889, 0x011E_0001))),
        (BitRate::Kbit800, Some((3, 12, 2, 867, 0x011B_0002))),
        (BitRate::Kbit500, Some((9, 6, 1, 875, 0x0005_0008))),
        (BitRate::Kbit250, Some((9, 13, 2, 875, 0x011C_0008))),
        (BitRate::Kbit125, Some((18, 13, 2, 875, 0x011C_0011))),
        (BitRate::Kbit100, Some((45, 6, 1, 875, 0x0005_002C))),
        (BitRate::Kbit50, Some((45, 13, 2, 875, 0x011C_002C))),
        (BitRate::Kbit20, Some((225, 6, 1, 875, 0x0005_00E0))),
        (BitRate::Kbit10, Some((225, 13, 2, 875, 0x011C_00E0))),
    ];

    #[test]
    fn every_bit_rate_is_as_the_table_has_it() {
        for (clock, table) in [(42_000_000, AT_42_MHZ), (36_000_000, AT_36_MHZ)] {
            for (bit_rate, row) in table {
                let found = Timing::new(clock, bit_rate, &Limits::BXCAN).map(|timing| {
                    (
                        timing.prescaler,
                        timing.segment_1,
                        timing.segment_2,
                        timing.sample_point(),
                        timing.bxcan_register(),
                    )
                });
                assert_eq!(found, row, "{bit_rate:?} from {clock} Hz");
            }
        }
    }

    #[test]
    fn every_timing_is_exact_and_fits_the_controller() {
        let limits = Limits::BXCAN;
        for clock_mhz in 1..=170 {
            let clock_hz = clock_mhz * 1_000_000;
            for bit_rate in DETECTABLE {
                let Some(timing) = Timing::new(clock_hz, bit_rate, &limits) else {
                    continue;
                };
                let bits = bit_rate.kbit_per_second() * 1_000;
                assert_eq!(timing.prescaler * timing.quanta() * bits, clock_hz);
                assert!((850..=900).contains(&timing.sample_point()));
                assert!((1..=limits.prescaler).contains(&timing.prescaler));
                assert!((1..=limits.segment_1).contains(&timing.segment_1));
                assert!((1..=limits.segment_2).contains(&timing.segment_2));
                assert!((1..=limits.jump.min(timing.segment_2)).contains(&timing.jump));
            }
        }
    }

    #[test]
    fn a_limit_may_be_reached_and_not_passed() {
        for bit_rate in BitRate::ALL {
            let timing = |limits: &Limits| Timing::new(36_000_000, bit_rate, limits);
            let best = timing(&Limits::BXCAN).unwrap();
            let reached = Limits {
                prescaler: best.prescaler,
                segment_1: best.segment_1,
                segment_2: best.segment_2,
                jump: best.jump,
            };
            assert_eq!(timing(&reached), Some(best), "{bit_rate:?}");
            let passed = [
                Limits {
                    prescaler: best.prescaler - 1,
                    ..reached
                },
                Limits {
                    segment_1: best.segment_1 - 1,
                    ..reached
                },
                Limits {
                    segment_2: best.segment_2 - 1,
                    ..reached
                },
            ];
            for limits in passed {
                assert_ne!(timing(&limits), Some(best), "{bit_rate:?}, {limits:?}");
            }
        }
    }

    #[test]
    fn a_clock_that_makes_no_bit_rate_reaches_none() {
        for clock in [0, 1, 999_983, 42_000_001] {
            for bit_rate in DETECTABLE {
                assert_eq!(Timing::new(clock, bit_rate, &Limits::BXCAN), None);
            }
        }
    }

    #[test]
    fn the_list_of_what_is_reachable_keeps_its_order() {
        let (rates, count) = reachable(42_000_000, &Limits::BXCAN, BitRate::ALL);
        let rates = &rates[..count];
        assert_eq!(count, 7);
        assert!(!rates.contains(&BitRate::Kbit800));
        assert!(rates.is_sorted_by_key(|rate| core::cmp::Reverse(rate.kbit_per_second())));
        assert_eq!(reachable(0, &Limits::BXCAN, BitRate::ALL).1, 0);
    }
}
