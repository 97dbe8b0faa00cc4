//! Transfers without a node around the server: values of every length, and a bus that loses, doubles and delays frames.

mod client;
mod line;
mod properties;
mod store;
mod values;

use store::Store;

use super::AbortCode;
use super::server::Server;
use crate::od::Unused;
use crate::time::Instant;
use crate::wire::sdo::Multiplexer;

/// A server whose buffer holds every value of these tests.
type TestServer = Server<[u8; 2048]>;

fn server() -> TestServer {
    let mut server = TestServer::UNUSED;
    server.reset();
    server
}

impl<B: AsRef<[u8]> + AsMut<[u8]>> Server<B> {
    /// The answer to a request, if it has one now.
    fn answer(&mut self, request: &[u8; 8], now: Instant, store: &mut Store) -> Option<[u8; 8]> {
        self.receive(request, now, store);
        self.answers.pop()
    }

    /// The next frame that is to be sent.
    fn transmit(&mut self, store: &mut Store) -> Option<[u8; 8]> {
        self.answers.pop().or_else(|| self.segment(store))
    }

    /// What a client is told at this moment.
    fn tell(&mut self, now: Instant, store: &mut Store) -> Option<[u8; 8]> {
        self.poll(now, store);
        self.answers.pop()
    }

    /// What a client is told when the owner of an object is done.
    fn done(&mut self, object: Multiplexer, result: Result<(), AbortCode>) -> Option<[u8; 8]> {
        self.complete(object, result);
        self.answers.pop()
    }
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
