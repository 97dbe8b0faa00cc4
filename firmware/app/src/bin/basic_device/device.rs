//! The device behind the frames: its node, and an application that has something to say. The image
//! whose flash is measured and the device that the tests put on a bus are this one.

use canopen::cia301::emergency::{Emergency, ErrorRegister};
use canopen::cia301::nmt::Reset;
use canopen::cia301::time_stamp::TimeOfDay;
use canopen::{BitRate, Event, Frame, Instant, Node, NodeId, Settings};

use super::dictionary::Dictionary;

/// What it tells while its alarm is on.
const ALARM: Emergency = Emergency {
    code: 0x2310,
    register: ErrorRegister::CURRENT,
    info: [0; 5],
};

/// A node with the objects of `tests/eds/basic-device.eds`.
#[derive(Debug)]
pub struct BasicDevice {
    node: Node<Dictionary>,
}

impl BasicDevice {
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
    }

    /// Lets time pass, and returns when it is to be called again at the latest.
    pub fn poll(&mut self, now: Instant) -> Instant {
        self.node.poll(now, &mut ())
    }

    /// The next frame to send.
    pub fn transmit(&mut self) -> Option<Frame> {
        self.node.transmit(&mut ())
    }

    /// The next thing that has happened. Resets are done by then; settings are kept as long as
    /// there is power.
    pub fn event(&mut self, now: Instant) -> Option<Event> {
        let event = self.node.event();
        match event {
            Some(Event::ResetRequested(reset)) => self.node.boot(reset, now, &mut ()),
            Some(Event::StoreSettings(_)) => self.node.settings_stored(Ok(())),
            _ => {}
        }
        event
    }

    /// The application's value goes out by 2006h, and what has come in by 2004h is its next order.
    pub fn exchange(&mut self, number: u32) -> u32 {
        let dictionary = self.node.dictionary_mut();
        dictionary.set_sent_number_2(number);
        dictionary.received_number_2()
    }

    /// An error comes, or goes.
    pub fn alarm(&mut self, is_on: bool, now: Instant) {
        if is_on {
            self.node.report(ALARM, now);
        } else {
            self.node.clear(ALARM.code, now);
        }
    }

    /// The time of the network.
    pub fn time_of_day(&self, now: Instant) -> Option<TimeOfDay> {
        self.node.time_of_day(now)
    }

    /// Tells the network the time; returns whether it is known.
    pub fn send_time_of_day(&mut self, now: Instant) -> bool {
        self.node.send_time_of_day(now)
    }
}
