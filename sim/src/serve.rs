//! The virtual drive in real time, for masters of other programs.
//!
//! Virtual time follows the computer's clock: the drive is polled when it asked for it or when a frame has come, and runs
//! every control tick that is due. After a stall of the machine it catches up tick by tick, so motion loses nothing: what waits is taken
//! before time passes, each frame at the time at which it came. SocketCAN tells that time; on TCP nobody does, so frames that have
//! waited there are spread over the stall.

use std::fmt;
use std::io::{self, Write};
use std::time::{Duration, Instant as WallClock};

use canopen::cia301::error_behaviour::CommunicationError;
use canopen::cia301::heartbeat::HeartbeatError;
use canopen::cia301::nmt::NmtState;
use canopen::{BitTiming, Event, Frame, Instant};

use crate::products::Drive;
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
    pub drive: Box<dyn Drive>,
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

    let mut server = Server::new(bus, service.drive, service.verbose);
    server.turn();
    // Nobody may be reading; the drive runs all the same.
    let mut output = io::stdout().lock();
    let _ = writeln!(output, "{greeting}ready").and_then(|()| output.flush());
    drop(output);
    server.run()
}

/// Messages between two turns of the drive, so that a flood of them does not stop it.
const BATCH: usize = 64;

/// The same after a stall: all that could wait for the drive.
const BACKLOG: usize = 4 * 1024;

/// Later than this is a stall.
const STALL: Duration = Duration::from_millis(10);

/// How long the transports are silent when they have handed over all that has waited for them.
const GRACE: Duration = Duration::from_millis(5);

/// The drive, the bus it is on, and the clock.
#[derive(Debug)]
pub struct Server {
    bus: LiveBus,
    drive: Box<dyn Drive>,
    start: WallClock,
    /// When the drive wants its next turn.
    deadline: WallClock,
    /// All that came until then is taken.
    taken: WallClock,
    /// The time of the drive.
    last: Instant,
    counts: Counts,
    verbose: bool,
    warned: bool,
}

/// What has passed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Frames of others.
    pub received: u64,
    /// Frames of the drive.
    pub sent: u64,
    /// Frames for which the system had no room.
    pub lost: u64,
    /// Lines that are no frames, and frames at another bit rate.
    pub refused: u64,
    /// Emergency messages of the drive.
    pub emergencies: u64,
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} frames in, {} out, {} lost, {} refused, {} emergency messages",
            self.received, self.sent, self.lost, self.refused, self.emergencies
        )
    }
}

impl Server {
    /// A drive on a bus, powered when it has its first turn.
    pub fn new(bus: LiveBus, drive: Box<dyn Drive>, verbose: bool) -> Self {
        Self::started(bus, drive, verbose, WallClock::now())
    }

    /// The same; its time begins at `start`. Since then it has stalled.
    pub fn started(bus: LiveBus, drive: Box<dyn Drive>, verbose: bool, start: WallClock) -> Self {
        Self {
            bus,
            drive,
            start,
            deadline: start,
            taken: start,
            last: Instant::from_ticks(0),
            counts: Counts::default(),
            verbose,
            warned: false,
        }
    }

    /// Runs until it is told to stop, or a transport fails.
    ///
    /// # Errors
    /// What failed, in one line.
    pub fn run(&mut self) -> Result<(), String> {
        while self.pass()? {}
        self.tell(&self.counts.to_string());
        Ok(())
    }

    /// Waits for what comes until the drive wants its turn, takes all of it, and lets the drive have that turn. Returns false when
    /// it is told to stop.
    ///
    /// # Errors
    /// What failed, in one line.
    pub fn pass(&mut self) -> Result<bool, String> {
        for message in self.gather() {
            match message {
                Incoming::Frame {
                    source,
                    frame,
                    bit_rate,
                    at,
                } => {
                    let now = self.time(at.min(self.taken));
                    self.forward(&frame, source, bit_rate, now);
                }
                Incoming::Lost(count) => {
                    self.counts.lost += u64::from(count);
                    self.drive.frames_lost(count, self.last);
                }
                Incoming::ClientLeft(number) => self.tell(&format!("client {number} left")),
                Incoming::ClientRefused(why) => {
                    note(&format!("cannot serve another client: {why}"));
                }
                Incoming::Refused => self.counts.refused += 1,
                Incoming::Failed(what) => return Err(what),
                Incoming::Stop => return Ok(false),
            }
        }
        self.turn_at(self.taken);
        Ok(true)
    }

    /// All that has come until now, which is then [`Server::taken`].
    fn gather(&mut self) -> Vec<Incoming> {
        let expected = self.deadline.max(self.taken);
        let mut messages = Vec::from_iter(self.bus.receive(self.deadline));
        let woken = WallClock::now();
        let has_stalled = woken.saturating_duration_since(expected) > STALL;
        // The transports have stalled as well.
        let (most, patience) = if has_stalled {
            (BACKLOG, GRACE)
        } else {
            (BATCH, Duration::ZERO)
        };
        self.taken = loop {
            let now = WallClock::now();
            match self.bus.receive(now + patience) {
                Some(message) => messages.push(message),
                None => break now,
            }
            if messages.len() >= most {
                // Time goes on to what was taken last; behind it there may be more.
                break match messages.last() {
                    Some(Incoming::Frame { at, .. }) => self.taken.max(*at),
                    _ => now,
                };
            }
        };
        if has_stalled {
            spread(&mut messages, expected, woken);
        }
        messages
    }

    /// The drive.
    pub fn drive(&self) -> &dyn Drive {
        &*self.drive
    }

    /// What has passed so far.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Lets the drive do what is due now, and sends its frames.
    pub fn turn(&mut self) {
        self.turn_at(WallClock::now());
    }

    fn turn_at(&mut self, now: WallClock) {
        let now = self.time(now);
        let mut wake = self.drive.poll(now);
        // Some times begin when a frame has left.
        while self.send_frames() {
            wake = self.drive.poll(now);
        }
        self.tell_events();
        let sleep = wake
            .checked_duration_since(now)
            .map_or(0, |span| span.ticks());
        let sleep = sleep.min(LONGEST_SLEEP.as_micros() as u64);
        self.deadline = self.start + Duration::from_micros(now.ticks() + sleep);
    }

    /// A time of the computer as one of the drive, which never runs backwards.
    fn time(&mut self, at: WallClock) -> Instant {
        let passed = at.saturating_duration_since(self.start).as_micros() as u64;
        self.last = self.last.max(Instant::from_ticks(passed));
        self.last
    }

    fn forward(&mut self, frame: &Frame, source: Source, bit_rate: Option<u32>, now: Instant) {
        self.counts.received += 1;
        self.send(frame, source, bit_rate);
        let own = self.bit_rate();
        if bit_rate.is_none() || bit_rate == own {
            self.drive.receive(frame, now);
            // What changed by this frame goes out before the answer to the next one, as on a board.
            self.drive.poll(now);
            self.send_frames();
            return;
        }
        self.counts.refused += 1;
        if self.drive.is_silent() {
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
            self.counts.sent += 1;
            let is_emergency = matches!(frame.standard_id(), Some(0x081..=0x0FF));
            self.counts.emergencies += u64::from(is_emergency);
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
                    let node = self.drive.node_id().get();
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

/// Frames that clients have sent during a stall were read when it was over: they are spread over what of it is behind those that were read
/// in time, as far from each other as from its ends. Then all are in the order of time, those of each transport in their own.
fn spread(messages: &mut [Incoming], from: WallClock, to: WallClock) {
    let read_late = |message: &Incoming| matches!(message, Incoming::Frame { source: Source::Slcan(_), at, .. } if *at + GRACE > to);
    let in_time = messages.iter().filter_map(|message| match message {
        Incoming::Frame {
            source: Source::Slcan(_),
            at,
            ..
        } if !read_late(message) => Some(*at),
        _ => None,
    });
    let from = in_time.fold(from, WallClock::max).min(to);
    let count = messages.iter().filter(|message| read_late(message)).count() as u32;
    let late = messages.iter_mut().filter(|message| read_late(message));
    for (number, message) in (0..).zip(late) {
        if let Incoming::Frame { at, .. } = message {
            *at = from + (to - from) * (2 * number + 1) / (2 * count);
        }
    }
    let mut last = from;
    messages.sort_by_cached_key(|message| {
        // What is no frame stays behind what came before it.
        if let Incoming::Frame { at, .. } = message {
            last = *at;
        }
        last
    });
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames of a client that the transport has read when the drive should have had its turn long ago, and behind the stall.
    #[test]
    fn the_frames_of_a_transport_stay_in_their_order() {
        let from = WallClock::now();
        let millis = |count| from + Duration::from_millis(count);
        let to = millis(40);
        let frame = |number: u8, source, at| Incoming::Frame {
            source,
            frame: Frame::data_frame(0x604, &[number]),
            bit_rate: None,
            at,
        };
        let client = Source::Slcan(1);
        let mut messages = vec![
            frame(1, client, millis(0)),
            frame(2, client, millis(20)),
            frame(9, Source::SocketCan, millis(30)),
            frame(3, client, millis(39)),
            Incoming::Lost(1),
            frame(4, client, millis(41)),
            // Another client's, read by another thread.
            frame(8, Source::Slcan(2), millis(34)),
            frame(5, client, millis(44)),
        ];
        spread(&mut messages, from, to);
        let order: Vec<u8> = (messages.iter())
            .filter_map(|message| match message {
                Incoming::Frame { frame, .. } => frame.payload().first().copied(),
                _ => None,
            })
            .collect();
        assert_eq!(order, [1, 2, 9, 8, 3, 4, 5]);
    }
}
