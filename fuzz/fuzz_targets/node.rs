//! The whole node: any frames at any times, and what its firmware does.
#![no_main]

use fuzz::hold;
use fuzz::watched::{Watched, decode};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut device = Watched::booted(4);
    for step in decode(bytes) {
        hold(device.take(&step));
    }
    hold(device.recover());
});
