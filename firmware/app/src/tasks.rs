//! What the tasks own, and how they begin.

use core::mem::MaybeUninit;

use cia402::inputs::Capture;
use cia402::{Actuator, Emitter, Exchange};
use cortex_m::peripheral::SYST;
use embedded_storage::nor_flash::ReadNorFlash;
use rtic::Mutex;
use runtime::{inbox, Controller, Inbox, Lost, Node, PowerUp, Received, Signals};
use store::Store;

use crate::board::{
    self, Board, ControlTimer, InputLines, Parts, Receive, Selected, ServoObjects, Steps,
};
use crate::clock;
use crate::control::{Control, CONFIG, RATE_HZ};
use crate::dictionary::Dictionary;
use crate::machine::Machine;
use crate::settings::BUILD;
use crate::share::{Around, LockedBus};
use crate::stepping::Stepping;

/// The CAN controller.
pub type CanBus = <Selected as Board>::Bus;

/// The lights.
pub type Panel = runtime::Panel<<Selected as Board>::Lights>;

/// In a control tick the node runs anyway, in microseconds.
const TICK: u64 = 1_000_000 / RATE_HZ as u64;

/// A deadline is no nearer than this, in microseconds: whatever is asked for, other tasks get their part of the processor.
const NEAREST: u64 = 50;

/// What all tasks own.
pub struct Firmware {
    pub exchange: &'static mut Exchange,
    pub bus: CanBus,
    pub reception: Reception,
    pub stepping: &'static Stepping,
    pub control: &'static mut Control,
    pub node: &'static mut NodeTask,
    pub step: Step,
    pub timer: ControlTimer,
    pub panel: Panel,
}

/// Where it lies.
pub struct Memory {
    pub frames: &'static mut inbox::Memory,
    pub lost: &'static Lost,
    pub edges: &'static Capture,
    pub exchange: &'static mut MaybeUninit<Exchange>,
    pub emitter: &'static mut MaybeUninit<Emitter>,
    pub stepping: &'static mut MaybeUninit<Stepping>,
    pub control: &'static mut MaybeUninit<Control>,
    pub node: &'static mut MaybeUninit<NodeTask>,
}

/// Received frames, and the inbox for them.
pub struct Reception {
    receiver: <Selected as Board>::Receiver,
    inbox: Inbox,
}

impl Reception {
    /// Frames have arrived or were sent, or the controller has seen errors. Returns whether some were lost.
    // Out of line: several interrupts call it.
    #[inline(never)]
    pub fn on_interrupt(&mut self, bus: &mut CanBus) -> bool {
        let before = self.inbox.lost();
        self.receiver.on_interrupt(bus, &mut self.inbox);
        self.inbox.lost() != before
    }
}

/// What step pulses and captured positions need of interrupts.
pub struct Step {
    steps: <Selected as Board>::Steps,
    lines: <Selected as Board>::InputLines,
    edges: &'static Capture,
}

impl Step {
    /// An interrupt of the pulses.
    #[allow(dead_code, reason = "a board with a servo binds no interrupt to it")]
    pub fn on_interrupt(&mut self) {
        self.steps.on_interrupt();
    }

    /// Some input has had an edge.
    // Out of line: several interrupts call it.
    #[inline(never)]
    pub fn on_edge(&mut self) {
        let Self {
            steps,
            lines,
            edges,
        } = self;
        let ticks = Selected::ticks();
        edges.note(
            lines.take(),
            Selected::input_levels(),
            |input| steps.count(input),
            ticks,
        );
    }
}

/// The node, with the frames that wait for it.
pub struct NodeTask {
    node: Node<Dictionary, Machine, Store<<Selected as Board>::Parameters>>,
    received: Received,
    servo_objects: <Selected as Board>::ServoObjects,
    /// The task has run: the first time it powers the node on.
    is_on: bool,
}

impl NodeTask {
    /// Everything there is to do; the first time the node is powered on before. `has_ticked` is whether a control tick has passed since the last run, `stop` is
    /// called as soon as the motor is to stop before the next one. Gives what the lights are to say, once for each step of their patterns.
    pub fn run(
        &mut self,
        mut exchange: impl Mutex<T = &'static mut Exchange>,
        mut bus: impl Mutex<T = CanBus>,
        has_ticked: bool,
        stop: impl FnMut(),
    ) -> Option<Signals> {
        let mut around = Around {
            exchange: &mut exchange,
            stop,
        };
        let mut bus = LockedBus(&mut bus);
        if !core::mem::replace(&mut self.is_on, true) {
            self.node.power_on(&mut around, &mut bus);
        }
        let deadline = (self.node).run(&mut around, &mut bus, &mut self.received);
        let (dictionary, product) = self.node.product();
        ServoObjects::attend(&mut self.servo_objects, dictionary, product, has_ticked);
        let now = clock::now();
        let wait = deadline.ticks().saturating_sub(now.ticks()).max(NEAREST);
        if wait < TICK {
            // Shorter than a tick.
            Selected::wake_in(wait as u32);
        }
        self.node.signal(now)
    }
}

/// Starts the board and the node.
pub fn start(device: <Selected as Board>::Device, timer: SYST, memory: Memory) -> Firmware {
    let Parts {
        pulses,
        steps,
        servo_objects,
        receiver,
        bus,
        stage,
        lights,
        input_lines,
        parameters,
        switches,
        factory_reset,
        serial_number,
        user_memory,
    } = Selected::start(device);
    let Memory {
        frames,
        lost,
        edges,
        exchange,
        emitter,
        stepping,
        control,
        node,
    } = memory;
    edges.begin(Selected::input_levels());

    // All of the board's sectors. They are far smaller than 4 GiB.
    let sectors = 0..parameters.capacity() as u32;
    let mut store = Store::new(parameters, sectors).ok();
    if store.is_none() {
        defmt::error!("the parameter sectors do not suit the store");
    }
    let power_up = PowerUp {
        build: BUILD,
        switches,
        factory: <Dictionary as canopen::od::Dictionary>::HABITS.factory,
        factory_reset,
    };
    let power_on = power_up.choose(&mut store, CanBus::BIT_RATES);

    let (inbox, received) = Inbox::new(frames, lost);
    let [value, spare] = user_memory;
    let machine = Machine::new(value, spare, &board::SCOPE_MEMORY);
    let node = place(node, || NodeTask {
        node: Node::new(Dictionary::new(), machine, &power_on, serial_number, store),
        received,
        servo_objects,
        is_on: false,
    });
    let modes = <<Selected as Board>::Axis as Actuator>::MODES;
    node.node.set_up(&power_on, CanBus::BIT_RATES, modes);
    let emitter = place(emitter, || Emitter::new(CONFIG));
    let stepping: &_ = place(stepping, || Stepping::new(emitter, pulses));
    let control = place(control, || {
        Control::new(stepping, stage, lost, edges, &board::SCOPE_MEMORY)
    });
    Firmware {
        exchange: place(exchange, Exchange::new),
        bus,
        reception: Reception { receiver, inbox },
        stepping,
        control,
        node,
        step: Step {
            steps,
            lines: input_lines,
            edges,
        },
        timer: ControlTimer::start::<Selected>(timer, RATE_HZ),
        panel: Panel::new(lights),
    }
}

/// Makes a value and puts it where it stays. On the stack each has a place of its own only while it is made.
#[inline(never)]
fn place<T>(memory: &'static mut MaybeUninit<T>, value: impl FnOnce() -> T) -> &'static mut T {
    memory.write(value())
}
