//! The drive's half with the motor: the control tick of the runtime, on the pulses and the power stage of the board.

use canopen::{Duration, Instant};
use cia402::inputs::{time_of_edge, Capture};
use cia402::recorder::Memory;
use cia402::{Actuator, AtPort, DriveConfig, Exchange, Inputs, Outputs, ServoAxis, StepAxis};
use motion::{AxisConfig, Clock, DriverTiming};
use rtic::Mutex;
use runtime::{Lost, PowerStage};

use crate::board::{Board, Pulses, Selected, Stage};
use crate::clock;
use crate::dictionary::Dictionary;
use crate::share::Locked;
use crate::stepping::{SharedEmitter, SharedPulses, Stepping};

/// Control ticks in a second.
pub const RATE_HZ: u32 = 1_000;

/// What a driver may ask for: pulses of 2.5 µs with as much between them, and 5 µs around a change of direction. Most
/// step/direction drivers are faster.
pub const TIMING: DriverTiming = DriverTiming {
    pulse_high: ticks(2_500),
    pulse_low: ticks(2_500),
    direction_setup: ticks(5_000),
    direction_hold: ticks(5_000),
};

/// The control tick with an actuator.
type ControlOf<A> = runtime::Control<Dictionary, &'static Memory, A>;

/// What moves the motor of a board: how the control tick is made with it.
pub trait Moving: Actuator + AtPort<SharedPulses> + Sized {
    /// With the emitter and the scope of the firmware.
    fn control(stepping: &'static Stepping, scope: &'static Memory) -> ControlOf<Self>;
}

impl Moving for StepAxis<SharedEmitter> {
    fn control(stepping: &'static Stepping, scope: &'static Memory) -> ControlOf<Self> {
        runtime::Control::with_emitter(CONFIG, scope, || SharedEmitter(stepping))
    }
}

impl Moving for ServoAxis<SharedEmitter> {
    fn control(stepping: &'static Stepping, scope: &'static Memory) -> ControlOf<Self> {
        runtime::Control::servo_with_emitter(CONFIG, scope, || SharedEmitter(stepping))
    }
}

/// The drive and what it works on.
pub struct Control {
    control: ControlOf<<Selected as Board>::Axis>,
    stage: StepStage,
    lost: &'static Lost,
}

impl Control {
    /// A drive that stands, without power.
    pub fn new(
        stepping: &'static Stepping,
        stage: <Selected as Board>::Stage,
        lost: &'static Lost,
        edges: &'static Capture,
        scope: &'static Memory,
    ) -> Self {
        Self {
            control: <Selected as Board>::Axis::control(stepping, scope),
            stage: StepStage {
                pulses: SharedPulses(stepping),
                stage,
                edges,
                now: Instant::from_ticks(0),
                counter: 0,
            },
            lost,
        }
    }

    /// One tick. `alive` is whether the node task ran since the last tick. Returns when it was, and when the next one is due if
    /// the drive says.
    pub fn tick(
        &mut self,
        mut exchange: impl Mutex<T = &'static mut Exchange>,
        alive: bool,
    ) -> (Instant, Option<Instant>) {
        let exchange = &mut Locked(&mut exchange);
        let lost = self.lost.count();
        self.control.tick(lost, alive, &mut self.stage, exchange)
    }

    /// A tick of its own for a command to stop, a stage that has failed or frames that are lost, unless a regular one was first.
    pub fn stop(&mut self, mut exchange: impl Mutex<T = &'static mut Exchange>) {
        let exchange = &mut Locked(&mut exchange);
        self.control
            .stop(self.lost.count(), &mut self.stage, exchange);
    }
}

/// The power stage of the board with its pulses, and the edges of its inputs.
struct StepStage {
    pulses: SharedPulses,
    stage: <Selected as Board>::Stage,
    edges: &'static Capture,
    /// When the tick has looked, and the board's counter then.
    now: Instant,
    counter: u32,
}

impl PowerStage for StepStage {
    type Pulses = SharedPulses;

    fn pulses(&mut self) -> &mut Self::Pulses {
        &mut self.pulses
    }

    fn service(&mut self) {
        self.pulses.service();
    }

    fn look(&mut self, inputs: &mut Inputs) -> Instant {
        self.pulses.service();
        self.now = clock::now();
        self.counter = Selected::ticks();
        inputs.supply = self.stage.supply();
        inputs.position = self.pulses.position();
        inputs.fault = self.stage.fault().or(self.pulses.fault());
        self.now
    }

    fn measure(&mut self, inputs: &mut Inputs) {
        self.stage.measure(inputs);
        let (now, counter, pulses) = (self.now, self.counter, &self.pulses);
        self.edges.take(
            Selected::input_levels(),
            &mut inputs.digital,
            |ticks| {
                let counts = counter.wrapping_sub(ticks);
                time_of_edge(now, counts, Selected::TICKS_PER_MICROSECOND)
            },
            |count| pulses.position_at(count),
        );
    }

    fn carry_out(&mut self, outputs: &Outputs) {
        self.stage.set_power(outputs.power_stage);
        self.stage.set_brake(outputs.brake_released);
        self.stage.set_outputs(outputs.digital);
        if !outputs.power_stage && self.pulses.fault().is_some() {
            self.pulses.mend();
        }
    }

    fn drop_pulses(&mut self) {
        self.pulses.drop_all();
    }

    fn feed_watchdog(&mut self) {
        self.stage.feed_watchdog();
    }
}

/// What the drive is built from.
pub const CONFIG: DriveConfig = {
    let Some(clock) = Clock::new(Selected::STEP_CLOCK_HZ) else {
        panic!("a step clock that motion can use")
    };
    DriveConfig {
        axis: AxisConfig {
            clock,
            time_slice: Selected::STEP_CLOCK_HZ / RATE_HZ / Selected::REFILLS,
            timing: Selected::TIMING,
        },
        tick: Duration::micros(1_000_000 / RATE_HZ as u64),
        refills: Selected::REFILLS,
    }
};

/// Nanoseconds in ticks of the step clock, rounded up.
const fn ticks(nanoseconds: u32) -> u32 {
    (nanoseconds as u64 * Selected::STEP_CLOCK_HZ as u64).div_ceil(1_000_000_000) as u32
}
