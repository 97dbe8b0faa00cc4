//! A device that holds its own data sheet (1021h).

use std::collections::VecDeque;

use master::bus::Station;
use sim::products::{Drive, Product};

use super::*;

/// The node-ID of the device.
const OTHER: u8 = 5;

/// A drive that also answers to 1021h and 1022h, by segments.
#[derive(Debug)]
struct WithSheet {
    drive: Box<dyn Drive>,
    format: u8,
    left: Option<Vec<u8>>,
    answers: VecDeque<Frame>,
}

impl WithSheet {
    /// The answer to a request about the two objects, or about a segment of the text.
    fn answer(&mut self, request: &[u8]) -> Option<[u8; 8]> {
        let text = || EDS.as_bytes().to_vec();
        match *request {
            [0x40, 0x21, 0x10, 0x00, ..] => {
                let [a, b, c, d] = (EDS.len() as u32).to_le_bytes();
                self.left = Some(text());
                Some([0x41, 0x21, 0x10, 0x00, a, b, c, d])
            }
            [0x40, 0x22, 0x10, 0x00, ..] => Some([0x4F, 0x22, 0x10, 0x00, self.format, 0, 0, 0]),
            [command @ (0x60 | 0x70), ..] => {
                let left = self.left.as_mut()?;
                let count = left.len().min(7);
                let mut answer = [0; 8];
                for (byte, value) in answer[1..].iter_mut().zip(left.drain(..count)) {
                    *byte = value;
                }
                answer[0] = (command & 0x10) | (7 - count as u8) << 1 | u8::from(left.is_empty());
                if left.is_empty() {
                    self.left = None;
                }
                Some(answer)
            }
            _ => None,
        }
    }
}

const EDS: &str = include_str!("../../../../products/tc1/tc1.eds");

impl Station for WithSheet {
    fn receive(&mut self, frame: &Frame, now: Instant) {
        let is_request = frame.standard_id() == Some(0x600 + u16::from(OTHER));
        let answer = is_request.then(|| self.answer(frame.payload())).flatten();
        match answer {
            Some(answer) => {
                let answer = Frame::data_frame(0x580 + u16::from(OTHER), &answer);
                self.answers.push_back(answer);
            }
            None => self.drive.receive(frame, now),
        }
    }

    fn poll(&mut self, now: Instant) -> Instant {
        self.drive.poll(now)
    }

    fn transmit(&mut self) -> Option<Frame> {
        self.answers.pop_front().or_else(|| self.drive.transmit())
    }
}

#[test]
fn a_data_sheet_that_the_device_holds_is_read_from_it() {
    // Plain text is read; what is packed in the way of a maker is not.
    for (format, expected) in [(0, "1021h of node 5"), (2, "the standard objects")] {
        let (mut bench, _) = Bench::with(DriveSetup::with_node_id(1, NODE), false);
        let product = Product::named("tc1").unwrap();
        let drive = product.drive(DriveSetup::with_node_id(2, OTHER));
        bench.bus().attach(WithSheet {
            drive,
            format,
            left: None,
            answers: VecDeque::new(),
        });
        bench.run_for(100);
        let Outcome::Done(Answer::Dictionary { title, entries }) =
            bench.order(Order::Dictionary { node: OTHER })
        else {
            panic!("no dictionary");
        };
        assert!(title.starts_with(expected), "{title}");
        let known = DataSheet::parse("tc1.eds", EDS).model().entries().count();
        assert_eq!(entries.len() == known, format == 0);
        bench.done(Order::Choose { node: OTHER });
        bench.run_for(200);
        assert!(bench.drive().answers);
    }
}
