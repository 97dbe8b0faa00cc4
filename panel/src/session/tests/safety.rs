//! What keeps a person safe: stop, jog, the guard by 1016h, the last window.

use super::*;
use crate::desk::Counts;
use crate::message::NmtOrder;

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
        bench.done(go(0, None));
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
        counts: bench.desk.counts(),
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
fn an_order_that_a_stop_has_overtaken_moves_nothing() {
    let mut bench = Bench::chosen();
    for order in [Order::Enable, go(1_000, None), Order::Home] {
        let (reply, outcome) = channel();
        let ticket = Ticket {
            window: bench.window,
            order,
            counts: bench.desk.counts(),
            reply: Box::new(move |outcome| reply.send(outcome).unwrap()),
        };
        bench.tickets.try_send(ticket).unwrap();
        bench.desk.stop();
        bench.run_for(300);
        assert_eq!(
            outcome.try_recv().unwrap(),
            Outcome::Error("a stop came behind it: it was not begun".to_owned())
        );
        assert_eq!(bench.drive().state, Some(DriveState::SwitchOnDisabled));
    }
    // The next one counts again.
    bench.done(Order::Enable);
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
        counts: Counts::default(),
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
fn a_stop_without_an_open_drive_says_that_it_stops_nothing() {
    let (mut bench, _) = Bench::with(DriveSetup::with_node_id(1, NODE), false);
    bench.desk.stop();
    bench.run_for(100);
    let notice = bench.session.state().notice.clone().unwrap();
    assert!(notice.starts_with("nothing was stopped: no drive is open"));
    bench.done(Order::Choose { node: NODE });
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
    bench.done(go(1_000_000, Some(5_000)));
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
    bench.done(go(1_000_000, Some(5_000)));
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
fn a_drive_that_starts_anew_is_guarded_anew() {
    let mut bench = Bench::enabled();
    bench.done(Order::Nmt {
        command: NmtOrder::Reset,
        node: NODE,
    });
    bench.run_for(500);
    assert_eq!(bench.drive().state, Some(DriveState::SwitchOnDisabled));
    assert_eq!(bench.drive().guard, Guard::Off);
    assert_eq!(bench.done(read("1016:1")), "0");
    bench.done(Order::Enable);
    bench.run_for(100);
    assert_eq!(bench.drive().guard, Guard::On);
    assert_eq!(bench.done(read("1016:1")), "0x007F01F4");
    // The panel says that it is there again, else the drive had a fault.
    bench.run_for(2_000);
    assert_eq!(bench.drive().fault, None);
    assert_eq!(bench.drive().state, Some(DriveState::OperationEnabled));
}

#[test]
fn what_the_panel_has_in_1016h_is_in_no_file_and_is_not_stored() {
    let mut bench = Bench::chosen();
    let file = bench.file();
    bench.done(Order::Enable);
    assert_eq!(bench.done(read("1016:1")), "0x007F01F4");
    assert_eq!(bench.differences(&file), []);
    assert_eq!(bench.file(), file);
    // A file that is loaded does not end the guard either.
    let (name, text) = file;
    bench.done(Order::Load {
        node: NODE,
        name,
        text,
    });
    // The drive stores while its motor has no power, and its page leaves it ready to switch on.
    let why = bench.refused(Order::Save { node: NODE });
    assert!(
        why.ends_with("; its motor has power: disable it first"),
        "{why}"
    );
    bench.done(transition(Transition::Shutdown));
    bench.done(Order::Save { node: NODE });
    assert_eq!(bench.drive_state(), Some(DriveState::SwitchOnDisabled));
    bench.run_for(100);
    assert_eq!(bench.drive().guard, Guard::On);
    assert_eq!(bench.done(read("1016:1")), "0x007F01F4");
    bench.done(Order::Nmt {
        command: NmtOrder::Reset,
        node: NODE,
    });
    bench.run_for(500);
    assert_eq!(bench.done(read("1016:1")), "0");
}

#[test]
fn what_somebody_else_has_written_into_1016h_stays() {
    let mut bench = Bench::enabled();
    bench.done(write("1016:1", "0x00050064"));
    bench.desk.close(bench.window);
    bench.run_for(500);
    bench.window = bench.desk.open();
    assert_eq!(bench.done(read("1016:1")), "0x00050064");
}
