//! The program with adapters of every kind: over TCP, on a serial port, those that fail and those that go away.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::thread;
use std::time::{Duration, Instant};

use master::bus::live::{Incoming, LiveBus};
use master::bus::slcan_client::Place;
use sim::drive::Setup;
use slcan::AdapterBitRate;

use super::program::{Served, assert_refused, run};

/// An adapter that says `reply` to every line, and nothing else.
fn adapter(reply: &'static [u8]) -> SocketAddr {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        let mut byte = [0];
        while let Ok(1) = stream.read(&mut byte) {
            if byte == *b"\r" && stream.write_all(reply).is_err() {
                return;
            }
        }
    });
    address
}

#[test]
fn an_adapter_that_cannot_send_is_told() {
    // It refuses its bit rate already.
    let address = adapter(b"\x07").to_string();
    assert_refused(
        &["--slcan", &address, "scan"],
        "the adapter refuses 1000 kbit/s",
        2,
    );
    // It never replies at all: then nobody answers, and that is no fault of the adapter.
    let address = adapter(b"").to_string();
    let read = [
        "--slcan",
        &address,
        "--timeout",
        "50",
        "od",
        "read",
        "4",
        "1000",
    ];
    assert_refused(&read, "node 4 does not answer", 1);
}

#[test]
fn an_adapter_that_goes_away_is_told() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let goes = thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        let mut lines = 0;
        let mut byte = [0];
        // Two empty lines and C, S, O; then the first frame.
        while lines < 6 {
            stream.read_exact(&mut byte).unwrap();
            if byte == *b"\r" {
                lines += 1;
                stream.write_all(b"\r").unwrap();
            }
        }
    });
    let read = [
        "--slcan",
        &address,
        "--timeout",
        "60000",
        "od",
        "read",
        "4",
        "1000",
    ];
    assert_refused(&read, "SLCAN adapter", 2);
    goes.join().unwrap();
}

#[test]
fn a_channel_that_is_opened_anew_has_no_failure_of_the_old_one() {
    let served = Served::start(Setup::with_node_id(1, 4));
    let place = Place::Tcp(served.address.to_string());
    let rates = [500, 1_000].map(|kbit| {
        let mut all = (0..=8).filter_map(AdapterBitRate::from_digit);
        all.find(|rate| rate.kbit_per_second() == kbit).unwrap()
    });
    let mut bus = LiveBus::new();
    bus.use_adapter(&place, Some(rates[1])).unwrap();
    for rate in rates.into_iter().cycle().take(40) {
        assert!(bus.set_adapter_bit_rate(rate).unwrap());
        let heard = bus.receive(Instant::now());
        assert!(!matches!(heard, Some(Incoming::Failed(_))), "{heard:?}");
    }
}

/// Carries bytes between a serial port and a TCP connection, as the cable of an adapter would.
#[cfg(unix)]
fn cable(port: serial2::SerialPort, address: SocketAddr) {
    let stream = TcpStream::connect(address).unwrap();
    stream.set_nodelay(true).unwrap();
    let (to_port, mut from_stream) = (port.try_clone().unwrap(), stream.try_clone().unwrap());
    thread::spawn(move || {
        let mut bytes = [0; 256];
        while let Ok(count @ 1..) = from_stream.read(&mut bytes) {
            if to_port.write_all(&bytes[..count]).is_err() {
                return;
            }
        }
    });
    thread::spawn(move || {
        let mut stream = stream;
        let mut bytes = [0; 256];
        loop {
            match port.read(&mut bytes) {
                Ok(0) => return,
                Ok(count) => {
                    if stream.write_all(&bytes[..count]).is_err() {
                        return;
                    }
                }
                Err(error) if error.kind() == std::io::ErrorKind::TimedOut => {}
                Err(_) => return,
            }
        }
    });
}

#[cfg(target_os = "linux")]
#[test]
fn an_adapter_on_a_serial_port_does_as_well() {
    use std::os::fd::AsRawFd;

    let served = Served::start(Setup::with_node_id(1, 4));
    let (mut ours, theirs) = serial2::SerialPort::pair().unwrap();
    let path = std::fs::read_link(format!("/proc/self/fd/{}", theirs.as_raw_fd())).unwrap();
    ours.set_read_timeout(Duration::from_millis(50)).unwrap();
    cable(ours, served.address);
    let output = run(&[
        "--slcan",
        path.to_str().unwrap(),
        "od",
        "read",
        "-b",
        "4",
        "1018:4",
    ]);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{error}");
    assert_eq!(output.stdout, b"1\n");
    drop(theirs);
}
