//! A CANopen device with nothing around its node: no application, nothing stored. Any dictionary fits.

use canopen::cia301::nmt::Reset;
use canopen::cia301::pdo::NotSent;
use canopen::od::Dictionary;
use canopen::{BitRate, Event, Frame, Instant, Node, NodeId, Settings};
use master::bus::Station;

use crate::line::Line;
use crate::multiplexed_device;

/// The device.
#[derive(Debug)]
pub struct BareNode<D: Dictionary> {
    node: Node<D>,
    is_powered: bool,
}

impl<D: Dictionary> BareNode<D> {
    fn serve_events(&mut self, now: Instant) {
        while let Some(event) = self.node.event() {
            if let Event::ResetRequested(reset) = event {
                self.node.boot(reset, now, &mut ());
            }
        }
    }
}

impl<D: Dictionary + std::fmt::Debug + 'static> Station for BareNode<D> {
    fn receive(&mut self, frame: &Frame, now: Instant) {
        self.node.receive(frame, now, &mut ());
        self.serve_events(now);
    }

    fn poll(&mut self, now: Instant) -> Instant {
        if !self.is_powered {
            self.is_powered = true;
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

/// A device with multiplexed PDOs (`eds/multiplexed-device.eds`), which are off at power-on, and a script on one bus.
pub type MultiplexedBench = Line<BareNode<multiplexed_device::Dictionary>>;

impl<D: Dictionary + Default + std::fmt::Debug + 'static> Line<BareNode<D>> {
    /// A device with this node-ID that has booted and is Pre-operational.
    pub fn bare(node_id: u8) -> Self {
        let settings = Settings {
            node_id: NodeId::new(node_id).expect("a node-ID"),
            bit_rate: BitRate::Kbit1000,
        };
        let device = BareNode {
            node: Node::new(D::default(), settings),
            is_powered: false,
        };
        let mut bench = Self::new(device, node_id);
        bench.expect(&format!("{:03X} [1] 00", 0x700 + u16::from(node_id)));
        bench
    }

    /// Changes values as the application of the device would.
    pub fn change(&mut self, change: impl FnOnce(&mut D)) {
        change(self.bus.station_mut(self.device).node.dictionary_mut());
    }

    /// The application sends an object of the scanner list.
    ///
    /// # Errors
    /// It is not sent, and why.
    pub fn announce(&mut self, index: u16, sub: u8) -> Result<(), NotSent> {
        let now = self.now();
        let node = &mut self.bus.station_mut(self.device).node;
        node.announce(index, sub, now)
    }

    /// The application sends a value to an object of another node, or of all with 0.
    ///
    /// # Errors
    /// It is not sent, and why.
    pub fn send_to(
        &mut self,
        node_id: u8,
        index: u16,
        sub: u8,
        value: [u8; 4],
    ) -> Result<(), NotSent> {
        let now = self.now();
        let node = &mut self.bus.station_mut(self.device).node;
        node.send_to(node_id, index, sub, value, now)
    }
}
