//! Who gets a frame: identifiers that change, and a second device with ours (C04).

mod device;

use device::Device;

fn collision(cob_id: u16) -> String {
    let [low, high] = cob_id.to_le_bytes();
    format!("084#508111{low:02X}{high:02X}000000")
}

#[test]
fn c04_a_frame_that_only_this_device_sends_is_told_once_for_each_identifier() {
    let mut device = Device::new();
    for (frame, cob_id) in [
        ("704#00", 0x704),
        ("584#4300100092010200", 0x584),
        ("084#0000000000000000", 0x084),
        ("184#0000000000000000", 0x184),
    ] {
        assert_eq!(device.ask(frame), [collision(cob_id)]);
        assert_eq!(device.ask(frame), [""; 0]);
    }
    assert_eq!(device.value(0x1001, 0), [0x11]);
    device.send("000#8204");
    device.serve_reset();
    assert_eq!(device.sent(), ["704#00"]);
    assert_eq!(device.value(0x1001, 0), [0], "communication starts anew");
}

#[test]
fn c04_what_others_may_send_is_no_collision() {
    let mut device = Device::new();
    for frame in [
        "705#05",
        "585#4300100092010200",
        "085#0000000000000000",
        "284#00",
        "185#00",
        "704#R",
        "184#R",
        "7E4#5004000000000000",
    ] {
        device.put(frame);
    }
    device.sent();
    assert_eq!(device.value(0x1001, 0), [0]);
}

#[test]
fn c04_an_identifier_that_moved_counts_from_then_on() {
    let mut device = Device::new();
    device.ask("604#23001801840100C0");
    assert_eq!(device.ask("184#00"), [""; 0], "the PDO is not valid");
    device.ask("604#2300180185010040");
    assert_eq!(device.ask("184#00"), [""; 0]);
    assert_eq!(device.ask("185#00"), [collision(0x185)]);
}
