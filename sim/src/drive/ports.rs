//! What the virtual drive gives to the runtime: the plant as its power stage, a CAN controller, virtual time.

use std::collections::VecDeque;
use std::sync::Arc;

use canopen::cia305::DETECTABLE;
use canopen::outbox::{Mailbox, Mailboxes};
use canopen::{BitRate, ControllerState, Event, Frame, Instant};
use cia402::inputs::DigitalInputs;
use cia402::recorder::Memory;
use cia402::{Behaves, Exchange, Inputs, Outputs, Share};
use runtime::{Control, Host, PowerStage, Reception, Stamped, Unreachable};

use crate::plant::{Plant, PulsePlayer, Sensed, ServoMotor, WIRES};

use super::Moving;

/// Events that are kept until somebody takes them; older ones are forgotten.
const EVENTS: usize = 64;

/// 2350h, load level warning (I²t): the heat has come near its bound.
const HEAT: u16 = 0x2350;

impl PowerStage for Plant {
    type Pulses = PulsePlayer;

    fn pulses(&mut self) -> &mut PulsePlayer {
        self.pulses_mut()
    }

    fn service(&mut self) {}

    fn look(&mut self, inputs: &mut Inputs) -> Instant {
        *inputs = Inputs {
            supply: self.supply,
            position: self.position(),
            warning: (self.warning).or(self.servo().filter(|servo| servo.is_hot()).map(|_| HEAT)),
            fault: self.fault.or(self.servo().and_then(ServoMotor::error_code)),
            digital: inputs.digital,
            stall: self.stall(),
            absolute_turn: self.absolute_turn(),
            position_tolerance: self.position_tolerance(),
            supply_voltage: Some(self.supply_voltage),
            temperature: Some(self.temperature),
            analogue: Some(self.analogue),
            auxiliary_voltage: Some(self.auxiliary_voltage),
            battery_voltage: Some(self.battery_voltage),
            has_compare: true,
            counter: self.second.count(self.now()),
        };
        self.now()
    }

    fn measure(&mut self, inputs: &mut Inputs) {
        inputs.digital = digital(Self::look(self));
    }

    fn carry_out(&mut self, outputs: &Outputs) {
        self.energise(outputs.power_stage);
        self.set_driver(outputs.current, outputs.microsteps);
        self.set_outputs(outputs.digital);
        self.pulses_mut().compare(outputs.compare);
        self.open_brake(outputs.brake_released);
    }

    fn drop_pulses(&mut self) {
        self.pulses_mut().drop_all();
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

/// The CAN controller. The bus takes the frames it sends one by one, when it is idle ([`Controller::slot`]).
#[derive(Debug)]
pub(super) struct Controller {
    pub(super) bit_rate: BitRate,
    /// It listens only.
    pub(super) is_silent: bool,
    /// It has seen a frame that it could not read.
    pub(super) has_seen_error: bool,
    pub(super) state: ControllerState,
    /// It was started since the bus looked last.
    pub(super) was_started: bool,
}

impl Controller {
    /// A controller that is set to this bit rate.
    pub(super) fn new(bit_rate: BitRate) -> Self {
        Self {
            bit_rate,
            is_silent: false,
            has_seen_error: false,
            state: ControllerState::ErrorActive,
            was_started: false,
        }
    }
}

/// The frames that have arrived.
#[derive(Debug, Default)]
pub(super) struct Received {
    pub(super) frames: VecDeque<Stamped>,
    pub(super) lost: u32,
}

impl Reception for Received {
    fn receive(&mut self) -> Option<Stamped> {
        self.frames.pop_front()
    }

    fn lost(&self) -> u32 {
        self.lost
    }
}

impl Mailboxes for Controller {
    fn mailbox_for(&mut self, _: u16) -> Mailbox {
        Mailbox::None
    }

    fn put(&mut self, frame: &Frame) -> Option<Frame> {
        Some(*frame)
    }
}

impl runtime::Controller for Controller {
    const BIT_RATES: &'static [BitRate] = &DETECTABLE;

    /// At once: a frame under way is the bus's.
    fn leave(&mut self) -> bool {
        true
    }

    fn start(&mut self, bit_rate: BitRate) -> Result<(), Unreachable> {
        self.bit_rate = bit_rate;
        self.is_silent = false;
        self.was_started = true;
        Ok(())
    }

    fn listen(&mut self, bit_rate: BitRate) -> Result<(), Unreachable> {
        self.bit_rate = bit_rate;
        self.is_silent = true;
        self.has_seen_error = false;
        Ok(())
    }

    fn error_seen(&mut self) -> bool {
        std::mem::take(&mut self.has_seen_error)
    }

    fn state(&mut self) -> ControllerState {
        self.state
    }
}

/// A mailbox for one frame.
#[derive(Debug, Default)]
pub(super) struct Slot(pub(super) Option<Frame>);

impl Mailboxes for Slot {
    fn mailbox_for(&mut self, _: u16) -> Mailbox {
        if self.0.is_some() {
            Mailbox::None
        } else {
            Mailbox::Free
        }
    }

    fn put(&mut self, frame: &Frame) -> Option<Frame> {
        self.0.replace(*frame)
    }
}

/// What is around the node while it runs.
pub(super) struct Tasks<'a, D, A> {
    pub(super) now: Instant,
    pub(super) exchange: &'a mut Exchange,
    pub(super) control: &'a mut Control<D, Arc<Memory>, A>,
    pub(super) plant: &'a mut Plant,
    /// How many frames were lost.
    pub(super) lost: u32,
    pub(super) events: &'a mut VecDeque<Event>,
    /// A tick was made for a command to stop.
    pub(super) has_stopped: bool,
}

impl<D, A> Share for Tasks<'_, D, A> {
    fn lock<R>(&mut self, f: impl FnOnce(&mut Exchange) -> R) -> R {
        f(self.exchange)
    }
}

impl<D: Behaves, A: Moving> Host for Tasks<'_, D, A> {
    fn now(&self) -> Instant {
        self.now
    }

    fn stop(&mut self) {
        self.has_stopped |= self.control.stop(self.lost, self.plant, self.exchange);
    }

    fn tell(&mut self, event: &Event) {
        if self.events.len() == EVENTS {
            self.events.pop_front();
        }
        self.events.push_back(*event);
    }
}
