//! The master against a device that lies: whatever it answers, and however much it sends unasked, each command ends within a time, and is
//! never longer than what it may read.
#![no_main]

use std::collections::VecDeque;

use canopen::{BitRate, Duration, Frame, Instant};
use libfuzzer_sys::fuzz_target;
use master::Master;
use master::axis402::{Console, Group, Node, Numbering, Problem, dump, find, number, save, scan};
use master::bus::Station;
use master::bus::simulated::Bus;

/// The node-ID that the liar says it has.
const NODE: u8 = 4;

/// The longest object that is read, in bytes.
const LONGEST: usize = 500;

/// A command that may take so much time of the bus ends within it, and a while to put things right.
const LIMIT: Duration = Duration::from_ticks(1_200_000_000);
const WHILE: Duration = Duration::from_ticks(60_000_000);

/// The search for devices ends by itself: 128 fastscans of 133 questions, and 24 that are begun anew.
const SEARCH: Duration = Duration::from_ticks(330_000_000);

/// What it sends is said by bytes, which begin anew at their end.
#[derive(Debug)]
struct Liar {
    bytes: Vec<u8>,
    place: usize,
    answers: VecDeque<Frame>,
    /// When it speaks unasked.
    next: Instant,
}

impl Liar {
    fn next(&mut self) -> u8 {
        let byte = self.bytes.get(self.place).copied().unwrap_or_default();
        self.place = (self.place + 1) % self.bytes.len().max(1);
        byte
    }

    /// An answer to `asked`: as it should be but for some bytes, or anything.
    fn answer(&mut self, asked: &Frame) {
        let how = self.next();
        let cob_id = match asked.standard_id() {
            Some(0x7E5) => 0x7E4,
            _ if how & 0xC0 == 0xC0 => 0x700 + u16::from(NODE),
            _ => 0x580 + u16::from(NODE),
        };
        let mut data = [0; 8];
        data[..asked.payload().len()].copy_from_slice(asked.payload());
        data[0] = match (cob_id, data[0]) {
            (0x7E4, 0x4C) => 0x50,
            (0x7E4, 0x51 | 0x46..=0x4B) => 0x4F,
            (0x7E4, specifier) => specifier,
            (_, 0x40) => 0x43,
            (_, command @ (0x60 | 0x70)) => command & 0x10 | how & 0x0F,
            (_, 0xA4) => 0xC6,
            (_, 0xA3) => 0x01,
            (_, 0x21..=0x2F) => 0x60,
            (_, command) => command,
        };
        for bit in 0..6 {
            if how >> bit & 1 != 0 && bit < 2 {
                let place = self.next() & 7;
                data[usize::from(place)] = self.next();
            }
        }
        let length = if how & 0x30 == 0x30 {
            usize::from(self.next() & 7)
        } else {
            8
        };
        let count = if how & 0x0C == 0x0C {
            self.next() & 0x3F
        } else {
            1
        };
        for number in 0..count {
            // Segments of a block count.
            if how & 0x08 != 0 {
                data[0] = data[0].wrapping_add(number);
            }
            self.answers
                .push_back(Frame::data_frame(cob_id, &data[..length]));
        }
    }
}

impl Station for Liar {
    fn receive(&mut self, frame: &Frame, _now: Instant) {
        self.answer(frame);
    }

    fn poll(&mut self, now: Instant) -> Instant {
        if now >= self.next {
            let pause = self.next();
            let (low, high) = (self.next(), self.next());
            let cob_id = u16::from_le_bytes([low, high]) & 0x7FF;
            let data = [self.next(); 8];
            self.answers.push_back(Frame::data_frame(cob_id, &data));
            self.next = now + Duration::millis(1 + u64::from(pause));
        }
        self.next
    }

    fn transmit(&mut self) -> Option<Frame> {
        self.answers.pop_front()
    }
}

fuzz_target!(|bytes: &[u8]| {
    let (first, rest) = bytes.split_first().unwrap_or((&0, &[]));
    let mut master = Master::new(Bus::new(BitRate::Kbit1000));
    master.bus_mut().attach(Liar {
        bytes: rest.to_vec(),
        place: 0,
        answers: VecDeque::new(),
        next: Instant::from_ticks(if first & 0x80 == 0 { u64::MAX } else { 1_000 }),
    });
    master.set_longest_upload(LONGEST);
    master.set_time_limit(LIMIT);
    let (mut output, mut progress) = (Vec::new(), Vec::new());
    let mut console = Console::new(&mut output, &mut progress, false);
    match first & 7 {
        0 => {
            let read = master.read::<Vec<u8>>(NODE, 0x1008, 0);
            assert!(read.map_or(0, |bytes| bytes.len()) <= LONGEST);
        }
        1 => {
            let read = master.read_by_blocks(NODE, 0x1008, 0);
            assert!(read.map_or(0, |bytes| bytes.len()) <= LONGEST);
        }
        2 => drop(master.download_segmented(NODE, 0x1008, 0, &[0x55; 300])),
        3 => drop(find(&mut master, &mut console)),
        4 => drop(number(
            &mut master,
            Numbering {
                first: 1,
                store: true,
            },
            &mut console,
        )),
        5 => drop(scan(&mut master, &mut console)),
        6 => drop(
            meet(&mut master).and_then(|node| save(&mut master, &node, Group::All, &mut console)),
        ),
        _ => drop(meet(&mut master).and_then(|node| dump(&mut master, &node, false, &mut console))),
    }
    let spent = master.now() - Instant::from_ticks(0);
    let bound = if first & 7 == 3 {
        SEARCH
    } else {
        LIMIT + WHILE
    };
    assert!(spent < bound, "{spent}");
});

fn meet(master: &mut Master) -> Result<Node, Problem> {
    Node::meet(master, NODE, None)
}
