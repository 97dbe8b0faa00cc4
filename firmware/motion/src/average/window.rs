//! Over how much time the mean of a plan is taken.

use crate::clock::Clock;
use crate::divide::div_rem;
use crate::low;
use crate::plan::Limits;

/// Over how many ticks a mean is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Window(u32);

impl Window {
    /// One tick.
    pub(super) const SHORTEST: Self = Self(1);

    /// The longest one, in ticks: 6.4 s at 168 MHz.
    const LONGEST: u32 = 1 << 30;

    /// The window in which the acceleration changes by `change` steps/s² at `jerk` steps/s³ or less. At least a time slice of so many ticks.
    pub(crate) fn new(clock: Clock, change: u64, jerk: u32, time_slice: u32) -> Self {
        let ticks = change.saturating_mul(clock.hz().into());
        let (ticks, over) = div_rem(ticks, jerk.max(1));
        let ticks = ticks.saturating_add(u64::from(over > 0));
        Self::of(low::u32(ticks.min(Self::LONGEST.into())), time_slice)
    }

    /// A window of so many ticks. At least a time slice.
    pub(crate) fn of(ticks: u32, time_slice: u32) -> Self {
        Self(ticks.max(time_slice).max(1))
    }

    /// In ticks.
    pub(crate) const fn ticks(self) -> u32 {
        self.0
    }

    /// The jerk where the deceleration follows the acceleration without a cruise, in steps/s³.
    pub(crate) fn jerk(self, clock: Clock, acceleration: u32, deceleration: u32) -> u32 {
        let change = u64::from(acceleration).saturating_add(deceleration.into());
        let (jerk, _) = div_rem(change.saturating_mul(clock.hz().into()), self.ticks());
        u32::try_from(jerk).unwrap_or(u32::MAX)
    }

    /// Limits for which the longest window is long enough, whatever comes after whatever: with a very low jerk the accelerations are less than
    /// what is allowed, and the jerk is kept.
    pub(crate) fn within(clock: Clock, limits: Limits, jerk: u32) -> Limits {
        let most = u64::from(jerk) * u64::from(Self::LONGEST / 2);
        let (most, _) = div_rem(most, clock.hz());
        let most = u32::try_from(most).unwrap_or(u32::MAX).max(1);
        Limits {
            acceleration: limits.acceleration.min(most),
            deceleration: limits.deceleration.min(most),
            ..limits
        }
    }
}
