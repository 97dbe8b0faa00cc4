//! The second SDO server, 1201h: S38 to S40 of the listed cases, and streamed objects.

use crate::device::{Device, abort};

const INVALID_VALUE: u32 = 0x0609_0030;

/// Switches the server on with free identifiers: requests on 6A4h, answers on 684h.
fn with_second_server() -> Device {
    let mut device = Device::new();
    for write in [
        "604: 23 01 12 01 A4 06 00 00",
        "604: 23 01 12 02 84 06 00 00",
    ] {
        assert_eq!(device.ask(write).len(), 1);
    }
    device
}

/// The same frame on the second server.
fn second(frame: &str) -> String {
    frame
        .replacen("604:", "6A4:", 1)
        .replacen("584:", "684:", 1)
}

#[test]
fn c04_nobody_else_sends_the_answers_of_either_server() {
    let mut device = with_second_server();
    for (answer, told) in [
        (
            "584: 43 00 10 00 92 01 02 00",
            "084: 50 81 11 84 05 00 00 00",
        ),
        (
            "684: 43 00 10 00 92 01 02 00",
            "084: 50 81 11 84 06 00 00 00",
        ),
    ] {
        assert_eq!(device.ask(answer), [told]);
    }
}

#[test]
fn s38_restricted_identifiers_are_refused() {
    let restricted = [
        0x000, 0x001, 0x07F, 0x101, 0x180, 0x581, 0x584, 0x5FF, 0x601, 0x604, 0x605, 0x67F, 0x6E0,
        0x6FF, 0x701, 0x77F, 0x7FF,
    ];
    for sub in [1, 2] {
        for cob_id in restricted {
            let mut device = Device::new();
            let [low, high] = u16::to_le_bytes(cob_id);
            let asked = format!("604: 23 01 12 {sub:02X} {low:02X} {high:02X} 00 00");
            assert_eq!(device.ask(&asked), [abort(0x1201, sub, INVALID_VALUE)]);
            // While it is off the number means nothing.
            let asked = format!("604: 23 01 12 {sub:02X} {low:02X} {high:02X} 00 80");
            assert_eq!(
                device.ask(&asked),
                [format!("584: 60 01 12 {sub:02X} 00 00 00 00")]
            );
        }
    }
}

#[test]
fn s38_identifiers_with_29_bits_and_dynamic_ones_are_refused() {
    for bits in ["20", "40", "A0"] {
        let mut device = Device::new();
        let asked = format!("604: 23 01 12 01 A4 06 00 {bits}");
        assert_eq!(device.ask(&asked), [abort(0x1201, 1, INVALID_VALUE)]);
    }
}

#[test]
fn s39_a_server_is_switched_off_before_it_changes() {
    let mut device = with_second_server();
    let moved = [
        "604: 23 01 12 01 A5 06 00 00",
        "604: 23 01 12 02 85 06 00 00",
    ];
    for (sub, asked) in (1..).zip(moved) {
        assert_eq!(device.ask(asked), [abort(0x1201, sub, INVALID_VALUE)]);
    }
    // The same value again changes nothing.
    assert_eq!(
        device.ask("604: 23 01 12 01 A4 06 00 00"),
        ["584: 60 01 12 01 00 00 00 00"]
    );
    assert_eq!(
        device.ask("604: 23 01 12 01 A4 06 00 80"),
        ["584: 60 01 12 01 00 00 00 00"]
    );
    assert!(device.ask("6A4: 40 00 10 00 00 00 00 00").is_empty());
    assert_eq!(
        device.ask("604: 23 01 12 01 A5 06 00 00"),
        ["584: 60 01 12 01 00 00 00 00"]
    );
    assert!(device.ask("6A4: 40 00 10 00 00 00 00 00").is_empty());
    assert_eq!(
        device.ask("6A5: 40 00 10 00 00 00 00 00"),
        ["684: 43 00 10 00 92 01 02 00"]
    );
}

#[test]
fn s39_one_identifier_for_both_ways_is_none() {
    let mut device = Device::new();
    assert_eq!(
        device.ask("604: 23 01 12 01 A4 06 00 00"),
        ["584: 60 01 12 01 00 00 00 00"]
    );
    assert_eq!(
        device.ask("604: 23 01 12 02 A4 06 00 00"),
        [abort(0x1201, 2, INVALID_VALUE)]
    );
}

#[test]
fn s40_transfers_on_two_servers_do_not_meet() {
    let mut device = with_second_server();
    device.set_value(0x200B, 0, b"a string of the device");
    // A segmented download here, an upload there, step by step.
    assert_eq!(
        device.ask("604: 21 01 20 00 09 00 00 00"),
        ["584: 60 01 20 00 00 00 00 00"]
    );
    assert_eq!(
        device.ask("6A4: 40 0B 20 00 00 00 00 00"),
        ["684: 41 0B 20 00 16 00 00 00"]
    );
    assert_eq!(
        device.ask("604: 00 61 62 63 64 65 66 67"),
        ["584: 20 00 00 00 00 00 00 00"]
    );
    assert_eq!(
        device.ask("6A4: 60 00 00 00 00 00 00 00"),
        ["684: 00 61 20 73 74 72 69 6E"]
    );
    assert_eq!(
        device.ask("6A4: 70 00 00 00 00 00 00 00"),
        ["684: 10 67 20 6F 66 20 74 68"]
    );
    assert_eq!(
        device.ask("604: 1B 68 69 00 00 00 00 00"),
        ["584: 30 00 00 00 00 00 00 00"]
    );
    assert_eq!(device.value(0x2001, 0), b"abcdefghi");
    // An abort here, and there it goes on.
    assert_eq!(device.ask("604: 40 01 20 00 00 00 00 00").len(), 1);
    assert!(device.ask("604: 80 01 20 00 00 00 00 00").is_empty());
    assert_eq!(
        device.ask("6A4: 60 00 00 00 00 00 00 00"),
        ["684: 00 65 20 64 65 76 69 63"]
    );
    assert_eq!(
        device.ask("6A4: 70 00 00 00 00 00 00 00"),
        ["684: 1D 65 00 00 00 00 00 00"]
    );
}

#[test]
fn s40_both_servers_time_out_alone() {
    let mut device = with_second_server();
    assert_eq!(device.ask("604: 40 01 20 00 00 00 00 00").len(), 1);
    assert!(device.pass(300).is_empty());
    assert_eq!(device.ask("6A4: 21 01 20 00 09 00 00 00").len(), 1);
    let sent = device.pass(2000);
    let expected = [
        (700, abort(0x2001, 0, 0x0504_0000)),
        (
            1000,
            abort(0x2001, 0, 0x0504_0000).replacen("584", "684", 1),
        ),
    ];
    assert_eq!(sent, expected);
}

#[test]
fn s40_a_server_that_is_not_valid_is_silent() {
    let mut device = Device::new();
    assert_eq!(device.ask("604: 23 01 12 01 A4 06 00 00").len(), 1);
    assert!(device.ask("6A4: 40 00 10 00 00 00 00 00").is_empty());
    assert_eq!(device.ask("604: 23 01 12 02 84 06 00 00").len(), 1);
    assert_eq!(
        device.ask("6A4: 40 00 10 00 00 00 00 00"),
        ["684: 43 00 10 00 92 01 02 00"]
    );
    device.send("000 [2] 82 04");
    device.serve_reset();
    assert_eq!(device.sent(), ["704 [1] 00"]);
    assert!(device.ask("6A4: 40 00 10 00 00 00 00 00").is_empty());
}

#[test]
fn s40_answers_leave_lowest_identifier_first() {
    let mut device = with_second_server();
    device.put("6A4: 40 00 10 00 00 00 00 00");
    device.put("604: 40 00 10 00 00 00 00 00");
    assert_eq!(
        device.sent(),
        [
            "584: 43 00 10 00 92 01 02 00",
            "684: 43 00 10 00 92 01 02 00"
        ]
    );
}

#[test]
fn a_server_that_switches_itself_off_still_answers() {
    let mut device = with_second_server();
    assert_eq!(
        device.ask("6A4: 23 01 12 01 A4 06 00 80"),
        ["684: 60 01 12 01 00 00 00 00"]
    );
    assert!(device.ask("6A4: 40 00 10 00 00 00 00 00").is_empty());
}

#[test]
fn a_server_is_deaf_while_the_node_is_stopped() {
    let mut device = with_second_server();
    device.send("000 [2] 02 04");
    assert!(device.ask("6A4: 40 00 10 00 00 00 00 00").is_empty());
    device.send("000 [2] 80 04");
    assert_eq!(
        device.ask("6A4: 40 00 10 00 00 00 00 00"),
        ["684: 43 00 10 00 92 01 02 00"]
    );
}

#[test]
fn one_client_at_a_time_writes_a_streamed_object() {
    let mut device = with_second_server();
    assert_eq!(device.ask("604: 20 14 20 00 00 00 00 00").len(), 1);
    let refused = second(&abort(0x2014, 0, 0x0800_0022));
    for initiate in [
        "6A4: 20 14 20 00 00 00 00 00",
        "6A4: C0 14 20 00 00 00 00 00",
    ] {
        assert_eq!(device.ask(initiate), std::slice::from_ref(&refused));
    }
    // It may be read meanwhile, and the first client goes on.
    assert_eq!(device.ask("6A4: 40 14 20 00 00 00 00 00").len(), 1);
    assert_eq!(
        device.ask("6A4: 60 00 00 00 00 00 00 00"),
        ["684: 0F 00 00 00 00 00 00 00"]
    );
    assert_eq!(
        device.ask("604: 05 61 62 63 64 65 00 00"),
        ["584: 20 00 00 00 00 00 00 00"]
    );
    assert_eq!(device.firmware.stream.value, b"abcde");
    assert_eq!(
        device.ask("6A4: 20 14 20 00 00 00 00 00"),
        ["684: 60 14 20 00 00 00 00 00"]
    );
}

#[test]
fn s27_each_segment_of_a_streamed_object_begins_the_time_of_the_next() {
    let mut device = with_second_server();
    assert_eq!(device.ask("604: 20 14 20 00 00 00 00 00").len(), 1);
    for (segment, answer) in [
        (
            "604: 00 61 62 63 64 65 66 67",
            "584: 20 00 00 00 00 00 00 00",
        ),
        (
            "604: 10 61 62 63 64 65 66 67",
            "584: 30 00 00 00 00 00 00 00",
        ),
        (
            "604: 05 61 62 63 64 65 00 00",
            "584: 20 00 00 00 00 00 00 00",
        ),
    ] {
        device.pass(600);
        assert_eq!(device.ask(segment), [answer]);
    }
    assert_eq!(device.firmware.stream.value, b"abcdefgabcdefgabcde");
}

#[test]
fn a_streamed_object_that_is_read_does_not_become_another_one() {
    let value = b"the old value";
    let start = || {
        let mut device = with_second_server();
        device.firmware.stream.value = value.to_vec();
        device
    };
    let read_first = |device: &mut Device| {
        assert_eq!(
            device.ask("6A4: 40 14 20 00 00 00 00 00"),
            ["684: 41 14 20 00 0D 00 00 00"]
        );
        assert_eq!(
            device.ask("6A4: 60 00 00 00 00 00 00 00"),
            [second("584: 00 74 68 65 20 6F 6C 64")]
        );
    };
    let read_last = |device: &mut Device| {
        assert_eq!(
            device.ask("6A4: 70 00 00 00 00 00 00 00"),
            [second("584: 13 20 76 61 6C 75 65 00")]
        );
    };
    let refused = abort(0x2014, 0, 0x0800_0022);

    // A write does not begin while another client reads.
    let mut device = start();
    read_first(&mut device);
    for initiate in [
        "604: 20 14 20 00 00 00 00 00",
        "604: C0 14 20 00 00 00 00 00",
    ] {
        assert_eq!(device.ask(initiate), std::slice::from_ref(&refused));
    }
    read_last(&mut device);
    assert_eq!(device.ask("604: 20 14 20 00 00 00 00 00").len(), 1);

    // Nor does one end that had begun before.
    let mut device = start();
    assert_eq!(device.ask("604: 20 14 20 00 00 00 00 00").len(), 1);
    read_first(&mut device);
    assert_eq!(device.ask("604: 05 61 62 63 64 65 00 00"), [refused]);
    assert_eq!(device.firmware.stream.value, value);
    assert_eq!(device.firmware.stream.abandoned, 1);
    read_last(&mut device);
}

#[test]
fn the_application_learns_of_a_write_that_ends_early() {
    // By the client, by a new request, by silence, by a segment in the wrong place, by NMT, by a reset.
    let endings: [fn(&mut Device); 6] = [
        |device| device.send("604: 80 14 20 00 00 00 00 00"),
        |device| device.send("604: 40 00 10 00 00 00 00 00"),
        |device| {
            device.pass(1000);
        },
        |device| device.send("604: 10 61 62 63 64 65 66 67"),
        |device| device.send("000 [2] 02 04"),
        |device| {
            device.put("000 [2] 81 04");
            device.serve_reset();
        },
    ];
    for initiate in [
        "604: 20 14 20 00 00 00 00 00",
        "604: C0 14 20 00 00 00 00 00",
    ] {
        for end in endings {
            let mut device = Device::new();
            assert_eq!(device.ask(initiate).len(), 1);
            assert!(device.firmware.stream.incoming.is_some());
            end(&mut device);
            if initiate.contains(": C0") && device.firmware.stream.abandoned == 0 {
                // Within a sub-block a request is a segment: only time tells.
                device.pass(1000);
            }
            assert_eq!(device.firmware.stream.abandoned, 1);
            assert!(device.firmware.stream.incoming.is_none());
        }
    }
}
