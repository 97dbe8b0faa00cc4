//! The LSS slave of a device without a node-ID, or of node 4: nine bytes a request, of which the first tells the pause before.
#![no_main]

use canopen::{Duration, Frame};
use fuzz::hold;
use fuzz::watched::{Step, Watched};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let (first, rest) = bytes.split_first().unwrap_or((&0, &[]));
    let mut device = Watched::booted(if first & 1 == 0 { 255 } else { 4 });
    for record in rest.chunks_exact(9) {
        let (how, request) = (record[0], &record[1..]);
        hold(device.take(&Step::Pass(Duration::from_ticks(
            u64::from(how >> 2) * 20_000,
        ))));
        // A reset of the node among the requests.
        let frame = if how & 1 == 0 {
            Frame::data_frame(0x7E5, request)
        } else {
            Frame::data_frame(0x000, &[0x81 + (how >> 1 & 1), 0])
        };
        hold(device.take(&Step::Frame(frame)));
        if how & 2 == 0 {
            hold(device.drain());
        }
    }
    hold(device.recover());
});
