//! Two masters ask one SDO server. Each hears the answers to the other, and takes none of them for its own.

use canopen::time::NEVER;
use canopen::{BitRate, Duration, Frame, Instant};
use master::Failure;
use master::bus::Station;
use master::bus::simulated::{Bus, Handle};
use master::scope::{Before, Recording, Request, Trigger, record};
use sim::Axis402;
use sim::drive::Setup;

use crate::bench::{Bench, refusal};

const POSITION: u32 = 0x6064_0020;

/// Reads the statusword, and switches between switch on disabled and ready to switch on.
const COMMANDS: [[u8; 8]; 3] = [
    [0x40, 0x41, 0x60, 0, 0, 0, 0, 0],
    [0x2B, 0x40, 0x60, 0, 0x06, 0, 0, 0],
    [0x2B, 0x40, 0x60, 0, 0x00, 0, 0, 0],
];

/// A master that asks node 4 again and again, so many times, and does not mind who else does.
#[derive(Debug)]
struct Other {
    requests: &'static [[u8; 8]],
    period: Duration,
    next: Instant,
    most: usize,
    asked: usize,
    due: bool,
    answers: usize,
    /// Answers that another master had asked for.
    strange: usize,
}

impl Other {
    fn new(requests: &'static [[u8; 8]], period: u64) -> Self {
        Self {
            requests,
            period: Duration::from_ticks(period),
            next: Instant::from_ticks(0),
            most: usize::MAX,
            asked: 0,
            due: false,
            answers: 0,
            strange: 0,
        }
    }
}

impl Station for Other {
    fn receive(&mut self, frame: &Frame, _now: Instant) {
        let is_answer = |request: &[u8; 8]| frame.payload()[1..4] == request[1..4];
        if frame.standard_id() != Some(0x584) {
            return;
        }
        if self.requests.iter().any(is_answer) {
            self.answers += 1;
        } else {
            self.strange += 1;
        }
    }

    fn poll(&mut self, now: Instant) -> Instant {
        if self.asked >= self.most {
            return NEVER;
        }
        if now >= self.next {
            self.next = now + self.period;
            self.due = true;
        }
        self.next
    }

    fn transmit(&mut self) -> Option<Frame> {
        if !std::mem::take(&mut self.due) {
            return None;
        }
        let request = self.requests[self.asked % self.requests.len()];
        self.asked += 1;
        Some(Frame::data_frame(0x604, &request))
    }
}

/// A drive of node-ID 4, and a master that sends these requests, and sends first where both masters want to.
fn with_other(requests: &'static [[u8; 8]], period: u64) -> (Bench, Handle<Other>) {
    let mut bus = Bus::new(BitRate::Kbit1000);
    let other = bus.attach(Other::new(requests, period));
    let mut bench = Bench::on(bus);
    bench.attach(Axis402::new(Setup::with_node_id(1, 4)));
    bench.master.run_for(Duration::from_ticks(10_000));
    (bench, other)
}

/// The other one has been asking all the time, and had its answers but for those on their way.
fn assert_served(bench: &Bench, other: Handle<Other>, least: usize) {
    let other = bench.master.station(other);
    assert!(other.asked >= least, "{other:?}");
    assert!(other.answers + 3 >= other.asked, "{other:?}");
}

#[test]
fn values_are_read_and_written_beside_another_master() {
    // None is a multiple of the time of an exchange.
    for period in [401, 733, 1_009] {
        let (mut bench, other) = with_other(&COMMANDS, period);
        for number in 1..=200_u32 {
            assert_eq!(bench.master.write(4, 0x6083, 0, number), Ok(()), "{period}");
            assert_eq!(bench.master.read(4, 0x6083, 0), Ok(number), "{period}");
        }
        assert_served(&bench, other, 100);
    }
}

#[test]
fn a_transfer_in_segments_is_begun_anew_when_another_master_has_ended_it() {
    let (mut bench, _) = Bench::with_drives(&[4]);
    let name = bench.master.read::<String>(4, 0x1008, 0).unwrap();
    assert!(name.len() > 4, "{name}");
    for period in [2_003, 3_001, 5_003] {
        let (mut bench, other) = with_other(&COMMANDS, period);
        for _ in 0..50 {
            assert_eq!(bench.master.read(4, 0x1008, 0), Ok(name.clone()));
        }
        assert_served(&bench, other, 15);
    }
}

#[test]
fn a_refusal_of_somebody_elses_request_is_not_ours() {
    // There is no 5000h.
    let (mut bench, other) = with_other(&[[0x40, 0x00, 0x50, 0, 0, 0, 0, 0]], 433);
    for _ in 0..200 {
        assert_eq!(bench.master.read(4, 0x1018, 4), Ok(1_u32));
    }
    let missing = bench.master.read::<u32>(4, 0x5001, 0);
    let refused = Failure::Abort {
        index: 0x5001,
        sub: 0,
        code: 0x0602_0000,
    };
    assert_eq!(missing, Err(refused));
    assert_served(&bench, other, 100);
}

#[test]
fn the_scope_records_while_another_master_commands_the_drive() {
    for period in [3_001, 7_001, 20_011] {
        let (mut bench, other) = with_other(&COMMANDS, period);
        // A recording of more than a sub-block needs a while without them.
        bench.master.station_mut(other).most = 40;
        let node = bench.meet(4);
        let request = Request {
            channels: Some(vec![POSITION]),
            divider: Some(1),
            samples: Some(400),
            before: Some(Before::Percent(25)),
            trigger: Trigger::parse("6041#0", &node.sheet).unwrap(),
            patience: Duration::from_ticks(5_000_000),
        };
        let recording: Recording = bench
            .run(|master, console| record(master, &node, &request, console))
            .unwrap();
        assert_eq!(recording.count() - recording.before, 300, "{period}");
        assert_served(&bench, other, 20);
    }
}

/// All of its memory, and no request for it meets one of the other master.
#[test]
fn a_server_of_its_own_keeps_the_scope_apart() {
    let (mut bench, other) = with_other(&COMMANDS, 1_501);
    let node = bench.meet(4);
    let refused = refusal(bench.run(|master, _| node.use_sdo_server(master, 2)));
    let why = "node 4: SDO server 2 has no identifiers; 1201h:01 and :02 take two that no other device uses";
    assert_eq!(refused, (why.to_owned(), 1));
    let refused = refusal(bench.run(|master, _| node.use_sdo_server(master, 9)));
    assert_eq!(
        refused,
        ("node 4 has no SDO server 9: 1208h is missing".to_owned(), 1)
    );
    bench.master.write(4, 0x1201, 1, 0x680_u32).unwrap();
    bench.master.write(4, 0x1201, 2, 0x681_u32).unwrap();
    bench
        .run(|master, _| node.use_sdo_server(master, 2))
        .unwrap();
    let strange = bench.master.station(other).strange;
    let request = Request {
        channels: Some(vec![POSITION]),
        divider: Some(1),
        samples: Some(0),
        before: Some(Before::Percent(0)),
        trigger: Trigger::parse("6041#0", &node.sheet).unwrap(),
        patience: Duration::from_ticks(20_000_000),
    };
    let recording: Recording = bench
        .run(|master, console| record(master, &node, &request, console))
        .unwrap();
    assert_eq!(recording.count(), 5_120);
    assert_served(&bench, other, 3_000);
    assert_eq!(bench.master.station(other).strange, strange);
}

/// A device of node-ID 4 that carries out what it is written, but whose answers are heard as those to somebody else.
#[derive(Debug, Default)]
struct Deaf {
    writes: u32,
    due: bool,
}

impl Station for Deaf {
    fn receive(&mut self, frame: &Frame, _now: Instant) {
        if frame.standard_id() == Some(0x604) {
            self.writes += 1;
            self.due = true;
        }
    }

    fn poll(&mut self, _now: Instant) -> Instant {
        NEVER
    }

    fn transmit(&mut self) -> Option<Frame> {
        let answer = [0x4B, 0x41, 0x60, 0, 0x40, 0, 0, 0];
        std::mem::take(&mut self.due).then(|| Frame::data_frame(0x584, &answer))
    }
}

/// It may have been carried out, and twice is not once: an order to the scope drops what has been recorded.
#[test]
fn a_write_without_an_answer_is_not_repeated() {
    let mut bus = Bus::new(BitRate::Kbit1000);
    let device = bus.attach(Deaf::default());
    let mut bench = Bench::on(bus);
    let written = bench.master.write(4, 0x20D0, 1, 1_u8);
    assert!(
        matches!(written, Err(Failure::Unexpected { .. })),
        "{written:?}"
    );
    assert_eq!(bench.master.station(device).writes, 1);
}
