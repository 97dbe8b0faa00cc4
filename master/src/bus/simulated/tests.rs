use canopen::time::NEVER;
use canopen::{BitRate, Duration, Frame, Instant};

use super::*;

/// Sends what it is given, hears everything, and can answer each frame it hears.
#[derive(Debug, Default)]
struct Talker {
    outgoing: VecDeque<Frame>,
    heard: Vec<(u64, Frame)>,
    answer: Option<Frame>,
    bit_rate: Option<BitRate>,
    reset: bool,
}

impl Talker {
    fn with(frames: impl IntoIterator<Item = Frame>) -> Self {
        Self {
            outgoing: frames.into_iter().collect(),
            ..Self::default()
        }
    }
}

impl Station for Talker {
    fn receive(&mut self, frame: &Frame, now: Instant) {
        self.heard.push((now.ticks(), *frame));
        self.outgoing.extend(self.answer);
    }

    fn poll(&mut self, _now: Instant) -> Instant {
        NEVER
    }

    fn transmit(&mut self) -> Option<Frame> {
        self.outgoing.pop_front()
    }

    fn bit_rate(&self) -> Option<BitRate> {
        self.bit_rate
    }

    fn was_reset(&mut self) -> bool {
        std::mem::take(&mut self.reset)
    }
}

fn frame(cob_id: u16) -> Frame {
    Frame::data_frame(cob_id, &[0x55])
}

fn bus() -> Bus {
    Bus::new(BitRate::Kbit1000)
}

fn order(bus: &Bus) -> Vec<u16> {
    bus.trace()
        .iter()
        .filter_map(|logged| logged.frame.standard_id())
        .collect()
}

const LONG: Duration = Duration::from_ticks(10_000);

#[test]
fn the_lowest_identifier_goes_first_and_the_others_follow() {
    let mut bus = bus();
    bus.attach(Talker::with([frame(0x704), frame(0x100)]));
    bus.attach(Talker::with([frame(0x080)]));
    bus.attach(Talker::with([frame(0x184), frame(0x7FF)]));
    bus.run_for(LONG);
    // 704h is in a mailbox when 080h wins; 100h joins it in the next arbitration.
    assert_eq!(order(&bus), [0x080, 0x100, 0x184, 0x704, 0x7FF]);
    assert_eq!(bus.collisions(), 0);
}

#[test]
fn every_other_station_hears_a_frame_at_its_end() {
    let mut bus = bus();
    let sender = bus.attach(Talker::with([frame(0x123)]));
    let listener = bus.attach(Talker::default());
    bus.run_for(LONG);
    let length = u64::from(frame_bits(&frame(0x123)));
    assert_eq!(bus.station(listener).heard, [(length, frame(0x123))]);
    assert_eq!(bus.station(sender).heard, []);
    let expected = Logged {
        at: Instant::from_ticks(length),
        sender: sender.number(),
        frame: frame(0x123),
    };
    assert_eq!(bus.trace(), [expected]);
}

#[test]
fn frames_follow_each_other_after_the_intermission() {
    let mut bus = bus();
    bus.attach(Talker::with([frame(1), frame(2)]));
    bus.attach(Talker::default());
    bus.run_for(LONG);
    let ends: Vec<u64> = bus.trace().iter().map(|logged| logged.at.ticks()).collect();
    let second = u64::from(frame_bits(&frame(2)));
    assert_eq!(ends[1] - ends[0], u64::from(INTERMISSION_BITS) + second);
}

#[test]
fn a_slower_bus_takes_longer_for_the_same_frame() {
    let end_at = |bit_rate| {
        let mut bus = Bus::new(bit_rate);
        bus.attach(Talker::with([frame(0x123)]));
        bus.attach(Talker::default());
        bus.run_for(Duration::from_ticks(100_000));
        bus.trace()[0].at.ticks()
    };
    assert_eq!(end_at(BitRate::Kbit10), 100 * end_at(BitRate::Kbit1000));
}

#[test]
fn an_answer_starts_after_the_intermission() {
    let mut bus = bus();
    bus.attach(Talker::with([frame(0x604)]));
    let answerer = Talker {
        answer: Some(frame(0x584)),
        ..Talker::default()
    };
    bus.attach(answerer);
    bus.run_for(LONG);
    assert_eq!(order(&bus), [0x604, 0x584]);
}

#[test]
fn identical_frames_that_start_together_merge() {
    let mut bus = bus();
    let answerer = || Talker {
        answer: Some(frame(0x7E4)),
        ..Talker::default()
    };
    let master = bus.attach(Talker::with([frame(0x7E5)]));
    bus.attach(answerer());
    bus.attach(answerer());
    bus.run_until(Instant::from_ticks(150));
    assert_eq!(bus.station(master).heard.len(), 1);
    assert_eq!(bus.collisions(), 0);
}

#[test]
fn different_frames_with_one_identifier_are_counted_as_a_collision() {
    let mut bus = bus();
    bus.attach(Talker::with([Frame::data_frame(0x184, &[1])]));
    bus.attach(Talker::with([Frame::data_frame(0x184, &[2])]));
    bus.run_for(LONG);
    assert_eq!(bus.collisions(), 1);
    assert_eq!(bus.trace().len(), 2);
}

#[test]
fn a_frame_that_nobody_hears_waits_for_a_listener_and_keeps_nobody_from_the_bus() {
    let mut bus = bus();
    let alone = bus.attach(Talker {
        bit_rate: Some(BitRate::Kbit500),
        ..Talker::with([frame(0x001)])
    });
    bus.attach(Talker {
        bit_rate: Some(BitRate::Kbit1000),
        ..Talker::with([frame(0x704)])
    });
    bus.attach(Talker {
        bit_rate: Some(BitRate::Kbit1000),
        ..Talker::default()
    });
    bus.run_for(LONG);
    assert_eq!(order(&bus), [0x704]);
    assert_eq!(bus.station(alone).heard, []);
    assert!(bus.destroyed() > 10);
    bus.station_mut(alone).bit_rate = Some(BitRate::Kbit1000);
    bus.run_for(LONG);
    assert_eq!(order(&bus), [0x704, 0x001]);
}

#[test]
fn a_lost_frame_reaches_nobody_and_a_destroyed_one_is_sent_again() {
    let mut bus = bus();
    bus.attach(Talker::with([frame(1), frame(2), frame(3)]));
    let listener = bus.attach(Talker::default());
    let mut count = 0;
    bus.interfere(move |_| {
        count += 1;
        match count {
            1 => Interference::Lose,
            2 => Interference::Destroy,
            _ => Interference::None,
        }
    });
    bus.run_for(LONG);
    let heard: Vec<Frame> = bus
        .station(listener)
        .heard
        .iter()
        .map(|(_, frame)| *frame)
        .collect();
    assert_eq!(heard, [frame(2), frame(3)]);
    assert_eq!(bus.destroyed(), 1);
}

#[test]
fn a_repeated_frame_is_received_twice() {
    let mut bus = bus();
    bus.attach(Talker::with([frame(1), frame(2)]));
    bus.attach(Talker::default());
    let mut is_first = true;
    bus.interfere(move |_| {
        if std::mem::take(&mut is_first) {
            Interference::Repeat
        } else {
            Interference::None
        }
    });
    bus.run_for(LONG);
    assert_eq!(order(&bus), [1, 1, 2]);
}

#[test]
fn what_interference_holds_up_goes_on_when_it_ends() {
    let mut bus = bus();
    bus.attach(Talker::with([frame(1), frame(2)]));
    bus.attach(Talker::default());
    bus.interfere(|_| Interference::Destroy);
    bus.run_for(LONG);
    assert!(order(&bus).is_empty());
    let destroyed = bus.destroyed();
    assert!(destroyed > 1, "the controller repeats the frame");
    bus.leave_in_peace();
    bus.run_for(LONG);
    assert_eq!(order(&bus), [1, 2]);
    // One at most was under way when it ended.
    assert!(bus.destroyed() <= destroyed + 1);
}

#[test]
fn nothing_starts_on_a_jammed_bus() {
    let mut bus = bus();
    bus.jam(Duration::from_ticks(5_000));
    bus.attach(Talker::with([frame(1)]));
    let listener = bus.attach(Talker::default());
    bus.run_for(LONG);
    assert!(bus.station(listener).heard[0].0 > 5_000);
}

#[test]
fn a_reset_controller_forgets_its_frames() {
    let mut bus = bus();
    let lone = bus.attach(Talker::with([frame(1)]));
    bus.run_for(LONG); // nobody acknowledges
    bus.station_mut(lone).reset = true;
    let listener = bus.attach(Talker::default());
    bus.run_for(LONG);
    assert_eq!(bus.station(listener).heard, []);
    assert!(bus.station(lone).outgoing.is_empty());
}

#[test]
fn a_detached_station_is_gone_and_comes_back_whole() {
    let mut bus = bus();
    let gone = bus.attach(Talker::with([frame(5)]));
    let station = bus.detach(gone);
    bus.attach(Talker::default());
    bus.run_for(LONG);
    assert_eq!(bus.trace(), []);
    assert_eq!(station.outgoing.len(), 1);
}

#[test]
fn time_ends_where_it_was_told_to() {
    let mut bus = bus();
    bus.attach(Talker::with([frame(5)]));
    bus.attach(Talker::default());
    bus.run_until(Instant::from_ticks(7));
    assert_eq!(bus.now().ticks(), 7);
    bus.run_until(Instant::from_ticks(3));
    assert_eq!(bus.now().ticks(), 7);
    bus.run_for(LONG);
    assert_eq!(bus.now().ticks(), 10_007);
    assert_eq!(bus.trace().len(), 1);
}
