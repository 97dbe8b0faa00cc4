//! An I/O device with two transmit PDOs: the inputs when they change, a voltage at each SYNC.
//!
//! ```text
//! cargo run --example io_device                     a short talk on a bus in memory, in virtual time
//! cargo run --example io_device 127.0.0.1:4000      in real time, for a master that speaks SLCAN on TCP
//! ```
//!
//! With python-canopen: `network.connect(interface="slcan", channel="socket://127.0.0.1:4000", bitrate=1000000)`, and the node-ID is 5.
//!
//! `dictionary.rs` was written from the data sheet beside it: `od-gen rust io-device.eds -o dictionary.rs`. A crate of its own has a build script
//! do that, as the README says.
#![forbid(unsafe_code)]

mod device;
#[rustfmt::skip]
mod dictionary;
mod serial_line;

use canopen::{Duration, Frame, Instant, NodeId};
use device::IoDevice;

fn main() -> std::io::Result<()> {
    let node_id = NodeId::new(5).expect("it is between 1 and 127");
    match std::env::args().nth(1) {
        Some(address) => serial_line::serve(&address, node_id),
        None => {
            talk(node_id);
            Ok(())
        }
    }
}

/// A master's frames, each with the time at which it comes, and all that the device answers.
fn talk(node_id: NodeId) {
    let script = [
        (
            "heartbeats each 500 ms",
            0x605,
            &[0x2B, 0x17, 0x10, 0, 0xF4, 1, 0, 0][..],
        ),
        ("start", 0x000, &[1, 5]),
        ("two outputs on", 0x205, &[0b11]),
        ("SYNC", 0x080, &[]),
    ];
    let mut now = Instant::from_ticks(0);
    let mut device = IoDevice::new(node_id, now);
    for (what, cob_id, data) in script {
        pass(&mut device, &mut now, Duration::millis(200));
        println!("{what}");
        device.receive(&Frame::data_frame(cob_id, data), now);
    }
    pass(&mut device, &mut now, Duration::secs(1));
}

/// Lets a span pass: the device is called at each moment that it has asked for, and what it sends is printed.
fn pass(device: &mut IoDevice, now: &mut Instant, span: Duration) {
    let end = *now + span;
    loop {
        let mut deadline = device.poll(*now);
        while let Some(frame) = device.transmit() {
            let (cob_id, data) = (frame.standard_id().unwrap_or_default(), frame.payload());
            println!("{:9} µs  {cob_id:03X} {data:02X?}", now.ticks());
            deadline = device.poll(*now);
        }
        if deadline > end {
            *now = end;
            return;
        }
        *now = deadline;
    }
}
