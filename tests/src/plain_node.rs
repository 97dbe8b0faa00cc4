//! A plain CANopen device with the objects of `eds/test-device.eds`, nothing else: what the protocol cases are put to.

use canopen::can_controller::ControllerState;
use canopen::cia301::nmt::Reset;
use canopen::time::NEVER;
use canopen::{BitRate, Duration, Event, Frame, Instant, Node, NodeId, Settings};
use master::bus::Station;

use crate::firmware::{Firmware, Store};
use crate::line::Line;
use crate::test_device::Dictionary;

/// Between two steps of storing parameters, as flash takes its time.
const STORE_STEP: Duration = Duration::millis(1);

/// The device, and what its firmware would do: boot after a reset, store settings and parameters.
#[derive(Debug)]
pub struct PlainNode {
    node: Node<Dictionary>,
    powered: bool,
    was_reset: bool,
    /// The application around the node.
    pub firmware: Firmware,
    /// Where parameters are stored.
    pub store: Store,
    /// When the next step of storing parameters may be done.
    next_store_step: Instant,
    /// The controller has left the bus: it neither sends nor receives.
    is_bus_off: bool,
}

impl PlainNode {
    /// A device that boots when the bus first runs.
    pub fn new(node_id: NodeId) -> Self {
        let settings = Settings {
            node_id,
            bit_rate: BitRate::Kbit1000,
        };
        Self {
            node: node(settings),
            powered: false,
            was_reset: false,
            firmware: Firmware::default(),
            store: Store::default(),
            next_store_step: Instant::from_ticks(0),
            is_bus_off: false,
        }
    }

    /// A device without a node-ID, with this identity (1018h).
    pub fn with_identity(identity: [u32; 4]) -> Self {
        let mut device = Self::new(NodeId::UNCONFIGURED);
        device.firmware.identity = Some(identity);
        device
    }

    /// The controller has seen too many errors.
    pub fn go_bus_off(&mut self, now: Instant) {
        self.is_bus_off = true;
        // What was in its mailboxes is gone.
        self.was_reset = true;
        self.node.controller_changed(ControllerState::BusOff, now);
    }

    fn restart_controller(&mut self, now: Instant) {
        self.is_bus_off = false;
        self.node
            .controller_changed(ControllerState::ErrorActive, now);
    }

    /// The node itself.
    pub fn node(&mut self) -> &mut Node<Dictionary> {
        &mut self.node
    }

    fn boot(&mut self, reset: Reset, now: Instant) {
        self.node.boot(reset, now, &mut self.firmware);
        self.node
            .load_parameters(&mut self.store, now, &mut self.firmware);
    }

    fn serve_events(&mut self, now: Instant) {
        while let Some(event) = self.node.event() {
            match event {
                Event::ResetRequested(reset) => self.boot(reset, now),
                Event::StoreSettings(_) => self.node.settings_stored(Ok(())),
                Event::RestartController => self.restart_controller(now),
                _ => {}
            }
        }
    }

    /// One step of storing parameters, if one is due. Returns when the next one is.
    fn store_parameters(&mut self, now: Instant) -> Instant {
        if !self.node.is_storing() {
            self.next_store_step = now + STORE_STEP;
            return NEVER;
        }
        if self.next_store_step <= now {
            self.node.store_parameters(&mut self.store, now);
            self.next_store_step = now + STORE_STEP;
        }
        self.next_store_step
    }
}

fn node(settings: Settings) -> Node<Dictionary> {
    Node::new(Dictionary::new(), settings).with_parameter_store()
}

impl Station for PlainNode {
    fn receive(&mut self, frame: &Frame, now: Instant) {
        if self.is_bus_off {
            return;
        }
        self.node.receive(frame, now, &mut self.firmware);
        self.serve_events(now);
    }

    fn poll(&mut self, now: Instant) -> Instant {
        if !self.powered {
            self.powered = true;
            self.boot(Reset::Node, now);
        }
        let next_step = self.store_parameters(now);
        let deadline = self.node.poll(now, &mut self.firmware);
        self.serve_events(now);
        deadline.min(next_step)
    }

    fn transmit(&mut self) -> Option<Frame> {
        if self.is_bus_off {
            return None;
        }
        self.node.transmit(&mut self.firmware)
    }

    fn was_reset(&mut self) -> bool {
        std::mem::take(&mut self.was_reset)
    }
}

/// A plain device and a script on one bus.
pub type Bench = Line<PlainNode>;

impl Bench {
    /// A device with this node-ID that is about to be powered.
    pub fn powered(node_id: u8) -> Self {
        let device = PlainNode::new(NodeId::new(node_id).expect("a node-ID"));
        Self::new(device, node_id)
    }

    /// A device that has booted and is Pre-operational.
    pub fn node(node_id: u8) -> Self {
        let mut bench = Self::powered(node_id);
        bench.expect(&format!("{:03X} [1] 00", 0x700 + u16::from(node_id)));
        bench
    }

    /// Changes values as the application of the device would.
    pub fn change(&mut self, change: impl FnOnce(&mut Dictionary)) {
        change(self.bus.station_mut(self.device).node.dictionary_mut());
    }

    /// One more device on the same bus.
    pub fn attach_another(&mut self, node_id: u8) {
        self.bus
            .attach(PlainNode::new(NodeId::new(node_id).expect("a node-ID")));
    }

    /// The device itself.
    pub fn device(&mut self) -> &mut PlainNode {
        self.bus.station_mut(self.device)
    }
}
