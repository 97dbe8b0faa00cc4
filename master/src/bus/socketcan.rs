//! SocketCAN: a station on a CAN interface of Linux, virtual or real.

use std::io;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;
use std::time::Duration;

use canopen::Frame;
use embedded_can::Frame as _;
use socketcan::{CanFrame, CanSocket, ShouldRetry, Socket};

use super::live::{Incoming, Source};
use crate::system_error::plain;

/// Frames that may wait for the interface. With a bus that is down, newer ones are dropped.
const QUEUE: usize = 256;

/// How long to wait when the interface's own queue is full.
const RETRY: Duration = Duration::from_millis(1);

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
    loop {
        let message = match socket.read_frame() {
            Ok(frame @ (CanFrame::Data(_) | CanFrame::Remote(_))) => match converted(&frame) {
                Some(frame) => Incoming::Frame {
                    source: Source::SocketCan,
                    frame,
                    bit_rate: None,
                },
                None => continue,
            },
            Ok(CanFrame::Error(_)) => continue,
            Err(error) if error.should_retry() => continue,
            Err(error) => Incoming::Failed(format!("the CAN interface failed: {}", plain(error))),
        };
        let failed = matches!(message, Incoming::Failed(_));
        if incoming.send(message).is_err() || failed {
            return;
        }
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

fn converted(frame: &CanFrame) -> Option<Frame> {
    if frame.is_remote_frame() {
        Frame::new_remote(frame.id(), frame.dlc())
    } else {
        Frame::new(frame.id(), frame.data())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_of_the_interface_are_those_of_the_bus() {
        let data = Frame::data_frame(0x604, &[1, 2, 3]);
        let frame = CanFrame::new(data.id(), data.payload()).unwrap();
        assert_eq!(converted(&frame), Some(data));
        let remote = Frame::remote_frame(0x704, 1);
        let frame = CanFrame::new_remote(remote.id(), 1).unwrap();
        assert_eq!(converted(&frame), Some(remote));
    }

    #[test]
    fn a_missing_interface_is_an_error() {
        let (incoming, _messages) = sync_channel(1);
        assert!(Interface::open("no-such-can0", incoming).is_err());
    }
}
