//! The device in real time, on a bus whose other end is a program: SLCAN on TCP.

use std::io::{self, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time;

use canopen::{Instant, NodeId};
use slcan::{Channel, Command, Decoder, encode};

use crate::device::IoDevice;

/// Serves one client after the other; the device runs all the time that one is connected.
pub fn serve(address: &str, node_id: NodeId) -> io::Result<()> {
    let listener = TcpListener::bind(address)?;
    let power_on = time::Instant::now();
    let mut device = IoDevice::new(node_id, Instant::from_ticks(0));
    println!("ready");
    for stream in listener.incoming() {
        let stream = stream?;
        stream.set_nodelay(true)?;
        let reader = stream.try_clone()?;
        let (sender, commands) = channel();
        thread::spawn(move || read(reader, &sender));
        // A client that has gone is no reason to end.
        let _ = run(&mut device, power_on, stream, &commands);
    }
    Ok(())
}

/// The device and one client, until that leaves.
fn run(
    device: &mut IoDevice,
    power_on: time::Instant,
    mut stream: TcpStream,
    commands: &Receiver<Command>,
) -> io::Result<()> {
    let now = || Instant::from_ticks(power_on.elapsed().as_micros() as u64);
    let mut channel = Channel::new();
    loop {
        let mut deadline = device.poll(now());
        while channel.is_open()
            && let Some(frame) = device.transmit()
        {
            stream.write_all(&encode(&frame))?;
            deadline = device.poll(now());
        }
        let wait = deadline.checked_duration_since(now());
        let wait = time::Duration::from_micros(wait.map_or(0, |span| span.ticks()));
        match commands.recv_timeout(wait) {
            Ok(command) => {
                let answer = channel.command(command);
                stream.write_all(answer.reply)?;
                if let Some(frame) = answer.frame {
                    device.receive(&frame, now());
                }
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        }
    }
}

/// Hands on what the client says.
fn read(mut stream: TcpStream, commands: &Sender<Command>) {
    let (mut decoder, mut bytes) = (Decoder::new(), [0; 256]);
    while let Ok(count @ 1..) = stream.read(&mut bytes) {
        for command in bytes[..count].iter().filter_map(|byte| decoder.push(*byte)) {
            if commands.send(command).is_err() {
                return;
            }
        }
    }
}
