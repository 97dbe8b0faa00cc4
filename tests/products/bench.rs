//! A product alone on a bus, frame by frame, on virtual time.

use std::collections::VecDeque;

use canopen::{Duration, Frame, Instant};
use sim::drive::Setup;
use sim::products::{Drive, Product};

/// From a look at the drive to the next.
const STEP: Duration = Duration::from_ticks(100);

/// How long an SDO answer may take; 1010h writes flash.
const ANSWER_TIME: u32 = 5_000;

pub struct Bench {
    pub drive: Box<dyn Drive>,
    now: Instant,
    /// What the drive has sent and nobody has looked at.
    pub sent: VecDeque<Frame>,
}

impl Bench {
    /// A product with power; its boot-up message waits.
    pub fn new(product: &str, setup: Setup) -> Self {
        let product = Product::named(product).expect("a product");
        let mut bench = Self {
            drive: product.drive(setup),
            now: Instant::from_ticks(0),
            sent: VecDeque::new(),
        };
        bench.run(20);
        bench
    }

    /// The same with a node-ID, whatever the product leaves the factory with.
    pub fn node(product: &str, node_id: u8) -> Self {
        Self::new(product, Setup::with_node_id(1, node_id))
    }

    /// Lets so many milliseconds pass.
    pub fn run(&mut self, milliseconds: u32) {
        let end = self.now + Duration::from_ticks(u64::from(milliseconds) * 1_000);
        while self.now < end {
            self.tick();
        }
    }

    /// Lets a tenth of a millisecond pass.
    pub fn tick(&mut self) {
        self.now += STEP;
        self.drive.poll(self.now);
        self.collect();
    }

    fn collect(&mut self) {
        while let Some(frame) = self.drive.transmit() {
            self.sent.push_back(frame);
            self.drive.poll(self.now);
        }
    }

    pub fn send(&mut self, frame: &Frame) {
        self.drive.receive(frame, self.now);
        self.drive.poll(self.now);
        self.collect();
    }

    /// The next frame with this identifier, within so many milliseconds; others are passed over.
    pub fn next(&mut self, cob_id: u16, within: u32) -> Option<Frame> {
        for _ in 0..within * 10 {
            while let Some(frame) = self.sent.pop_front() {
                if frame.standard_id() == Some(cob_id) {
                    return Some(frame);
                }
            }
            self.now += STEP;
            self.drive.poll(self.now);
            self.collect();
        }
        None
    }

    /// The answer to an SDO request.
    pub fn sdo(&mut self, node: u8, request: [u8; 8]) -> [u8; 8] {
        let (request_id, answer_id) = (0x600 + u16::from(node), 0x580 + u16::from(node));
        self.sent
            .retain(|frame| frame.standard_id() != Some(answer_id));
        self.send(&Frame::full(request_id, request));
        let answer = self.next(answer_id, ANSWER_TIME).expect("an SDO answer");
        *answer.full_payload().unwrap()
    }

    /// Writes the whole of an object; `value` has its length.
    pub fn write(&mut self, node: u8, index: u16, sub: u8, value: &[u8]) {
        let [low, high] = index.to_le_bytes();
        let mut request = [
            0x23 | ((4 - value.len() as u8) << 2),
            low,
            high,
            sub,
            0,
            0,
            0,
            0,
        ];
        request[4..4 + value.len()].copy_from_slice(value);
        let answer = self.sdo(node, request);
        assert_eq!(answer[0], 0x60, "{index:04X}h:{sub}: {answer:02X?}");
    }

    /// The number in an object, as its four bytes.
    pub fn read(&mut self, node: u8, index: u16, sub: u8) -> u32 {
        let [low, high] = index.to_le_bytes();
        let answer = self.sdo(node, [0x40, low, high, sub, 0, 0, 0, 0]);
        assert_eq!(answer[0] & 0xE3, 0x43, "{index:04X}h:{sub}: {answer:02X?}");
        u32::from_le_bytes([answer[4], answer[5], answer[6], answer[7]])
    }

    /// Looks at the statusword until it is this under the mask.
    pub fn wait_for_status(&mut self, node: u8, mask: u16, value: u16, milliseconds: u32) {
        for _ in 0..milliseconds / 5 {
            if self.read(node, 0x6041, 0) as u16 & mask == value {
                return;
            }
            self.run(5);
        }
        let status = self.read(node, 0x6041, 0);
        panic!("statusword {status:04X}h, and not {value:04X}h under {mask:04X}h");
    }

    /// Through the states to operation enabled.
    pub fn enable(&mut self, node: u8) {
        for (controlword, state) in [(0x06_u16, 0x21), (0x07, 0x23), (0x0F, 0x27)] {
            self.write(node, 0x6040, 0, &controlword.to_le_bytes());
            self.wait_for_status(node, 0x6F, state, 1_000);
        }
    }
}
