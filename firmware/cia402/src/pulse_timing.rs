//! What the step/direction driver needs of its signals (20B0h): a known driver, or times in nanoseconds.
//!
//! | 20B0h | |
//! |---|---|
//! | :1 | 0 as the firmware was built for its board, 1 A4988, 2 DRV8825, 3 TMC2209, 4 TMC5160, 5 LV8729, 6 TB6600, 255 the times of :2 to :5 |
//! | :2, :3 | shortest time of the step signal being high, and low |
//! | :4, :5 | from a change of direction to the next pulse, and from the end of a pulse to a change of direction |
//!
//! Times are rounded up to ticks of the step clock and cut to what a timer can do; in :2 and :3 less than 100 ns counts as 100 ns. The
//! velocity is limited to 1 / (high + low), and statusword bit 11 says so. A change takes effect while the motor has no power.

use motion::{Clock, Driver, DriverTiming, Nanoseconds};

use crate::objects::Objects;

/// 20B0h:1 for the times of :2 to :5.
const OWN: u8 = 255;

/// Which times count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PulseTiming {
    /// Those that the drive was built with.
    AsBuilt,
    /// These.
    Given(Nanoseconds),
}

impl PulseTiming {
    /// What the objects of a dictionary say.
    pub(crate) fn of<D: Objects>(dictionary: &D) -> Self {
        match dictionary.pulse_driver() {
            OWN => Self::Given(Nanoseconds {
                pulse_high: dictionary.pulse_high(),
                pulse_low: dictionary.pulse_low(),
                direction_setup: dictionary.pulse_direction_setup(),
                direction_hold: dictionary.pulse_direction_hold(),
            }),
            number => Self::from_code(number).unwrap_or(Self::AsBuilt),
        }
    }

    /// The timing for a number in 20B0h:1, that of :2 to :5 not yet filled in; `None` if it means nothing.
    pub(crate) fn from_code(number: u8) -> Option<Self> {
        match number {
            0 | OWN => Some(Self::AsBuilt),
            number => Driver::ALL
                .get(usize::from(number) - 1)
                .map(|driver| Self::Given(driver.timing())),
        }
    }

    /// In ticks of the step clock.
    #[inline(never)]
    pub(crate) fn in_ticks(self, clock: Clock, as_built: DriverTiming) -> DriverTiming {
        match self {
            Self::AsBuilt => as_built,
            Self::Given(times) => times.in_ticks(clock),
        }
    }
}
