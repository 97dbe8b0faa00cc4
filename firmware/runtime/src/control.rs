//! What the control tick does: measure, let the drive decide, act.
//!
//! The contract:
//! - One tick is one call of [`Drive::tick`], whatever the bus does; a command to stop has one of [`Drive::early_tick`] before the next, a stage
//!   that fails another, and the regular ticks come when they would have come. The exchange is locked for the copies only.
//! - A fault of the stage goes before lost frames: a drive has one cause at a time. Bus-off is for the device to see: it
//!   stops the motor as every communication error does.
//! - Lost frames are a fault only while the motor has current. Storing stops the processor, so on a busy bus frames are lost
//!   then; a master gets the device's message, and no fault it would have to reset.
//! - Pulses the drive gives up are dropped in the same tick.
//! - A refill may interrupt a tick: it needs the emitter alone ([`cia402::Emitter`]), which the tick locks for a question, a copy or the first
//!   pulses of a motor that stood. Where the two come one after the other, [`Control::refill`] is for it.
//! - The watchdog is fed only if the node task has run since the last tick: if either of the two hangs, the board
//!   starts anew. That may take seconds, so a motor with current stops before, with a fault, when the node task has not run for 20 ms; it is fed
//!   until that stop is over.

use core::ops::Deref;

use canopen::{Duration, Instant};
use cia402::recorder::{Memory, Recorder};
use cia402::{
    Actuator, AtPort, Drive, DriveConfig, Emitter, EmitterLock, Inputs, Objects, Outputs,
    ServoAxis, Share, State, StepAxis,
};
use motion::PulseSink;

use crate::ports::PowerStage;

/// Error code 8110h of CiA 301: frames were lost, a command may have been among them. A fault while the drive is enabled;
/// with no current in the motor there is nothing to stop, and it is a message alone.
const CAN_OVERRUN: u16 = 0x8110;

/// Error code 6100h of CiA 402: the firmware itself. Nobody could command the motor any more.
const NODE_HANGS: u16 = 0x6100;

/// How long the node task may not run while the motor has current.
const NODE_PATIENCE: Duration = Duration::millis(20);

/// The drive of the dictionary `D` and what it works on, with the memory `M` of the scope, and with an actuator `A`. The power stage is the host's: it comes with each call, always the
/// same one.
#[derive(Debug)]
pub struct Control<D, M, A = StepAxis> {
    drive: Drive<D, A>,
    recorder: Recorder<M>,
    /// How many frames were lost before.
    lost: u32,
    /// The motor had current after the last tick.
    powered: bool,
    /// When the node task was seen to run last.
    alive_at: Instant,
    /// It has hung with current in the motor, and not run since.
    hangs: bool,
    /// What was measured in the last tick. It stays here: the edges of the inputs are many words that seldom change.
    inputs: Inputs,
}

impl<D: Objects, M: Deref<Target = Memory>> Control<D, M> {
    /// A drive that stands, without power.
    pub fn new(config: DriveConfig, scope: M) -> Self {
        Self::with_emitter(config, scope, || Emitter::new(config))
    }
}

impl<D: Objects, M: Deref<Target = Memory>, L: EmitterLock> Control<D, M, StepAxis<L>> {
    /// The same with an emitter that refills use between any two moments of a tick.
    // Out of line, so that it is made where it stays.
    #[inline(never)]
    pub fn with_emitter(config: DriveConfig, scope: M, emitter: impl FnOnce() -> L) -> Self {
        Self::with_drive(config, scope, || Drive::with_emitter(config, emitter))
    }
}

impl<D: Objects, M: Deref<Target = Memory>> Control<D, M, ServoAxis> {
    /// A drive whose motor is moved by its current, without power.
    pub fn servo(config: DriveConfig, scope: M) -> Self {
        Self::servo_with_emitter(config, scope, || Emitter::new(config))
    }
}

impl<D: Objects, M: Deref<Target = Memory>, L: EmitterLock> Control<D, M, ServoAxis<L>> {
    /// The same with an emitter that others than a tick may look at.
    #[inline(never)]
    pub fn servo_with_emitter(config: DriveConfig, scope: M, emitter: impl FnOnce() -> L) -> Self {
        Self::with_drive(config, scope, || Drive::servo(config, emitter))
    }
}

impl<D: Objects, M: Deref<Target = Memory>, A: Actuator> Control<D, M, A> {
    #[inline]
    fn with_drive(config: DriveConfig, scope: M, drive: impl FnOnce() -> Drive<D, A>) -> Self {
        Self {
            recorder: Recorder::new(scope, config.tick),
            lost: 0,
            powered: false,
            alive_at: Instant::from_ticks(0),
            hangs: false,
            inputs: Inputs::default(),
            // Last, as it is large: so it is made where it stays.
            drive: drive(),
        }
    }

    /// One tick. `lost` is how many received frames were lost since power-on, `alive` whether the node task ran since the last tick.
    /// Returns when it was, and when the next one is due if the drive says.
    pub fn tick<S: PowerStage>(
        &mut self,
        lost: u32,
        alive: bool,
        stage: &mut S,
        exchange: &mut impl Share,
    ) -> (Instant, Option<Instant>)
    where
        A: AtPort<S::Pulses>,
    {
        let overrun = self.has_overrun(lost);
        self.lost = lost;
        let now = self.look(overrun, stage);
        self.watch_node(now, alive);
        stage.measure(&mut self.inputs);
        let outputs = self.drive.tick(now, &self.inputs, stage.pulses(), exchange);
        self.carry_out(&outputs, stage);
        self.recorder.tick(&self.drive, exchange);
        // A motor that stops because the node hangs comes to its end first, which 20A1h bounds.
        if alive || self.hangs && self.powered {
            stage.feed_watchdog();
        }
        (now, outputs.next_tick)
    }

    /// A tick of its own for a command to stop, unless a regular one was first, or while the motor has current for what is a fault since the last
    /// one: of the stage, its supply, frames that were lost (`lost` as for [`Control::tick`]). Returns whether there was one.
    pub fn stop<S: PowerStage>(
        &mut self,
        lost: u32,
        stage: &mut S,
        exchange: &mut impl Share,
    ) -> bool
    where
        A: AtPort<S::Pulses>,
    {
        let calls = exchange.lock(|exchange| exchange.calls_early());
        if !calls && !self.powered {
            return false;
        }
        let was_well = self.is_well();
        let now = self.look(self.has_overrun(lost), stage);
        let has_failed = was_well && !self.is_well();
        if !calls && !has_failed {
            return false;
        }
        self.lost = lost;
        let outputs = self
            .drive
            .early_tick(now, &self.inputs, stage.pulses(), exchange);
        self.carry_out(&outputs, stage);
        true
    }

    /// Commits pulses between two ticks, if none of them is interrupted by a refill.
    pub fn refill<S: PowerStage>(&mut self, stage: &mut S)
    where
        A: AtPort<S::Pulses>,
    {
        stage.service();
        self.drive.refill(stage.pulses());
    }

    /// Takes what the stage sees and every tick needs. Returns when that was.
    fn look(&mut self, overrun: bool, stage: &mut impl PowerStage) -> Instant {
        let now = stage.look(&mut self.inputs);
        let fault = &mut self.inputs.fault;
        *fault = fault.or(overrun.then_some(CAN_OVERRUN));
        now
    }

    /// Whether frames were lost since the last tick, and that is more than a message.
    fn has_overrun(&self, lost: u32) -> bool {
        let harmless = !self.powered
            && !matches!(
                self.drive.state(),
                State::Fault | State::FaultReactionActive
            );
        lost != self.lost && !harmless
    }

    /// The stage was so when it was looked at.
    fn is_well(&self) -> bool {
        self.inputs.supply && self.inputs.fault.is_none()
    }

    /// A node task that hangs is a fault if the motor has current.
    fn watch_node(&mut self, now: Instant, alive: bool) {
        if alive {
            self.alive_at = now;
            self.hangs = false;
        } else if self.powered {
            let silent = now.checked_duration_since(self.alive_at);
            self.hangs |= silent.is_some_and(|silent| silent > NODE_PATIENCE);
        }
        let fault = &mut self.inputs.fault;
        *fault = fault.or(self.hangs.then_some(NODE_HANGS));
    }

    fn carry_out(&mut self, outputs: &Outputs, stage: &mut impl PowerStage) {
        stage.carry_out(outputs);
        self.powered = outputs.power_stage;
        if outputs.drop_pulses && stage.pulses().pending() > 0 {
            stage.drop_pulses();
        }
    }
}
