//! The virtual drive in real time, for masters of other programs.
//!
//! Virtual time follows the computer's clock: the drive is polled when it asked for it or when a frame has come, and runs
//! every control tick that is due. After a stall of the machine it catches up tick by tick, so motion loses nothing.

use std::io::{self, Write};
use std::time::Instant as WallClock;

use canopen::cia301::error_behaviour::CommunicationError;
use canopen::cia301::heartbeat::HeartbeatError;
use canopen::cia301::nmt::NmtState;
use canopen::{BitTiming, Event, Frame, Instant};

use crate::Axis402;
use crate::drive::Setup;
use master::bus::Station;
use master::bus::live::{Incoming, LONGEST_SLEEP, LiveBus, Source};
use master::command_line::note;
use master::system_error::plain;

/// What a server is to be.
#[derive(Debug)]
pub struct Service {
    /// Where to serve SLCAN, `host:port`.
    pub slcan: Option<String>,
    /// Which SocketCAN interface to join.
    pub socketcan: Option<String>,
    /// The drive.
    pub setup: Setup,
    /// Tell on standard error what the node does.
    pub verbose: bool,
}

/// Runs a drive until it is stopped by a signal. Prints `ready` on a line of its own once it can be reached.
///
/// # Errors
/// One line for people: a busy port, a missing interface, an interface that went away.
pub fn serve(service: Service) -> Result<(), String> {
    let mut bus = LiveBus::new();
    let mut greeting = String::new();
    if let Some(address) = &service.slcan {
        let server = bus
            .serve_slcan(address)
            .map_err(|error| format!("cannot serve SLCAN on {address}: {}", plain(error)))?;
        let address = server.address();
        if !address.ip().is_loopback() {
            note(&format!(
                "SLCAN on {address} is open to the network, without a password; 127.0.0.1 is for this computer alone"
            ));
        }
        greeting += &format!("SLCAN on {address}\n");
    }
    if let Some(interface) = &service.socketcan {
        bus.join_socketcan(interface).map_err(|error| {
            format!(
                "cannot open the CAN interface {interface}: {}",
                plain(error)
            )
        })?;
        greeting += &format!("SocketCAN on {interface}\n");
    }
    let stopper = bus.stopper();
    ctrlc::set_handler(move || {
        // An error means that the server has ended already.
        let _ = stopper.send(Incoming::Stop);
    })
    .map_err(|error| format!("cannot catch signals: {}", plain(error)))?;

    let mut server = Server::new(bus, service.setup, service.verbose);
    server.turn();
    // Nobody may be reading; the drive runs all the same.
    let mut output = io::stdout().lock();
    let _ = writeln!(output, "{greeting}ready").and_then(|()| output.flush());
    drop(output);
    server.run()
}

/// Messages between two turns of the drive, so that a flood of them does not stop it.
const BATCH: usize = 64;

/// The drive, the bus it is on, and the clock.
#[derive(Debug)]
pub struct Server {
    bus: LiveBus,
    drive: Axis402,
    start: WallClock,
    verbose: bool,
    warned: bool,
}

impl Server {
    /// A drive on a bus, powered when it has its first turn.
    pub fn new(bus: LiveBus, setup: Setup, verbose: bool) -> Self {
        Self {
            bus,
            drive: Axis402::new(setup),
            start: WallClock::now(),
            verbose,
            warned: false,
        }
    }

    /// Runs until it is told to stop, or a transport fails.
    ///
    /// # Errors
    /// What failed, in one line.
    pub fn run(&mut self) -> Result<(), String> {
        loop {
            let mut deadline = self.turn();
            for _ in 0..BATCH {
                match self.bus.receive(deadline) {
                    Some(Incoming::Frame {
                        source,
                        frame,
                        bit_rate,
                    }) => self.forward(&frame, source, bit_rate),
                    Some(Incoming::ClientLeft(number)) => {
                        self.tell(&format!("client {number} left"));
                    }
                    Some(Incoming::ClientRefused(why)) => {
                        note(&format!("cannot serve another client: {why}"));
                    }
                    // A server has no adapter.
                    Some(Incoming::Refused) => {}
                    Some(Incoming::Failed(what)) => return Err(what),
                    Some(Incoming::Stop) => return Ok(()),
                    None => break,
                }
                // What else is there is taken, but not waited for.
                deadline = self.start;
            }
        }
    }

    /// Lets the drive do what is due now, and sends its frames. Returns when it wants its next turn.
    pub fn turn(&mut self) -> WallClock {
        let now = self.now();
        let mut wake = self.drive.poll(now);
        // Some times begin when a frame has left.
        while self.send_frames() {
            wake = self.drive.poll(now);
        }
        self.tell_events();
        let sleep = wake
            .checked_duration_since(now)
            .map_or(0, |span| span.ticks());
        self.start
            + std::time::Duration::from_micros(
                now.ticks() + sleep.min(LONGEST_SLEEP.as_micros() as u64),
            )
    }

    fn now(&self) -> Instant {
        Instant::from_ticks(self.start.elapsed().as_micros() as u64)
    }

    fn forward(&mut self, frame: &Frame, source: Source, bit_rate: Option<u32>) {
        self.send(frame, source, bit_rate);
        let own = self.bit_rate();
        if bit_rate.is_none() || bit_rate == own {
            let now = self.now();
            self.drive.receive(frame, now);
            // What changed by this frame goes out before the answer to the next one, as on a board.
            self.drive.poll(now);
            self.send_frames();
        } else if self.drive.is_silent() {
            let now = self.now();
            self.drive.error_seen(now);
        } else if !self.warned {
            self.warned = true;
            note(&format!(
                "a client sends at {} kbit/s, the drive is set to {} kbit/s: they do not hear each other",
                bit_rate.unwrap_or_default(),
                own.unwrap_or_default(),
            ));
        }
    }

    /// Sends what the drive has to send; returns whether that was anything.
    fn send_frames(&mut self) -> bool {
        let mut has_sent = false;
        while let Some(frame) = self.drive.transmit() {
            let bit_rate = self.bit_rate();
            self.send(&frame, Source::Own, bit_rate);
            has_sent = true;
        }
        has_sent
    }

    fn send(&mut self, frame: &Frame, source: Source, bit_rate: Option<u32>) {
        for client in self.bus.send(frame, source, bit_rate) {
            note(&format!("client {client} does not read, disconnected"));
        }
    }

    fn bit_rate(&self) -> Option<u32> {
        self.drive.bit_rate().map(|rate| rate.kbit_per_second())
    }

    fn tell_events(&mut self) {
        while let Some(event) = self.drive.take_event() {
            let text = match event {
                Event::StateChanged(state) => {
                    let node = self.drive.device().node().settings().node_id.get();
                    format!("node {node}: {}", state_name(state))
                }
                Event::StoreSettings(settings) => format!(
                    "stores node-ID {} and {}",
                    settings.node_id.get(),
                    rate_name(settings.bit_timing)
                ),
                Event::SwitchBitRate { bit_rate, .. } => {
                    format!("LSS switches to {} kbit/s", bit_rate.kbit_per_second())
                }
                Event::FindBitRate { .. } => "LSS has it find the bit rate".to_owned(),
                Event::RestartController => "the CAN controller starts again".to_owned(),
                Event::EmergencyReceived(emergency) => format!(
                    "node {} has error {:04X}h",
                    emergency.consumer, emergency.code
                ),
                Event::CommunicationError(error) => describe(error),
                Event::ResetRequested(_) => "reset".to_owned(),
                other => format!("{other:?}"),
            };
            self.tell(&text);
        }
    }

    fn tell(&self, text: &str) {
        if self.verbose {
            note(text);
        }
    }
}

/// A bit rate as it is configured.
fn rate_name(timing: BitTiming) -> String {
    match timing.bit_rate() {
        Some(bit_rate) => format!("{} kbit/s", bit_rate.kbit_per_second()),
        None => "automatic bit rate".to_owned(),
    }
}

/// The name of an NMT state.
fn state_name(state: NmtState) -> &'static str {
    match state {
        NmtState::Initialisation => "initialisation",
        NmtState::Stopped => "stopped",
        NmtState::Operational => "operational",
        NmtState::PreOperational => "pre-operational",
    }
}

fn describe(error: CommunicationError) -> String {
    match error {
        CommunicationError::Heartbeat(HeartbeatError::Lost(node_id)) => {
            format!("node {} is silent", node_id.get())
        }
        CommunicationError::Heartbeat(HeartbeatError::Restarted(node_id)) => {
            format!("node {} has started anew", node_id.get())
        }
        CommunicationError::LifeGuarding => "nobody guards the drive any more".to_owned(),
        CommunicationError::BusOff => "the CAN controller is bus-off".to_owned(),
        other => format!("{other:?}"),
    }
}
