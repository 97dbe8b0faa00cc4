//! The control tick, made by the system timer that every Cortex-M has.

use canopen::{Duration, Instant};
use cia402::cyclic::TickTimer;
use cortex_m::peripheral::SYST;

use super::Board;

/// The system timer, which makes the control tick.
pub struct ControlTimer {
    timer: SYST,
    /// Counts of a nominal tick.
    nominal: u32,
    rhythm: TickTimer,
}

impl ControlTimer {
    /// Starts the timer.
    pub fn start<B: Board>(mut timer: SYST, rate_hz: u32) -> Self {
        let nominal = B::SYSTEM_TIMER_HZ / rate_hz;
        timer.set_clock_source(cortex_m::peripheral::syst::SystClkSource::Core);
        timer.set_reload(nominal - 1);
        timer.clear_current();
        timer.enable_interrupt();
        timer.enable_counter();
        Self {
            timer,
            nominal,
            rhythm: TickTimer::new(Duration::micros((1_000_000 / rate_hz).into())),
        }
    }

    /// The tick that runs at `now` says when the next one is due. The timer is counting to that one already, so what is said changes the
    /// tick behind it; the rhythm is the same, one tick later.
    pub fn schedule<B: Board>(&mut self, now: Instant, next: Option<Instant>) {
        let counts = self.rhythm.next(now, next).map_or(self.nominal, |length| {
            length * (B::SYSTEM_TIMER_HZ / 1_000_000)
        });
        self.timer.set_reload(counts - 1);
    }
}
