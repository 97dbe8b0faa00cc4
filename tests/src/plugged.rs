//! A virtual drive whose plug can be pulled at any time, in the middle of a write to its flash too.

use canopen::time::NEVER;
use canopen::{BitRate, Frame, Instant};
use master::bus::Station;
use sim::drive::Setup;
use sim::flash::{Flash, Power};

use crate::drive::AxisDrive;

/// A drive with a plug. While it is out, the drive neither hears nor sends; what it had not sent is lost.
#[derive(Debug)]
pub struct Plugged {
    drive: AxisDrive,
    power: Power,
    pull_at: Instant,
    was_pulled: bool,
}

impl Plugged {
    /// A drive with this serial number, fresh from the factory and plugged in.
    pub fn new(serial_number: u32) -> Self {
        let power = Power::new();
        let setup = Setup {
            store: Flash::in_memory().powered_by(&power).into_store(),
            ..Setup::unconfigured(serial_number)
        };
        Self {
            drive: AxisDrive::new(setup),
            power,
            pull_at: NEVER,
            was_pulled: false,
        }
    }

    /// The plug is pulled at this time.
    pub fn pull_at(&mut self, at: Instant) {
        self.pull_at = at;
    }

    /// The plug is pulled when so many more bytes of flash have been programmed or erased, the last of them half.
    pub fn pull_at_byte(&mut self, count: u64) {
        self.power.cut_at_byte(count);
    }

    /// Whether the plug is out.
    pub fn is_out(&self) -> bool {
        !self.power.is_on()
    }

    /// Plugs it in; what would have pulled it later is off. It boots when the bus runs on.
    pub fn plug_in(&mut self) {
        self.power.restore();
        self.pull_at = NEVER;
        self.drive.power_cycle();
    }

    /// Pulls the plug if it is time. Returns whether it is out.
    fn is_out_at(&mut self, now: Instant) -> bool {
        if now >= self.pull_at && !self.is_out() {
            self.power.cut_at_byte(0);
            self.was_pulled = true;
        }
        self.is_out()
    }
}

impl Station for Plugged {
    fn receive(&mut self, frame: &Frame, now: Instant) {
        if self.is_out_at(now) {
            return;
        }
        self.drive.receive(frame, now);
        self.was_pulled = self.is_out();
    }

    fn poll(&mut self, now: Instant) -> Instant {
        if self.is_out_at(now) {
            return NEVER;
        }
        let deadline = self.drive.poll(now);
        self.was_pulled = self.is_out();
        deadline.min(self.pull_at)
    }

    fn transmit(&mut self) -> Option<Frame> {
        if self.is_out() {
            return None;
        }
        self.drive.transmit()
    }

    /// Without power it follows any: somebody else on the bus acknowledges.
    fn bit_rate(&self) -> Option<BitRate> {
        self.drive.bit_rate().filter(|_| !self.is_out())
    }

    fn was_reset(&mut self) -> bool {
        std::mem::take(&mut self.was_pulled) | self.drive.was_reset()
    }
}
