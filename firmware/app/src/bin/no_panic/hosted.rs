//! The runtime on a host that may say and do anything.

use canopen::node::StoreError;
use canopen::outbox::{Mailbox, Mailboxes};
use canopen::{BitRate, Configuration, ControllerState, Event, Frame, Instant};
use cia402::recorder::Memory;
use cia402::{DriveConfig, Exchange, Inputs, Outputs, Share};
use runtime::{
    Control, Controller, Host, Lights, Machine, Node, Panel, PowerStage, PowerUp, Reception,
    Stamped, Storage, Unreachable,
};

use super::dictionary::Dictionary;
use super::{
    any, any_controller_state, any_frame, any_inputs, any_result, any_time, look, AnyMailboxes,
    AnyStore, Axis402, Moving, Sink, SCOPE,
};

/// A host.
pub struct Hosted {
    node: Node<Dictionary, Machine<[u8; 64], &'static Memory>, AnyStore>,
    control: Control<Dictionary, &'static Memory, Axis402>,
    panel: Panel<AnyLights>,
    around: Around,
}

impl Hosted {
    pub fn new(config: DriveConfig) -> Self {
        let mut store = (any() == 0).then_some(AnyStore);
        let power_up = PowerUp {
            factory_reset: any() == 0,
            ..PowerUp::default()
        };
        let power_on = power_up.choose(&mut store, AnyController::BIT_RATES);
        let machine = Machine::new([0; 64], [0; 64], &SCOPE as &'static Memory);
        let mut node = Node::new(Dictionary::new(), machine, &power_on, any(), store);
        node.set_up(&power_on, AnyController::BIT_RATES, any());
        Self {
            node,
            control: Axis402::control(config),
            panel: Panel::new(AnyLights),
            around: Around(Exchange::new()),
        }
    }

    #[inline(never)]
    pub fn run(&mut self) {
        let Self {
            node,
            control,
            panel,
            around,
        } = self;
        match any() {
            0 => node.power_on(around, &mut AnyController),
            1 => {
                let deadline = node.run(around, &mut AnyController, &mut AnyReception);
                look(deadline.ticks() as u32);
            }
            2 => node.send(any_time(), &mut AnyMailboxes),
            3 => {
                if let Some(signals) = node.signal(any_time()) {
                    panel.advance(&signals);
                }
            }
            4 => {
                let (now, next) = control.tick(any(), any() == 0, &mut AnyStage(Sink), around);
                look(now.ticks() as u32 + next.map_or(0, |next| next.ticks() as u32));
            }
            5 => look(control.stop(any(), &mut AnyStage(Sink), around).into()),
            _ => control.refill(&mut AnyStage(Sink)),
        }
    }
}

struct Around(Exchange);

impl Share for Around {
    fn lock<R>(&mut self, f: impl FnOnce(&mut Exchange) -> R) -> R {
        f(&mut self.0)
    }
}

impl Host for Around {
    fn now(&self) -> Instant {
        any_time()
    }

    fn stop(&mut self) {
        look(0);
    }

    fn tell(&mut self, event: &Event) {
        look(matches!(event, Event::RestartController).into());
    }
}

/// In place of the queue [`runtime::inbox`]: its length is in its type, and the compiler has forgotten it where it divides by it.
struct AnyReception;

impl Reception for AnyReception {
    fn receive(&mut self) -> Option<Stamped> {
        (any() == 0).then(|| Stamped {
            frame: any_frame(),
            at: any_time(),
        })
    }

    fn lost(&self) -> u32 {
        any()
    }
}

struct AnyController;

impl Mailboxes for AnyController {
    fn mailbox_for(&mut self, cob_id: u16) -> Mailbox {
        AnyMailboxes.mailbox_for(cob_id)
    }

    fn put(&mut self, frame: &Frame) -> Option<Frame> {
        AnyMailboxes.put(frame)
    }
}

impl Controller for AnyController {
    const BIT_RATES: &'static [BitRate] = &BitRate::ALL;

    fn leave(&mut self) -> bool {
        any() == 0
    }

    fn start(&mut self, bit_rate: BitRate) -> Result<(), Unreachable> {
        look(bit_rate.kbit_per_second());
        any_result().map_err(|_| Unreachable)
    }

    fn listen(&mut self, bit_rate: BitRate) -> Result<(), Unreachable> {
        self.start(bit_rate)
    }

    fn error_seen(&mut self) -> bool {
        any() == 0
    }

    fn state(&mut self) -> ControllerState {
        any_controller_state()
    }
}

impl Storage for AnyStore {
    fn load(&mut self) -> Result<Option<Configuration>, StoreError> {
        any_result().map(|()| None)
    }

    fn save(&mut self, settings: &Configuration) -> Result<(), StoreError> {
        look(settings.node_id.get().into());
        any_result()
    }

    fn forget(&mut self) -> Result<(), StoreError> {
        any_result()
    }

    fn serial_number(&mut self) -> Option<u32> {
        (any() == 0).then(any)
    }
}

struct AnyStage(Sink);

impl PowerStage for AnyStage {
    type Pulses = Sink;

    fn pulses(&mut self) -> &mut Sink {
        &mut self.0
    }

    fn service(&mut self) {
        look(0);
    }

    fn look(&mut self, inputs: &mut Inputs) -> Instant {
        *inputs = any_inputs();
        any_time()
    }

    fn measure(&mut self, inputs: &mut Inputs) {
        *inputs = any_inputs();
    }

    fn carry_out(&mut self, outputs: &Outputs) {
        look(u32::from(outputs.power_stage) + u32::from(outputs.current));
    }

    fn drop_pulses(&mut self) {
        look(0);
    }
}

struct AnyLights;

impl Lights for AnyLights {
    const BICOLOUR: bool = true;

    fn set_run(&mut self, on: bool) {
        look(on.into());
    }

    fn set_error(&mut self, on: bool) {
        look(on.into());
    }

    fn set_drive(&mut self, on: bool) {
        look(on.into());
    }
}
