//! How long a condition has held: the times that belong to windows and thresholds.

use canopen::{Duration, Instant};

/// Since when a condition has held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct WindowTimer {
    since: Option<Instant>,
}

impl WindowTimer {
    /// It does not hold yet.
    pub(crate) const fn new() -> Self {
        Self { since: None }
    }

    /// Whether the condition holds now and has done so for `time` milliseconds. When it fails once, the time starts anew.
    pub(crate) fn has_held(&mut self, now: Instant, condition: bool, time: u16) -> bool {
        if !condition {
            self.since = None;
            return false;
        }
        let since = *self.since.get_or_insert(now);
        now.checked_duration_since(since)
            .is_some_and(|held| held >= Duration::from_ticks(u64::from(time) * 1000))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(milliseconds: u64) -> Instant {
        Instant::from_ticks(milliseconds * 1000)
    }

    #[test]
    fn m34_leaving_the_window_starts_the_time_anew() {
        let mut timer = WindowTimer::new();
        assert!(!timer.has_held(at(0), true, 10));
        assert!(!timer.has_held(at(9), true, 10));
        assert!(!timer.has_held(at(9), false, 10));
        assert!(!timer.has_held(at(10), true, 10));
        assert!(!timer.has_held(at(19), true, 10));
        assert!(timer.has_held(at(20), true, 10));
    }

    #[test]
    fn m34_without_a_time_it_counts_at_once() {
        let mut timer = WindowTimer::new();
        assert!(timer.has_held(at(0), true, 0));
        assert!(!timer.has_held(at(1), false, 0));
    }
}
