//! The recorder itself: what happens behind a control tick.

use core::ops::Deref;

use canopen::Duration;

use super::Memory;
use super::memory::Outcome;
use super::values::bits;
use crate::actuator::Actuator;
use crate::drive::Drive;
use crate::exchange::{Share, TickResult};
use crate::objects::Objects;
use crate::scope::{Setup, State, Status};

/// In the mode that repeats itself, how long nobody may have read a recording that was read to its end before the next one begins:
/// a client may ask again for segments that it has lost. In milliseconds.
const QUIET: u64 = 100;

/// The recorder. It works on a [`Memory`] by a reference, an `Arc` or the like.
#[derive(Debug)]
pub struct Recorder<M> {
    memory: M,
    /// The period of the control tick in nanoseconds.
    tick: u32,
    state: State,
    setup: Setup,
    /// Counts recordings.
    run: u32,
    /// Samples there are to be in all.
    capacity: u16,
    /// Words of the ring.
    span: u32,
    /// The word where the next sample begins.
    next: u32,
    /// Samples in the ring that count: before the trigger no more than are asked for.
    recorded: u16,
    /// Control ticks until the next sample.
    skip: u16,
    was_high: Option<bool>,
    /// The trigger was ordered.
    is_ordered: bool,
    found: Found,
    /// Control ticks since a recording that is to be repeated was read, and the count of readings then.
    quiet: (u32, u32),
    /// Ticks that make [`QUIET`].
    quiet_ticks: u32,
    /// State and number of samples that were published last; the initial value is never published.
    published: (State, u16),
    /// Nothing is to be done until an order comes.
    is_asleep: bool,
}

/// Where the trigger was.
#[derive(Clone, Copy, Debug, Default)]
struct Found {
    /// When, in microseconds.
    at: u64,
    /// The samples that are older.
    before: u16,
    /// Control ticks from there to the next sample.
    late: u16,
    /// That sample has been taken.
    is_behind: bool,
}

impl<M: Deref<Target = Memory>> Recorder<M> {
    /// A recorder that is idle, for a drive with this period of the control tick. What is in the memory is forgotten.
    pub fn new(memory: M, tick: Duration) -> Self {
        memory.clear();
        let nanoseconds = tick.ticks().saturating_mul(1_000);
        let quiet_ticks = (QUIET * 1_000).checked_div(tick.ticks()).unwrap_or(0);
        Self {
            memory,
            tick: u32::try_from(nanoseconds).unwrap_or(u32::MAX),
            state: State::Idle,
            setup: Setup::NONE,
            run: 0,
            capacity: 0,
            span: 0,
            next: 0,
            recorded: 0,
            skip: 0,
            was_high: None,
            is_ordered: false,
            found: Found::default(),
            quiet: (0, 0),
            quiet_ticks: u32::try_from(quiet_ticks).unwrap_or(u32::MAX),
            published: (State::Armed, 0),
            is_asleep: false,
        }
    }

    /// Call it behind each [`Drive::tick`].
    #[inline]
    pub fn tick<D: Objects, A: Actuator, X: Share>(
        &mut self,
        drive: &Drive<D, A>,
        exchange: &mut X,
    ) {
        if !D::DRIVE.scope {
            return;
        }
        let has_orders = exchange.lock(|exchange| exchange.has_orders());
        if has_orders {
            self.obey(exchange);
        } else if self.is_asleep {
            return;
        }
        self.work(drive, exchange);
    }

    /// A tick in which it is not idle.
    #[inline(never)]
    fn work<D: Objects, A: Actuator, X: Share>(&mut self, drive: &Drive<D, A>, exchange: &mut X) {
        if self.state.is_at_work() {
            let actuals = exchange.lock(|exchange| *exchange.newest());
            self.advance(&drive.result(&actuals));
        } else {
            self.repeat_if_read();
        }
        if (self.state, self.recorded) != self.published {
            self.tell(exchange);
        }
    }

    /// Says what it is doing.
    fn tell<X: Share>(&mut self, exchange: &mut X) {
        self.published = (self.state, self.recorded);
        self.is_asleep = match self.state {
            State::Idle => true,
            State::Armed | State::Triggered => false,
            State::Full => !self.setup.is_repeated,
        };
        let status = Status {
            state: self.state,
            recorded: self.recorded,
            memory: self.memory.words().saturating_mul(4),
            tick: self.tick,
        };
        exchange.lock(|exchange| exchange.set_scope(status));
    }

    /// What there is to do in a tick in which it records.
    fn advance(&mut self, tick: &TickResult<'_>) {
        if self.state == State::Armed && (self.meets_trigger(tick) || self.is_ordered) {
            self.state = State::Triggered;
            self.found = Found {
                at: tick.actuals.at.ticks(),
                before: self.recorded,
                ..Found::default()
            };
        }
        if let Some(left) = self.skip.checked_sub(1) {
            self.skip = left;
            if !self.found.is_behind {
                self.found.late = self.found.late.saturating_add(1);
            }
            return;
        }
        self.skip = self.setup.divider.saturating_sub(1);
        self.sample(tick);
        self.count();
    }

    /// Whether the trigger comes in this tick.
    fn meets_trigger(&mut self, tick: &TickResult<'_>) -> bool {
        let trigger = &self.setup.trigger;
        let Some(signal) = trigger.signal else {
            return false;
        };
        let is_high = trigger.is_high(signal, bits(signal, tick));
        let was_high = self.was_high.replace(is_high);
        was_high.is_some_and(|was_high| trigger.is_edge(was_high, is_high))
    }

    /// Puts down the values of this tick, one behind the other, the last word filled up with zeros.
    fn sample(&mut self, tick: &TickResult<'_>) {
        let (mut word, mut filled) = (0, 0);
        let mut place = self.next;
        for signal in self.setup.signals() {
            let (bits, length) = (bits(signal, tick), signal.length());
            word |= bits << filled;
            let free = 32 - filled;
            if length < free {
                filled += length;
                continue;
            }
            self.memory.put(place, word);
            place = place.wrapping_add(1);
            filled = length - free;
            // Of a value that ended with the word nothing is left.
            word = bits.checked_shr(free).unwrap_or(0);
        }
        if filled > 0 {
            self.memory.put(place, word);
            place = place.wrapping_add(1);
        }
        self.next = if place < self.span { place } else { 0 };
    }

    /// A sample has been put down.
    fn count(&mut self) {
        if self.state == State::Armed {
            self.recorded = self.recorded.saturating_add(1).min(self.setup.before);
            return;
        }
        self.found.is_behind = true;
        self.recorded = self.recorded.saturating_add(1);
        // Fewer are older where the trigger came early; as many as asked for are younger.
        let younger = self.capacity.saturating_sub(self.setup.before);
        let count = self.found.before.saturating_add(younger);
        if self.recorded >= count {
            self.conclude();
        }
    }

    /// All samples are there.
    #[cold]
    #[inline(never)]
    fn conclude(&mut self) {
        self.state = State::Full;
        let words = u32::from(self.recorded).saturating_mul(self.setup.stride());
        let oldest = match self.next.checked_sub(words) {
            Some(oldest) => oldest,
            None => self.next.saturating_add(self.span).saturating_sub(words),
        };
        let outcome = Outcome {
            oldest,
            count: self.recorded,
            before: self.found.before,
            late: self.found.late,
            triggered: self.found.at,
        };
        self.memory
            .publish(self.run, &self.setup, self.tick, &outcome);
        let (_, readings) = self.memory.readings(self.run);
        self.quiet = (0, readings);
    }

    /// What a master wants.
    #[cold]
    #[inline(never)]
    fn obey<X: Share>(&mut self, exchange: &mut X) {
        let orders = exchange.lock(|exchange| exchange.take_orders());
        if orders.stop {
            self.setup.is_repeated = false;
            if self.state.is_at_work() {
                self.state = State::Idle;
                self.recorded = 0;
            }
        }
        if let Some(setup) = orders.arm {
            self.setup = setup;
            self.arm();
        }
        self.is_ordered = orders.trigger;
        // The exchange shows what is expected of the order; now it shows what came of it.
        self.tell(exchange);
    }

    /// Begins a recording.
    fn arm(&mut self) {
        let words = self.memory.words();
        if self.setup.check(words).is_err() {
            return;
        }
        self.memory.clear();
        self.run = self.run.wrapping_add(1).max(1);
        self.state = State::Armed;
        self.capacity = self.setup.capacity(words);
        self.span = self.setup.span(words);
        self.next = 0;
        self.recorded = 0;
        self.skip = 0;
        self.was_high = None;
        self.is_ordered = false;
        self.found = Found::default();
    }

    /// A recording that repeats itself begins anew when the last one has been read and nobody reads it any more.
    fn repeat_if_read(&mut self) {
        if self.state != State::Full || !self.setup.is_repeated {
            return;
        }
        let (is_fetched, readings) = self.memory.readings(self.run);
        let (ticks, before) = self.quiet;
        if !is_fetched || readings != before {
            self.quiet = (0, readings);
        } else if ticks < self.quiet_ticks {
            self.quiet = (ticks + 1, readings);
        } else {
            self.arm();
        }
    }
}
