//! The runtime on a host of its own: virtual time, a controller with one mailbox, flash that may fail.

use std::collections::VecDeque;

use canopen::cia301::parameters::{CHUNK, ParameterSet, ParameterSets, ParameterStore};
use canopen::node::StoreError;
use canopen::outbox::{Mailboxes, Room};
use canopen::settings::{PowerOn, Source, Wish};
use canopen::{
    BitRate, BitTiming, Configuration, ControllerState, Duration, Frame, Instant, NodeId,
};
use cia402::recorder::Memory;
use cia402::{DriveConfig, Exchange, Inputs, Outputs, Share};
use core::sync::atomic::AtomicU32;
use motion::{AxisConfig, Clock, DriverTiming, PulseSink, Record, Ticks};
use products::lmd::Dictionary;
use runtime::inbox::DEPTH;
use runtime::{
    Control, Controller, Host, Machine, Node, PowerStage, PowerUp, Reception, Stamped, Storage,
    Unreachable,
};

static SCOPE: Memory<[AtomicU32; 4]> = Memory::new();

/// The nominal control tick.
const TICK: Duration = Duration::from_ticks(1_000);

/// A controller with one mailbox.
#[derive(Debug)]
struct Bus {
    /// It can leave the bus now.
    leaves: bool,
    started: Vec<BitRate>,
    listens: Vec<BitRate>,
    mailbox: Option<Frame>,
    received: VecDeque<Stamped>,
    lost: u32,
}

impl Mailboxes for Bus {
    fn room(&mut self, _: u16) -> Room {
        if self.mailbox.is_some() {
            Room::None
        } else {
            Room::Free
        }
    }

    fn put(&mut self, frame: &Frame) -> Option<Frame> {
        self.mailbox.replace(*frame)
    }
}

impl Controller for Bus {
    const BIT_RATES: &'static [BitRate] = &[BitRate::Kbit1000, BitRate::Kbit500, BitRate::Kbit20];

    fn leave(&mut self) -> bool {
        self.leaves
    }

    fn start(&mut self, bit_rate: BitRate) -> Result<(), Unreachable> {
        self.started.push(bit_rate);
        Ok(())
    }

    fn listen(&mut self, bit_rate: BitRate) -> Result<(), Unreachable> {
        self.listens.push(bit_rate);
        Ok(())
    }

    fn error_seen(&mut self) -> bool {
        false
    }

    fn state(&mut self) -> ControllerState {
        ControllerState::ErrorActive
    }
}

/// What has arrived at the bus.
struct Received<'a>(&'a mut VecDeque<Stamped>, u32);

impl Reception for Received<'_> {
    fn receive(&mut self) -> Option<Stamped> {
        self.0.pop_front()
    }

    fn lost(&self) -> u32 {
        self.1
    }
}

/// Flash that may fail.
#[derive(Clone, Copy, Debug, Default)]
struct Flash {
    settings: Option<Configuration>,
    is_broken: bool,
}

impl Flash {
    fn works(&self) -> Result<(), StoreError> {
        if self.is_broken {
            Err(StoreError::Medium)
        } else {
            Ok(())
        }
    }
}

impl ParameterStore for Flash {
    fn begin(&mut self, _: ParameterSets) -> Result<(), StoreError> {
        self.works()
    }

    fn append(&mut self, _: ParameterSet, _: &[u8]) -> Result<(), StoreError> {
        self.works()
    }

    fn commit(&mut self) -> Result<(), StoreError> {
        self.works()
    }

    fn open(&mut self, _: ParameterSet) -> Result<u16, StoreError> {
        Ok(0)
    }

    fn read(&mut self, _: ParameterSet, _: u16, _: &mut [u8; CHUNK]) -> Result<usize, StoreError> {
        Err(StoreError::Medium)
    }
}

impl Storage for Flash {
    fn load(&mut self) -> Result<Option<Configuration>, StoreError> {
        Ok(self.settings)
    }

    fn save(&mut self, settings: &Configuration) -> Result<(), StoreError> {
        self.works()?;
        self.settings = Some(*settings);
        Ok(())
    }

    fn forget(&mut self) -> Result<(), StoreError> {
        self.works()?;
        self.settings = None;
        Ok(())
    }

    fn serial_number(&mut self) -> Option<u32> {
        None
    }
}

/// A power stage that takes every pulse.
#[derive(Debug, Default)]
struct Stage {
    now: u64,
    pulses: Pulses,
    fed: u32,
    powered: bool,
}

#[derive(Debug, Default)]
struct Pulses;

impl PulseSink for Pulses {
    fn push(&mut self, _: Record) -> Result<(), Record> {
        Ok(())
    }

    fn pending(&self) -> Ticks {
        0
    }

    fn free(&self) -> usize {
        100
    }
}

impl PowerStage for Stage {
    type Pulses = Pulses;

    fn pulses(&mut self) -> &mut Pulses {
        &mut self.pulses
    }

    fn service(&mut self) {}

    fn look(&mut self, inputs: &mut Inputs) -> Instant {
        inputs.supply = true;
        inputs.fault = None;
        Instant::from_ticks(self.now)
    }

    fn measure(&mut self, _: &mut Inputs) {}

    fn carry_out(&mut self, outputs: &Outputs) {
        self.powered = outputs.power_stage;
    }

    fn drop_pulses(&mut self) {}

    fn feed_watchdog(&mut self) {
        self.fed += 1;
    }
}

/// The exchange and the time.
#[derive(Debug)]
struct Around {
    exchange: Exchange,
    now: u64,
}

impl Share for Around {
    fn lock<R>(&mut self, f: impl FnOnce(&mut Exchange) -> R) -> R {
        f(&mut self.exchange)
    }
}

impl Host for Around {
    fn now(&self) -> Instant {
        Instant::from_ticks(self.now)
    }

    fn stop(&mut self) {}
}

/// A host with all that the runtime needs.
struct Rig {
    node: Node<Dictionary, Machine<[u8; 8], &'static Memory>, Flash>,
    control: Control<Dictionary, &'static Memory>,
    around: Around,
    stage: Stage,
    bus: Bus,
}

impl Rig {
    fn new(power_up: PowerUp, flash: Flash) -> Self {
        let mut store = Some(flash);
        let power_on = power_up.choose(&mut store, Bus::BIT_RATES);
        let machine = Machine::new([0; 8], [0; 8], &SCOPE as &'static Memory);
        let config = DriveConfig {
            axis: AxisConfig {
                clock: Clock::new(1_000_000).unwrap(),
                segment: 1_000,
                timing: DriverTiming {
                    pulse_high: 2,
                    pulse_low: 2,
                    direction_setup: 5,
                    direction_hold: 5,
                },
            },
            tick: TICK,
            refills: 1,
        };
        let dictionary = Dictionary::new();
        let mut rig = Self {
            node: Node::new(dictionary, machine, &power_on, 7, Bus::BIT_RATES, store),
            control: Control::new(config, &SCOPE),
            around: Around {
                exchange: Exchange::new(),
                now: 0,
            },
            stage: Stage::default(),
            bus: Bus {
                leaves: true,
                started: Vec::new(),
                listens: Vec::new(),
                mailbox: None,
                received: VecDeque::new(),
                lost: 0,
            },
        };
        rig.node.power_on(&mut rig.around, &mut rig.bus);
        rig
    }

    /// With node-ID 4 at this bit rate.
    fn at(bit_timing: BitTiming) -> Self {
        let build = Wish {
            node_id: NodeId::new(4),
            bit_timing: Some(bit_timing),
        };
        let power_up = PowerUp {
            build,
            ..PowerUp::default()
        };
        Self::new(power_up, Flash::default())
    }

    /// With node-ID 4 from the store, so that LSS may change it.
    fn stored(flash: Flash) -> Self {
        let settings = Configuration {
            node_id: NodeId::new(4).unwrap(),
            bit_timing: BitTiming::Fixed(BitRate::Kbit1000),
        };
        let flash = Flash {
            settings: Some(settings),
            ..flash
        };
        Self::new(PowerUp::default(), flash)
    }

    fn flash(&mut self) -> Flash {
        self.node.store_mut().unwrap()
    }

    fn run(&mut self) -> Instant {
        let mut queue = std::mem::take(&mut self.bus.received);
        let mut received = Received(&mut queue, self.bus.lost);
        let deadline = (self.node).run(&mut self.around, &mut self.bus, &mut received);
        self.bus.received = queue;
        deadline
    }

    fn receive(&mut self, cob_id: u16, data: &[u8]) {
        let frame = Frame::data_frame(cob_id, data);
        let at = Instant::from_ticks(self.around.now);
        self.bus.received.push_back(Stamped { frame, at });
    }

    /// A request of LSS.
    fn lss(&mut self, request: &[u8]) {
        let mut data = [0; 8];
        data[..request.len()].copy_from_slice(request);
        self.receive(0x7E5, &data);
    }

    /// So many control ticks, each with a run of the node behind it. Returns the frames that left.
    fn ticks(&mut self, count: usize) -> Vec<Frame> {
        let mut sent = Vec::new();
        for _ in 0..count {
            self.around.now += TICK.ticks();
            self.stage.now = self.around.now;
            let exchange = &mut self.around.exchange;
            (self.control).tick(self.bus.lost, true, &mut self.stage, exchange);
            self.run();
            sent.extend(self.drain());
        }
        sent
    }

    /// Everything that leaves without time passing.
    fn drain(&mut self) -> Vec<Frame> {
        std::iter::from_fn(|| {
            self.run();
            self.bus.mailbox.take()
        })
        .collect()
    }
}

/// The answer of the LSS slave to a request.
fn answer(frames: &[Frame]) -> Option<&[u8]> {
    let answer = (frames.iter()).find(|frame| frame.standard_id() == Some(0x7E4));
    answer.map(Frame::payload)
}

#[test]
fn one_run_takes_no_more_frames_than_can_wait() {
    let mut rig = Rig::at(BitTiming::Fixed(BitRate::Kbit500));
    for _ in 0..DEPTH + 3 {
        rig.receive(0x123, &[]);
    }
    rig.run();
    assert_eq!(rig.bus.received.len(), 3);
}

#[test]
fn frames_wait_for_room_and_the_first_is_the_boot_up_message() {
    let mut rig = Rig::at(BitTiming::Fixed(BitRate::Kbit500));
    assert_eq!(rig.bus.started, [BitRate::Kbit500]);
    rig.run();
    assert_eq!(rig.bus.mailbox, Some(Frame::data_frame(0x704, &[0])));
    rig.receive(0x604, &[0x40, 0, 0x10, 0, 0, 0, 0, 0]);
    rig.run();
    assert_eq!(rig.bus.mailbox.take(), Some(Frame::data_frame(0x704, &[0])));
    rig.run();
    let answer = rig.bus.mailbox.and_then(|frame| frame.standard_id());
    assert_eq!(answer, Some(0x584));
}

#[test]
fn the_bit_rate_changes_at_its_moment_and_behind_the_frame_on_the_bus() {
    let mut rig = Rig::stored(Flash::default());
    rig.ticks(2);
    rig.lss(&[0x04, 1]);
    rig.lss(&[0x13, 0, 2]);
    rig.lss(&[0x15, 10]);
    rig.drain();
    let switch = rig.around.now + 10_000;
    assert!(rig.run() <= Instant::from_ticks(switch));
    rig.ticks(9);
    assert_eq!(rig.bus.started, [BitRate::Kbit1000]);
    rig.bus.leaves = false;
    rig.ticks(3);
    assert_eq!(rig.bus.started, [BitRate::Kbit1000]);
    rig.bus.leaves = true;
    rig.ticks(1);
    assert_eq!(rig.bus.started, [BitRate::Kbit1000, BitRate::Kbit500]);
}

#[test]
fn what_comes_before_the_controller_has_left_counts_for_the_bit_rate_it_had() {
    let mut rig = Rig::at(BitTiming::Automatic);
    assert_eq!(rig.bus.listens, [BitRate::Kbit1000]);
    rig.ticks(1_199);
    rig.bus.leaves = false;
    rig.ticks(5);
    assert_eq!(rig.bus.listens, [BitRate::Kbit1000]);
    assert!(rig.drain().is_empty(), "it listens in silence");
    rig.receive(0x123, &[]);
    rig.bus.leaves = true;
    let sent = rig.ticks(1);
    assert_eq!(rig.bus.started, [BitRate::Kbit1000]);
    assert_eq!(sent, [Frame::data_frame(0x704, &[0])]);
}

#[test]
fn a_silent_network_has_one_bit_rate_tried_after_the_other() {
    let mut rig = Rig::at(BitTiming::Automatic);
    rig.ticks(2_401);
    let tried = [BitRate::Kbit1000, BitRate::Kbit500, BitRate::Kbit20];
    assert_eq!(rig.bus.listens, tried);
}

#[test]
fn settings_are_stored_when_the_drive_is_safe_and_not_before() {
    let mut rig = Rig::stored(Flash::default());
    rig.lss(&[0x04, 1]);
    rig.lss(&[0x11, 11]);
    rig.drain();
    rig.lss(&[0x17]);
    // No control tick has told that the motor has no power.
    assert_eq!(answer(&rig.drain()), None);
    let sent = rig.ticks(2);
    assert_eq!(answer(&sent).map(|data| data[1]), Some(0));
    assert_eq!(rig.flash().settings.unwrap().node_id.get(), 11);
}

#[test]
fn who_orders_to_store_while_the_drive_is_not_safe_is_refused_in_time() {
    let mut rig = Rig::stored(Flash::default());
    rig.lss(&[0x04, 1]);
    rig.lss(&[0x11, 11]);
    rig.lss(&[0x17]);
    rig.drain();
    assert_eq!(rig.run(), Instant::from_ticks(50_000));
    rig.around.now = 50_000;
    let sent = rig.drain();
    assert_eq!(answer(&sent).map(|data| data[1]), Some(2));
    assert_eq!(rig.flash().settings.unwrap().node_id.get(), 4);
}

#[test]
fn flash_that_fails_is_told() {
    let mut rig = Rig::stored(Flash {
        is_broken: true,
        ..Flash::default()
    });
    rig.lss(&[0x04, 1]);
    rig.lss(&[0x17]);
    let sent = rig.ticks(2);
    let mut results = sent.iter().filter(|frame| frame.payload()[0] == 0x17);
    let last = results.next_back().map(|frame| frame.payload()[1]);
    assert_eq!(last, Some(2));
}

#[test]
fn a_factory_reset_forgets_and_counts_even_where_flash_does_not() {
    let settings = Configuration {
        node_id: NodeId::new(9).unwrap(),
        bit_timing: BitTiming::Fixed(BitRate::Kbit20),
    };
    for is_broken in [false, true] {
        let mut store = Some(Flash {
            settings: Some(settings),
            is_broken,
        });
        let choose = |factory_reset, store: &mut Option<Flash>| -> PowerOn {
            let power_up = PowerUp {
                factory_reset,
                ..PowerUp::default()
            };
            power_up.choose(store, Bus::BIT_RATES)
        };
        let kept = choose(false, &mut store).node_id;
        assert_eq!((kept.value.get(), kept.source), (9, Source::Store));
        let power_on = choose(true, &mut store);
        assert_eq!(power_on.node_id.source, Source::Factory);
        assert_eq!(power_on.bit_timing.source, Source::Factory);
        assert_eq!(store.unwrap().settings.is_some(), is_broken);
    }
}

#[test]
fn the_watchdog_is_fed_while_the_node_lives() {
    let mut rig = Rig::at(BitTiming::Fixed(BitRate::Kbit500));
    let exchange = &mut rig.around.exchange;
    for (alive, fed) in [(true, 1), (false, 1), (true, 2)] {
        (rig.control).tick(0, alive, &mut rig.stage, exchange);
        assert_eq!(rig.stage.fed, fed);
    }
}

/// Control ticks in which the node does not run; then the error code.
fn hang(rig: &mut Rig, ticks: u64) -> u16 {
    for _ in 0..ticks {
        rig.around.now += TICK.ticks();
        rig.stage.now = rig.around.now;
        let exchange = &mut rig.around.exchange;
        (rig.control).tick(0, false, &mut rig.stage, exchange);
    }
    let actuals = rig.around.exchange.actuals_at(canopen::time::NEVER);
    actuals.error_code
}

#[test]
fn a_node_that_hangs_is_a_fault_while_the_motor_has_current() {
    let mut rig = Rig::at(BitTiming::Fixed(BitRate::Kbit500));
    rig.ticks(3);
    assert_eq!(hang(&mut rig, 100), 0);
    for controlword in [6, 7, 15] {
        let write = [0x2B, 0x40, 0x60, 0, controlword, 0, 0, 0];
        rig.bus.received.push_back(Stamped {
            frame: Frame::data_frame(0x604, &write),
            at: Instant::from_ticks(rig.around.now),
        });
        rig.ticks(3);
    }
    assert!(rig.stage.powered);
    assert_eq!(hang(&mut rig, 19), 0);
    assert_eq!(hang(&mut rig, 3), 0x6100);
    rig.ticks(50);
    assert!(!rig.stage.powered);
}

#[test]
fn frames_that_are_lost_without_power_are_a_message_and_no_fault() {
    let mut rig = Rig::at(BitTiming::Fixed(BitRate::Kbit500));
    rig.ticks(3);
    rig.bus.lost = 2;
    let sent = rig.ticks(2);
    let emergency = |frame: &&Frame| frame.standard_id() == Some(0x84);
    let codes: Vec<_> = sent.iter().filter(emergency).collect();
    assert_eq!(codes.len(), 1);
    assert_eq!(codes[0].payload()[..2], [0x10, 0x81]);
    let actuals = rig.around.exchange.actuals_at(canopen::time::NEVER);
    assert_eq!(actuals.error_code, 0);
}
