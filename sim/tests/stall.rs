//! A computer that stalls: the drive takes what has waited before time passes, so nothing is lost that was there in time.

use std::io::{Read, Write};
use std::net::TcpStream;
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

/// SYNCs that waited with the receive PDOs between them: what the transmit PDOs of one SYNC bring is of one SYNC.
#[test]
fn a_tpdo_of_one_sync_is_not_newer_than_its_sisters() {
    const ROUNDS: u32 = 40;
    /// Numbers of 32 bits that a PDO may carry in either direction.
    const OBJECTS: [u16; 4] = [0x6083, 0x6084, 0x6085, 0x609A];
    let mut bus = LiveBus::new();
    let address = bus.serve_slcan("127.0.0.1:0").unwrap().address();
    let mut client = TcpStream::connect(address).unwrap();
    client.write_all(b"O\r").unwrap();
    client.read_exact(&mut [0]).unwrap();
    let transport = bus.stopper();
    let start = Instant::now() - STALL;
    let mut server = Server::started(
        bus,
        Box::new(Axis402::new(Setup::with_node_id(1, 4))),
        false,
        start,
    );
    let send = |cob_id: u16, data: &[u8], came: u32| {
        let frame = Incoming::Frame {
            source: Source::SocketCan,
            frame: Frame::data_frame(cob_id, data),
            bit_rate: None,
            at: start + Duration::from_millis(came.into()),
        };
        transport.send(frame).unwrap();
    };
    let write = |index: u16, sub: u8, command: u8, value: u32| {
        let [low, high] = index.to_le_bytes();
        let [a, b, c, d] = value.to_le_bytes();
        send(0x604, &[command, low, high, sub, a, b, c, d], 10);
    };
    for (number, object) in (0_u16..).zip(OBJECTS) {
        let receive = (0x1400, 0x204);
        let transmit = (0x1800, 0x4000_0184);
        for (first, cob_id) in [receive, transmit] {
            let (communication, mapping) = (first + number, first + 0x200 + number);
            let cob_id = cob_id + 0x100 * u32::from(number);
            write(communication, 1, 0x23, 1 << 31 | cob_id);
            write(mapping, 0, 0x2F, 0);
            write(mapping, 1, 0x23, u32::from(object) << 16 | 32);
            write(mapping, 0, 0x2F, 1);
            write(communication, 2, 0x2F, 1);
            write(communication, 1, 0x23, cob_id);
        }
    }
    send(0x000, &[1, 4], 20);
    for count in 1..=ROUNDS {
        let came = 50 + 20 * count;
        for cob_id in [0x204, 0x304, 0x404, 0x504] {
            send(cob_id, &count.to_le_bytes(), came);
        }
        send(0x080, &[], came + 1);
    }
    server.pass().unwrap();

    let is_tpdo = |line: &&str| {
        let starts = ["t1844", "t2844", "t3844", "t4844"];
        starts.iter().any(|start| line.starts_with(start))
    };
    client
        .set_read_timeout(Some(Duration::from_secs(20)))
        .unwrap();
    let (mut heard, mut buffer) = (String::new(), [0; 4096]);
    while heard.split('\r').filter(is_tpdo).count() < 4 * ROUNDS as usize {
        let count = client.read(&mut buffer).unwrap();
        heard += std::str::from_utf8(&buffer[..count]).unwrap();
    }
    let rounds: Vec<Vec<&str>> = heard
        .split("t0800\r")
        .skip(1)
        .map(|round| round.split('\r').filter(is_tpdo).collect())
        .collect();
    assert_eq!(rounds.len(), ROUNDS as usize);
    // The first SYNCs show what was there before.
    for (count, round) in (1_u32..).zip(&rounds).skip(2) {
        let values: Vec<&str> = round.iter().map(|line| &line[5..13]).collect();
        assert_eq!(values.len(), 4, "{count}: {round:?}");
        assert!(
            values.iter().all(|value| *value == values[0]),
            "{count}: {round:?}"
        );
        let value = u32::from_str_radix(values[0], 16).unwrap().swap_bytes();
        assert!((count - 1..=count).contains(&value), "{count}: {value}");
    }
}
