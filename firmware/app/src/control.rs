//! What the control tick does: measure, let the drive decide, act.
//!
//! Every millisecond, or in step with SYNC, the drive gets what the board sees (supply, the steps that have left, the fault of the stage, the
//! state of the bus), and answers with pulses for the step interrupt and with whether the motor may have current. Which
//! fault stops the motor how is for [`Drive`] to say; this file only names the faults.
//!
//! The contract:
//! - One tick is one call of [`Drive::tick`], whatever the bus does; a command to stop has one of [`Drive::early_tick`] before the next, and
//!   the ticks keep their beat. The exchange is locked for the copies only.
//! - A fault of the stage goes before lost frames: a drive has one cause at a time. Bus-off is for the device to see: it
//!   stops the motor as every communication error does.
//! - Lost frames are a fault only while the motor has current. Storing stops the processor, so on a busy bus frames are lost
//!   then; a master gets the device's message, and no fault it would have to reset.
//! - Pulses the drive gives up are dropped in the same tick.
//! - An early tick begins with a segment and a half of pulses left at least: the refills have its priority and wait for it, and may wait for the
//!   regular one behind it too.
//! - The watchdog is fed only if the node task has run since the last tick: if either of the two hangs, the board
//!   starts anew.

use canopen::{Duration, Instant};
use cia402::inputs::{time_of_edge, Capture};
use cia402::recorder::{Memory, Recorder};
use cia402::{Drive, DriveConfig, Exchange, Inputs, Outputs, State};
use motion::{AxisConfig, Clock, DriverTiming, PulseSink};
use rtic::Mutex;

use crate::board::{Board, Pulses, Selected, Stage};
use crate::clock;
use crate::dictionary::Dictionary;
use crate::inbox::Lost;
use crate::share::Locked;

/// Control ticks in a second.
pub const RATE_HZ: u32 = 1_000;

/// Error code 8110h of CiA 301: frames were lost, a command may have been among them. A fault while the drive is enabled;
/// with no current in the motor there is nothing to stop, and it is a message alone.
const CAN_OVERRUN: u16 = 0x8110;

/// What a driver may ask for: pulses of 2.5 µs with as much between them, and 5 µs around a change of direction. Most
/// step/direction drivers are faster.
pub const TIMING: DriverTiming = DriverTiming {
    pulse_high: ticks(2_500),
    pulse_low: ticks(2_500),
    direction_setup: ticks(5_000),
    direction_hold: ticks(5_000),
};

/// The drive and what it works on.
pub struct Control {
    drive: Drive<Dictionary>,
    recorder: Recorder<&'static Memory>,
    pulses: <Selected as Board>::Pulses,
    stage: <Selected as Board>::Stage,
    lost: &'static Lost,
    edges: &'static Capture,
    lost_before: u32,
    /// The motor had current after the last tick.
    powered: bool,
    /// What the board measured in the last tick. It stays here: the edges of the inputs are many words that seldom change.
    inputs: Inputs,
}

impl Control {
    /// A drive that stands, without power.
    pub fn new(
        pulses: <Selected as Board>::Pulses,
        stage: <Selected as Board>::Stage,
        lost: &'static Lost,
        edges: &'static Capture,
        scope: &'static Memory,
    ) -> Self {
        Self {
            drive: Drive::new(config()),
            recorder: Recorder::new(scope, config().tick),
            pulses,
            stage,
            lost,
            edges,
            lost_before: 0,
            powered: false,
            inputs: Inputs::default(),
        }
    }

    /// One tick. `alive` is whether the node task ran since the last tick. Returns when it was, and when the next one is due if
    /// the drive says.
    pub fn tick(
        &mut self,
        mut exchange: impl Mutex<T = Exchange>,
        alive: bool,
    ) -> (Instant, Option<Instant>) {
        let lost = self.lost.count();
        let overrun = lost != self.lost_before;
        self.lost_before = lost;
        let harmless = !self.powered
            && !matches!(
                self.drive.state(),
                State::Fault | State::FaultReactionActive
            );

        let (now, counter) = self.look(overrun && !harmless);
        let inputs = &mut self.inputs;
        self.stage.measure(inputs);
        let pulses = &self.pulses;
        self.edges.take(
            Selected::input_levels(),
            &mut inputs.digital,
            |ticks| {
                let counts = counter.wrapping_sub(ticks);
                time_of_edge(now, counts, Selected::TICKS_PER_MICROSECOND)
            },
            |count| pulses.position_at(count),
        );
        let outputs = self
            .drive
            .tick(now, inputs, &mut self.pulses, &mut Locked(&mut exchange));
        self.carry_out(&outputs);
        self.recorder.tick(&self.drive, &mut Locked(&mut exchange));
        if alive {
            self.stage.feed_watchdog();
        }
        (now, outputs.next_tick)
    }

    /// A tick of its own for a command to stop, unless a regular one was first.
    pub fn stop(&mut self, mut exchange: impl Mutex<T = Exchange>) {
        if !exchange.lock(|exchange| exchange.calls_early()) {
            return;
        }
        self.pulses.service();
        self.drive.top_up(&mut self.pulses);
        let (now, _) = self.look(false);
        let outputs = self.drive.early_tick(
            now,
            &self.inputs,
            &mut self.pulses,
            &mut Locked(&mut exchange),
        );
        self.carry_out(&outputs);
    }

    /// Takes what the board sees and every tick needs. Returns when that was, and the board's counter then.
    fn look(&mut self, overrun: bool) -> (Instant, u32) {
        self.pulses.service();
        let now = clock::now();
        let counter = Selected::ticks();
        let inputs = &mut self.inputs;
        inputs.supply = self.stage.supply();
        inputs.position = self.pulses.position();
        inputs.fault = self
            .stage
            .fault()
            .or(self.pulses.fault())
            .or(overrun.then_some(CAN_OVERRUN));
        (now, counter)
    }

    fn carry_out(&mut self, outputs: &Outputs) {
        self.stage.set_power(outputs.power_stage);
        self.stage.set_brake(outputs.brake_released);
        self.stage.set_outputs(outputs.digital);
        self.powered = outputs.power_stage;
        if !self.powered && self.pulses.fault().is_some() {
            self.pulses.mend();
        }
        if outputs.drop_pulses && self.pulses.pending() > 0 {
            self.pulses.drop_all();
        }
    }

    /// Hands out pulses between two ticks.
    pub fn refill(&mut self) {
        self.pulses.service();
        self.drive.refill(&mut self.pulses);
        Selected::refill_done();
    }
}

const fn config() -> DriveConfig {
    let Some(clock) = Clock::new(Selected::STEP_CLOCK_HZ) else {
        panic!("a step clock that motion can use")
    };
    DriveConfig {
        axis: AxisConfig {
            clock,
            segment: Selected::STEP_CLOCK_HZ / RATE_HZ / Selected::REFILLS,
            timing: TIMING,
        },
        tick: Duration::micros(1_000_000 / RATE_HZ as u64),
        refills: Selected::REFILLS,
    }
}

/// Nanoseconds in ticks of the step clock, rounded up.
const fn ticks(nanoseconds: u32) -> u32 {
    (nanoseconds as u64 * Selected::STEP_CLOCK_HZ as u64).div_ceil(1_000_000_000) as u32
}
