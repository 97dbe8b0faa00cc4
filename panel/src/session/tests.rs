//! The session with a virtual drive, on virtual time: what windows order, and what the bus sees.

mod bus;
mod modes;
mod pages;
mod safety;
mod stored_sheet;
mod tuning;

use std::sync::mpsc::{SyncSender, channel, sync_channel};

use canopen::{BitRate, Frame};
use master::bus::Station;
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
        Self::with_station(Axis402::new(drive), read_only)
    }

    fn with_station<S: Station>(drive: S, read_only: bool) -> (Self, Handle<S>) {
        let mut master = Master::new(Bus::new(BitRate::Kbit1000));
        master.set_answer_time(milliseconds(1_000));
        let drive = master.bus_mut().attach(drive);
        master.run_for(milliseconds(20));
        let desk = Arc::new(Desk::default());
        let (tickets, orders) = sync_channel(8);
        let setup = Setup {
            title: "simulated".to_owned(),
            is_virtual: false,
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
            counts: self.desk.counts(),
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
    bench.done(go(3_000, Some(20_000)));
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
        acceleration: Some(50_000),
        deceleration: Some(60_000),
    });
    bench.run_for(1_000);
    assert_eq!(bench.drive().position, Some(2_500));
    assert_eq!(bench.done(read("6083")), "50000");
    assert_eq!(bench.done(read("6084")), "60000");
    assert_eq!(bench.drive().units, ["steps", "steps/s", "steps/s²"]);
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
fn nothing_of_a_fresh_drive_is_marked_as_changed() {
    let mut bench = Bench::chosen();
    let Outcome::Done(Answer::Dictionary { entries, .. }) =
        bench.order(Order::Dictionary { node: NODE })
    else {
        panic!("no dictionary");
    };
    let mut compared = 0;
    let mut changed = Vec::new();
    for entry in entries {
        if !entry.readable || !entry.writable || entry.data_type == "DOMAIN" {
            continue;
        }
        if let Some(default) = entry.default {
            let value = bench.done(read(&entry.address));
            compared += 1;
            if value != default {
                changed.push(format!("{}: {value}, {default}", entry.address));
            }
        }
    }
    assert!(compared > 200, "{compared}");
    assert_eq!(changed, [""; 0]);
    assert_eq!(bench.done(read("1400:1")), "0x204");
    assert_eq!(bench.done(read("1800:1")), "0x40000184");
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

fn go(target: i32, velocity: Option<u32>) -> Order {
    Order::Move {
        target,
        relative: false,
        velocity,
        acceleration: None,
        deceleration: None,
    }
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
