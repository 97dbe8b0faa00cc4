//! A bus in real time: whatever transports there are, with a drive or a master.
//!
//! One thread owns the station and puts every frame on all transports in the order in which it saw them, so all of them see the
//! same bus. Transports have threads of their own and hand over what they receive as [`Incoming`].

use std::fmt;
use std::io;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::{Duration, Instant};

use canopen::Frame;
use slcan::AdapterBitRate;

use super::slcan_client::{Place, SlcanClient};
use super::slcan_tcp::SlcanServer;
#[cfg(target_os = "linux")]
use super::socketcan::Interface;

/// Frames that may wait for the station; a transport that brings more has to wait.
const QUEUE: usize = 1024;

/// Where a frame came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// The drive or the master that this bus is for.
    Own,
    /// An SLCAN client, by its number.
    Slcan(u64),
    /// The SocketCAN interface.
    SocketCan,
    /// The SLCAN adapter.
    Adapter,
}

/// What transports hand over.
#[derive(Debug)]
pub enum Incoming {
    /// A frame.
    Frame {
        /// Who sent it.
        source: Source,
        /// The frame.
        frame: Frame,
        /// Its bit rate in kbit/s, if the transport knows one.
        bit_rate: Option<u32>,
        /// When it came: where the system tells, even if this program was not running.
        at: Instant,
    },
    /// The system had no room for so many frames.
    Lost(u32),
    /// The SLCAN adapter refused a frame, or a line of a client was refused.
    Refused,
    /// An SLCAN client closed its connection.
    ClientLeft(u64),
    /// No SLCAN client can be served at present; why.
    ClientRefused(String),
    /// A transport cannot go on.
    Failed(String),
    /// The program shall end.
    Stop,
}

/// All transports of a program.
pub struct LiveBus {
    incoming: Receiver<Incoming>,
    sender: SyncSender<Incoming>,
    slcan: Option<SlcanServer>,
    adapter: Option<SlcanClient>,
    #[cfg(target_os = "linux")]
    interface: Option<Interface>,
}

impl LiveBus {
    /// A bus without any transport.
    pub fn new() -> Self {
        let (sender, incoming) = sync_channel(QUEUE);
        Self {
            incoming,
            sender,
            slcan: None,
            adapter: None,
            #[cfg(target_os = "linux")]
            interface: None,
        }
    }

    /// Serves SLCAN on a TCP address.
    ///
    /// # Errors
    /// As [`SlcanServer::listen`].
    pub fn serve_slcan(&mut self, address: &str) -> io::Result<&SlcanServer> {
        let server = SlcanServer::listen(address, self.sender.clone())?;
        Ok(self.slcan.insert(server))
    }

    /// Goes on the bus of an SLCAN adapter, at `bit_rate` if there is one; leaves that of the one before.
    ///
    /// # Errors
    /// As [`SlcanClient::open`].
    pub fn use_adapter(
        &mut self,
        place: &Place,
        bit_rate: Option<AdapterBitRate>,
    ) -> io::Result<()> {
        // Closed first: it may be the same adapter.
        self.adapter = None;
        self.adapter = Some(SlcanClient::open(place, bit_rate, self.sender.clone())?);
        Ok(())
    }

    /// Opens the channel of the adapter anew at another bit rate; false if there is no adapter.
    ///
    /// # Errors
    /// As [`LiveBus::use_adapter`].
    pub fn set_adapter_bit_rate(&mut self, bit_rate: AdapterBitRate) -> io::Result<bool> {
        let Some(adapter) = &self.adapter else {
            return Ok(false);
        };
        let place = adapter.place().clone();
        self.use_adapter(&place, Some(bit_rate)).map(|()| true)
    }

    /// Joins a SocketCAN interface.
    ///
    /// # Errors
    /// If there is no such interface, or no SocketCAN at all.
    pub fn join_socketcan(&mut self, name: &str) -> io::Result<()> {
        #[cfg(target_os = "linux")]
        {
            self.interface = Some(Interface::open(name, self.sender.clone())?);
            Ok(())
        }
        #[cfg(not(target_os = "linux"))]
        {
            let _ = name;
            Err(io::Error::new(
                io::ErrorKind::Unsupported,
                "SocketCAN is a part of Linux",
            ))
        }
    }

    /// A sender for [`Incoming::Stop`].
    pub fn stopper(&self) -> SyncSender<Incoming> {
        self.sender.clone()
    }

    /// Waits for the next message until `deadline`; `None` if none came.
    pub fn receive(&self, deadline: Instant) -> Option<Incoming> {
        let wait = deadline.saturating_duration_since(Instant::now());
        // This end holds a sender too, so the only error is that nothing came in time.
        self.incoming.recv_timeout(wait).ok()
    }

    /// Puts a frame on every transport but the one it came from. Returns the SLCAN clients that were disconnected because
    /// they do not read.
    pub fn send(&mut self, frame: &Frame, source: Source, bit_rate: Option<u32>) -> Vec<u64> {
        #[cfg(target_os = "linux")]
        if let Some(interface) = self
            .interface
            .as_mut()
            .filter(|_| source != Source::SocketCan)
        {
            interface.send(frame);
        }
        if let Some(adapter) = self.adapter.as_mut().filter(|_| source != Source::Adapter) {
            adapter.send(frame);
        }
        match &self.slcan {
            Some(server) => server.send(frame, source, bit_rate),
            None => Vec::new(),
        }
    }
}

impl Default for LiveBus {
    fn default() -> Self {
        Self::new()
    }
}

impl fmt::Debug for LiveBus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LiveBus")
            .field("slcan", &self.slcan)
            .finish_non_exhaustive()
    }
}

/// How long nothing may wait: the longest sleep of a server.
pub const LONGEST_SLEEP: Duration = Duration::from_millis(100);
