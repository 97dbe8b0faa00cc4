//! The position window 6067h and its time 6068h: when a position counts as reached.

use canopen::{Duration, Instant};

/// How long the position has been inside the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PositionWindow {
    inside_since: Option<Instant>,
}

impl PositionWindow {
    /// 6067h: the window is not looked at.
    pub(crate) const OFF: u32 = u32::MAX;

    /// Not inside yet.
    pub(crate) const fn new() -> Self {
        Self { inside_since: None }
    }

    /// Whether the position has stayed inside the window (`distance` from the target at most `window`) for `time`
    /// milliseconds. Leaving it once starts the time anew.
    pub(crate) fn is_reached(
        &mut self,
        now: Instant,
        distance: u64,
        window: u32,
        time: u16,
    ) -> bool {
        if distance > u64::from(window) {
            self.inside_since = None;
            return false;
        }
        let since = *self.inside_since.get_or_insert(now);
        now.checked_duration_since(since)
            .is_some_and(|inside| inside >= Duration::from_ticks(u64::from(time) * 1000))
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
        let mut window = PositionWindow::new();
        assert!(!window.is_reached(at(0), 5, 5, 10));
        assert!(!window.is_reached(at(9), 0, 5, 10));
        assert!(!window.is_reached(at(9), 6, 5, 10));
        assert!(!window.is_reached(at(10), 5, 5, 10));
        assert!(!window.is_reached(at(19), 5, 5, 10));
        assert!(window.is_reached(at(20), 5, 5, 10));
        assert!(!window.is_reached(at(21), u64::MAX, 5, 10));
    }

    #[test]
    fn m34_without_a_time_the_window_is_enough() {
        let mut window = PositionWindow::new();
        assert!(!window.is_reached(at(0), 1, 0, 0));
        assert!(window.is_reached(at(0), 0, 0, 0));
    }
}
