//! SLCAN served on TCP: each connection is a CAN adapter of its own on one bus.
//!
//! Every client sees the frames of the drive and of all other clients, in one order. Small segments are sent and
//! acknowledged at once, so that a request and its answer do not wait for each other. A client that does not read is
//! disconnected when its queue is full; nobody waits for it.
//!
//! A client that chose a bit rate (`S`) only hears frames of that rate, as on copper; one that chose none hears all.

use std::io::{self, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream, ToSocketAddrs};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use canopen::Frame;
use slcan::{Channel, Decoder, encode};
use socket2::SockRef;

use super::live::{Incoming, Source};
use crate::system_error::plain;

/// Lines that may wait for a client. At 1 Mbit/s a full bus fills this in about half a second.
const QUEUE: usize = 4096;

/// Bytes the system keeps for a client that does not read. What is older than that is worth nothing.
const SEND_BUFFER: usize = 64 * 1024;

/// How long nobody is accepted when there are no files or threads left for a client.
const PAUSE: Duration = Duration::from_millis(100);

/// The server: a listening socket and the clients that are connected.
#[derive(Debug)]
pub struct SlcanServer {
    address: SocketAddr,
    clients: Clients,
}

type Clients = Arc<Mutex<Vec<Client>>>;

#[derive(Debug)]
struct Client {
    number: u64,
    stream: TcpStream,
    lines: SyncSender<Vec<u8>>,
    channel: Arc<Mutex<Channel>>,
}

impl SlcanServer {
    /// Listens on `address` (`host:port`; port 0 takes any that is free) and hands what clients send to `incoming`.
    ///
    /// # Errors
    /// If the address means nothing or the port is taken.
    pub fn listen(address: &str, incoming: SyncSender<Incoming>) -> io::Result<Self> {
        let addresses: Vec<SocketAddr> = address.to_socket_addrs()?.collect();
        let listener = TcpListener::bind(&*addresses)?;
        let address = listener.local_addr()?;
        let clients = Clients::default();
        let server = Self {
            address,
            clients: Arc::clone(&clients),
        };
        thread::Builder::new()
            .name("slcan listener".to_owned())
            .spawn(move || {
                accept(listener.incoming(), &clients, &incoming, || {
                    thread::sleep(PAUSE);
                });
            })?;
        Ok(server)
    }

    /// Where clients connect.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Sends a frame to every client with an open channel that hears `bit_rate` (in kbit/s; `None`: all do), but for the
    /// one it came from. Returns the numbers of clients that were disconnected because they do not read.
    pub fn send(&self, frame: &Frame, source: Source, bit_rate: Option<u32>) -> Vec<u64> {
        let line = encode(frame);
        let mut dropped = Vec::new();
        locked(&self.clients).retain(|client| {
            if source == Source::Slcan(client.number) || !client.hears(bit_rate) {
                return true;
            }
            match client.lines.try_send(line.to_vec()) {
                Ok(()) => true,
                Err(TrySendError::Disconnected(_)) => false,
                Err(TrySendError::Full(_)) => {
                    // Its threads end with the socket. An error means that it is closed already.
                    let _ = client.stream.shutdown(Shutdown::Both);
                    dropped.push(client.number);
                    false
                }
            }
        });
        dropped
    }
}

impl Client {
    fn hears(&self, bit_rate: Option<u32>) -> bool {
        let channel = locked(&self.channel);
        let own = channel.bit_rate().map(|rate| rate.kbit_per_second());
        channel.is_open() && (own.is_none() || bit_rate.is_none() || own == bit_rate)
    }
}

/// Connects each client that comes. Where the computer has no means for one (files, threads), it is told once, and the next is
/// taken after a pause: whoever waits is served when others have left.
fn accept(
    streams: impl Iterator<Item = io::Result<TcpStream>>,
    clients: &Clients,
    incoming: &SyncSender<Incoming>,
    mut pause: impl FnMut(),
) {
    let mut is_told = false;
    for (number, stream) in (1..).zip(streams) {
        match stream.and_then(|stream| connect(number, stream, clients, incoming.clone())) {
            Ok(()) => is_told = false,
            // A connection that failed while it was made is the client's to repeat.
            Err(error) if is_of_the_client(&error) => {}
            Err(error) => {
                if !std::mem::replace(&mut is_told, true) {
                    let _ = incoming.send(Incoming::ClientRefused(plain(error)));
                }
                pause();
            }
        }
    }
}

fn is_of_the_client(error: &io::Error) -> bool {
    use io::ErrorKind::{ConnectionAborted, ConnectionReset, Interrupted, NotConnected};
    let kinds = [
        ConnectionAborted,
        ConnectionReset,
        Interrupted,
        NotConnected,
    ];
    kinds.contains(&error.kind())
}

/// Starts a reader and a writer for a new client.
fn connect(
    number: u64,
    stream: TcpStream,
    clients: &Clients,
    incoming: SyncSender<Incoming>,
) -> io::Result<()> {
    stream.set_nodelay(true)?;
    SockRef::from(&stream).set_send_buffer_size(SEND_BUFFER)?;
    // A computer that was switched off does not say that it leaves.
    SockRef::from(&stream).set_keepalive(true)?;
    let (lines, queue) = sync_channel(QUEUE);
    let channel = Arc::new(Mutex::new(Channel::new()));
    let client = Client {
        number,
        stream: stream.try_clone()?,
        lines: lines.clone(),
        channel: Arc::clone(&channel),
    };
    let writer = stream.try_clone()?;
    thread::Builder::new()
        .name(format!("slcan writer {number}"))
        .spawn(move || write_lines(writer, &queue))?;
    locked(clients).push(client);
    let members = Arc::clone(clients);
    let reader = thread::Builder::new()
        .name(format!("slcan reader {number}"))
        .spawn(move || {
            read_commands(number, &stream, &channel, &lines, &incoming);
            let _ = stream.shutdown(Shutdown::Both);
            // The writer ends when the last sender of its queue is gone: this thread's and the one in the list.
            forget(&members, number);
            let _ = incoming.send(Incoming::ClientLeft(number));
        });
    reader.map(|_| ()).inspect_err(|_| forget(clients, number))
}

fn forget(clients: &Clients, number: u64) {
    locked(clients).retain(|client| client.number != number);
}

fn read_commands(
    number: u64,
    mut stream: &TcpStream,
    channel: &Mutex<Channel>,
    lines: &SyncSender<Vec<u8>>,
    incoming: &SyncSender<Incoming>,
) {
    let mut decoder = Decoder::new();
    let mut bytes = [0; 4096];
    loop {
        acknowledge_quickly(stream);
        let count = match stream.read(&mut bytes) {
            Ok(0) => return,
            Ok(count) => count,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(_) => return,
        };
        let at = Instant::now();
        let (mut replies, mut messages) = (Vec::new(), Vec::new());
        for command in bytes[..count].iter().filter_map(|byte| decoder.push(*byte)) {
            let (answer, bit_rate) = {
                let mut channel = locked(channel);
                (channel.command(command), channel.bit_rate())
            };
            replies.extend_from_slice(answer.reply);
            messages.extend(answer.frame.map(|frame| Incoming::Frame {
                source: Source::Slcan(number),
                frame,
                bit_rate: bit_rate.map(|rate| rate.kbit_per_second()),
                at,
            }));
            if answer.reply == b"\x07" {
                messages.push(Incoming::Refused);
            }
        }
        // A client that sends without reading its replies is not served any longer.
        if !replies.is_empty() && lines.try_send(replies).is_err() {
            return;
        }
        for message in messages {
            if incoming.send(message).is_err() {
                return;
            }
        }
    }
}

fn write_lines(mut stream: TcpStream, queue: &Receiver<Vec<u8>>) {
    while let Ok(mut bytes) = queue.recv() {
        while let Ok(more) = queue.try_recv() {
            bytes.extend_from_slice(&more);
        }
        if stream.write_all(&bytes).is_err() {
            return;
        }
    }
}

/// Linux delays acknowledgements by 40 ms and forgets that it should not, so it is told before each read.
#[cfg(target_os = "linux")]
fn acknowledge_quickly(stream: &TcpStream) {
    // Only speed is lost if this fails.
    let _ = SockRef::from(stream).set_tcp_quickack(true);
}

#[cfg(not(target_os = "linux"))]
fn acknowledge_quickly(_stream: &TcpStream) {}

/// A panic in another thread leaves lists of clients and channel states whole.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_files_it_says_so_once_and_pauses_each_time() {
        const TOO_MANY_FILES: i32 = 24;
        let (incoming, messages) = sync_channel(8);
        let errors = [
            io::Error::from_raw_os_error(TOO_MANY_FILES),
            io::Error::from_raw_os_error(TOO_MANY_FILES),
            io::ErrorKind::ConnectionAborted.into(),
            io::Error::from_raw_os_error(TOO_MANY_FILES),
        ];
        let mut pauses = 0;
        accept(
            errors.into_iter().map(Err),
            &Clients::default(),
            &incoming,
            || pauses += 1,
        );
        assert_eq!(pauses, 3);
        let told: Vec<Incoming> = messages.try_iter().collect();
        assert!(
            matches!(&told[..], [Incoming::ClientRefused(why)] if why.contains("open files")),
            "{told:?}"
        );
    }
}
