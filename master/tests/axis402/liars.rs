//! Devices that do not end: what they send is stopped at a bound, and the bus is left as it should be.

use std::collections::VecDeque;

use canopen::time::NEVER;
use canopen::{Duration, Frame, Instant};
use master::axis402::{Group, Numbering, dump, find, number, save, scan};
use master::bus::Station;
use master::{Failure, LONGEST_UPLOAD};

use crate::bench::{Bench, refusal};

/// What a device answers to a frame.
type Answer = dyn FnMut(&Frame) -> Vec<Frame>;

/// A device of node-ID 4 that answers each frame to it, as a function says.
struct Liar {
    answer: Box<Answer>,
    answers: VecDeque<Frame>,
    aborts: usize,
}

impl Liar {
    fn new(answer: impl FnMut(&Frame) -> Vec<Frame> + 'static) -> Self {
        Self {
            answer: Box::new(answer),
            answers: VecDeque::new(),
            aborts: 0,
        }
    }
}

impl std::fmt::Debug for Liar {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Liar").finish_non_exhaustive()
    }
}

impl Station for Liar {
    fn receive(&mut self, frame: &Frame, _now: Instant) {
        self.aborts += usize::from(frame.payload().first() == Some(&0x80));
        self.answers.extend((self.answer)(frame));
    }

    fn poll(&mut self, _now: Instant) -> Instant {
        NEVER
    }

    fn transmit(&mut self) -> Option<Frame> {
        self.answers.pop_front()
    }
}

fn sdo(payload: [u8; 8]) -> Vec<Frame> {
    vec![Frame::data_frame(0x584, &payload)]
}

/// Reads 1008h of a liar with a limit of 2,000 bytes; returns the failure.
fn read(
    answer: fn(&Frame) -> Vec<Frame>,
    transfer: fn(&mut master::Master) -> Result<Vec<u8>, Failure>,
) -> Failure {
    let mut bench = Bench::new();
    let liar = bench.attach(Liar::new(answer));
    bench.master.set_longest_upload(2_000);
    let failure = transfer(&mut bench.master).unwrap_err();
    // What it has sent ahead goes first.
    bench.master.run_for(Duration::from_ticks(5_000_000));
    assert!(bench.master.station(liar).aborts > 0, "{failure}");
    let spent = bench.master.now().ticks();
    assert!(spent < 60_000_000, "{spent} µs");
    failure
}

/// Segments of 7 bytes, or empty ones, for ever.
fn segments(frame: &Frame, command: u8) -> Vec<Frame> {
    match frame.payload() {
        [0x40, low, high, sub, ..] => sdo([0x40, *low, *high, *sub, 0, 0, 0, 0]),
        [toggle @ (0x60 | 0x70), ..] => sdo([toggle & 0x10 | command, 0, 0, 0, 0, 0, 0, 0]),
        _ => Vec::new(),
    }
}

#[test]
fn an_upload_without_end_stops_at_a_bound() {
    let by_segments = |master: &mut master::Master| master.read::<Vec<u8>>(4, 0x1008, 0);
    let endless = read(|frame| segments(frame, 0), by_segments);
    assert_eq!(
        endless.to_string(),
        "1008h:00 does not end: stopped after 2000 bytes"
    );
    let empty = read(|frame| segments(frame, 0x0E), by_segments);
    assert!(matches!(empty, Failure::Endless { .. }), "{empty}");
    const { assert!(LONGEST_UPLOAD >= 1 << 20, "too little for a recording") };
}

#[test]
fn more_than_was_announced_is_not_taken() {
    let announced = |frame: &Frame| match frame.payload() {
        [0x40, low, high, sub, ..] => sdo([0x41, *low, *high, *sub, 20, 0, 0, 0]),
        _ => segments(frame, 0),
    };
    let longer = read(announced, |master| master.read::<Vec<u8>>(4, 0x1008, 0));
    assert_eq!(
        longer.to_string(),
        "1008h:00 does not end: stopped after 20 bytes"
    );
}

/// Sub-blocks of 127 segments for ever.
fn sub_blocks(frame: &Frame) -> Vec<Frame> {
    match frame.payload() {
        [0xA4, low, high, sub, ..] => sdo([0xC0, *low, *high, *sub, 0, 0, 0, 0]),
        [0xA3 | 0xA2, ..] => (1..=127)
            .map(|number| Frame::data_frame(0x584, &[number, 0, 0, 0, 0, 0, 0, 0]))
            .collect(),
        _ => Vec::new(),
    }
}

/// Segments that are never the next one, more than there is time for.
fn wrong_segments(frame: &Frame) -> Vec<Frame> {
    match frame.payload() {
        [0xA3 | 0xA2, ..] => vec![Frame::data_frame(0x584, &[5, 0, 0, 0, 0, 0, 0, 0]); 2_000],
        _ => sub_blocks(frame),
    }
}

#[test]
fn a_block_upload_without_end_stops_at_a_bound() {
    let by_blocks = |master: &mut master::Master| master.read_by_blocks(4, 0x1008, 0);
    let endless = read(sub_blocks, by_blocks);
    assert!(matches!(endless, Failure::Endless { .. }), "{endless}");
    let lost = read(wrong_segments, by_blocks);
    assert!(matches!(lost, Failure::Timeout { .. }), "{lost}");
}

#[test]
fn who_is_not_there_is_not_waited_for_as_long_as_a_save_takes() {
    let (mut bench, _) = Bench::with_drives(&[4]);
    let node = bench.meet(4);
    let absent = master::axis402::Node { id: 5, ..node };
    let before = bench.master.now();
    let refused = bench.run(|master, console| save(master, &absent, Group::All, console));
    assert_eq!(refusal(refused), ("node 5 does not answer".to_owned(), 1));
    let waited = bench.master.now() - before;
    assert!(waited < Duration::from_ticks(1_100_000), "{waited}");
}

#[test]
fn a_device_that_is_found_for_ever_is_found_twice() {
    let mut bench = Bench::new();
    // It says yes to every question of a fastscan, and never goes to configuration state.
    bench.attach(Liar::new(|frame| match frame.payload() {
        [0x51, ..] => vec![Frame::data_frame(0x7E4, &[0x4F, 0, 0, 0, 0, 0, 0, 0])],
        _ => Vec::new(),
    }));
    let (told, code) = refusal(bench.run(find));
    assert!(
        told.contains("does not end: stopped after 2 devices"),
        "{told}"
    );
    assert_eq!(code, 1);
}

fn yes() -> Vec<Frame> {
    vec![Frame::data_frame(0x7E4, &[0x4F, 0, 0, 0, 0, 0, 0, 0])]
}

/// Found by the fuzz target `master`: three scans end in nonsense, the fourth finds somebody new, and so on: 42 minutes for 127 devices.
#[test]
fn scans_that_are_misled_again_and_again_come_to_an_end() {
    let mut bench = Bench::new();
    let mut scan = 0;
    bench.attach(Liar::new(move |frame| match frame.payload() {
        [0x51, _, _, _, _, 0x80, ..] => {
            scan += 1;
            yes()
        }
        // The serial number is all but right in three of four scans.
        [0x51, _, _, _, _, 0, 3, 0] if scan % 4 != 0 => Vec::new(),
        [0x51, number @ .., bit, sub, _] => {
            let word = u32::from_le_bytes(number.try_into().unwrap());
            let own = if *sub == 3 { scan / 4 } else { 0 };
            if (own ^ word) >> bit == 0 {
                yes()
            } else {
                Vec::new()
            }
        }
        _ => Vec::new(),
    }));
    let (told, code) = refusal(bench.run(find));
    assert!(told.contains("expected a slave with"), "{told}");
    assert_eq!(code, 1);
    assert!(bench.output.lines().count() > 7, "{}", bench.output);
    let spent = bench.master.now().ticks();
    assert!(spent < 330_000_000, "{spent} µs");
}

#[test]
fn a_device_that_is_numbered_and_found_again_ends_the_numbering() {
    let mut bench = Bench::new();
    bench.attach(Liar::new(|frame| match frame.payload() {
        [0x51, ..] => yes(),
        [service @ (0x11 | 0x17), number, ..] => {
            let answer = Frame::data_frame(0x7E4, &[*service, 0, 0, 0, 0, 0, 0, 0]);
            let boot_up = Frame::data_frame(0x700 + u16::from(*number), &[0]);
            vec![answer, boot_up]
        }
        _ => Vec::new(),
    }));
    let all = Numbering {
        first: 1,
        store: false,
    };
    let (told, _) = refusal(bench.run(|master, console| number(master, all, console)));
    assert!(told.contains("stopped after 2 devices"), "{told}");
}

#[test]
fn whatever_a_device_sends_a_command_ends_when_its_time_is_up() {
    let mut bench = Bench::new();
    let limit = Duration::from_ticks(20_000_000);
    // Every object has four megabytes.
    bench.attach(Liar::new(|frame| segments(frame, 0)));
    let node = master::axis402::Node {
        id: 4,
        sheet: master::data_sheet::DataSheet::standard(),
    };
    bench.master.set_time_limit(limit);
    let (told, code) = refusal(bench.run(|master, console| dump(master, &node, true, console)));
    assert_eq!((told.as_str(), code), ("no end after 20 s: stopped", 1));
    let aborted = bench.master.now();
    bench.master.run_for(Duration::from_ticks(10_000));
    bench.master.set_time_limit(limit);
    assert_eq!(refusal(bench.run(scan)).0, "no end after 20 s: stopped");
    assert!(bench.master.now() - aborted < limit + limit);
}

#[test]
fn answers_of_lss_that_never_end_keep_nobody_waiting() {
    let mut bench = Bench::new();
    bench.attach(Liar::new(|frame| match frame.payload() {
        [0x13, ..] => vec![Frame::data_frame(0x7E4, &[0x13, 0, 0, 0, 0, 0, 0, 0]); 100_000],
        _ => Vec::new(),
    }));
    let within = Duration::from_ticks(50_000);
    let request = [0x13, 0, 0, 0, 0, 0, 0, 0];
    let answers = bench.master.lss_ask_all(request, usize::MAX, within);
    assert!(answers.unwrap().len() > 100);
    assert!(bench.master.now().ticks() < 60_000);
}
