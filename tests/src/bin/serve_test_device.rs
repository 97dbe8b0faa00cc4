//! Serves the plain test device in real time, for masters of other programs.
//!
//! The drive has no DOMAIN, as no user would need one there; transfers of many thousand bytes go to this device. Like the
//! virtual drive it waits for a node-ID by LSS, says `ready` once it can be reached, and ends by a signal.

use std::io::{self, Write};
use std::process::ExitCode;
use std::{env, time};

use canopen::{Instant, NodeId};
use sim::bus::Station;
use sim::bus::live::{Incoming, LONGEST_SLEEP, LiveBus, Source};
use tests::plain_node::PlainNode;

const USAGE: &str = "Usage: serve_test_device --slcan <ADDRESS:PORT> | --socketcan <INTERFACE>";

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let mut bus = LiveBus::new();
    let joined = match arguments.as_slice() {
        ["--slcan", address] => bus.serve_slcan(address).map(drop),
        ["--socketcan", interface] => bus.join_socketcan(interface),
        _ => {
            eprintln!("{USAGE}");
            return ExitCode::from(2);
        }
    };
    if let Err(error) = joined {
        eprintln!("serve_test_device: {}: {error}", arguments[1]);
        return ExitCode::from(2);
    }
    match run(&mut bus) {
        Ok(()) => ExitCode::SUCCESS,
        Err(what) => {
            eprintln!("serve_test_device: {what}");
            ExitCode::FAILURE
        }
    }
}

/// Runs the device until a signal comes or the transport fails.
fn run(bus: &mut LiveBus) -> Result<(), String> {
    let stopper = bus.stopper();
    ctrlc::set_handler(move || {
        // An error means that the loop has ended already.
        let _ = stopper.send(Incoming::Stop);
    })
    .map_err(|error| format!("cannot catch signals: {error}"))?;

    let mut device = PlainNode::new(NodeId::UNCONFIGURED);
    let start = time::Instant::now();
    let now = || Instant::from_ticks(start.elapsed().as_micros() as u64);
    let mut is_ready = false;
    loop {
        let wake = time::Duration::from_micros(device.poll(now()).ticks());
        send_all(&mut device, bus);
        if !is_ready {
            is_ready = true;
            println!("ready");
            // Nobody may be reading; the device runs all the same.
            let _ = io::stdout().flush();
        }
        let deadline = start + wake.min(start.elapsed() + LONGEST_SLEEP);
        match bus.receive(deadline) {
            Some(Incoming::Frame { source, frame, .. }) => {
                bus.send(&frame, source, None);
                device.receive(&frame, now());
            }
            Some(Incoming::Failed(what)) => return Err(what),
            Some(Incoming::Stop) => return Ok(()),
            Some(Incoming::ClientLeft(_) | Incoming::Refused) | None => {}
        }
        send_all(&mut device, bus);
    }
}

fn send_all(device: &mut PlainNode, bus: &mut LiveBus) {
    while let Some(frame) = device.transmit() {
        bus.send(&frame, Source::Own, None);
    }
}
