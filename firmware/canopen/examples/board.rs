//! The loop of a board: any CAN driver that implements `embedded_can::nb::Can`, and any clock that counts microseconds.
//!
//! On a board `Driver` is that of its HAL (`bxcan`, `fdcan`, `mcp2515` ...) and the program is `no_std`. Here the driver is a loop of wire, so
//! that the example runs: `cargo run --example board`.
#![forbid(unsafe_code)]

#[path = "io_device/device.rs"]
mod device;
#[path = "io_device/dictionary.rs"]
#[rustfmt::skip]
mod dictionary;

use std::collections::VecDeque;

use canopen::{Frame, Instant, NodeId};
use device::IoDevice;
use embedded_can::nb::Can;

/// A driver with the device behind it.
struct Board<Driver: Can> {
    can: Driver,
    device: IoDevice,
    /// A frame that the mailboxes had no room for.
    waiting: Option<Driver::Frame>,
}

impl<Driver: Can> Board<Driver> {
    /// One turn. To be repeated after each interrupt of the controller, and at the moment that it returns.
    fn turn(&mut self, now: Instant) -> Instant {
        while let Ok(received) = self.can.receive() {
            if let Some(frame) = converted(&received) {
                self.device.receive(&frame, now);
            }
        }
        let mut deadline = self.device.poll(now);
        loop {
            let next = self.waiting.take();
            let Some(frame) = next.or_else(|| converted(&self.device.transmit()?)) else {
                return deadline;
            };
            match self.can.transmit(&frame) {
                // With a controller whose mailboxes can be looked into, `canopen::Outbox` also takes back what has become less urgent.
                Ok(None) => deadline = self.device.poll(now),
                Ok(displaced) => self.waiting = displaced,
                Err(_) => {
                    self.waiting = Some(frame);
                    return deadline;
                }
            }
        }
    }
}

/// A frame as another crate has it.
fn converted<From: embedded_can::Frame, To: embedded_can::Frame>(frame: &From) -> Option<To> {
    if frame.is_remote_frame() {
        To::new_remote(frame.id(), frame.dlc())
    } else {
        To::new(frame.id(), frame.data())
    }
}

/// In place of a driver: what is to be received, and what was sent.
#[derive(Default)]
struct Wire {
    to_device: VecDeque<Frame>,
    from_device: Vec<Frame>,
}

impl Can for Wire {
    type Frame = Frame;
    type Error = embedded_can::ErrorKind;

    fn transmit(&mut self, frame: &Frame) -> nb::Result<Option<Frame>, Self::Error> {
        self.from_device.push(*frame);
        Ok(None)
    }

    fn receive(&mut self) -> nb::Result<Frame, Self::Error> {
        self.to_device.pop_front().ok_or(nb::Error::WouldBlock)
    }
}

fn main() {
    let node_id = NodeId::new(5).expect("it is between 1 and 127");
    let mut board = Board {
        can: Wire::default(),
        device: IoDevice::new(node_id, Instant::from_ticks(0)),
        waiting: None,
    };
    let read_identity = [0x40, 0x18, 0x10, 2, 0, 0, 0, 0];
    let frame = Frame::data_frame(0x605, &read_identity);
    board.can.to_device.push_back(frame);
    for millisecond in 0..3 {
        board.turn(Instant::from_ticks(millisecond * 1_000));
    }
    let sent = board.can.from_device.iter();
    let sent: Vec<_> = sent
        .map(|frame| (frame.standard_id(), frame.payload()))
        .collect();
    assert_eq!(
        sent,
        [
            (Some(0x705), &[0][..]),
            (Some(0x585), &[0x43, 0x18, 0x10, 2, 0x01, 0x04, 0, 0])
        ]
    );
    println!("{sent:02X?}");
}
