//! How a transfer ends beside its last segment: by the client's abort on a busy bus, and by the time of its frames.

mod device;

use canopen::Duration;
use device::{Device, abort};

const OPEN_DOWNLOAD: &str = "604#2101200005000000";
const TIMED_OUT: u32 = 0x0504_0000;

/// Time passes; the device is not called.
fn wait(device: &mut Device, milliseconds: u64) {
    device.now += Duration::millis(milliseconds);
}

#[test]
fn an_abort_needs_no_room_for_an_answer() {
    let mut device = Device::new();
    assert_eq!(device.ask("604#4001200000000000").len(), 1);
    device.put("604#4000100000000000");
    device.put("604#2101200003000000");
    assert_eq!(device.node.overflows(), 0);
    device.put("604#8001200000000000");
    assert_eq!(device.node.overflows(), 0, "nothing is lost");
    assert_eq!(device.sent().len(), 2);
    assert_eq!(
        device.ask("604#0961626300000000"),
        [abort(0, 0, 0x0504_0001)],
        "no transfer is open"
    );
    assert!(device.pass(2000).is_empty(), "nor times out");
}

#[test]
fn s26_a_segment_that_comes_too_late_ends_the_transfer() {
    let mut device = Device::new();
    assert_eq!(device.ask(OPEN_DOWNLOAD), ["584#6001200000000000"]);
    wait(&mut device, 1000);
    // The frame is served before time is.
    device.put("604#0561626364650000");
    assert_eq!(device.sent(), [abort(0x2001, 0, TIMED_OUT)]);
    assert_eq!(device.value(0x2001, 0)[..5], *b"hello");
    assert!(device.pass(2000).is_empty(), "told once");

    assert_eq!(device.ask("604#4001200000000000"), ["584#4101200005000000"]);
    wait(&mut device, 1000);
    device.put("604#6000000000000000");
    assert_eq!(device.sent(), [abort(0x2001, 0, TIMED_OUT)]);
}

#[test]
fn s27_a_segment_just_in_time_is_taken() {
    let mut device = Device::new();
    assert_eq!(device.ask(OPEN_DOWNLOAD), ["584#6001200000000000"]);
    device.now += Duration::micros(999_999);
    device.put("604#0561626364650000");
    assert_eq!(device.sent(), ["584#2000000000000000"]);
}
