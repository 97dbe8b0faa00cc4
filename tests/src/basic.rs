//! The device whose flash is measured (`firmware/app/src/bin/basic_device`), on a bus.

use canopen::{Frame, Instant, NodeId};
use master::bus::Station;

pub use crate::basic_device as dictionary;
use crate::line::Line;

#[path = "../../firmware/app/src/bin/basic_device/device.rs"]
mod device;

pub use device::BasicDevice;

/// The number that makes the application tell of an error, as long as it stands.
pub const ALARMING: u32 = 0xA1A1_A1A1;

/// The device with something around it: the number that 2004h has received is what 2006h sends.
#[derive(Debug)]
pub struct Wired {
    device: BasicDevice,
    order: u32,
}

impl Wired {
    fn serve_events(&mut self, now: Instant) {
        while self.device.event(now).is_some() {}
    }
}

impl Station for Wired {
    fn receive(&mut self, frame: &Frame, now: Instant) {
        self.device.receive(frame, now);
        self.serve_events(now);
    }

    fn poll(&mut self, now: Instant) -> Instant {
        let before = self.order;
        self.order = self.device.exchange(before);
        if self.order != before {
            self.device.exchange(self.order);
            self.device.alarm(self.order == ALARMING, now);
        }
        let deadline = self.device.poll(now);
        self.serve_events(now);
        deadline
    }

    fn transmit(&mut self) -> Option<Frame> {
        self.device.transmit()
    }
}

/// The device, without a node-ID, on one bus with a script.
pub fn line() -> Line<Wired> {
    let device = BasicDevice::new(NodeId::UNCONFIGURED, Instant::from_ticks(0));
    Line::new(Wired { device, order: 0 }, 0)
}
