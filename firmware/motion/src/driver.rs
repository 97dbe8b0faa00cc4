//! What the inputs of stepper drivers need. Where each number is from is told in `docs/step-engine.md`.

use crate::clock::Clock;
use crate::record::DriverTiming;

/// The step signal is high and low for so many nanoseconds at least. No driver needs less; and the timer that counts the pulses, at
/// half the clock of the one that makes them, would miss levels of two or three ticks.
const SHORTEST_PULSE: u32 = 100;

/// The times of a driver in nanoseconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Nanoseconds {
    /// Shortest time of the step signal being high.
    pub pulse_high: u32,
    /// Shortest time of the step signal being low.
    pub pulse_low: u32,
    /// From a change of direction to the next pulse.
    pub direction_setup: u32,
    /// From the end of a pulse to a change of direction.
    pub direction_hold: u32,
}

impl Nanoseconds {
    /// In ticks of a clock, rounded up, and brought into the range of [`DriverTiming`]. The step signal is high and low for 100 ns at
    /// least.
    pub fn in_ticks(self, clock: Clock) -> DriverTiming {
        let ticks = |nanoseconds: u32| {
            let product = u64::from(nanoseconds) * u64::from(clock.hz());
            u32::try_from(product.div_ceil(1_000_000_000)).unwrap_or(u32::MAX)
        };
        DriverTiming {
            pulse_high: ticks(self.pulse_high.max(SHORTEST_PULSE)),
            pulse_low: ticks(self.pulse_low.max(SHORTEST_PULSE)),
            direction_setup: ticks(self.direction_setup),
            direction_hold: ticks(self.direction_hold),
        }
        .checked()
    }
}

/// Drivers whose times are known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Driver {
    /// Allegro A4988.
    A4988,
    /// Texas Instruments DRV8825.
    Drv8825,
    /// Trinamic TMC2209.
    Tmc2209,
    /// Trinamic TMC5160 in step/direction mode.
    Tmc5160,
    /// ON Semiconductor LV8729.
    Lv8729,
    /// Toshiba TB6600, as on boards with optocouplers.
    Tb6600,
}

impl Driver {
    /// All of them, in the order of their numbers, from 1 on.
    pub const ALL: [Self; 6] = [
        Self::A4988,
        Self::Drv8825,
        Self::Tmc2209,
        Self::Tmc5160,
        Self::Lv8729,
        Self::Tb6600,
    ];

    /// Its times.
    pub const fn timing(self) -> Nanoseconds {
        let (pulse_high, pulse_low, direction) = match self {
            // Its data sheet.
            Self::A4988 => (1_000, 1_000, 200),
            // Its data sheet: 1.9 µs each at least, and 250 kHz at most.
            Self::Drv8825 => (1_900, 2_100, 650),
            // Typical in their data sheets. The worst is a clock of the chip and 20 ns: 107 ns at 11.5 MHz.
            Self::Tmc2209 | Self::Tmc5160 => (100, 100, 20),
            // Marlin, whose direction times are a guess.
            Self::Lv8729 => (500, 500, 500),
            // Marlin: 150 kHz at most; the direction times are a guess.
            Self::Tb6600 => (3_000, 3_667, 1_500),
        };
        Nanoseconds {
            pulse_high,
            pulse_low,
            direction_setup: direction,
            direction_hold: direction,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_rounded_up_to_ticks() {
        let clock = Clock::new(168_000_000).unwrap();
        let timing = Driver::Tmc2209.timing().in_ticks(clock);
        // 16.8 ticks, and 3.36.
        assert_eq!((timing.pulse_high, timing.pulse_low), (17, 17));
        assert_eq!((timing.direction_setup, timing.direction_hold), (4, 4));
        assert_eq!(clock.hz() / timing.shortest_period(), 4_941_176);
    }

    #[test]
    fn what_no_timer_can_do_is_cut() {
        let max = Nanoseconds {
            pulse_high: u32::MAX,
            pulse_low: u32::MAX,
            direction_setup: u32::MAX,
            direction_hold: 0,
        };
        let timing = max.in_ticks(Clock::new(168_000_000).unwrap());
        assert_eq!(timing.pulse_high, 32_767);
        assert_eq!(timing.pulse_low, 1 << 24);
        assert_eq!(
            (timing.direction_setup, timing.direction_hold),
            (1 << 24, 0)
        );
    }

    #[test]
    fn a_pulse_that_the_counter_would_miss_is_made_longer() {
        let none = Nanoseconds {
            pulse_high: 0,
            pulse_low: 7,
            direction_setup: 0,
            direction_hold: 0,
        };
        let timing = none.in_ticks(Clock::new(168_000_000).unwrap());
        assert_eq!((timing.pulse_high, timing.pulse_low), (17, 17));
        assert_eq!((timing.direction_setup, timing.direction_hold), (0, 0));
    }

    #[test]
    fn each_driver_has_a_highest_rate() {
        let clock = Clock::new(168_000_000).unwrap();
        let rates = Driver::ALL
            .map(|driver| clock.hz() / driver.timing().in_ticks(clock).shortest_period());
        assert_eq!(
            rates,
            [500_000, 249_628, 4_941_176, 4_941_176, 1_000_000, 149_866]
        );
    }

    /// Pulse high, pulse low and direction in nanoseconds, as the data sheets and the sources of other firmwares have them.
    #[test]
    fn each_driver_has_its_times() {
        let known = [
            (Driver::A4988, 1_000, 1_000, 200),
            (Driver::Drv8825, 1_900, 2_100, 650),
            (Driver::Tmc2209, 100, 100, 20),
            (Driver::Tmc5160, 100, 100, 20),
            (Driver::Lv8729, 500, 500, 500),
            (Driver::Tb6600, 3_000, 3_667, 1_500),
        ];
        assert_eq!(Driver::ALL, known.map(|times| times.0));
        for (driver, pulse_high, pulse_low, direction) in known {
            let times = Nanoseconds {
                pulse_high,
                pulse_low,
                direction_setup: direction,
                direction_hold: direction,
            };
            assert_eq!(driver.timing(), times, "{driver:?}");
        }
    }

    /// Upwards, so that no driver gets less than it needs; by hand for two clocks.
    #[test]
    fn each_driver_has_its_ticks() {
        let ticks = |hz: u32| {
            let clock = Clock::new(hz).unwrap();
            Driver::ALL.map(|driver| {
                let timing = driver.timing().in_ticks(clock);
                assert_eq!(timing.direction_setup, timing.direction_hold);
                (timing.pulse_high, timing.pulse_low, timing.direction_setup)
            })
        };
        assert_eq!(
            ticks(168_000_000),
            [
                (168, 168, 34),
                (320, 353, 110),
                (17, 17, 4),
                (17, 17, 4),
                (84, 84, 84),
                (504, 617, 252)
            ]
        );
        assert_eq!(
            ticks(84_000_000),
            [
                (84, 84, 17),
                (160, 177, 55),
                (9, 9, 2),
                (9, 9, 2),
                (42, 42, 42),
                (252, 309, 126)
            ]
        );
    }
}
