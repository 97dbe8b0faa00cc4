//! The session with a virtual drive, on virtual time: what windows order, and what the bus sees.

mod pages;

use std::sync::mpsc::{SyncSender, channel, sync_channel};

use canopen::{BitRate, Frame};
use master::bus::simulated::{Bus, Handle, Interference, Logged};
use master::{NmtCommand, Simulated};
use sim::Axis402;
use sim::drive::Setup as DriveSetup;

use super::*;
use crate::fsa::{DriveState, Transition};
use crate::message::Guard;

/// The node-ID of the drive.
const NODE: u8 = 4;

/// The station of the panel and that of the drive.
const PANEL: usize = 0;

struct Bench {
    session: Session<Simulated>,
    desk: Arc<Desk>,
    tickets: SyncSender<Ticket>,
    window: u64,
}

impl Bench {
    fn with(drive: DriveSetup, read_only: bool) -> (Self, Handle<Axis402>) {
        let mut master = Master::new(Bus::new(BitRate::Kbit1000));
        master.set_answer_time(milliseconds(1_000));
        let drive = master.bus_mut().attach(Axis402::new(drive));
        master.run_for(milliseconds(20));
        let desk = Arc::new(Desk::default());
        let (tickets, orders) = sync_channel(8);
        let setup = Setup {
            title: "simulated".to_owned(),
            bit_rate: Some(1_000_000),
            read_only,
            own_node: 127,
            sheets: Vec::new(),
            notice: None,
        };
        let session = Session::new(master, Arc::clone(&desk), orders, Outlet::new(), setup);
        let window = desk.open();
        let bench = Self {
            session,
            desk,
            tickets,
            window,
        };
        (bench, drive)
    }

    /// With a drive that has a node-ID and is chosen.
    fn chosen() -> Self {
        let (mut bench, _) = Self::with(DriveSetup::with_node_id(1, NODE), false);
        bench.done(Order::Choose { node: NODE });
        bench
    }

    fn enabled() -> Self {
        let mut bench = Self::chosen();
        bench.done(Order::Enable);
        assert_eq!(bench.drive_state(), Some(DriveState::OperationEnabled));
        bench
    }

    fn bus(&mut self) -> &mut Bus {
        self.session.master_mut().line_mut().inner_mut().bus_mut()
    }

    /// Orders something, and runs until it is answered.
    fn order_of(&mut self, window: u64, order: Order) -> Outcome {
        let (reply, outcome) = channel();
        let ticket = Ticket {
            window,
            order,
            releases: self.desk.counts().releases,
            reply: Box::new(move |outcome| reply.send(outcome).unwrap()),
        };
        self.tickets.try_send(ticket).unwrap();
        loop {
            assert_eq!(self.session.pass(), Ok(true));
            if let Ok(outcome) = outcome.try_recv() {
                return outcome;
            }
        }
    }

    fn order(&mut self, order: Order) -> Outcome {
        self.order_of(self.window, order)
    }

    fn done(&mut self, order: Order) -> String {
        match self.order(order.clone()) {
            Outcome::Done(Answer::Text(text)) => text,
            other => panic!("{order:?}: {other:?}"),
        }
    }

    fn refused(&mut self, order: Order) -> String {
        match self.order(order.clone()) {
            Outcome::Error(why) => why,
            done => panic!("{order:?}: {done:?}"),
        }
    }

    /// Lets the session live for so long.
    fn run_for(&mut self, count: u64) {
        let end = self.session.master_mut().now() + milliseconds(count);
        while self.session.master_mut().now() < end {
            assert_eq!(self.session.pass(), Ok(true));
        }
    }

    fn drive(&self) -> &crate::message::Drive {
        self.session.state().drive.as_ref().unwrap()
    }

    fn drive_state(&mut self) -> Option<DriveState> {
        self.run_for(200);
        self.drive().state
    }

    /// When the panel wrote this number to this object by an expedited transfer.
    fn written(&mut self, index: u16, sub: u8, value: u32) -> Option<Instant> {
        let [low, high] = index.to_le_bytes();
        let is = |logged: &&Logged| match logged.frame.payload() {
            [command, a, b, c, rest @ ..] if command & 0xE3 == 0x23 => {
                let number = rest
                    .iter()
                    .rev()
                    .fold(0, |sum, byte| sum << 8 | u32::from(*byte));
                logged.sender == PANEL && [*a, *b, *c] == [low, high, sub] && number == value
            }
            _ => false,
        };
        self.bus().trace().iter().find(is).map(|logged| logged.at)
    }
}

fn milliseconds(count: u64) -> Duration {
    Duration::from_ticks(count * 1_000)
}

#[test]
fn a_drive_without_a_node_id_makes_a_move() {
    let (mut bench, _) = Bench::with(DriveSetup::unconfigured(0xC0FFEE), false);
    assert_eq!(bench.done(Order::Scan), "no node answers");
    assert_eq!(bench.session.state().bus.unnumbered, Some(true));
    let numbered = bench.done(Order::Number {
        first: NODE,
        store: true,
    });
    assert_eq!(numbered, "1 device has a node-ID now");
    bench.run_for(100);
    assert_eq!(bench.session.state().bus.unnumbered, Some(false));
    let node = &bench.session.state().nodes[0];
    assert_eq!((node.id, node.is_drive), (NODE, true));
    assert_eq!(
        node.identity.as_deref(),
        Some("00000000:00000402:00010000:00C0FFEE")
    );
    bench.done(Order::Choose { node: NODE });
    assert_eq!(bench.drive_state(), Some(DriveState::SwitchOnDisabled));
    bench.done(Order::Enable);
    bench.run_for(50);
    assert_eq!(bench.drive().guard, Guard::On);
    bench.done(Order::Move {
        target: 3_000,
        relative: false,
        velocity: Some(20_000),
    });
    bench.run_for(2_000);
    assert_eq!(
        (bench.drive().position, bench.drive().velocity),
        (Some(3_000), Some(0))
    );
    let words = bench.drive().statusword.clone().unwrap().words;
    assert_eq!(words, "operation enabled, target reached");
    bench.done(Order::Move {
        target: -500,
        relative: true,
        velocity: None,
    });
    bench.run_for(1_000);
    assert_eq!(bench.drive().position, Some(2_500));
    assert_eq!(bench.drive().units, ["steps", "steps/s"]);
}

#[test]
fn a_jog_ends_when_it_is_released_and_when_beats_stay_away() {
    let mut bench = Bench::enabled();
    for is_released in [true, false] {
        bench.bus().take_trace();
        bench.done(Order::Jog { velocity: 4_000 });
        for _ in 0..10 {
            bench.run_for(50);
            bench.desk.beat();
        }
        assert!(bench.drive().jogging);
        assert_eq!(bench.drive().velocity, Some(4_000));
        assert_eq!(bench.written(0x6040, 0, 0x10F), None);
        if is_released {
            bench.desk.release();
        }
        let last = bench.session.master_mut().now();
        bench.run_for(500);
        let halted = bench.written(0x6040, 0, 0x10F).unwrap();
        let bound = if is_released { 20 } else { 200 };
        let took = halted.checked_duration_since(last).unwrap();
        assert!(took <= milliseconds(bound), "{took}");
        assert!(
            is_released || took >= milliseconds(100),
            "it ended by itself: {took}"
        );
        assert!(!bench.drive().jogging);
        assert_eq!(bench.drive().velocity, Some(0));
        // The drive is still enabled, and a move follows.
        bench.done(Order::Move {
            target: 0,
            relative: false,
            velocity: None,
        });
        bench.run_for(3_000);
        assert_eq!(bench.drive().position, Some(0));
    }
}

#[test]
fn a_button_that_is_up_again_moves_nothing() {
    let mut bench = Bench::enabled();
    let (reply, outcome) = channel();
    let ticket = Ticket {
        window: bench.window,
        order: Order::Jog { velocity: 4_000 },
        releases: bench.desk.counts().releases,
        reply: Box::new(move |outcome| reply.send(outcome).unwrap()),
    };
    bench.tickets.try_send(ticket).unwrap();
    bench.desk.release();
    bench.bus().take_trace();
    bench.run_for(300);
    assert_eq!(
        outcome.try_recv().unwrap(),
        Outcome::Done(Answer::Text("released".to_owned()))
    );
    assert_eq!(bench.written(0x60FF, 0, 4_000), None);
}

#[test]
fn a_stop_waits_for_no_answer() {
    let mut bench = Bench::enabled();
    bench.done(Order::Jog { velocity: 4_000 });
    // An answer is lost: its request would be waited for.
    let mut lost = false;
    bench.bus().interfere(move |logged| {
        let is_answer = logged.frame.standard_id() == Some(0x580 + u16::from(NODE));
        if is_answer && !lost {
            lost = true;
            return Interference::Lose;
        }
        Interference::None
    });
    bench.desk.beat();
    let (reply, outcome) = channel();
    let ticket = Ticket {
        window: bench.window,
        order: Order::Read {
            node: NODE,
            object: "1008".to_owned(),
        },
        releases: 0,
        reply: Box::new(move |outcome| reply.send(outcome).unwrap()),
    };
    bench.tickets.try_send(ticket).unwrap();
    bench.bus().take_trace();
    let at = bench.session.master_mut().now();
    bench.desk.stop();
    bench.run_for(100);
    let stopped = bench.written(0x6040, 0, 0x02).unwrap();
    assert!(stopped.checked_duration_since(at).unwrap() <= milliseconds(10));
    drop(outcome);
    assert_eq!(bench.drive_state(), Some(DriveState::SwitchOnDisabled));
    assert_eq!(bench.drive().velocity, Some(0));
    assert_eq!(bench.session.state().notice, None);
}

#[test]
fn a_stop_that_is_not_acknowledged_is_one_by_nmt() {
    let mut bench = Bench::enabled();
    bench
        .bus()
        .interfere(|logged| match logged.frame.standard_id() {
            Some(0x580..=0x5FF) => Interference::Lose,
            _ => Interference::None,
        });
    bench.bus().take_trace();
    bench.desk.stop();
    bench.run_for(1_000);
    let stop = Frame::data_frame(0, &[NmtCommand::Stop as u8, NODE]);
    assert!(
        bench
            .bus()
            .trace()
            .iter()
            .any(|logged| logged.frame == stop)
    );
    let notice = bench.session.state().notice.clone().unwrap();
    assert_eq!(
        notice,
        "the stop was not acknowledged (node 4 does not answer); node 4 was stopped by NMT"
    );
}

#[test]
fn the_last_window_that_closes_leaves_a_drive_that_stands_and_1016h_as_it_was() {
    let mut bench = Bench::enabled();
    assert_eq!(bench.done(read("1016:1")), "0x007F01F4");
    bench.done(Order::Move {
        target: 1_000_000,
        relative: false,
        velocity: Some(5_000),
    });
    bench.run_for(500);
    assert_eq!(bench.drive().velocity, Some(5_000));
    bench.desk.close(bench.window);
    bench.run_for(1_000);
    assert_eq!(bench.drive().velocity, Some(0));
    assert_eq!(bench.drive().state, Some(DriveState::SwitchOnDisabled));
    bench.window = bench.desk.open();
    assert_eq!(bench.done(read("1016:1")), "0");
    bench.run_for(1_000);
    assert_eq!(bench.drive().fault, None, "nobody misses the heartbeat");
}

#[test]
fn a_panel_that_dies_stops_the_drive() {
    let (mut bench, drive) = Bench::with(DriveSetup::with_node_id(1, NODE), false);
    bench.done(Order::Choose { node: NODE });
    bench.done(Order::Enable);
    bench.done(Order::Move {
        target: 1_000_000,
        relative: false,
        velocity: Some(5_000),
    });
    bench.run_for(1_500);
    assert_eq!(
        (bench.drive().velocity, bench.drive().fault.clone()),
        (Some(5_000), None)
    );
    // Nobody runs the session any more. The time is that of the bus.
    let bus = bench.bus();
    let heartbeat = |logged: &&Logged| logged.frame.standard_id() == Some(0x700 + 127);
    let last = bus.trace().iter().rfind(heartbeat).unwrap().at;
    bus.take_trace();
    bus.station_mut(drive).record_motion();
    bus.run_for(milliseconds(1_500));
    let missed = bus.trace().iter().find(|logged| {
        logged.frame.standard_id() == Some(0x080 + u16::from(NODE))
            && logged.frame.payload()[..2] == 0x8130u16.to_le_bytes()
    });
    let after = |at: Instant| at.checked_duration_since(last).unwrap();
    let missed = after(missed.unwrap().at);
    assert!(
        (milliseconds(500)..=milliseconds(505)).contains(&missed),
        "{missed}"
    );
    let samples = bus.station(drive).motion_samples();
    let end = samples.last().unwrap().position;
    let moving = samples
        .iter()
        .rfind(|sample| sample.position != end)
        .unwrap();
    // The heartbeat that is missed, and the ramp: 5,000 steps/s by 6085h.
    assert!(
        after(moving.at) <= milliseconds(800),
        "{}",
        after(moving.at)
    );
}

#[test]
fn a_panel_that_only_reads_sends_nothing_but_uploads() {
    let (mut bench, _) = Bench::with(DriveSetup::with_node_id(1, NODE), true);
    bench.bus().take_trace();
    bench.done(Order::Scan);
    bench.done(Order::Choose { node: NODE });
    bench.done(read("6064"));
    for order in [
        Order::Enable,
        Order::Number {
            first: 1,
            store: false,
        },
        Order::Jog { velocity: 1 },
        write("6083", "1"),
    ] {
        let why = bench.refused(order);
        assert_eq!(
            why,
            "the panel was started with --read-only: nothing is written"
        );
    }
    bench.desk.stop();
    bench.run_for(300);
    bench.desk.close(bench.window);
    bench.run_for(300);
    let mut sent = 0;
    for logged in bench.bus().take_trace() {
        if logged.sender == PANEL {
            let id = logged.frame.standard_id().unwrap();
            let command = logged.frame.payload()[0];
            assert!((0x601..=0x67F).contains(&id), "{:?}", logged.frame);
            // Initiate and upload segments, and the end of a question that nobody answered.
            assert!(matches!(command, 0x40 | 0x60 | 0x70), "{:?}", logged.frame);
            sent += 1;
        }
    }
    assert!(sent > 127, "{sent}");
}

#[test]
fn one_window_writes_and_the_others_watch() {
    let mut bench = Bench::chosen();
    let second = bench.desk.open();
    let refused = Outcome::Error("another window has control: take it first".to_owned());
    assert_eq!(bench.order_of(second, Order::Enable), refused);
    assert_eq!(bench.order_of(second, write("6083", "1000")), refused);
    assert!(matches!(
        bench.order_of(second, read("6064")),
        Outcome::Done(_)
    ));
    bench.desk.take(second);
    assert_eq!(bench.order(Order::Enable), refused);
    assert!(matches!(
        bench.order_of(second, write("6083", "1000")),
        Outcome::Done(_)
    ));
}

#[test]
fn what_is_written_is_checked_before_the_bus_sees_it() {
    let mut bench = Bench::chosen();
    bench.bus().take_trace();
    let refusals = [
        (
            write("6007", "4"),
            "6007h:00 Abort connection option code: 4 is above 3",
        ),
        (
            write("6064", "0"),
            "6064h:00 Position actual value: it can only be read",
        ),
        (write("6083", "fast"), "6083h:00 Profile acceleration: "),
    ];
    for (order, expected) in refusals {
        let why = bench.refused(order);
        assert!(why.starts_with(expected), "{why}");
    }
    let is_download = |logged: &Logged| {
        logged.sender == PANEL
            && logged
                .frame
                .payload()
                .first()
                .is_some_and(|byte| byte >> 5 == 1)
    };
    assert!(!bench.bus().trace().iter().any(is_download));
    assert_eq!(bench.done(write("profile acceleration", "50000")), "50000");
    // What the device refuses is told with its words.
    bench.done(Order::Enable);
    let why = bench.refused(write("608F:1", "1"));
    assert!(
        why.starts_with("node 4 refuses 608Fh:01 with 080000"),
        "{why}"
    );
}

#[test]
fn the_dictionary_is_that_of_the_data_sheet() {
    let mut bench = Bench::chosen();
    let Outcome::Done(Answer::Dictionary { title, entries }) =
        bench.order(Order::Dictionary { node: NODE })
    else {
        panic!("no dictionary");
    };
    assert_eq!(title, "axis402.eds");
    let entry = entries
        .iter()
        .find(|entry| entry.address == "6007h:00")
        .unwrap();
    assert_eq!(
        (entry.low.as_deref(), entry.high.as_deref()),
        (Some("0"), Some("3"))
    );
    assert_eq!((entry.data_type, entry.writable), ("INTEGER16", true));
}

#[test]
fn transitions_are_those_of_the_state() {
    let mut bench = Bench::chosen();
    bench.run_for(200);
    let legal = |bench: &Bench| {
        let ways = bench.drive().transitions.iter();
        ways.map(|way| way.number).collect::<Vec<_>>()
    };
    assert_eq!(legal(&bench), [2]);
    let why = bench.refused(transition(Transition::EnableOperation));
    assert_eq!(why, "Enable operation leads nowhere in this state");
    for (way, numbers) in [
        (Transition::Shutdown, vec![3, 7]),
        (Transition::SwitchOn, vec![4, 6, 10]),
        (Transition::EnableOperation, vec![5, 8, 9, 11]),
        (Transition::QuickStop, vec![2]),
    ] {
        bench.done(transition(way));
        bench.run_for(200);
        assert_eq!(legal(&bench), numbers, "{way:?}");
    }
}

#[test]
fn what_is_no_drive_is_told() {
    let (mut bench, _) = Bench::with(DriveSetup::with_node_id(1, NODE), false);
    assert_eq!(
        bench.refused(Order::Choose { node: 9 }),
        "node 9 does not answer"
    );
    assert_eq!(bench.refused(Order::Enable), "no drive is chosen");
    assert_eq!(bench.refused(read_of(0, "6064")), "a node-ID is 1 to 127");
}

#[test]
fn a_drive_that_vanishes_is_told_and_comes_back() {
    let mut bench = Bench::chosen();
    bench.run_for(100);
    assert!(bench.drive().answers);
    bench
        .bus()
        .interfere(|logged| match logged.frame.standard_id() {
            Some(0x580..=0x5FF) => Interference::Lose,
            _ => Interference::None,
        });
    bench.run_for(1_000);
    assert!(!bench.drive().answers);
    bench.bus().interfere(|_| Interference::None);
    bench.run_for(2_500);
    assert!(bench.drive().answers);
}

#[test]
fn frames_are_told_in_words_to_those_who_listen() {
    let mut bench = Bench::chosen();
    bench.run_for(200);
    let mut frames = bench.session.outlet.frames.subscribe();
    bench.run_for(100);
    let told = frames.try_recv().unwrap();
    assert!(told.contains("SDO read 6041h statusword"), "{told}");
    assert!(told.contains(r#""kind":"SDO""#), "{told}");
}

fn read(object: &str) -> Order {
    read_of(NODE, object)
}

fn read_of(node: u8, object: &str) -> Order {
    Order::Read {
        node,
        object: object.to_owned(),
    }
}

fn write(object: &str, value: &str) -> Order {
    Order::Write {
        node: NODE,
        object: object.to_owned(),
        value: value.to_owned(),
    }
}

fn transition(transition: Transition) -> Order {
    Order::Transition { transition }
}
