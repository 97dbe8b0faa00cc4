//! Sync events, slots and the times of the control ticks, from tick to tick.

use canopen::{Duration, Instant};

use motion::low;

use crate::cyclic::{
    Buffer, CyclicConfiguration, LOCKED, MicrosQ16, NetworkClock, POINT, Pipeline, RecordClock,
    Schedule, Slots, SyncEvent, SyncStatus, micros_q16,
};
use crate::exchange::{Exchange, Share, Waiting};
use crate::mode::Mode;

/// The clock of the network, the times of the control ticks, and what waits.
#[derive(Debug)]
pub(crate) struct Cyclic {
    clock: NetworkClock,
    /// The clock of the data records, where there is no SYNC.
    record_clock: RecordClock,
    schedule: Schedule,
    pub(crate) pipeline: Pipeline,
    /// The set-points of this tick.
    pub(crate) slots: Slots,
    pub(crate) buffer: Buffer,
    /// Too many set-points were missing in this tick.
    pub(crate) set_points_lost: bool,
    /// How often that was.
    pub(crate) lost: u32,
    /// The status of the network clock (2050h).
    shown: SyncStatus,
    /// SYNC comes with another period than is set up.
    differs: bool,
    /// The two fields above are to be computed again: a sync event has come, or is missing.
    is_new: bool,
}

impl Cyclic {
    pub(crate) fn new(ahead: MicrosQ16, tick: Duration) -> Self {
        let schedule = Schedule::new(tick);
        Self {
            pipeline: Pipeline::new(ahead, schedule.tick(), schedule.sync_lead()),
            clock: NetworkClock::new(),
            record_clock: RecordClock::new(),
            schedule,
            slots: Slots::new(),
            buffer: Buffer::new(),
            set_points_lost: false,
            lost: 0,
            shown: SyncStatus::NONE,
            differs: false,
            is_new: true,
        }
    }

    /// The configuration may have changed.
    pub(crate) const fn look_anew(&mut self) {
        self.is_new = true;
    }

    /// Takes what has come since the last tick: each piece under a lock of its own, in which nothing is computed. `keeps_records` is
    /// false in a drive without a mode for data records; so it is in the next function.
    pub(crate) fn take<X: Share>(
        &mut self,
        waiting: Waiting,
        exchange: &mut X,
        configuration: &CyclicConfiguration,
        (mode, wanted): (Mode, Mode),
        keeps_records: bool,
    ) {
        self.slots.clear();
        // The mode may become another in this tick.
        let begins_anew = self.clock.set_used(mode.is_cyclic() || wanted.is_cyclic());
        self.is_new |= begins_anew || waiting.sync_events > 0 || waiting.is_configured;
        let has_records = keeps_records && mode == Mode::InterpolatedPosition;
        if !has_records {
            self.record_clock.stop();
        }
        if waiting.clears_records || !has_records {
            self.buffer.clear();
        }
        let mut is_empty = waiting.records > 0 && self.buffer.len() == 0;
        if waiting.records > 0 {
            self.take_records(waiting.records, exchange, configuration, has_records);
        }
        for _ in 0..waiting.sync_events {
            if let Some(event) = exchange.lock(Exchange::take_sync_event) {
                if event.is_sync || !has_records {
                    self.on_sync_event(event, configuration, mode);
                } else if core::mem::take(&mut is_empty) {
                    self.record_clock
                        .on_record(micros_q16(event.at), micros(configuration.period));
                }
            }
        }
    }

    #[inline(never)]
    fn take_records<X: Share>(
        &mut self,
        number: usize,
        exchange: &mut X,
        configuration: &CyclicConfiguration,
        has_records: bool,
    ) {
        for _ in 0..number {
            let record = exchange.lock(Exchange::take_record);
            if has_records && let Some(record) = record {
                self.buffer.push(record, configuration.buffer);
            }
        }
    }

    #[inline(never)]
    fn on_sync_event(&mut self, event: SyncEvent, configuration: &CyclicConfiguration, mode: Mode) {
        self.record_clock.stop();
        let is_new = match mode {
            Mode::CyclicVelocity => event.velocity.is_some(),
            Mode::CyclicTorque => event.torque.is_some(),
            Mode::InterpolatedPosition => false,
            _ => event.position.is_some(),
        };
        self.clock
            .on_sync_event(event, is_new, configuration.periods(), &mut self.slots);
    }

    /// Lets time pass. `configuration` is what was taken with the sync events of this tick.
    pub(crate) fn pass(
        &mut self,
        now: MicrosQ16,
        configuration: &CyclicConfiguration,
        keeps_records: bool,
    ) {
        self.is_new |= self.clock.pass(now, &mut self.slots);
        if core::mem::take(&mut self.is_new) {
            self.look_at_clock(configuration);
        }
        if keeps_records && self.record_clock.is_running() {
            self.slots.clear();
            let waits = self.buffer.len();
            self.record_clock
                .pass(now, micros(configuration.period), waits, &mut self.slots);
        }
        if !self.slots.is_empty() {
            self.aim(configuration.is_cubic);
        }
    }

    /// The slots of this tick, and when the motor is to be at their set-points.
    #[inline(never)]
    fn aim(&mut self, is_cubic: bool) {
        for slot in &mut self.slots {
            slot.latency = self.pipeline.latency(slot.period);
            self.schedule.aim(slot.due(is_cubic));
        }
    }

    /// When the next tick is due, in step with the sync events if there is a mode that needs it.
    pub(crate) fn next_tick(&mut self, now: Instant, is_in_step: bool) -> Option<Instant> {
        let pll = self.clock.pll();
        (is_in_step && pll.is_running()).then(|| self.schedule.next(now, pll))
    }

    /// The sync events or the configuration have changed.
    #[inline(never)]
    fn look_at_clock(&mut self, configuration: &CyclicConfiguration) {
        let period = self.clock.period();
        self.pipeline.expect(period);
        let (interpolation, cycle) = configuration.periods();
        let latency = self.pipeline.latency(period) >> POINT;
        self.shown = SyncStatus {
            latency: u32::try_from(latency).unwrap_or(u32::MAX),
            ..self.clock.status()
        };
        self.differs = self.shown.state == LOCKED && self.clock.differs(interpolation, cycle);
    }

    /// Whether SYNC comes with another period than is set up.
    pub(crate) const fn differs(&self) -> bool {
        self.differs
    }

    /// 2050h and 60C4h:4.
    #[inline]
    pub(crate) fn status(&self) -> SyncStatus {
        SyncStatus {
            lost_set_points: self.lost,
            // Records are fewer than 16 bits count.
            buffered: low::u16(low::word(self.buffer.len())),
            ..self.shown
        }
    }
}

/// Microseconds in the unit of moments.
fn micros(time: u32) -> MicrosQ16 {
    MicrosQ16::from(time) << POINT
}
