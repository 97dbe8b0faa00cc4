//! A virtual drive in this process, for who has none on the desk: fresh from the factory, with a motor that moves a belt.

use std::net::SocketAddr;
use std::path::Path;
use std::sync::mpsc::SyncSender;
use std::thread::{self, JoinHandle};

use master::bus::live::{Incoming, LiveBus};
use master::system_error::plain;
use sim::drive::Setup;
use sim::plant::{Axis, ServoAxisData};
use sim::products;
use sim::serve::Server;

/// What it moves, where nothing else is said.
const BELT: &str = include_str!("../../sim/plants/with_motor/belt.toml");

/// Its serial number (1018h:4).
const SERIAL_NUMBER: u32 = 0x00C0_FFEE;

/// A drive that runs until this is dropped. It serves SLCAN, for the panel and for other masters.
#[derive(Debug)]
pub struct VirtualDrive {
    address: SocketAddr,
    stopper: SyncSender<Incoming>,
    server: Option<JoinHandle<Result<(), String>>>,
}

impl VirtualDrive {
    /// Starts it without a node-ID.
    ///
    /// # Errors
    /// What is wrong with the file of its axis, or that there is no port for it.
    pub fn start(plant: Option<&Path>, servo: Option<&ServoAxisData>) -> Result<Self, String> {
        let axis = match (plant, servo) {
            (Some(file), _) => Axis::read(file)?,
            (None, Some(servo)) => Axis::servo(servo),
            (None, None) => Axis::from_toml(BELT).map_err(|(_, why)| why)?,
        };
        let mut bus = LiveBus::new();
        let port = bus.serve_slcan("127.0.0.1:0").map_err(plain)?;
        let address = port.address();
        let stopper = bus.stopper();
        let setup = Setup {
            axis: Some(axis),
            ..Setup::unconfigured(SERIAL_NUMBER)
        };
        let server = thread::spawn(move || {
            let drive = products::drive(None, setup);
            Server::new(bus, drive, false).run()
        });
        Ok(Self {
            address,
            stopper,
            server: Some(server),
        })
    }

    /// Where it serves SLCAN.
    pub fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Drop for VirtualDrive {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.stopper.send(Incoming::Stop);
        let _ = self.server.take().map(JoinHandle::join);
    }
}
