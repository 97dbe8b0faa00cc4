//! The virtual drive: both halves of the firmware's drive and a simulated motor, on virtual time.
//!
//! It hosts the runtime as the tasks of the firmware do: a control tick each millisecond, a refill of the pulses each quarter of one, and
//! the node behind each tick, each frame and at its deadlines. It is a [`Station`], so any bus can carry it.

mod ports;
mod setup;

use std::collections::VecDeque;
use std::sync::Arc;

use canopen::settings::PowerOn;
use canopen::time::NEVER;
use canopen::{BitRate, ControllerState, Duration, Event, Frame, Instant};
use cia402::recorder::Memory;
use cia402::{
    Actuals, Actuator, AtPort, Behaves, Behaviour, Device, DriveConfig, Exchange, Objects,
    ServoAxis, StepAxis,
};
use motion::{AxisConfig, Clock, DriverTiming};
use runtime::servo::ServoObjects;
use runtime::{Control, Controller as _, Node, PowerUp, Stamped};

use crate::flash::Flash;
use crate::machine::{Machine, machine};
use crate::plant::{Plant, PulsePlayer, STEP_CLOCK_HZ};
use crate::settings::FactoryStore;
use master::bus::Station;
use ports::{Controller, Received, Slot, Tasks};

pub use setup::Setup;

/// The period of the control tick.
pub const CONTROL_TICK: Duration = Duration::from_ticks(1_000);

/// Pulses are emitted so often in a control tick, by a timer of its own as on the board.
const REFILLS: u32 = 4;

/// From a refill to the next.
const REFILL: Duration = Duration::from_ticks(CONTROL_TICK.ticks() / REFILLS as u64);

/// A sample of the motor, for plots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MotionSample {
    /// When.
    pub at: Instant,
    /// Where the motor was, in steps.
    pub position: i64,
}

/// A drive with the dictionary `D` of its firmware; on power it boots, then it lives on frames and time.
#[derive(Debug)]
pub struct VirtualDrive<D: Behaves, A = StepAxis> {
    serial_number: u32,
    power_up: PowerUp,
    powered: bool,
    was_reset: bool,
    node: BusNode<D>,
    control: Control<D, Arc<Memory>, A>,
    exchange: Exchange,
    controller: Controller,
    received: Received,
    plant: Plant,
    now: Instant,
    next_tick: Instant,
    next_refill: Instant,
    events: VecDeque<Event>,
    samples: Option<Vec<MotionSample>>,
    servo_objects: ServoObjects,
}

impl<D: Behaves + Default, A: Moving> VirtualDrive<D, A> {
    /// A drive without power; it gets it when it is polled for the first time.
    pub fn new(setup: Setup) -> Self {
        let now = Instant::from_ticks(0);
        let mut plant = Plant::new(now);
        if let Some(axis) = &setup.axis {
            plant.mount(axis);
        }
        let power_up = PowerUp {
            build: setup.build,
            switches: setup.switches,
            factory: D::HABITS.factory,
            factory_reset: false,
        };
        let settings = setup.axis.as_ref().map(|axis| &axis.settings);
        let store = FactoryStore::new(setup.store, settings, setup.settings);
        let (node, control) = firmware(setup.serial_number, &power_up, Some(store));
        Self {
            serial_number: setup.serial_number,
            power_up,
            powered: false,
            was_reset: false,
            controller: controller(&node),
            node,
            control,
            received: Received::default(),
            exchange: Exchange::new(),
            plant,
            now,
            next_tick: now,
            next_refill: now,
            events: VecDeque::new(),
            samples: None,
            servo_objects: ServoObjects::default(),
        }
    }

    /// Takes the power away and gives it back at once: everything that is not stored is lost, frames under way too. The
    /// motor stays where it is mounted but counts from 0 again, as a drive without an encoder does, or from the zero of an absolute encoder.
    pub fn power_cycle(&mut self) {
        let store = self.node.store_mut().take();
        (self.node, self.control) = firmware(self.serial_number, &self.power_up, store);
        self.controller = controller(&self.node);
        self.received = Received::default();
        self.exchange = Exchange::new();
        self.servo_objects = ServoObjects::default();
        self.events.clear();
        self.powered = false;
        self.was_reset = true;
    }

    /// The flash behind the parameter store, to break it.
    pub fn with_flash(&mut self, change: impl FnOnce(&mut Flash)) {
        if let Some(store) = self.node.store_mut() {
            store.with_flash(change);
        }
    }

    /// The CANopen half, for its dictionary and state.
    pub fn device(&self) -> &Device<D, Machine> {
        self.node.device()
    }

    /// The motor.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// The motor, to take its supply, to raise a fault, to mount switches.
    pub fn plant_mut(&mut self) -> &mut Plant {
        &mut self.plant
    }

    /// What the drive published last.
    pub fn actuals(&self) -> Actuals {
        self.exchange.actuals_at(NEVER)
    }

    /// The oldest event of the node that nobody has taken yet. The drive has done its part already.
    pub fn take_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    /// Keeps a sample of the motor from each control tick on from now.
    pub fn record_motion(&mut self) {
        self.samples.get_or_insert_default();
    }

    /// The samples kept so far.
    pub fn motion_samples(&self) -> &[MotionSample] {
        self.samples.as_deref().unwrap_or_default()
    }

    /// Gives power to a drive that has none.
    fn power_on(&mut self, now: Instant) {
        self.plant.power_on(now);
        self.powered = true;
        self.next_tick = now;
        self.next_refill = now + REFILL;
        let (node, controller, _, mut tasks) = self.tasks(now);
        node.power_on(&mut tasks, controller);
    }

    /// Runs every control tick and every refill up to and including `now`.
    fn run_until(&mut self, now: Instant) {
        self.now = now;
        if !self.powered {
            self.power_on(now);
        }
        loop {
            if self.next_tick <= now && self.next_tick <= self.next_refill {
                self.control_tick(self.next_tick);
            } else if self.next_refill <= now {
                self.plant.advance(self.next_refill);
                self.control.refill(&mut self.plant);
                self.next_refill += REFILL;
            } else {
                break;
            }
        }
        self.plant.advance(now);
    }

    fn control_tick(&mut self, now: Instant) {
        self.plant.advance(now);
        let (_, next) = self.control.tick(
            self.received.lost,
            true,
            &mut self.plant,
            &mut self.exchange,
        );
        // A tick takes time.
        self.next_tick = next
            .unwrap_or(now + CONTROL_TICK)
            .max(now + CONTROL_TICK / 2);
        if let Some(samples) = &mut self.samples {
            samples.push(MotionSample {
                at: now,
                position: self.plant.position(),
            });
        }
        self.run_node(now);
        self.attend();
    }

    /// What a servo has beside its orders.
    fn attend(&mut self) {
        let Some(servo) = self.plant.servo_mut() else {
            return;
        };
        let rated = servo.rated();
        let (mut settings, mut request) = self
            .servo_objects
            .read(self.node.device().node().dictionary());
        if D::Behaviour::IS_THERE {
            let (dictionary, product) = self.node.product();
            request = product.loops(dictionary, &servo.loop_report(), &mut settings);
        }
        servo.set_up(&settings);
        if let Some(request) = request {
            servo.request(request);
        }
        self.servo_objects
            .show(self.node.dictionary_mut(), servo.loops().found());
        ServoObjects::show_lead(self.node.dictionary_mut(), servo.loops().lead());
        ServoObjects::show_rated(self.node.dictionary_mut(), rated);
    }

    /// Lets the node do what there is to do. Returns when it wants to run again.
    fn run_node(&mut self, now: Instant) -> Instant {
        loop {
            let (node, controller, received, mut tasks) = self.tasks(now);
            let deadline = node.run(&mut tasks, controller, received);
            if !tasks.has_stopped {
                return deadline;
            }
        }
    }

    /// The node, and what is around it.
    fn tasks(
        &mut self,
        now: Instant,
    ) -> (
        &mut BusNode<D>,
        &mut Controller,
        &mut Received,
        Tasks<'_, D, A>,
    ) {
        let tasks = Tasks {
            now,
            exchange: &mut self.exchange,
            control: &mut self.control,
            plant: &mut self.plant,
            lost: self.received.lost,
            events: &mut self.events,
            has_stopped: false,
        };
        (
            &mut self.node,
            &mut self.controller,
            &mut self.received,
            tasks,
        )
    }
}

impl<D, A> Station for VirtualDrive<D, A>
where
    A: Moving,
    D: Behaves + Default + std::fmt::Debug + 'static,
{
    fn receive(&mut self, frame: &Frame, now: Instant) {
        self.run_until(now);
        let frame = *frame;
        self.received.frames.push_back(Stamped { frame, at: now });
        self.run_node(now);
    }

    fn poll(&mut self, now: Instant) -> Instant {
        self.run_until(now);
        self.run_node(now).min(self.next_tick)
    }

    fn transmit(&mut self) -> Option<Frame> {
        let mut slot = Slot::default();
        self.node.send(self.now, &mut slot);
        slot.0
    }

    fn is_silent(&self) -> bool {
        self.controller.is_silent
    }

    fn error_seen(&mut self, now: Instant) {
        self.run_until(now);
        self.controller.has_seen_error = true;
        self.run_node(now);
    }

    fn bit_rate(&self) -> Option<BitRate> {
        Some(self.controller.bit_rate)
    }

    fn was_reset(&mut self) -> bool {
        std::mem::take(&mut self.was_reset)
    }

    fn controller_changed(&mut self, state: ControllerState, now: Instant) {
        self.run_until(now);
        self.controller.state = state;
        self.run_node(now);
    }

    fn frames_lost(&mut self, count: u32, now: Instant) {
        self.run_until(now);
        self.received.lost = self.received.lost.wrapping_add(count);
        self.run_node(now);
    }

    fn restarts_controller(&mut self) -> bool {
        std::mem::take(&mut self.controller.was_started)
    }
}

/// The half of the firmware that is on the bus.
type BusNode<D> = Node<D, Machine, FactoryStore>;

/// Both halves of a drive that has just got power.
fn firmware<D: Behaves + Default, A: Moving>(
    serial_number: u32,
    power_up: &PowerUp,
    mut store: Option<FactoryStore>,
) -> (BusNode<D>, Control<D, Arc<Memory>, A>) {
    let power_on: PowerOn = power_up.choose(&mut store, Controller::BIT_RATES);
    let (machine, scope) = machine();
    let dictionary = D::default();
    let mut node = Node::new(dictionary, machine, &power_on, serial_number, store);
    node.set_up(&power_on, Controller::BIT_RATES, A::MODES);
    (node, A::control(scope))
}

/// What moves the motor of a virtual drive: how the firmware is made with it.
pub trait Moving: Actuator + AtPort<PulsePlayer> + std::fmt::Debug + Sized {
    /// The half of the firmware with the motor.
    fn control<D: Objects>(scope: Arc<Memory>) -> Control<D, Arc<Memory>, Self>;
}

impl Moving for StepAxis {
    fn control<D: Objects>(scope: Arc<Memory>) -> Control<D, Arc<Memory>, Self> {
        Control::new(drive_config(STEP_DRIVER), scope)
    }
}

impl Moving for ServoAxis {
    fn control<D: Objects>(scope: Arc<Memory>) -> Control<D, Arc<Memory>, Self> {
        Control::servo(drive_config(NO_DRIVER), scope)
    }
}

/// The controller of a node that has just got power.
fn controller<D: Behaves>(node: &BusNode<D>) -> Controller {
    Controller::new(node.device().node().settings().bit_rate)
}

/// Ticks of the step clock in a microsecond.
const MICROSECOND: u32 = STEP_CLOCK_HZ / 1_000_000;

/// A stepper driver of the usual kind: pulses of at least 1 µs with 1 µs between, direction 5 µs before and after.
const STEP_DRIVER: DriverTiming = DriverTiming {
    pulse_high: MICROSECOND,
    pulse_low: MICROSECOND,
    direction_setup: 5 * MICROSECOND,
    direction_hold: 5 * MICROSECOND,
};

/// Nothing takes pulses: they are so short that no speed of a motor is beyond them.
const NO_DRIVER: DriverTiming = DriverTiming {
    pulse_high: 8,
    pulse_low: 8,
    direction_setup: 0,
    direction_hold: 0,
};

fn drive_config(timing: DriverTiming) -> DriveConfig {
    DriveConfig {
        axis: AxisConfig {
            clock: Clock::new(STEP_CLOCK_HZ).expect("84 MHz is a step clock"),
            time_slice: REFILL.ticks() as u32 * MICROSECOND,
            timing,
        },
        tick: CONTROL_TICK,
        refills: REFILLS,
    }
}
