//! The server of the virtual drive: up to three clients at once that send any bytes and leave. Whoever comes behind them is served.
//!
//! The drive lives on from input to input, as that of a server does that runs for days.
#![no_main]

use std::cell::RefCell;
use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::{Duration, Instant};

use libfuzzer_sys::fuzz_target;
use master::bus::live::LiveBus;
use sim::Axis402;
use sim::drive::Setup;
use sim::serve::Server;

/// How long a client waits for its answer.
const PATIENCE: Duration = Duration::from_secs(5);

thread_local! {
    static SERVER: RefCell<(Server, SocketAddr)> = RefCell::new(started());
}

fn started() -> (Server, SocketAddr) {
    let mut bus = LiveBus::new();
    let address = bus.serve_slcan("127.0.0.1:0").unwrap().address();
    let drive = Box::new(Axis402::new(Setup::with_node_id(1, 4)));
    (Server::new(bus, drive, false), address)
}

fuzz_target!(|bytes: &[u8]| {
    SERVER.with_borrow_mut(|(server, address)| {
        let parts = bytes.split(|byte| *byte == 0).take(3);
        let clients: Vec<TcpStream> = parts.map(|part| client(*address, part)).collect();
        server.pass().unwrap();
        drop(clients);
        let mut client = client(*address, b"\rC\rV\r");
        client.set_nonblocking(true).unwrap();
        let (mut heard, mut buffer) = (Vec::new(), [0; 64]);
        let end = Instant::now() + PATIENCE;
        while heard != b"\r\rV0100\r" {
            assert!(Instant::now() < end, "heard {heard:?}");
            server.pass().unwrap();
            match client.read(&mut buffer) {
                Ok(0) => panic!("the server has hung up"),
                Ok(count) => heard.extend_from_slice(&buffer[..count]),
                Err(error) => assert_eq!(error.kind(), ErrorKind::WouldBlock),
            }
        }
    });
});

/// Connects and sends; a server that hangs up on nonsense may do so before it has come.
fn client(address: SocketAddr, bytes: &[u8]) -> TcpStream {
    let mut client = TcpStream::connect(address).unwrap();
    let _ = client.write_all(bytes);
    client
}
