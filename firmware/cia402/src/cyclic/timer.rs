//! The timer of the control tick, made to keep the moments at which ticks are due.
//!
//! When a tick runs, such a timer counts to the next tick already, so a new length takes effect behind that one. The time to which it
//! counts is known from the lengths that it was programmed with, and is not measured in each tick: a tick runs late now and then, and
//! lengths that corrected that at once would oscillate. A sixteenth of what is measured is corrected, so that the two clocks stay together.

use canopen::{Duration, Instant};

/// What the timer was programmed with.
#[derive(Clone, Copy, Debug)]
struct Programmed {
    /// When the tick was to run that runs now.
    now: Instant,
    /// When the tick is to run that the timer counts to.
    next: Instant,
    /// When the tick that runs now was due.
    due: Instant,
}

/// The lengths of the ticks.
#[derive(Debug)]
pub struct TickTimer {
    /// A nominal tick in microseconds.
    nominal: i64,
    programmed: Option<Programmed>,
}

impl TickTimer {
    /// A timer that makes ticks of this length, as long as it is told nothing else.
    pub const fn new(nominal: Duration) -> Self {
        Self {
            nominal: nominal.ticks().cast_signed(),
            programmed: None,
        }
    }

    /// The tick that runs at `now` says when the next one is due, or `None` if that does not matter. Returns how many microseconds
    /// the tick behind that one is to be long: 1/2 to 9/8 of a nominal tick, `None` for a nominal one.
    pub fn next(&mut self, now: Instant, due: Option<Instant>) -> Option<u32> {
        let Some(due) = due else {
            self.programmed = None;
            return None;
        };
        let programmed = self
            .programmed
            .filter(|programmed| self.is_near(programmed.now, now));
        let (counts_to, tick) = match programmed {
            Some(programmed) => {
                let late = micros(programmed.now, now) / 16;
                (later(programmed.next, late), micros(programmed.due, due))
            }
            None => (later(now, self.nominal), self.nominal),
        };
        let length = micros(counts_to, later(due, self.within(tick)));
        let length = self.within(length);
        self.programmed = Some(Programmed {
            now: counts_to,
            next: later(counts_to, length),
            due,
        });
        u32::try_from(length).ok()
    }

    /// A tick ran about when it was to run.
    fn is_near(&self, told: Instant, now: Instant) -> bool {
        micros(told, now).saturating_abs() < self.nominal / 2
    }

    /// A length that a tick may have.
    fn within(&self, length: i64) -> i64 {
        let max = self.nominal.saturating_add(self.nominal / 8);
        length.max(self.nominal / 2).min(max)
    }
}

/// From one moment to another.
const fn micros(from: Instant, to: Instant) -> i64 {
    to.ticks().wrapping_sub(from.ticks()).cast_signed()
}

/// A moment so many microseconds later.
const fn later(moment: Instant, micros: i64) -> Instant {
    Instant::from_ticks(moment.ticks().wrapping_add_signed(micros))
}

#[cfg(test)]
mod tests {
    use super::super::pll::Pll;
    use super::super::schedule::Schedule;
    use super::super::{MicrosQ16, POINT};
    use super::*;

    const BEGIN: u64 = 1_000_000;

    /// A timer that runs this many ppm too slowly, and ticks that run up to 60 µs late, now and then 200. Returns how far ticks are from
    /// the moments of a SYNC each two milliseconds once they are in step.
    fn run(drift: i64) -> std::vec::Vec<i64> {
        let nominal = Duration::micros(1_000);
        let mut pll = Pll::new();
        let mut schedule = Schedule::new(nominal);
        let mut timer = TickTimer::new(nominal);
        let micros_q16 = |micros: u64| -> MicrosQ16 { micros << POINT };
        let mut sync = BEGIN;
        let mut fire = micros_q16(BEGIN + 333);
        let mut lengths = [1_000_u32; 2];
        let mut random = 1_u32;
        let mut off = std::vec::Vec::new();
        for tick in 0..20_000 {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let late = if random.is_multiple_of(37) {
                200
            } else {
                random >> 24 & 63
            };
            let now = (fire >> POINT) + u64::from(late);
            while sync <= now {
                pll.on_sync_event(micros_q16(sync), [micros_q16(2_000), 0]);
                sync += 2_000;
            }
            if tick > 1_000 {
                let since = (fire >> POINT).wrapping_sub(BEGIN - 250) % 1_000;
                off.push((since.cast_signed() + 500) % 1_000 - 500);
            }
            let now = Instant::from_ticks(now);
            let due = schedule.next(now, &pll);
            let behind = timer.next(now, Some(due)).unwrap();
            lengths = [lengths[1], behind];
            let length = micros_q16(lengths[0].into());
            let drift = length.cast_signed() / 1_000_000 * drift;
            fire = fire.wrapping_add(length).wrapping_add_signed(drift);
        }
        off
    }

    #[test]
    fn m63_ticks_stay_in_step_with_sync_though_they_run_late() {
        for drift in [0, 100, -100] {
            for off in run(drift) {
                assert!(off.abs() < 90, "{off} us off with {drift} ppm");
            }
        }
    }

    #[test]
    fn without_a_moment_that_matters_ticks_are_nominal() {
        let mut timer = TickTimer::new(Duration::micros(1_000));
        let at = Instant::from_ticks(BEGIN);
        assert!(timer.next(at, Some(at + Duration::micros(900))).is_some());
        assert_eq!(timer.next(at, None), None);
    }

    #[test]
    fn a_moment_far_off_gives_a_tick_that_is_allowed() {
        let mut timer = TickTimer::new(Duration::micros(1_000));
        let at = Instant::from_ticks(BEGIN);
        for far in [0, 1, u64::MAX / 2, u64::MAX] {
            let length = timer.next(at, Some(Instant::from_ticks(far))).unwrap();
            assert!((500..=1_125).contains(&length), "{length}");
        }
    }
}
