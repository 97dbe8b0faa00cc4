//! A drive behind SLCAN on a free port; it ends with the test.

use std::net::SocketAddr;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::{self, JoinHandle};

use master::bus::live::{Incoming, LiveBus};
use sim::Axis402;
use sim::drive::Setup;
use sim::serve::Server;

pub struct Served {
    pub address: SocketAddr,
    stopper: SyncSender<Incoming>,
    server: Option<JoinHandle<Result<(), String>>>,
}

impl Served {
    /// It boots before there are clients, so that none of them sees the boot-up message.
    pub fn start(setup: Setup) -> Self {
        let mut bus = LiveBus::new();
        let address = bus.serve_slcan("127.0.0.1:0").unwrap().address();
        let stopper = bus.stopper();
        let (booted, has_booted) = sync_channel(1);
        let server = thread::spawn(move || {
            let mut server = Server::new(bus, Box::new(Axis402::new(setup)), false);
            server.turn();
            booted.send(()).unwrap();
            server.run()
        });
        has_booted.recv().unwrap();
        Self {
            address,
            stopper,
            server: Some(server),
        }
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.stopper.send(Incoming::Stop).unwrap();
        let result = self.server.take().map(JoinHandle::join);
        if !thread::panicking() {
            assert_eq!(result.unwrap().unwrap(), Ok(()));
        }
    }
}
