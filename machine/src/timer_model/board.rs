//! The drive as it is on the board: both halves of the firmware's drive, and its pulses made by the modelled timers.
//!
//! It runs what the tasks of the firmware run, at their rates: a control tick each millisecond, a refill each quarter of one, the
//! node when a frame comes. Instructions take no time here; in their place each control tick, each refill and each early tick comes late by up to
//! 50 µs, which is longer than what the processor is busy with in most of them (`docs/benchmarks.md`). With [`Board::set_busy`] the ticks take
//! a time of their own, in which refills come at any moment.

use std::fmt;
use std::rc::Rc;

use canopen::{BitRate, Duration, Frame, Instant, NodeId, Settings};
use cia402::faults::of_pulses;
use cia402::{Device, Drive, DriveConfig, Everything, Exchange, Inputs, Outputs, State, StepAxis};
use motion::advanced_timer::Ring;
use motion::{AxisConfig, Clock, DriverTiming, PulseSink};

use super::rig::{HZ, TIME_SLICE};
use super::stepping::{Beat, Lateness, MICROSECOND, REFILL, SharedEmitter, SharedPulses, Stepping};
use super::{Judge, TimerModel};
use crate::dictionary::Dictionary;
use master::bus::Station;

/// Control ticks are so far apart.
const CONTROL: Duration = Duration::from_ticks(1_000);

/// What a DMA burst may take (`docs/step-engine.md`), in ticks.
const BURST: u64 = 84;

/// From a break to what its interrupt does: two microseconds.
const BREAK_LATENCY: u64 = 2 * MICROSECOND;

/// A control tick or a refill is late by less than this, in microseconds, in place of all that the processor does.
const LATEST: u64 = 50;

/// The same where the ticks take a time of their own: the interrupts of higher priority.
const INTERRUPTED: u64 = 18;

/// A drive on the modelled timers. Its node-ID is [`Board::NODE`]; the supply is there.
pub struct Board {
    device: Device<Dictionary>,
    drive: Drive<Everything, StepAxis<SharedEmitter>>,
    exchange: Exchange,
    stepping: Rc<Stepping>,
    model: TimerModel<'static>,
    control: Beat,
    /// When a command to stop is carried out that has come.
    early: Option<Instant>,
    /// How long control ticks take, early ones too.
    busy: Duration,
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
                time_slice: TIME_SLICE,
                timing,
            },
            tick: CONTROL,
            refills: (CONTROL.ticks() / REFILL.ticks()) as u32,
        };
        let settings = Settings {
            node_id: NodeId::new(Self::NODE).expect("a node-ID"),
            bit_rate: BitRate::Kbit1000,
        };
        let timers = (model.clone(), ring);
        let stepping = Rc::new(Stepping::new(config, timers, phase, Lateness::new(LATEST)));
        Self {
            device: Device::new(Dictionary::default(), settings, 1),
            drive: Drive::with_emitter(config, || SharedEmitter(Rc::clone(&stepping))),
            exchange: Exchange::new(),
            stepping,
            model,
            control: Beat::at_phase(Duration::from_ticks(0)),
            early: None,
            busy: Duration::from_ticks(0),
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

    /// Control ticks take so long from now on, early ones too, and refills come in between. What
    /// is due comes late by up to 18 µs then, for the interrupts of higher priority.
    pub fn set_busy(&mut self, busy: Duration) {
        self.busy = busy;
        self.stepping.lateness.set_latest(INTERRUPTED);
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
        while let Some(next) = Some(self.next_tick()).filter(|next| *next <= now) {
            self.stepping.run_until(next);
            self.begin(self.stepping.now());
        }
        self.stepping.run_until(now);
    }

    /// When the next tick is due, or the one that runs ends.
    fn next_tick(&self) -> Instant {
        let control = self.control.at();
        let next = control.min(self.early.unwrap_or(control));
        next.max(self.stepping.now())
    }

    /// A tick is due. The system timer goes before what software has asked for.
    fn begin(&mut self, now: Instant) {
        let is_regular = self.control.at() <= now;
        if is_regular {
            self.control = (self.control).after(CONTROL, self.stepping.lateness.next());
        } else {
            self.early = None;
            if !self.exchange.calls_early() {
                // A control tick was first.
                return;
            }
        }
        self.ticked = now;
        self.stepping.begin_tick(self.busy);
        let inputs = self.inputs();
        let (exchange, pulses) = (
            &mut self.exchange,
            &mut SharedPulses(Rc::clone(&self.stepping)),
        );
        let outputs = if is_regular {
            self.drive.tick(now, &inputs, pulses, exchange)
        } else {
            self.drive.early_tick(now, &inputs, pulses, exchange)
        };
        self.stepping.end_tick();
        self.end_tick(self.stepping.now(), &outputs);
        self.stepping.answer_break();
    }

    /// The break input is active from now on, or no longer.
    pub fn set_break(&mut self, now: Instant, is_active: bool) {
        self.run_until(now);
        self.model.set_break(is_active);
        if is_active {
            self.model.run(BREAK_LATENCY);
        }
        self.stepping.answer_break();
    }

    fn inputs(&mut self) -> Inputs {
        let mut output = self.stepping.output.borrow_mut();
        output.service();
        let position = output.position();
        drop(output);
        Inputs {
            supply: true,
            position,
            fault: self.fault(),
            ..Inputs::default()
        }
    }

    fn fault(&self) -> Option<u16> {
        let output = self.stepping.output.borrow();
        of_pulses(output.has_failed(), output.is_broken())
    }

    fn end_tick(&mut self, now: Instant, outputs: &Outputs) {
        let is_failed = self.fault().is_some();
        let mut output = self.stepping.output.borrow_mut();
        if !outputs.power_stage && is_failed {
            output.mend();
        }
        if outputs.drop_pulses && output.pending() > 0 {
            output.drop_all();
        }
        drop(output);
        self.device.poll(now, &mut self.exchange);
        self.heed_stop(now);
    }

    /// A command to stop has come: an early tick is due.
    fn heed_stop(&mut self, now: Instant) {
        if self.device.calls_early() {
            let late = self.stepping.lateness.next();
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
        deadline.min(self.next_tick()).min(self.stepping.next())
    }

    fn transmit(&mut self) -> Option<Frame> {
        self.device.transmit()
    }
}
