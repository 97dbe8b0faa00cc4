//! The virtual drive: both halves of the firmware's drive and a simulated motor, on virtual time.
//!
//! It does what the tasks of the firmware do around the core: a control tick each millisecond, a refill of the pulses each quarter of
//! one, frames in and out, the parameter store, the switch of the bit rate. It is a [`Station`], so any bus can carry it.

use std::collections::VecDeque;
use std::sync::Arc;

use canopen::cia305::{DETECTABLE, Detection};
use canopen::node::StoreError;
use canopen::od::Dictionary;
use canopen::settings::{PowerOn, Sources, Wish};
use canopen::time::NEVER;
use canopen::{
    BitRate, BitTiming, Configuration, ControllerState, Duration, Event, Frame, Instant, NodeId,
    Settings,
};
use cia402::inputs::DigitalInputs;
use cia402::recorder::{Memory, Recorder};
use cia402::{Actuals, Device, Drive, DriveConfig, Exchange, Inputs, Objects, Outputs};
use motion::{AxisConfig, Clock, DriverTiming};

use crate::flash::{Flash, ParameterStore};
use crate::machine::{Machine, machine};
use crate::plant::{Axis, Plant, STEP_CLOCK_HZ, Sensed, WIRES};
use crate::settings::{FactoryStore, Settings as FactorySettings};
use master::bus::Station;

/// The period of the control tick.
pub const CONTROL_TICK: Duration = Duration::from_ticks(1_000);

/// Pulses are handed out so often in a control tick, by a timer of its own as on the board.
const REFILLS: u32 = 4;

/// From a refill to the next.
const REFILL: Duration = Duration::from_ticks(CONTROL_TICK.ticks() / REFILLS as u64);

/// Events that are kept until somebody takes them; older ones are forgotten.
const EVENTS: usize = 64;

/// What a drive is made of.
#[derive(Debug)]
pub struct Setup {
    /// 1018h:4.
    pub serial_number: u32,
    /// Settings for the first power-on, in place of what is stored, and for later ones as long as nothing is. `None` takes
    /// what is stored; if nothing is, the drive is unconfigured at 1 Mbit/s.
    pub settings: Option<Configuration>,
    /// What the build of the firmware fixes, before all other sources of node-ID and bit rate.
    pub build: Wish,
    /// What the switches of the board ask for at each power-on, before what is stored.
    pub switches: Wish,
    /// Where LSS stores settings, and 1010h parameters.
    pub store: ParameterStore,
    /// What the motor drives; `None` has nothing along it.
    pub axis: Option<Axis>,
}

impl Setup {
    /// A drive fresh from the factory: no node-ID, 1 Mbit/s, an empty store that lasts as long as the drive.
    pub fn unconfigured(serial_number: u32) -> Self {
        Self {
            serial_number,
            settings: None,
            build: Wish::NOTHING,
            switches: Wish::NOTHING,
            store: Flash::in_memory().into_store(),
            axis: None,
        }
    }

    /// A drive with a node-ID (1 to 127, or 255 for none) at 1 Mbit/s and an empty store.
    ///
    /// # Panics
    /// If there is no such node-ID.
    pub fn with_node_id(serial_number: u32, node_id: u8) -> Self {
        let settings = Settings {
            node_id: NodeId::new(node_id).expect("a node-ID is 1 to 127, or 255"),
            bit_rate: BitRate::Kbit1000,
        };
        Self {
            settings: Some(settings.into()),
            ..Self::unconfigured(serial_number)
        }
    }

    /// What the first power-on brings.
    fn first_power_on(&mut self) -> PowerOn {
        let stored = self.settings.or_else(|| self.store.load().ok().flatten());
        self.choose(stored)
    }

    /// What a later power-on brings. A store that cannot be read counts as empty.
    fn power_on(&mut self) -> PowerOn {
        let stored = self.store.load().ok().flatten();
        self.choose(stored.or(self.settings))
    }

    /// The serial number of production.
    fn produced(&mut self) -> Option<u32> {
        self.store.serial_number().ok().flatten()
    }

    /// The sources in their order.
    fn choose(&self, stored: Option<Configuration>) -> PowerOn {
        let sources = Sources {
            build: self.build,
            switches: self.switches,
            stored,
        };
        sources.choose(&BitRate::ALL)
    }
}

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
pub struct VirtualDrive<D: Dictionary> {
    setup: Setup,
    powered: bool,
    was_reset: bool,
    device: Device<D, Machine>,
    drive: Drive<D>,
    recorder: Recorder<Arc<Memory>>,
    exchange: Exchange,
    plant: Plant,
    next_tick: Instant,
    next_refill: Instant,
    bit_rate: BitRate,
    /// What this power-on has brought.
    bit_timing: BitTiming,
    switch_bit_rate: Option<(Instant, BitTiming)>,
    /// The bit rate is not known, and the controller listens.
    detection: Option<Detection>,
    /// The node is on the network, or waits for a switch of the bit rate: it has booted.
    booted: bool,
    restarts_controller: bool,
    events: VecDeque<Event>,
    samples: Option<Vec<MotionSample>>,
}

impl<D: Dictionary + Objects + Default> VirtualDrive<D> {
    /// A drive without power; it gets it when it is polled for the first time.
    pub fn new(mut setup: Setup) -> Self {
        let power_on = setup.first_power_on();
        let mut plant = Plant::new(Instant::from_ticks(0));
        if let Some(axis) = &setup.axis {
            plant.mount(axis);
        }
        let (machine, scope) = machine();
        let device = device(&power_on, setup.serial_number, machine).produced(setup.produced());
        Self {
            powered: false,
            was_reset: false,
            recorder: Recorder::new(scope, CONTROL_TICK),
            device,
            drive: Drive::new(drive_config()),
            exchange: Exchange::new(),
            plant,
            next_tick: Instant::from_ticks(0),
            next_refill: Instant::from_ticks(0),
            bit_rate: bit_rate(&power_on),
            bit_timing: power_on.bit_timing.value,
            switch_bit_rate: None,
            detection: None,
            booted: false,
            restarts_controller: false,
            events: VecDeque::new(),
            samples: None,
            setup,
        }
    }

    /// Takes the power away and gives it back at once: everything that is not stored is lost, frames under way too. The
    /// motor stays where it is mounted but counts from 0 again, as a drive without an encoder does.
    pub fn power_cycle(&mut self) {
        let power_on = self.setup.power_on();
        let (machine, scope) = machine();
        self.device =
            device(&power_on, self.setup.serial_number, machine).produced(self.setup.produced());
        self.recorder = Recorder::new(scope, CONTROL_TICK);
        self.drive = Drive::new(drive_config());
        self.exchange = Exchange::new();
        self.bit_rate = bit_rate(&power_on);
        self.bit_timing = power_on.bit_timing.value;
        self.switch_bit_rate = None;
        self.detection = None;
        self.booted = false;
        self.restarts_controller = false;
        self.events.clear();
        self.powered = false;
        self.was_reset = true;
    }

    /// The flash behind the parameter store, to break it.
    pub fn with_flash(&mut self, change: impl FnOnce(&mut Flash)) {
        let empty = Flash::in_memory().into_store();
        let mut flash = std::mem::replace(&mut self.setup.store, empty).release();
        change(&mut flash);
        self.setup.store = flash.into_store();
    }

    /// The CANopen half, for its dictionary and state.
    pub fn device(&self) -> &Device<D, Machine> {
        &self.device
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
        match self.bit_timing {
            BitTiming::Fixed(_) => self.boot(now),
            BitTiming::Automatic => self.find_bit_rate(now),
        }
    }

    fn boot(&mut self, now: Instant) {
        self.booted = true;
        self.device.power_on(now, &mut self.exchange);
        self.serve_store(now);
    }

    /// Listens until the bit rate is known.
    fn find_bit_rate(&mut self, now: Instant) {
        self.detection = Some(Detection::new(&DETECTABLE, now));
    }

    /// Goes on the bus when the bit rate is known.
    fn serve_detection(&mut self, now: Instant) -> Instant {
        let Some(detection) = &mut self.detection else {
            return NEVER;
        };
        let mut deadline = detection.poll(now);
        if detection.is_over() {
            // This controller leaves at once: on this bus frames take no time.
            detection.left(now);
            deadline = detection.poll(now);
        }
        self.bit_rate = detection.bit_rate();
        if detection.found().is_some() {
            self.detection = None;
            self.device.bit_rate_found(self.bit_rate, now);
            if !self.booted {
                self.boot(now);
            }
        }
        deadline
    }

    /// Runs every control tick and every refill up to and including `now`.
    fn run_until(&mut self, now: Instant) {
        if !self.powered {
            self.power_on(now);
        }
        loop {
            if self.next_tick <= now && self.next_tick <= self.next_refill {
                let now = self.next_tick;
                let next = self.control_tick(now);
                // A tick takes time.
                self.next_tick = next
                    .unwrap_or(now + CONTROL_TICK)
                    .max(now + CONTROL_TICK / 2);
            } else if self.next_refill <= now {
                self.plant.advance(self.next_refill);
                self.drive.refill(self.plant.pulses_mut());
                self.next_refill += REFILL;
            } else {
                break;
            }
        }
        self.plant.advance(now);
        match self.switch_bit_rate.take_if(|(at, _)| *at <= now) {
            Some((_, BitTiming::Fixed(bit_rate))) => {
                self.detection = None;
                self.bit_rate = bit_rate;
            }
            Some((_, BitTiming::Automatic)) => self.find_bit_rate(now),
            None => {}
        }
    }

    /// Returns when the next one is due, if the drive says.
    fn control_tick(&mut self, now: Instant) -> Option<Instant> {
        self.plant.advance(now);
        let inputs = Inputs {
            digital: digital(self.plant.look()),
            ..self.inputs()
        };
        let outputs = self
            .drive
            .tick(now, &inputs, self.plant.pulses_mut(), &mut self.exchange);
        self.recorder.tick(&self.drive, &mut self.exchange);
        self.carry_out(&outputs);
        if let Some(samples) = &mut self.samples {
            samples.push(MotionSample {
                at: now,
                position: self.plant.position(),
            });
        }
        self.end_tick(now);
        self.heed_stop(now);
        outputs.next_tick
    }

    /// A command to stop that no tick has carried out yet has a tick of its own. The next control tick comes when it would have come.
    /// Returns whether there was one.
    fn heed_stop(&mut self, now: Instant) -> bool {
        if !self.device.calls_early() || !self.exchange.calls_early() {
            return false;
        }
        let inputs = self.inputs();
        let outputs =
            self.drive
                .early_tick(now, &inputs, self.plant.pulses_mut(), &mut self.exchange);
        self.carry_out(&outputs);
        self.end_tick(now);
        true
    }

    /// What the board measures, but for the edges of the inputs.
    fn inputs(&self) -> Inputs {
        Inputs {
            supply: self.plant.supply,
            position: self.plant.position(),
            warning: self.plant.warning,
            fault: self.plant.fault,
            digital: DigitalInputs::NONE,
            stall: self.plant.stall(),
            slack: self.plant.slack(),
            supply_voltage: Some(self.plant.supply_voltage),
            temperature: Some(self.plant.temperature),
            analogue: Some(self.plant.analogue),
        }
    }

    fn carry_out(&mut self, outputs: &Outputs) {
        if outputs.drop_pulses {
            self.plant.pulses_mut().drop_all();
        }
        self.plant.energise(outputs.power_stage);
        self.plant.set_driver(outputs.current, outputs.microsteps);
        self.plant.set_outputs(outputs.digital);
        self.plant.open_brake(outputs.brake_released);
    }

    /// What the node does behind each tick.
    fn end_tick(&mut self, now: Instant) {
        self.device.poll(now, &mut self.exchange);
        self.serve_store(now);
        self.handle_events();
    }

    fn serve_store(&mut self, now: Instant) {
        let none = FactorySettings::default();
        let axis = self.setup.axis.as_ref();
        let settings = axis.map_or(&none, |axis| &axis.settings);
        let mut store = FactoryStore::new(&mut self.setup.store, settings);
        self.device.serve_store(&mut store, now, &mut self.exchange);
    }

    fn handle_events(&mut self) {
        while let Some(event) = self.device.event() {
            match event {
                Event::StoreSettings(settings) => {
                    let result = self.setup.store.save(&settings);
                    self.device
                        .settings_stored(result.map_err(|_| StoreError::Medium));
                }
                Event::SwitchBitRate { bit_rate, at } => {
                    self.switch_bit_rate = Some((at, BitTiming::Fixed(bit_rate)));
                }
                Event::FindBitRate { at } => {
                    self.switch_bit_rate = Some((at, BitTiming::Automatic));
                }
                Event::RestartController => self.restarts_controller = true,
                _ => {}
            }
            if self.events.len() == EVENTS {
                self.events.pop_front();
            }
            self.events.push_back(event);
        }
    }
}

impl<D> Station for VirtualDrive<D>
where
    D: Dictionary + Objects + Default + std::fmt::Debug + 'static,
{
    fn receive(&mut self, frame: &Frame, now: Instant) {
        self.run_until(now);
        if let Some(detection) = &mut self.detection {
            // It shows the bit rate; what it says is for those that have acknowledged it.
            detection.frame_received();
            self.serve_detection(now);
            return;
        }
        self.device.receive(frame, now, &mut self.exchange);
        self.handle_events();
        self.heed_stop(now);
    }

    fn poll(&mut self, now: Instant) -> Instant {
        self.run_until(now);
        let found = self.serve_detection(now);
        let mut deadline = self.device.poll(now, &mut self.exchange);
        self.serve_store(now);
        self.handle_events();
        if self.heed_stop(now) {
            deadline = self.device.poll(now, &mut self.exchange);
        }
        let deadline = deadline.min(found);
        let switch = self.switch_bit_rate.map_or(deadline, |(at, _)| at);
        deadline.min(switch).min(self.next_tick)
    }

    fn transmit(&mut self) -> Option<Frame> {
        self.device.transmit()
    }

    fn is_silent(&self) -> bool {
        self.detection.is_some()
    }

    fn error_seen(&mut self, now: Instant) {
        self.run_until(now);
        if let Some(detection) = &mut self.detection {
            detection.error_seen();
            self.serve_detection(now);
        }
    }

    fn bit_rate(&self) -> Option<BitRate> {
        Some(self.bit_rate)
    }

    fn was_reset(&mut self) -> bool {
        std::mem::take(&mut self.was_reset)
    }

    fn controller_changed(&mut self, state: ControllerState, now: Instant) {
        self.run_until(now);
        self.device
            .controller_changed(state, now, &mut self.exchange);
        self.heed_stop(now);
    }

    fn frames_lost(&mut self, count: u32, now: Instant) {
        self.run_until(now);
        self.device.frames_lost(count, now);
    }

    fn restarts_controller(&mut self) -> bool {
        std::mem::take(&mut self.restarts_controller)
    }
}

/// The inputs of the drive, wired to the plant.
fn digital(wires: [Sensed; WIRES]) -> DigitalInputs {
    let mut inputs = DigitalInputs::NONE;
    for (n, (wire, captured)) in wires.iter().zip(&mut inputs.captured).enumerate() {
        inputs.levels |= u8::from(wire.level) << n;
        inputs.changed |= u8::from(wire.rose.is_some() || wire.fell.is_some()) << n;
        captured.rose = wire.rose;
        captured.fell = wire.fell;
    }
    inputs
}

/// The CANopen half of a drive, without power.
fn device<D>(power_on: &PowerOn, serial_number: u32, machine: Machine) -> Device<D, Machine>
where
    D: Dictionary + Objects + Default,
{
    let settings = Settings {
        node_id: power_on.node_id.value,
        bit_rate: bit_rate(power_on),
    };
    Device::with_application(D::default(), settings, serial_number, machine)
        .with_parameter_store()
        .started(power_on)
        .detecting()
}

/// The bit rate to begin with.
fn bit_rate(power_on: &PowerOn) -> BitRate {
    power_on
        .bit_timing
        .value
        .bit_rate()
        .unwrap_or(Settings::default().bit_rate)
}

/// A stepper driver of the usual kind: pulses of at least 1 µs with 1 µs between, direction 5 µs before and after.
fn drive_config() -> DriveConfig {
    const MICROSECOND: u32 = STEP_CLOCK_HZ / 1_000_000;
    DriveConfig {
        axis: AxisConfig {
            clock: Clock::new(STEP_CLOCK_HZ).expect("84 MHz is a step clock"),
            segment: REFILL.ticks() as u32 * MICROSECOND,
            timing: DriverTiming {
                pulse_high: MICROSECOND,
                pulse_low: MICROSECOND,
                direction_setup: 5 * MICROSECOND,
                direction_hold: 5 * MICROSECOND,
            },
        },
        tick: CONTROL_TICK,
        refills: REFILLS,
    }
}
