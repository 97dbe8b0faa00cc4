//! The device, whatever bus it is on: eight outputs that are wired to eight inputs, and a voltage that follows them.

use canopen::cia301::nmt::Reset;
use canopen::{BitRate, Event, Frame, Instant, Node, NodeId, Settings};

use crate::dictionary::Dictionary;

/// What each output that is on adds to the voltage, in millivolts.
const MILLIVOLTS: i16 = 1_000;

/// A CANopen node with the objects of `io-device.eds`, and what its application does.
#[derive(Debug)]
pub struct IoDevice {
    node: Node<Dictionary>,
}

impl IoDevice {
    /// A device with this node-ID that has just been powered.
    pub fn new(node_id: NodeId, now: Instant) -> Self {
        let settings = Settings {
            node_id,
            bit_rate: BitRate::Kbit1000,
        };
        let mut node = Node::new(Dictionary::new(), settings);
        node.boot(Reset::Node, now, &mut ());
        Self { node }
    }

    /// A frame has come.
    pub fn receive(&mut self, frame: &Frame, now: Instant) {
        self.node.receive(frame, now, &mut ());
        while let Some(event) = self.node.event() {
            // A device that moves something would stop it first.
            if let Event::ResetRequested(reset) = event {
                self.node.boot(reset, now, &mut ());
            }
        }
    }

    /// Lets time pass, and returns when it is to be called again at the latest.
    pub fn poll(&mut self, now: Instant) -> Instant {
        // A real device writes pins here and reads others.
        let pins = self.node.dictionary().digital_outputs_1_to_8();
        let voltage = MILLIVOLTS * pins.count_ones() as i16;
        let dictionary = self.node.dictionary_mut();
        dictionary.set_digital_inputs_1_to_8(pins);
        dictionary.set_analogue_input_voltage(voltage);
        self.node.poll(now, &mut ())
    }

    /// The next frame to send. When the last one has left, [`IoDevice::poll`] is due once more.
    pub fn transmit(&mut self) -> Option<Frame> {
        self.node.transmit(&mut ())
    }
}
