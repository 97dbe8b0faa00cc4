//! The longest paths: the most instructions that one call of the device has cost.
//!
//! Ten thousand frames and pauses, most of them nearly right, from a generator with a fixed seed. A bound by search is no
//! proof, but what nobody thought of shows here first.

use canopen::cia301::emergency::Emergency;
use canopen::cia301::nmt::Reset;
use canopen::od::Dictionary as _;
use canopen::{BitRate, Duration, Event, Frame, Instant, Node, NodeId, Settings};

use crate::device::Dictionary;
use crate::{count, row};

const NODE_ID: u8 = 10;

/// Frames and pauses.
const STEPS: u32 = 10_000;

/// A generator of numbers that look random (xorshift by Marsaglia, 32 bits).
struct Random(u32);

impl Random {
    fn next(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0
    }

    fn below(&mut self, end: usize) -> usize {
        self.next() as usize % end
    }

    fn one_of<T: Copy>(&mut self, values: &[T]) -> T {
        values[self.below(values.len())]
    }

    fn bytes(&mut self) -> [u8; 8] {
        let (low, high) = (u64::from(self.next()), u64::from(self.next()));
        (low | high << 32).to_le_bytes()
    }
}

/// Command specifiers of requests, of all protocols.
const COMMANDS: [u8; 24] = [
    0x40, 0x60, 0x70, 0x20, 0x21, 0x22, 0x23, 0x2B, 0x2F, 0x00, 0x10, 0x01, 0x11, 0x0F, 0x80, 0xA0,
    0xA4, 0xA3, 0xA2, 0xA1, 0xC2, 0xC6, 0x81, 0xC1,
];

/// The most that a call of each kind has cost.
#[derive(Default)]
struct Longest {
    receive: u32,
    poll: u32,
    transmit: u32,
    report: u32,
    boot: u32,
}

struct Run {
    node: Node<Dictionary>,
    now: Instant,
    random: Random,
    longest: Longest,
}

impl Run {
    /// A frame for the device, nearly right.
    fn frame(&mut self) -> Frame {
        let own = u16::from(NODE_ID);
        let random = &mut self.random;
        let data = random.bytes();
        match random.below(16) {
            0..=6 => {
                let entry =
                    &Dictionary::TABLE.entries[random.below(Dictionary::TABLE.entries.len())];
                let [low, high] = entry.index.to_le_bytes();
                let size = (entry.size().clamp(1, 4) as u8 - 1) & 3;
                let command = if random.below(2) == 0 {
                    0x23 | (3 - size) << 2
                } else {
                    random.one_of(&COMMANDS)
                };
                let mut request = [command, low, high, entry.sub, data[0], 0, 0, 0];
                if random.below(4) == 0 {
                    request[4..].copy_from_slice(&data[..4]);
                }
                Frame::full(0x600 + own, request)
            }
            7..=8 => Frame::full(0x600 + own, data),
            9 => {
                let command = random.one_of(&[1, 1, 1, 1, 2, 0x80, 0x81, 0x82]);
                Frame::data_frame(0, &[command, NODE_ID])
            }
            10..=11 => Frame::data_frame(0x080, &data[..random.below(2)]),
            12..=13 => {
                let id = random.one_of(&[0x200, 0x300, 0x400, 0x500, 0x180, 0x700]) + own;
                Frame::data_frame(id, &data[..random.below(9)])
            }
            14 => Frame::full(0x7E5, data),
            _ => Frame::remote_frame(random.one_of(&[0x180, 0x280, 0x700]) + own, 8),
        }
    }

    fn step(&mut self) {
        let pause = self.random.one_of(&[0, 50, 500, 1_000, 20_000, 1_100_000]);
        self.now += Duration::from_ticks(pause);
        let frame = self.frame();
        let (cost, ()) = count(|| self.node.receive(&frame, self.now, &mut ()));
        self.longest.receive = self.longest.receive.max(cost);
        if self.random.below(50) == 0 {
            let number = self.random.next() as u8 & 31;
            let emergency = Emergency {
                code: 0xFF00 + u16::from(number),
                register: number,
                info: [number; 5],
            };
            let (cost, ()) = count(|| self.node.report(emergency, self.now));
            self.longest.report = self.longest.report.max(cost);
        }
        let dictionary = self.node.dictionary_mut();
        let number = self.random.next();
        dictionary.set_sent_number_1(number);
        dictionary.set_sent_number_2(!number);
        let (cost, _) = count(|| self.node.poll(self.now, &mut ()));
        self.longest.poll = self.longest.poll.max(cost);
        for _ in 0..self.random.below(12) {
            let (cost, frame) = count(|| self.node.transmit(&mut ()));
            self.longest.transmit = self.longest.transmit.max(cost);
            if frame.is_none() {
                break;
            }
        }
        while let Some(event) = self.node.event() {
            match event {
                Event::ResetRequested(reset) => self.boot(reset),
                Event::StoreSettings(_) => self.node.settings_stored(Ok(())),
                _ => {}
            }
        }
    }

    fn boot(&mut self, reset: Reset) {
        let (cost, ()) = count(|| self.node.boot(reset, self.now, &mut ()));
        self.longest.boot = self.longest.boot.max(cost);
    }
}

/// Searches, and prints the rows.
pub fn run() {
    let settings = Settings {
        node_id: NodeId::new(NODE_ID).unwrap(),
        bit_rate: BitRate::Kbit1000,
    };
    let mut run = Run {
        node: Node::new(Dictionary::new(), settings),
        now: Instant::from_ticks(0),
        random: Random(402),
        longest: Longest::default(),
    };
    run.boot(Reset::Node);
    for _ in 0..STEPS {
        run.step();
    }
    let Longest {
        receive,
        poll,
        transmit,
        report,
        boot,
    } = run.longest;
    row("receive", receive);
    row("poll", poll);
    row("transmit", transmit);
    row("report an error", report);
    row("boot", boot);
}
