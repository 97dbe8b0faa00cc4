//! An SLCAN adapter used from the PC: on a serial port, or behind a TCP address as a virtual drive or an emulator has it.
//!
//! The channel is closed, set to its bit rate and opened; then each frame is a line in either direction. Adapters differ in what they
//! reply, and some do not reply at all: silence is taken for consent, BEL for a refusal.

use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpStream, ToSocketAddrs};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{SyncSender, TrySendError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use canopen::Frame;
use serial2::SerialPort;
use slcan::{AdapterBitRate, Command, Decoder, encode};

use super::live::{Incoming, Source};
use crate::system_error::plain;

/// How long a connection may take to be made.
const CONNECT: Duration = Duration::from_secs(5);

/// How long the reader waits at most before it looks whether it shall end.
const READ: Duration = Duration::from_millis(50);

/// How long a line may take to be written.
const WRITE: Duration = Duration::from_secs(2);

/// How long an adapter may take to reply to a command. One that never replies costs this once for each command.
const REPLY: Duration = Duration::from_millis(200);

/// How often the reader looks whether there is room for what has come.
const ROOM: Duration = Duration::from_millis(1);

/// Where an adapter is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// A TCP address, `host:port`.
    Tcp(String),
    /// A serial port and its baud rate, which adapters on USB ignore.
    Serial(String, u32),
}

/// An adapter with an open channel.
#[derive(Debug)]
pub struct SlcanClient {
    place: Place,
    connection: Connection,
    ended: Arc<AtomicBool>,
    reader: Option<JoinHandle<()>>,
    failures: SyncSender<Incoming>,
}

impl SlcanClient {
    /// Opens the channel of an adapter at `bit_rate`; `None` leaves the adapter at the rate it has. What it receives goes to
    /// `incoming`.
    ///
    /// # Errors
    /// If there is no such adapter, or it refuses the bit rate or to open its channel.
    pub fn open(
        place: &Place,
        bit_rate: Option<AdapterBitRate>,
        incoming: SyncSender<Incoming>,
    ) -> io::Result<Self> {
        let mut connection = Connection::open(place)?;
        connection.begin()?;
        if let Some(bit_rate) = bit_rate {
            let command = format!("S{}\r", bit_rate.digit());
            let what = format!("the adapter refuses {} kbit/s", bit_rate.kbit_per_second());
            connection.command(&command, &what)?;
        }
        connection.command("O\r", "the adapter refuses to open its channel")?;
        let ended = Arc::new(AtomicBool::new(false));
        let (reader, stop, failures) = (
            connection.try_clone()?,
            Arc::clone(&ended),
            incoming.clone(),
        );
        let reader = thread::Builder::new()
            .name("slcan adapter".to_owned())
            .spawn(move || read_lines(reader, &stop, &incoming))?;
        Ok(Self {
            place: place.clone(),
            connection,
            ended,
            reader: Some(reader),
            failures,
        })
    }

    /// Where it is.
    pub fn place(&self) -> &Place {
        &self.place
    }

    /// Sends a frame.
    pub fn send(&mut self, frame: &Frame) {
        if let Err(error) = self.connection.write_all(&encode(frame)) {
            // Nobody listens any more: then nobody waits for it either.
            let _ = self.failures.try_send(lost(error));
        }
    }
}

impl Drop for SlcanClient {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::SeqCst);
        // It may be gone already.
        let _ = self.connection.write_all(b"C\r");
        self.connection.close();
        // Until then it would take the replies to whoever opens this adapter next.
        let _ = self.reader.take().map(JoinHandle::join);
    }
}

fn lost(error: io::Error) -> Incoming {
    Incoming::Failed(format!("the SLCAN adapter failed: {}", plain(error)))
}

fn read_lines(mut connection: Connection, ended: &AtomicBool, incoming: &SyncSender<Incoming>) {
    let mut decoder = Decoder::new();
    let mut bytes = [0; 4096];
    while !ended.load(Ordering::SeqCst) {
        let received = match connection.read(&mut bytes) {
            Ok([]) => {
                let closed = "the SLCAN adapter closed the connection".to_owned();
                deliver(Incoming::Failed(closed), ended, incoming);
                return;
            }
            Ok(received) => received,
            Err(error) if is_only_late(&error) => continue,
            Err(error) => {
                deliver(lost(error), ended, incoming);
                return;
            }
        };
        for byte in received {
            let message = match decoder.push(*byte) {
                // BEL ends a line too, of replies.
                None if *byte == BEL => {
                    decoder = Decoder::new();
                    Incoming::Refused
                }
                Some(Command::Frame(frame)) => Incoming::Frame {
                    source: Source::Adapter,
                    frame,
                    bit_rate: None,
                    at: Instant::now(),
                },
                // Replies, and what adapters say besides.
                _ => continue,
            };
            if !deliver(message, ended, incoming) {
                return;
            }
        }
    }
}

/// Hands a message over, when there is room for it. Returns false if nobody wants it any more: what an adapter says while its channel
/// is closed is no failure of the one that is opened next.
fn deliver(mut message: Incoming, ended: &AtomicBool, incoming: &SyncSender<Incoming>) -> bool {
    while !ended.load(Ordering::SeqCst) {
        match incoming.try_send(message) {
            Ok(()) => return true,
            Err(TrySendError::Full(back)) => message = back,
            Err(TrySendError::Disconnected(_)) => return false,
        }
        thread::sleep(ROOM);
    }
    false
}

const BEL: u8 = 0x07;

fn is_only_late(error: &io::Error) -> bool {
    use io::ErrorKind::{Interrupted, TimedOut, WouldBlock};
    matches!(error.kind(), Interrupted | TimedOut | WouldBlock)
}

/// The bytes to an adapter and back.
#[derive(Debug)]
enum Connection {
    Tcp(TcpStream),
    Serial(SerialPort),
}

impl Connection {
    fn open(place: &Place) -> io::Result<Self> {
        match place {
            Place::Tcp(address) => {
                let mut last = io::Error::new(io::ErrorKind::NotFound, "no such address");
                for address in address.to_socket_addrs()? {
                    match TcpStream::connect_timeout(&address, CONNECT) {
                        Ok(stream) => {
                            stream.set_nodelay(true)?;
                            stream.set_read_timeout(Some(READ))?;
                            stream.set_write_timeout(Some(WRITE))?;
                            return Ok(Self::Tcp(stream));
                        }
                        Err(error) => last = error,
                    }
                }
                Err(last)
            }
            Place::Serial(path, baud_rate) => {
                let mut port = SerialPort::open(path, *baud_rate)?;
                port.set_read_timeout(READ)?;
                port.set_write_timeout(WRITE)?;
                Ok(Self::Serial(port))
            }
        }
    }

    fn try_clone(&self) -> io::Result<Self> {
        match self {
            Self::Tcp(stream) => stream.try_clone().map(Self::Tcp),
            Self::Serial(port) => port.try_clone().map(Self::Serial),
        }
    }

    /// What has come; nothing when the other end closed.
    fn read<'a>(&mut self, bytes: &'a mut [u8]) -> io::Result<&'a [u8]> {
        let count = match self {
            Self::Tcp(stream) => stream.read(bytes)?,
            Self::Serial(port) => port.read(bytes)?,
        };
        Ok(bytes.get(..count).unwrap_or_default())
    }

    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        match self {
            Self::Tcp(stream) => stream.write_all(bytes),
            Self::Serial(port) => port.write_all(bytes),
        }
    }

    fn close(&self) {
        if let Self::Tcp(stream) = self {
            // It may be closed already.
            let _ = stream.shutdown(Shutdown::Both);
        }
    }

    /// Ends whatever line the adapter is in, closes its channel, and drops what it says to that.
    fn begin(&mut self) -> io::Result<()> {
        self.write_all(b"\r\rC\r")?;
        self.replies(3).map(|_| ())
    }

    /// Sends a command and waits for the reply to it. `refusal` is what a refusal means.
    fn command(&mut self, command: &str, refusal: &str) -> io::Result<()> {
        self.write_all(command.as_bytes())?;
        if self.replies(1)?.contains(&BEL) {
            return Err(io::Error::other(refusal.to_owned()));
        }
        Ok(())
    }

    /// Reads until so many replies have come, or none comes any more.
    fn replies(&mut self, count: usize) -> io::Result<Vec<u8>> {
        let mut replies = Vec::new();
        let mut bytes = [0; 256];
        let mut end = Instant::now() + REPLY;
        let is_end = |byte: &&u8| matches!(**byte, BEL | b'\r');
        while replies.iter().filter(is_end).count() < count && Instant::now() < end {
            match self.read(&mut bytes) {
                Ok([]) => return Err(io::ErrorKind::UnexpectedEof.into()),
                Ok(more) => {
                    replies.extend_from_slice(more);
                    end = Instant::now() + REPLY;
                }
                Err(error) if is_only_late(&error) => {}
                Err(error) => return Err(error),
            }
        }
        Ok(replies)
    }
}
