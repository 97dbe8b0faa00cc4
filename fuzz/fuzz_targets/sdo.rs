//! Two SDO servers and any requests: nine bytes each, of which the first tells the server and the pause before.
#![no_main]

use canopen::{Duration, Frame};
use fuzz::hold;
use fuzz::watched::{Step, Watched};
use libfuzzer_sys::fuzz_target;

/// The second server listens at 680h and answers at 681h.
const SECOND_SERVER: [[u8; 8]; 2] = [
    [0x23, 0x01, 0x12, 1, 0x80, 0x06, 0, 0],
    [0x23, 0x01, 0x12, 2, 0x81, 0x06, 0, 0],
];

fuzz_target!(|bytes: &[u8]| {
    let mut device = Watched::booted(4);
    for request in SECOND_SERVER {
        hold(device.take(&Step::Frame(Frame::data_frame(0x604, &request))));
        hold(device.drain());
    }
    for record in bytes.chunks_exact(9) {
        let (how, request) = (record[0], &record[1..]);
        let server = if how & 1 == 0 { 0x604 } else { 0x680 };
        // Up to 1.2 seconds: a transfer times out after one.
        let pause = u64::from(how >> 2 & 0x1F) * 40_000;
        hold(device.take(&Step::Pass(Duration::from_ticks(pause))));
        hold(device.take(&Step::Frame(Frame::data_frame(server, request))));
        // On a bus that is not free the answers wait.
        if how & 2 == 0 {
            hold(device.drain());
        }
    }
    hold(device.recover());
});
