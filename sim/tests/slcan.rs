//! The SLCAN server with real sockets: what clients send, and what each of them gets.

mod served;

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use served::Served;
use sim::drive::Setup;

/// The longest wait for something that must come; nothing waits so long unless a test fails.
const PATIENCE: Duration = Duration::from_secs(20);

const READ_DEVICE_TYPE: &str = "t60484000100000000000";
const DEVICE_TYPE: &str = "t58484300100092010400";

/// A drive with node-ID 4.
fn served() -> Served {
    Served::start(Setup::with_node_id(1, 4))
}

impl Served {
    /// A client with an open channel at 1 Mbit/s.
    fn client(&self) -> Client {
        let mut client = self.connection();
        client.send("C");
        client.send("S8");
        client.send("O");
        assert_eq!(client.bytes(3), b"\r\r\r");
        client
    }

    fn connection(&self) -> Client {
        let stream = TcpStream::connect(self.address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream.set_nodelay(true).unwrap();
        Client {
            stream: BufReader::new(stream),
        }
    }
}

struct Client {
    stream: BufReader<TcpStream>,
}

impl Client {
    fn send(&mut self, line: &str) {
        self.stream
            .get_mut()
            .write_all(format!("{line}\r").as_bytes())
            .unwrap();
    }

    fn bytes(&mut self, count: usize) -> Vec<u8> {
        let mut bytes = vec![0; count];
        self.stream.read_exact(&mut bytes).unwrap();
        bytes
    }

    /// The next frame; replies before it are skipped.
    fn frame(&mut self) -> String {
        loop {
            let mut line = Vec::new();
            self.stream.read_until(b'\r', &mut line).unwrap();
            assert_eq!(line.pop(), Some(b'\r'), "the server closed the connection");
            if !line.is_empty() {
                return String::from_utf8(line).unwrap();
            }
        }
    }
}

#[test]
fn a_client_reads_the_device_type() {
    let served = served();
    let mut client = served.client();
    client.send(READ_DEVICE_TYPE);
    assert_eq!(client.frame(), DEVICE_TYPE);
}

#[test]
fn every_client_sees_the_frames_of_the_others_and_of_the_drive() {
    let served = served();
    let (mut first, mut second) = (served.client(), served.client());
    first.send(READ_DEVICE_TYPE);
    assert_eq!(second.frame(), READ_DEVICE_TYPE);
    assert_eq!(second.frame(), DEVICE_TYPE);
    second.send("t7FF2ABCD");
    // The first did not get its own request back, but the answer to it.
    assert_eq!(first.frame(), DEVICE_TYPE);
    assert_eq!(first.frame(), "t7FF2ABCD");
}

#[test]
fn a_client_at_another_bit_rate_hears_nothing_until_it_follows() {
    let served = served();
    // It connects first: when the client has an answer, it was this one's turn to get it already.
    let mut other = served.connection();
    other.send("S6");
    other.send("O");
    assert_eq!(other.bytes(2), b"\r\r");
    let mut client = served.client();
    other.send("t7FF111");
    assert_eq!(other.bytes(1), b"\r");
    client.send(READ_DEVICE_TYPE);
    assert_eq!(client.frame(), DEVICE_TYPE);
    other.send("C");
    other.send("S8");
    other.send("O");
    assert_eq!(other.bytes(3), b"\r\r\r");
    client.send("t7FF122");
    assert_eq!(other.frame(), "t7FF122");
}

#[test]
fn garbage_is_refused_and_forgotten() {
    let served = served();
    let mut client = served.client();
    client.send(&"garbage".repeat(10_000));
    client.send("t60Z");
    assert_eq!(client.bytes(2), b"\x07\x07");
    client.send(READ_DEVICE_TYPE);
    assert_eq!(client.bytes(1), b"\r");
    assert_eq!(client.frame(), DEVICE_TYPE);
}

#[test]
fn a_client_may_leave_and_come_back() {
    let served = served();
    for _ in 0..10 {
        let mut client = served.client();
        client.send(READ_DEVICE_TYPE);
        assert_eq!(client.frame(), DEVICE_TYPE);
    }
}

#[test]
fn a_client_that_does_not_read_is_left_behind() {
    let served = served();
    let mut slow = served.client();
    let mut busy = served.client();
    // More than all buffers on the way to the slow client hold.
    let burst = format!("{}\r", "t7FF81122334455667788").repeat(1_000);
    for _ in 0..400 {
        busy.stream.get_mut().write_all(burst.as_bytes()).unwrap();
        assert_eq!(busy.bytes(1_000), [b'\r'; 1_000]);
    }
    busy.send(READ_DEVICE_TYPE);
    assert_eq!(busy.frame(), DEVICE_TYPE);
    // The connection of the slow client ends, after what was on its way.
    let mut rest = Vec::new();
    let end = slow.stream.read_to_end(&mut rest);
    assert!(
        rest.len() < 400 * burst.len(),
        "{end:?} after {} bytes",
        rest.len()
    );
}

#[test]
fn a_flood_reaches_a_client_that_reads_whole_and_in_order() {
    let served = served();
    let (mut busy, mut reader) = (served.client(), served.client());
    for burst in 0..20 {
        let lines: Vec<String> = (0..1_000)
            .map(|number| format!("t7FF4{burst:04X}{number:04X}"))
            .collect();
        busy.send(&lines.join("\r"));
        for line in &lines {
            assert_eq!(reader.frame(), *line);
        }
        assert_eq!(busy.bytes(1_000), [b'\r'; 1_000]);
    }
}
