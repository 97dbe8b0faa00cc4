//! The clock of interpolated position where there is no SYNC: a slot in each period 60C2h, however far apart records are written.
//!
//! A master may write each record when it is due, or several of them in a burst. Writes that come while records wait say nothing about the
//! moment of a slot. One that finds the buffer empty does: it should come half a period before its slot, so that neither is it
//! late when the master is, nor do the clocks of master and drive drift apart. The slots are brought there by at most 1/32 of a period
//! each time.

use super::clock::{Slot, Slots};
use super::{MicrosQ16, span};

/// After so many slots without a record the next record begins the slots anew.
const PAUSE: u8 = 8;

/// The longest time by which a record should be ahead of its slot, 20 ms.
const AHEAD: MicrosQ16 = 20_000 << super::POINT;

/// The clock of the data records.
#[derive(Debug)]
pub(crate) struct RecordClock {
    /// When the next slot is due; `None` where SYNC is the clock, or no record has come.
    next: Option<MicrosQ16>,
    /// Slots in a row that found no record.
    idle: u8,
}

impl RecordClock {
    pub(crate) const fn new() -> Self {
        Self {
            next: None,
            idle: 0,
        }
    }

    /// Something else is the clock.
    pub(crate) const fn stop(&mut self) {
        self.next = None;
    }

    pub(crate) const fn is_running(&self) -> bool {
        self.next.is_some()
    }

    /// A record came at `stamp` and found the buffer empty.
    #[inline(never)]
    pub(crate) fn on_record(&mut self, stamp: MicrosQ16, period: MicrosQ16) {
        let ahead = (period / 2).min(AHEAD);
        let Some(next) = self.next.filter(|_| self.idle < PAUSE) else {
            self.next = Some(stamp.wrapping_add(ahead));
            self.idle = 0;
            return;
        };
        let period = period.cast_signed();
        // To the nearest moment at which a record should come.
        let late = span(next.wrapping_sub(ahead), stamp);
        let late = late.checked_rem_euclid(period).unwrap_or(0);
        let late = if late > period / 2 {
            late.wrapping_sub(period)
        } else {
            late
        };
        self.next = Some(next.wrapping_add_signed(late / 32));
    }

    /// Lets time pass, while so many records wait.
    #[inline(never)]
    pub(crate) fn pass(
        &mut self,
        now: MicrosQ16,
        period: MicrosQ16,
        mut waiting: usize,
        slots: &mut Slots,
    ) {
        while let Some(at) = self.next
            && span(at, now) >= 0
            && !slots.is_full()
        {
            self.next = Some(at.wrapping_add(period));
            self.idle = if waiting == 0 {
                self.idle.saturating_add(1)
            } else {
                0
            };
            waiting = waiting.saturating_sub(1);
            let event = None;
            let _ = slots.push(Slot {
                at,
                period,
                latency: 0,
                event,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: MicrosQ16 = 1_000 << super::super::POINT;

    /// The slots from `from` to `to` in milliseconds.
    fn slots(
        clock: &mut RecordClock,
        from: u64,
        to: u64,
        waiting: usize,
    ) -> std::vec::Vec<MicrosQ16> {
        let mut all = std::vec::Vec::new();
        for now in from..=to {
            let mut slots = Slots::new();
            clock.pass(now * MS, 10 * MS, waiting, &mut slots);
            all.extend(slots.iter().map(|slot| slot.at));
        }
        all
    }

    #[test]
    fn m68_slots_are_a_period_apart_from_half_a_period_behind_the_first_record_on() {
        let mut clock = RecordClock::new();
        assert!(slots(&mut clock, 0, 100, 0).is_empty());
        clock.on_record(100 * MS, 10 * MS);
        assert_eq!(
            slots(&mut clock, 101, 140, 5),
            [105 * MS, 115 * MS, 125 * MS, 135 * MS]
        );
        // A record behind its slot, and one ahead of it, move the next one a little.
        clock.on_record(143 * MS, 10 * MS);
        assert_eq!(slots(&mut clock, 144, 150, 1), [145 * MS + 3 * MS / 32]);
        clock.on_record(149 * MS, 10 * MS);
        let [at] = slots(&mut clock, 150, 160, 1)[..] else {
            panic!("one slot");
        };
        assert!(at > 155 * MS && at < 155 * MS + 3 * MS / 32);
        // After a pause they begin anew.
        assert_eq!(slots(&mut clock, 161, 244, 0).len(), 8);
        clock.on_record(250 * MS + 1, 10 * MS);
        assert_eq!(slots(&mut clock, 251, 260, 1), [255 * MS + 1]);
    }
}
