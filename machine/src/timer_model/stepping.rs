//! The emitter and the pulses of a modelled board: refills use them above the control ticks, as on the board.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use canopen::{Duration, Instant};
use cia402::{DriveConfig, Emitter, EmitterLock};
use motion::advanced_timer::{Output, Ring, on_break};
use motion::{PulseSink, Record, Ticks};

use super::TimerModel;
use super::rig::HZ;

/// Ticks of the step timer in a microsecond.
pub(super) const MICROSECOND: u64 = HZ as u64 / 1_000_000;

/// Refills are so far apart.
pub(super) const REFILL: Duration = Duration::from_ticks(250);

/// Says how late something is (an xorshift generator).
#[derive(Debug)]
pub(super) struct Lateness {
    random: Cell<u64>,
    /// In microseconds.
    latest: Cell<u64>,
}

impl Lateness {
    pub(super) const fn new(latest: u64) -> Self {
        Self {
            random: Cell::new(0x9E37_79B9_7F4A_7C15),
            latest: Cell::new(latest),
        }
    }

    pub(super) fn set_latest(&self, latest: u64) {
        self.latest.set(latest);
    }

    pub(super) fn next(&self) -> Duration {
        Duration::from_ticks(self.below(self.latest.get()))
    }

    fn below(&self, most: u64) -> u64 {
        let mut random = self.random.get();
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        self.random.set(random);
        random % most
    }
}

/// Something that comes again and again, more or less late.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beat {
    due: Instant,
    late: Duration,
}

impl Beat {
    pub(super) fn at_phase(phase: Duration) -> Self {
        Self {
            due: Instant::from_ticks(0) + phase,
            late: Duration::from_ticks(0),
        }
    }

    pub(super) fn at(self) -> Instant {
        self.due + self.late
    }

    /// The next one.
    pub(super) fn after(self, period: Duration, late: Duration) -> Self {
        Self {
            due: self.due + period,
            late,
        }
    }
}

/// What refills and control ticks share. Time passes here.
#[derive(Debug)]
pub(super) struct Stepping {
    pub(super) emitter: RefCell<Emitter>,
    pub(super) output: RefCell<Output<'static, TimerModel<'static>>>,
    model: TimerModel<'static>,
    refill: Cell<Beat>,
    pub(super) lateness: Lateness,
    /// How long the tick that runs still takes, in microseconds.
    left: Cell<u64>,
}

impl Stepping {
    pub(super) fn new(
        config: DriveConfig,
        (model, ring): (TimerModel<'static>, &'static Ring),
        phase: Duration,
        lateness: Lateness,
    ) -> Self {
        Self {
            emitter: RefCell::new(Emitter::new(config)),
            output: RefCell::new(Output::new(model.clone(), ring)),
            model,
            refill: Cell::new(Beat::at_phase(phase)),
            lateness,
            left: Cell::new(0),
        }
    }

    /// When the next refill is.
    pub(super) fn next(&self) -> Instant {
        self.refill.get().at()
    }

    /// Up to which microsecond time has passed.
    pub(super) fn now(&self) -> Instant {
        Instant::from_ticks(self.model.time() / MICROSECOND)
    }

    /// Runs every refill up to and including `now`, and the timers.
    pub(super) fn run_until(&self, now: Instant) {
        while self.next() <= now {
            self.play_until(self.next());
            let next = self.refill.get().after(REFILL, self.lateness.next());
            self.refill.set(next);
            let mut output = self.output.borrow_mut();
            output.service();
            self.emitter.borrow_mut().refill(&mut *output);
            drop(output);
            self.answer_break();
        }
        self.play_until(now);
    }

    fn play_until(&self, now: Instant) {
        let ticks = (now.ticks() * MICROSECOND).saturating_sub(self.model.time());
        self.model.run(ticks);
    }

    /// The interrupt of the break.
    pub(super) fn answer_break(&self) {
        if self.model.is_break_interrupt() {
            on_break(&mut self.model.clone());
        }
    }

    /// A tick begins that takes so long.
    pub(super) fn begin_tick(&self, busy: Duration) {
        self.left.set(busy.ticks());
    }

    /// It is over.
    pub(super) fn end_tick(&self) {
        let left = Duration::from_ticks(self.left.take());
        self.run_until(self.now() + left);
    }

    /// Before the tick that runs locks the emitter, some of its time has passed.
    fn pass(&self) {
        let left = self.left.get();
        if left > 0 {
            let passed = self.lateness.below(left + 1);
            self.left.set(left - passed);
            self.run_until(self.now() + Duration::from_ticks(passed));
        }
    }
}

/// The emitter for the control tick.
#[derive(Clone, Debug)]
pub(super) struct SharedEmitter(pub(super) Rc<Stepping>);

impl EmitterLock for SharedEmitter {
    fn look<R>(&self, f: impl FnOnce(&Emitter) -> R) -> R {
        self.0.pass();
        f(&self.0.emitter.borrow())
    }

    fn lock<R>(&mut self, f: impl FnOnce(&mut Emitter) -> R) -> R {
        self.0.pass();
        f(&mut self.0.emitter.borrow_mut())
    }
}

/// The pulses for the control tick.
#[derive(Clone, Debug)]
pub(super) struct SharedPulses(pub(super) Rc<Stepping>);

impl PulseSink for SharedPulses {
    fn push(&mut self, record: Record) -> Result<(), Record> {
        self.0.output.borrow_mut().push(record)
    }

    fn push_all(&mut self, records: &[Record]) -> usize {
        self.0.output.borrow_mut().push_all(records)
    }

    fn pending(&self) -> Ticks {
        self.0.output.borrow().pending()
    }

    fn free(&self) -> usize {
        self.0.output.borrow().free()
    }
}
