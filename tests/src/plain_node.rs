//! A plain CANopen device with the objects of `eds/test-device.eds`, nothing else: what the protocol cases are put to.

use canopen::cia301::nmt::Reset;
use canopen::node::StoreError;
use canopen::od::Dictionary as _;
use canopen::{BitRate, Event, Frame, Instant, Node, NodeId, Settings};
use sim::bus::Station;

use crate::line::Line;
use crate::test_device::Dictionary;

/// The device, and what its firmware would do: boot after a reset, store settings.
#[derive(Debug)]
pub struct PlainNode {
    node: Node<Dictionary>,
    powered: bool,
    /// What storing settings will end with.
    pub store_result: Result<(), StoreError>,
    /// What LSS has stored.
    pub stored: Option<Settings>,
    /// Bit rates LSS has ordered, with the time to switch.
    pub bit_rates: Vec<(BitRate, Instant)>,
}

impl PlainNode {
    /// A device that boots when the bus first runs.
    pub fn new(node_id: NodeId) -> Self {
        let settings = Settings {
            node_id,
            bit_rate: BitRate::Kbit1000,
        };
        Self {
            node: Node::new(Dictionary::new(), settings),
            powered: false,
            store_result: Ok(()),
            stored: None,
            bit_rates: Vec::new(),
        }
    }

    fn serve_events(&mut self, now: Instant) {
        while let Some(event) = self.node.event() {
            match event {
                Event::ResetRequested(reset) => self.node.boot(reset, now, &mut ()),
                Event::StoreSettings(settings) => {
                    if self.store_result.is_ok() {
                        self.stored = Some(settings);
                    }
                    self.node.settings_stored(self.store_result);
                }
                Event::SwitchBitRate { bit_rate, at } => self.bit_rates.push((bit_rate, at)),
                _ => {}
            }
        }
    }
}

impl Station for PlainNode {
    fn receive(&mut self, frame: &Frame, now: Instant) {
        self.node.receive(frame, now, &mut ());
        self.serve_events(now);
    }

    fn poll(&mut self, now: Instant) -> Instant {
        if !self.powered {
            self.powered = true;
            self.node.boot(Reset::Node, now, &mut ());
        }
        let deadline = self.node.poll(now, &mut ());
        self.serve_events(now);
        deadline
    }

    fn transmit(&mut self) -> Option<Frame> {
        self.node.transmit(&mut ())
    }
}

/// A plain device and a script on one bus.
pub type Bench = Line<PlainNode>;

impl Bench {
    /// A device with this node-ID that is about to be powered.
    pub fn powered(node_id: u8) -> Self {
        let device = PlainNode::new(NodeId::new(node_id).expect("a node-ID"));
        Self::new(device, node_id, Dictionary::TABLE)
    }

    /// A device that has booted and is Pre-operational.
    pub fn node(node_id: u8) -> Self {
        let mut bench = Self::powered(node_id);
        bench.expect(&format!("{:03X} [1] 00", 0x700 + u16::from(node_id)));
        bench
    }

    /// A device without a node-ID.
    pub fn unconfigured() -> Self {
        Self::powered(255)
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
