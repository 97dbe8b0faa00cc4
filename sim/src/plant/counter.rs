//! The second counter: an external encoder that somebody turns, such as the master axis of electronic gearing.

use canopen::Instant;

/// An encoder that turns evenly.
#[derive(Clone, Copy, Debug)]
pub struct SecondCounter {
    from: i64,
    since: Instant,
    /// Counts/s.
    speed: i64,
}

impl Default for SecondCounter {
    fn default() -> Self {
        Self {
            from: 0,
            since: Instant::from_ticks(0),
            speed: 0,
        }
    }
}

impl SecondCounter {
    /// Turns it with so many counts/s from now on.
    pub fn turn(&mut self, speed: i64, now: Instant) {
        self.from = self.at(now);
        self.since = now;
        self.speed = speed;
    }

    /// What the counter shows.
    pub fn count(&self, now: Instant) -> i32 {
        self.at(now) as i32
    }

    fn at(&self, now: Instant) -> i64 {
        let span = now.checked_duration_since(self.since);
        let span = span.map_or(0, |span| i64::try_from(span.ticks()).unwrap_or(0));
        self.from + (self.speed * span).div_euclid(1_000_000)
    }
}
