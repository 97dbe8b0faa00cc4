//! SocketCAN: a station on a CAN interface of Linux, virtual or real.

use std::io::{self, IoSliceMut};
use std::os::fd::{AsFd, AsRawFd};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;
use std::time::{Duration as WallDuration, Instant, SystemTime};

use canopen::Frame;
use embedded_can::{ExtendedId, Frame as _, Id, StandardId};
use nix::errno::Errno;
use nix::sys::socket::sockopt::{ReceiveTimestampns, RxqOvfl};
use nix::sys::socket::{ControlMessageOwned, MsgFlags, recvmsg, setsockopt};
use nix::sys::time::TimeSpec;
use socketcan::{CanFrame, CanSocket, ShouldRetry, Socket};

use super::live::{Incoming, Source};
use crate::system_error::plain;

/// Frames that may wait for the interface. With a bus that is down, newer ones are dropped.
const QUEUE: usize = 256;

/// How long to wait when the interface's own queue is full.
const RETRY: WallDuration = WallDuration::from_millis(1);

/// An open CAN interface.
#[derive(Debug)]
pub struct Interface {
    frames: SyncSender<CanFrame>,
}

impl Interface {
    /// Opens the interface and hands what it receives to `incoming`.
    ///
    /// # Errors
    /// If there is no such interface, or it is no CAN interface.
    pub fn open(name: &str, incoming: SyncSender<Incoming>) -> io::Result<Self> {
        let socket = Arc::new(CanSocket::open(name)?);
        setsockopt(&socket.as_fd(), ReceiveTimestampns, &true)?;
        setsockopt(&socket.as_fd(), RxqOvfl, &1)?;
        let (frames, queue) = sync_channel(QUEUE);
        let writer = Arc::clone(&socket);
        let failures = incoming.clone();
        thread::Builder::new()
            .name("socketcan writer".to_owned())
            .spawn(move || write_frames(&writer, &queue, &failures))?;
        thread::Builder::new()
            .name("socketcan reader".to_owned())
            .spawn(move || read_frames(&socket, &incoming))?;
        Ok(Self { frames })
    }

    /// Queues a frame for the interface.
    pub fn send(&mut self, frame: &Frame) {
        let frame = if frame.is_remote() {
            CanFrame::new_remote(frame.id(), frame.length().into())
        } else {
            CanFrame::new(frame.id(), frame.payload())
        };
        if let Some(frame) = frame {
            // Full: nobody acknowledges on that bus. Data that old is worth nothing.
            let _ = self.frames.try_send(frame);
        }
    }
}

fn read_frames(socket: &CanSocket, incoming: &SyncSender<Incoming>) {
    let mut lost = 0;
    let mut latest = Instant::now();
    loop {
        let messages = match receive(socket) {
            Ok(Received { frame, at, dropped }) => {
                let newly = dropped.map_or(0, |dropped| dropped.wrapping_sub(lost));
                lost = dropped.unwrap_or(lost);
                // Two clocks make the time: it may differ by less than lies between two frames, but those stay in their order.
                latest = latest.max(at);
                let at = latest;
                let frame = frame.map(|frame| Incoming::Frame {
                    source: Source::SocketCan,
                    frame,
                    bit_rate: None,
                    at,
                });
                // Those that were dropped came behind what waited then, and before this one or later.
                [(newly > 0).then_some(Incoming::Lost(newly)), frame]
            }
            Err(Errno::EINTR | Errno::EAGAIN) => continue,
            Err(error) => {
                let error = format!(
                    "the CAN interface failed: {}",
                    plain(io::Error::from(error))
                );
                let _ = incoming.send(Incoming::Failed(error));
                return;
            }
        };
        for message in messages.into_iter().flatten() {
            if incoming.send(message).is_err() {
                return;
            }
        }
    }
}

/// What the system tells of a frame.
struct Received {
    /// `None` for an error frame.
    frame: Option<Frame>,
    at: Instant,
    /// Frames that found no room since the socket was opened.
    dropped: Option<u32>,
}

/// A frame, with the time at which it came.
fn receive(socket: &CanSocket) -> Result<Received, Errno> {
    let mut bytes = [0; FRAME];
    let mut told = nix::cmsg_space!(TimeSpec, u32);
    let mut parts = [IoSliceMut::new(&mut bytes)];
    let file = socket.as_fd().as_raw_fd();
    let message = recvmsg::<()>(file, &mut parts, Some(&mut told), MsgFlags::empty())?;
    let (mut at, mut dropped) = (Instant::now(), None);
    for told in message.cmsgs()? {
        match told {
            ControlMessageOwned::ScmTimestampns(stamp) => {
                let stamp = SystemTime::UNIX_EPOCH + WallDuration::from(stamp);
                let age = stamp.elapsed().unwrap_or_default();
                at = at.checked_sub(age).unwrap_or(at);
            }
            ControlMessageOwned::RxqOvfl(count) => dropped = Some(count),
            _ => {}
        }
    }
    Ok(Received {
        frame: parsed(&bytes),
        at,
        dropped,
    })
}

/// Bytes of a frame on a socket: identifier and flags, length, three of no meaning, data.
const FRAME: usize = 16;

fn parsed(bytes: &[u8; FRAME]) -> Option<Frame> {
    const EXTENDED: u32 = 1 << 31;
    const REMOTE: u32 = 1 << 30;
    const ERROR: u32 = 1 << 29;
    let [a, b, c, d, length, _, _, _, data @ ..] = *bytes;
    let word = u32::from_ne_bytes([a, b, c, d]);
    let id = if word & EXTENDED != 0 {
        Id::from(ExtendedId::new(word & 0x1FFF_FFFF)?)
    } else {
        Id::from(StandardId::new((word & 0x7FF) as u16)?)
    };
    match word & (REMOTE | ERROR) {
        0 => Frame::new(id, data.get(..length.into())?),
        REMOTE => Frame::new_remote(id, length.into()),
        _ => None,
    }
}

fn write_frames(socket: &CanSocket, queue: &Receiver<CanFrame>, failures: &SyncSender<Incoming>) {
    while let Ok(frame) = queue.recv() {
        while let Err(error) = socket.write_frame(&frame) {
            // The interface's queue is full.
            if error.should_retry() || error.raw_os_error() == Some(NO_BUFFER_SPACE) {
                thread::sleep(RETRY);
                continue;
            }
            let failed = Incoming::Failed(format!("the CAN interface failed: {}", plain(error)));
            let _ = failures.send(failed);
            return;
        }
    }
}

/// ENOBUFS of Linux.
const NO_BUFFER_SPACE: i32 = 105;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_of_the_interface_are_those_of_the_bus() {
        let bytes = |word: u32, length, data: &[u8]| {
            let mut bytes = [0; FRAME];
            bytes[..4].copy_from_slice(&word.to_ne_bytes());
            bytes[4] = length;
            bytes[8..8 + data.len()].copy_from_slice(data);
            parsed(&bytes)
        };
        let data = Frame::data_frame(0x604, &[1, 2, 3]);
        assert_eq!(bytes(0x604, 3, &[1, 2, 3]), Some(data));
        let remote = Frame::remote_frame(0x704, 1);
        assert_eq!(bytes(0x4000_0704, 1, &[]), Some(remote));
        let long = bytes(0x9234_5678, 0, &[]).unwrap();
        assert_eq!(long.id(), ExtendedId::new(0x1234_5678).unwrap().into());
        assert_eq!(bytes(0x2000_0004, 8, &[0; 8]), None, "an error frame");
        assert_eq!(bytes(0x604, 9, &[]), None, "longer than any");
    }

    #[test]
    fn a_missing_interface_is_an_error() {
        let (incoming, _messages) = sync_channel(1);
        assert!(Interface::open("no-such-can0", incoming).is_err());
    }
}
