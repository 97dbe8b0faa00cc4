//! Transfers without a node around the server: values of every length, and a bus that loses, doubles and delays frames.

mod client;
mod line;
mod properties;
mod store;
mod values;

use super::server::Server;
use crate::od::Unused;
use crate::wire::sdo::Multiplexer;

/// A server whose buffer holds every value of these tests.
type TestServer = Server<[u8; 2048]>;

fn server() -> TestServer {
    TestServer::UNUSED
}

/// A string in RAM.
const STRING: Multiplexer = Multiplexer {
    index: 0x2000,
    sub: 0,
};
/// What the application serves piece by piece.
const STREAM: Multiplexer = Multiplexer {
    index: 0x2001,
    sub: 0,
};
