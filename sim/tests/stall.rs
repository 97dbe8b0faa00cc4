//! A computer that stalls: the drive takes what has waited before time passes, so nothing is lost that was there in time.

use std::time::{Duration, Instant};

use canopen::Frame;
use master::bus::live::{Incoming, LiveBus, Source};
use sim::Axis402;
use sim::drive::Setup;
use sim::serve::Server;

/// For how long the computer has stood still.
const STALL: Duration = Duration::from_secs(2);

/// A drive of node-ID 4 that has booted and then stood still, after frames have come to it: it watches the heartbeat of node 5, for 75 ms,
/// and this comes every 50 ms. `at` says how long after the start a transport tells that a frame came.
fn after_stall(source: Source, at: impl Fn(Duration) -> Duration) -> Server {
    let bus = LiveBus::new();
    let transport = bus.stopper();
    let start = Instant::now() - STALL;
    let drive = Box::new(Axis402::new(Setup::with_node_id(1, 4)));
    let mut server = Server::started(bus, drive, false, start);
    let send = |frame: Frame, came: Duration| {
        let frame = Incoming::Frame {
            source,
            frame,
            bit_rate: None,
            at: start + at(came),
        };
        transport.send(frame).unwrap();
    };
    // 1016h:1: node 5, 75 ms.
    let watch = [0x23, 0x16, 0x10, 1, 75, 0, 5, 0];
    send(Frame::data_frame(0x604, &watch), Duration::ZERO);
    let beats = STALL.as_millis() as u64 / 50;
    for beat in 0..beats {
        let came = Duration::from_millis(25 + 50 * beat);
        send(Frame::data_frame(0x705, &[5]), came);
    }
    server.pass().unwrap();
    let counts = server.counts();
    assert_eq!((counts.received, counts.lost), (beats + 1, 0));
    server
}

/// How many errors the drive remembers (1003h:0).
fn errors(server: &Server) -> u8 {
    server.drive().object(0x1003, 0).unwrap()[0]
}

#[test]
fn frames_that_waited_count_at_the_time_at_which_they_came() {
    let server = after_stall(Source::SocketCan, |came| came);
    assert_eq!(errors(&server), 0);
    assert_eq!(server.counts().emergencies, 0);
}

#[test]
fn where_nobody_tells_when_they_came_they_are_spread_over_the_stall() {
    let server = after_stall(Source::Slcan(1), |_| STALL);
    assert_eq!(errors(&server), 0);
}

#[test]
fn a_producer_that_was_silent_in_the_stall_is_missed() {
    let early = |came: Duration| came.min(Duration::from_millis(500));
    let server = after_stall(Source::SocketCan, early);
    assert!(errors(&server) > 0);
    assert!(server.counts().emergencies > 0);
}

/// 8110h is for what the system had no room for.
#[test]
fn frames_that_the_system_has_lost_are_told() {
    let bus = LiveBus::new();
    let transport = bus.stopper();
    let mut server = Server::new(
        bus,
        Box::new(Axis402::new(Setup::with_node_id(1, 4))),
        false,
    );
    server.turn();
    transport.send(Incoming::Lost(3)).unwrap();
    server.pass().unwrap();
    assert_eq!(server.counts().lost, 3);
    let error = server.drive().object(0x1003, 1).unwrap();
    assert_eq!(error[..2], 0x8110_u16.to_le_bytes());
}
