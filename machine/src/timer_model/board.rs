//! The drive as it is on the board: both halves of the firmware's drive, and its pulses made by the modelled timers.
//!
//! It runs what the tasks of the firmware run, at their rates: a control tick each millisecond, a refill each quarter of one, the
//! node when a frame comes. Instructions take no time here; in their place each control tick, each refill and each early tick comes late by up to
//! 50 µs, which is longer than what the processor is busy with in most of them (`docs/benchmarks.md`). With [`Board::set_busy`] the ticks take
//! a time of their own, in which nothing else of their priority runs.

use std::fmt;

use canopen::{BitRate, Duration, Frame, Instant, NodeId, Settings};
use cia402::faults::of_pulses;
use cia402::{Device, Drive, DriveConfig, Exchange, Inputs, Outputs, State};
use motion::advanced_timer::{Output, Ring, on_break};
use motion::{AxisConfig, Clock, DriverTiming, PulseSink};

use super::rig::{HZ, SEGMENT};
use super::{Judge, TimerModel};
use crate::dictionary::Dictionary;
use master::bus::Station;

/// Ticks of the step timer in a microsecond.
const MICROSECOND: u64 = HZ as u64 / 1_000_000;

/// Control ticks are so far apart.
const CONTROL: Duration = Duration::from_ticks(1_000);

/// Refills are so far apart.
const REFILL: Duration = Duration::from_ticks(250);

/// What a DMA burst may take (`docs/step-engine.md`), in ticks.
const BURST: u64 = 84;

/// From a break to what its interrupt does: two microseconds.
const BREAK_LATENCY: u64 = 2 * MICROSECOND;

/// A control tick or a refill is late by less than this, in microseconds, in place of all that the processor does.
const LATEST: u64 = 50;

/// The same where the ticks take a time of their own: the interrupts of higher priority.
const INTERRUPTED: u64 = 18;

/// Something that comes again and again, more or less late.
#[derive(Clone, Copy, Debug)]
struct Beat {
    due: Instant,
    late: Duration,
}

impl Beat {
    fn at(self) -> Instant {
        self.due + self.late
    }
}

/// What runs at the priority of the control tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Task {
    Control,
    Early,
    Refill,
}

/// A drive on the modelled timers. Its node-ID is [`Board::NODE`]; the supply is there.
pub struct Board {
    device: Device<Dictionary>,
    drive: Drive,
    exchange: Exchange,
    output: Output<'static, TimerModel<'static>>,
    model: TimerModel<'static>,
    control: Beat,
    refill: Beat,
    /// When a command to stop is carried out that has come.
    early: Option<Instant>,
    /// How long control ticks take, early ones too, before they hand out pulses.
    busy: Duration,
    /// The one that is running, and when it does so.
    running: Option<(Instant, Task)>,
    /// A control tick, an early one or a refill is late by less than this, in microseconds.
    latest: u64,
    /// What says how late the next one is (an xorshift generator).
    random: u64,
    powered: bool,
    /// When the last control tick was, or an early one.
    ticked: Instant,
}

impl fmt::Debug for Board {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Board")
            .field("drive", &self.drive)
            .field("model", &self.model)
            .finish_non_exhaustive()
    }
}

impl Board {
    /// The node-ID.
    pub const NODE: u8 = 10;

    /// A board without power; it gets it when it is polled for the first time. `timing` is what its driver needs; the refills come
    /// `phase` later than the control ticks.
    ///
    /// # Panics
    /// Never: the clock is one that motion can use, and the node-ID is one.
    pub fn new(timing: DriverTiming, phase: Duration) -> Self {
        // A bus owns its stations. What few boards there are may stay.
        let ring: &'static Ring = Box::leak(Box::new(Ring::new()));
        let model = TimerModel::new(ring, Judge::new(timing));
        model.set_burst(BURST);
        let config = DriveConfig {
            axis: AxisConfig {
                clock: Clock::new(HZ).expect("a clock that motion can use"),
                segment: SEGMENT,
                timing,
            },
            tick: CONTROL,
            refills: (CONTROL.ticks() / REFILL.ticks()) as u32,
        };
        let settings = Settings {
            node_id: NodeId::new(Self::NODE).expect("a node-ID"),
            bit_rate: BitRate::Kbit1000,
        };
        let beat = |phase| Beat {
            due: Instant::from_ticks(0) + phase,
            late: Duration::from_ticks(0),
        };
        Self {
            device: Device::new(Dictionary::default(), settings, 1),
            drive: Drive::new(config),
            exchange: Exchange::new(),
            output: Output::new(model.clone(), ring),
            model,
            control: beat(Duration::from_ticks(0)),
            refill: beat(phase),
            early: None,
            busy: Duration::from_ticks(0),
            running: None,
            latest: LATEST,
            random: 0x9E37_79B9_7F4A_7C15,
            powered: false,
            ticked: Instant::from_ticks(0),
        }
    }

    /// The timers, and the pins.
    pub fn model(&self) -> &TimerModel<'static> {
        &self.model
    }

    /// The state of the drive.
    pub fn state(&self) -> State {
        self.drive.state()
    }

    /// When the last control tick was, or an early one.
    pub fn last_tick(&self) -> Instant {
        self.ticked
    }

    /// Control ticks take so long from now on, early ones too: what they hand out comes at the end. Nothing of their priority runs meanwhile. What
    /// is due comes late by up to 18 µs then, for the interrupts of higher priority.
    pub fn set_busy(&mut self, busy: Duration) {
        self.busy = busy;
        self.latest = INTERRUPTED;
    }

    /// The pulses that have left until `now`.
    pub fn pulses_at(&mut self, now: Instant) -> u64 {
        self.run_until(now);
        self.model.judge().pulses
    }

    /// `now` in ticks of the step timer.
    pub fn ticks(now: Instant) -> u64 {
        now.ticks() * MICROSECOND
    }

    /// Runs every control tick and every refill up to `now`, and the timers.
    fn run_until(&mut self, now: Instant) {
        if !self.powered {
            self.powered = true;
            self.device.power_on(now, &mut self.exchange);
        }
        while let Some(next) = Some(self.next()).filter(|next| *next <= now) {
            self.play_until(next);
            match self.running.take() {
                Some((_, task)) => self.run(task, next),
                None => self.begin(next),
            }
        }
        self.play_until(now);
    }

    /// When something ends or begins.
    fn next(&self) -> Instant {
        if let Some((end, _)) = self.running {
            return end;
        }
        let beat = self.control.at().min(self.refill.at());
        beat.min(self.early.unwrap_or(beat))
    }

    /// Something is due. Of one priority the system timer goes first, then the timer of the refills, then what software has asked for.
    fn begin(&mut self, now: Instant) {
        let task = if self.control.at() <= now {
            self.control = self.after(self.control, CONTROL);
            Task::Control
        } else if self.refill.at() <= now {
            self.refill = self.after(self.refill, REFILL);
            Task::Refill
        } else {
            self.early = None;
            Task::Early
        };
        if task != Task::Refill {
            self.output.service();
            self.drive.top_up(&mut self.output);
        }
        if task == Task::Refill || self.busy.ticks() == 0 {
            self.run(task, now);
        } else {
            self.running = Some((now + self.busy, task));
        }
    }

    fn run(&mut self, task: Task, now: Instant) {
        match task {
            Task::Control => self.control_tick(now),
            Task::Early => self.early_tick(now),
            Task::Refill => {
                self.output.service();
                self.drive.refill(&mut self.output);
            }
        }
        self.answer_break();
    }

    /// The next of its kind.
    fn after(&mut self, beat: Beat, period: Duration) -> Beat {
        Beat {
            due: beat.due + period,
            late: self.lateness(),
        }
    }

    fn lateness(&mut self) -> Duration {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        Duration::from_ticks(self.random % self.latest)
    }

    /// The break input is active from now on, or no longer.
    pub fn set_break(&mut self, now: Instant, is_active: bool) {
        self.run_until(now);
        self.model.set_break(is_active);
        if is_active {
            self.model.run(BREAK_LATENCY);
        }
        self.answer_break();
    }

    /// The interrupt of the break.
    fn answer_break(&mut self) {
        if self.model.is_break_interrupt() {
            on_break(&mut self.model);
        }
    }

    fn play_until(&mut self, now: Instant) {
        let ticks = Self::ticks(now).saturating_sub(self.model.time());
        self.model.run(ticks);
    }

    fn control_tick(&mut self, now: Instant) {
        self.ticked = now;
        let inputs = self.inputs();
        let outputs = self
            .drive
            .tick(now, &inputs, &mut self.output, &mut self.exchange);
        self.end_tick(now, &outputs);
    }

    fn early_tick(&mut self, now: Instant) {
        if !self.exchange.calls_early() {
            // A control tick was first.
            return;
        }
        self.ticked = now;
        let inputs = self.inputs();
        let outputs = self
            .drive
            .early_tick(now, &inputs, &mut self.output, &mut self.exchange);
        self.end_tick(now, &outputs);
    }

    fn inputs(&mut self) -> Inputs {
        self.output.service();
        Inputs {
            supply: true,
            position: self.output.position(),
            fault: self.fault(),
            ..Inputs::default()
        }
    }

    fn fault(&self) -> Option<u16> {
        of_pulses(self.output.has_failed(), self.output.is_broken())
    }

    fn end_tick(&mut self, now: Instant, outputs: &Outputs) {
        if !outputs.power_stage && self.fault().is_some() {
            self.output.mend();
        }
        if outputs.drop_pulses && self.output.pending() > 0 {
            self.output.drop_all();
        }
        self.device.poll(now, &mut self.exchange);
        self.heed_stop(now);
    }

    /// A command to stop has come: an early tick is due.
    fn heed_stop(&mut self, now: Instant) {
        if self.device.calls_early() {
            let late = self.lateness();
            self.early.get_or_insert(now + late);
        }
    }
}

impl Station for Board {
    fn receive(&mut self, frame: &Frame, now: Instant) {
        self.run_until(now);
        self.device.receive(frame, now, &mut self.exchange);
        self.heed_stop(now);
    }

    fn poll(&mut self, now: Instant) -> Instant {
        self.run_until(now);
        let deadline = self.device.poll(now, &mut self.exchange);
        self.heed_stop(now);
        while self.device.event().is_some() {}
        deadline.min(self.next())
    }

    fn transmit(&mut self) -> Option<Frame> {
        self.device.transmit()
    }
}
