//! A host with all that the runtime needs: a bus with one mailbox, flash that may fail, a stage.

use std::collections::VecDeque;

use canopen::cia301::parameters::{CHUNK, ParameterSet, ParameterSets, ParameterStore};
use canopen::node::StoreError;
use canopen::outbox::{Mailbox, Mailboxes};
use canopen::settings::Wish;
use canopen::{
    BitRate, BitTiming, Configuration, ControllerState, Duration, Frame, Instant, NodeId,
};
use cia402::recorder::Memory;
use cia402::{DriveConfig, Exchange, Inputs, Outputs, Share};
use core::sync::atomic::AtomicU32;
use motion::{AxisConfig, Clock, DriverTiming, PulseSink, Record, Ticks};
use products::lmd::Dictionary;
use runtime::{
    Control, Controller, Host, Machine, Node, PowerStage, PowerUp, Reception, Stamped, Storage,
    Unreachable,
};

static SCOPE: Memory<[AtomicU32; 4]> = Memory::new();

/// The nominal control tick.
pub const TICK: Duration = Duration::from_ticks(1_000);

/// A controller with one mailbox.
#[derive(Debug)]
pub struct Bus {
    /// It can leave the bus now.
    pub leaves: bool,
    pub started: Vec<BitRate>,
    pub listens: Vec<BitRate>,
    pub mailbox: Option<Frame>,
    pub received: VecDeque<Stamped>,
    pub lost: u32,
}

impl Mailboxes for Bus {
    fn mailbox_for(&mut self, _: u16) -> Mailbox {
        if self.mailbox.is_some() {
            Mailbox::None
        } else {
            Mailbox::Free
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
pub struct Flash {
    pub settings: Option<Configuration>,
    pub is_broken: bool,
}

impl Flash {
    pub fn works(&self) -> Result<(), StoreError> {
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
pub struct Stage {
    pub now: u64,
    pub pulses: Pulses,
    pub fed: u32,
    pub powered: bool,
    pub has_no_supply: bool,
    pub fault: Option<u16>,
}

#[derive(Debug, Default)]
pub struct Pulses;

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
        inputs.supply = !self.has_no_supply;
        inputs.fault = self.fault;
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
pub struct Around {
    pub exchange: Exchange,
    pub now: u64,
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
pub struct Rig {
    pub node: Node<Dictionary, Machine<[u8; 8], &'static Memory>, Flash>,
    pub control: Control<Dictionary, &'static Memory>,
    pub around: Around,
    pub stage: Stage,
    pub bus: Bus,
}

impl Rig {
    pub fn new(power_up: PowerUp, flash: Flash) -> Self {
        let mut store = Some(flash);
        let power_on = power_up.choose(&mut store, Bus::BIT_RATES);
        let machine = Machine::new([0; 8], [0; 8], &SCOPE as &'static Memory);
        let config = DriveConfig {
            axis: AxisConfig {
                clock: Clock::new(1_000_000).unwrap(),
                time_slice: 1_000,
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
            node: Node::new(dictionary, machine, &power_on, 7, store),
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
        rig.node.set_up(&power_on, Bus::BIT_RATES, u32::MAX);
        rig.node.power_on(&mut rig.around, &mut rig.bus);
        rig
    }

    /// With node-ID 4 at this bit rate.
    pub fn at(bit_timing: BitTiming) -> Self {
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
    pub fn stored(flash: Flash) -> Self {
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

    pub fn flash(&mut self) -> Flash {
        self.node.store_mut().unwrap()
    }

    pub fn run(&mut self) -> Instant {
        let mut queue = std::mem::take(&mut self.bus.received);
        let mut received = Received(&mut queue, self.bus.lost);
        let deadline = (self.node).run(&mut self.around, &mut self.bus, &mut received);
        self.bus.received = queue;
        deadline
    }

    pub fn receive(&mut self, cob_id: u16, data: &[u8]) {
        let frame = Frame::data_frame(cob_id, data);
        let at = Instant::from_ticks(self.around.now);
        self.bus.received.push_back(Stamped { frame, at });
    }

    /// The motor gets current.
    pub fn enable(&mut self) {
        for controlword in [6, 7, 15] {
            self.receive(0x604, &[0x2B, 0x40, 0x60, 0, controlword, 0, 0, 0]);
            self.ticks(3);
        }
        assert!(self.stage.powered);
    }

    /// What the host does between two ticks; whether there was something to do.
    pub fn stop(&mut self) -> bool {
        self.control
            .stop(self.bus.lost, &mut self.stage, &mut self.around.exchange)
    }

    /// A request of LSS.
    pub fn lss(&mut self, request: &[u8]) {
        let mut data = [0; 8];
        data[..request.len()].copy_from_slice(request);
        self.receive(0x7E5, &data);
    }

    /// So many control ticks, each with a run of the node behind it. Returns the frames that left.
    pub fn ticks(&mut self, count: usize) -> Vec<Frame> {
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
    pub fn drain(&mut self) -> Vec<Frame> {
        std::iter::from_fn(|| {
            self.run();
            self.bus.mailbox.take()
        })
        .collect()
    }
}

/// The answer of the LSS slave to a request.
pub fn answer(frames: &[Frame]) -> Option<&[u8]> {
    let answer = (frames.iter()).find(|frame| frame.standard_id() == Some(0x7E4));
    answer.map(Frame::payload)
}
