//! Emergency producer: error register, history, messages and their inhibit time.

use crate::device::{Device, abort};
use canopen::cia301::emergency::{Emergency, ErrorRegister};

pub const OVERCURRENT: Emergency = Emergency {
    code: 0x2310,
    register: ErrorRegister::CURRENT,
    info: [0x11, 0x22, 0x33, 0x44, 0x55],
};
pub const OVERHEATED: Emergency = Emergency {
    code: 0x4210,
    register: ErrorRegister::TEMPERATURE,
    info: [0; 5],
};

pub fn report(device: &mut Device, emergency: Emergency) -> Vec<String> {
    device.node.report(emergency, device.now);
    device.poll();
    device.sent()
}

pub fn clear(device: &mut Device, code: u16) -> Vec<String> {
    device.node.clear(code, device.now);
    device.poll();
    device.sent()
}

/// One of many different errors.
pub fn error(number: u8) -> Emergency {
    Emergency {
        code: 0xFF00 + u16::from(number),
        register: ErrorRegister::MANUFACTURER,
        info: [number; 5],
    }
}

#[test]
fn e01_without_a_valid_cob_id_only_the_history_grows() {
    let mut device = Device::new();
    assert_eq!(
        device.ask("604: 23 14 10 00 84 00 00 80"),
        ["584: 60 14 10 00 00 00 00 00"]
    );
    assert!(report(&mut device, OVERCURRENT).is_empty());
    assert_eq!(device.value(0x1003, 0), [1]);
    assert_eq!(device.value(0x1001, 0), [3]);
    assert_eq!(
        device.ask("604: 23 14 10 00 84 00 00 00"),
        ["584: 60 14 10 00 00 00 00 00"]
    );
    assert_eq!(
        report(&mut device, OVERHEATED),
        ["084: 10 42 0B 00 00 00 00 00"]
    );
}

#[test]
fn e02_the_identifier_changes_only_while_it_is_not_valid() {
    let mut device = Device::new();
    assert_eq!(
        device.ask("604: 23 14 10 00 85 00 00 00"),
        [abort(0x1014, 0, 0x0609_0030)]
    );
    assert_eq!(
        device.ask("604: 23 14 10 00 84 00 00 00"),
        ["584: 60 14 10 00 00 00 00 00"],
        "the same value again"
    );
    assert_eq!(
        device.ask("604: 23 14 10 00 84 00 00 80"),
        ["584: 60 14 10 00 00 00 00 00"]
    );
    assert_eq!(
        device.ask("604: 23 14 10 00 90 00 00 00"),
        ["584: 60 14 10 00 00 00 00 00"]
    );
    assert_eq!(
        report(&mut device, OVERHEATED),
        ["090: 10 42 09 00 00 00 00 00"]
    );
}

#[test]
fn e02_extended_and_reserved_bits_are_refused() {
    let mut device = Device::new();
    for value in ["84000020", "84000040", "840800A0"] {
        assert_eq!(
            device.ask(&format!("604: 23 14 10 00 {value}")),
            [abort(0x1014, 0, 0x0609_0030)],
            "{value}"
        );
    }
}

#[test]
fn e03_the_first_error_shows_everywhere() {
    let mut device = Device::new();
    assert_eq!(
        report(&mut device, OVERCURRENT),
        ["084: 10 23 03 11 22 33 44 55"]
    );
    assert_eq!(
        device.ask("604: 40 01 10 00 00 00 00 00"),
        ["584: 4F 01 10 00 03 00 00 00"]
    );
    assert_eq!(
        device.ask("604: 40 03 10 00 00 00 00 00"),
        ["584: 4F 03 10 00 01 00 00 00"]
    );
    assert_eq!(
        device.ask("604: 40 03 10 01 00 00 00 00"),
        ["584: 43 03 10 01 10 23 11 22"]
    );
}

#[test]
fn e04_an_error_is_told_once_and_its_end_once() {
    let mut device = Device::new();
    report(&mut device, OVERCURRENT);
    assert!(report(&mut device, OVERCURRENT).is_empty());
    assert_eq!(device.value(0x1003, 0), [1]);
    report(&mut device, OVERHEATED);
    assert_eq!(
        clear(&mut device, 0x2310),
        ["084: 00 00 09 00 00 00 00 00"],
        "the other error stands"
    );
    assert!(clear(&mut device, 0x2310).is_empty());
    assert_eq!(clear(&mut device, 0x4210), ["084: 00 00 00 00 00 00 00 00"]);
    assert_eq!(device.value(0x1001, 0), [0]);
    assert_eq!(device.value(0x1003, 0), [2], "the history remains");
    assert_eq!(
        report(&mut device, OVERCURRENT).len(),
        1,
        "it may come again"
    );
}

#[test]
fn e05_the_oldest_of_nine_errors_falls_out() {
    let mut device = Device::new();
    for number in 1..=9 {
        assert_eq!(report(&mut device, error(number)).len(), 1);
    }
    assert_eq!(device.value(0x1003, 0), [8]);
    for (sub, number) in (1..=8).zip((2..=9).rev()) {
        assert_eq!(device.value(0x1003, sub), [number, 0xFF, number, number]);
    }
}

#[test]
fn e06_writing_zero_clears_the_history() {
    let mut device = Device::new();
    report(&mut device, OVERCURRENT);
    assert_eq!(
        device.ask("604: 2F 03 10 00 01 00 00 00"),
        [abort(0x1003, 0, 0x0609_0030)]
    );
    assert_eq!(device.value(0x1003, 0), [1]);
    assert_eq!(
        device.ask("604: 2F 03 10 00 00 00 00 00"),
        ["584: 60 03 10 00 00 00 00 00"]
    );
    assert_eq!(
        device.ask("604: 40 03 10 00 00 00 00 00"),
        ["584: 4F 03 10 00 00 00 00 00"]
    );
    assert_eq!(
        device.ask("604: 40 03 10 01 00 00 00 00"),
        [abort(0x1003, 1, 0x0800_0024)]
    );
    assert_eq!(device.value(0x1001, 0), [3], "the error stands");
}

#[test]
fn e07_the_inhibit_time_delays_and_loses_nothing() {
    let mut device = Device::new();
    assert_eq!(
        device.ask("604: 2B 15 10 00 E8 03 00 00"),
        ["584: 60 15 10 00 00 00 00 00"]
    );
    for number in 1..=3 {
        device.node.report(error(number), device.now);
    }
    let expected = [
        (0, "084: 01 FF 81 01 01 01 01 01".into()),
        (100, "084: 02 FF 81 02 02 02 02 02".into()),
        (200, "084: 03 FF 81 03 03 03 03 03".into()),
    ];
    assert_eq!(device.pass(1000), expected);
    device.node.report(error(4), device.now);
    assert_eq!(device.pass(1000).len(), 1, "after a pause at once");
}

#[test]
fn e07_more_messages_than_the_queue_holds_are_counted() {
    let mut device = Device::new();
    for number in 1..=18 {
        device.node.report(error(number), device.now);
    }
    let sent = device.sent();
    assert_eq!(sent.len(), 16);
    assert_eq!(
        sent[0], "084: 03 FF 81 03 03 03 03 03",
        "the oldest are lost"
    );
    assert_eq!(sent[15], "084: 12 FF 81 12 12 12 12 12");
    assert_eq!(device.node.overflows(), 2);
    assert_eq!(
        device.value(0x1003, 1),
        [18, 0xFF, 18, 18],
        "the history has them all"
    );
}

#[test]
fn e07_the_last_message_agrees_with_the_error_register() {
    let mut device = Device::operational();
    assert_eq!(
        device.ask("604: 2B 15 10 00 D0 07 00 00"),
        ["584: 60 15 10 00 00 00 00 00"]
    );
    for _ in 0..12 {
        device.send("204 [2] 01 02");
        device.send("204: 01 02 03 04 05 06 07 08");
    }
    assert_eq!(device.node.overflows(), 24 - 16);
    let sent = device.pass(10_000);
    assert_eq!(sent.len(), 16);
    assert_eq!(sent[15].1, "084: 00 00 00 00 00 00 00 00");
    assert_eq!(device.value(0x1001, 0), [0]);
}

#[test]
fn e07_a_new_inhibit_time_counts_for_a_message_that_is_held() {
    let mut device = Device::new();
    assert_eq!(
        device.ask("604: 2B 15 10 00 10 27 00 00"),
        ["584: 60 15 10 00 00 00 00 00"]
    );
    assert_eq!(report(&mut device, error(1)).len(), 1);
    assert!(report(&mut device, error(2)).is_empty());
    device.pass(10);
    assert_eq!(
        device.ask("604: 2B 15 10 00 E8 03 00 00"),
        ["584: 60 15 10 00 00 00 00 00"]
    );
    assert_eq!(
        device.pass(2000),
        [(90, "084: 02 FF 81 02 02 02 02 02".to_owned())]
    );
    assert!(report(&mut device, error(5)).len() == 1);
    assert!(report(&mut device, error(6)).is_empty());
    device.pass(10);
    // Longer than it was, then shorter: 200 ms in the end.
    assert_eq!(device.ask("604: 2B 15 10 00 10 27 00 00").len(), 1);
    assert_eq!(device.ask("604: 2B 15 10 00 D0 07 00 00").len(), 1);
    assert_eq!(
        device.pass(2000),
        [(190, "084: 06 FF 81 06 06 06 06 06".to_owned())]
    );
    assert_eq!(report(&mut device, error(3)).len(), 1);
    assert!(report(&mut device, error(4)).is_empty());
    assert_eq!(
        device.ask("604: 2B 15 10 00 00 00 00 00"),
        [
            "084: 04 FF 81 04 04 04 04 04",
            "584: 60 15 10 00 00 00 00 00"
        ],
        "none at all"
    );
}

#[test]
fn e08_the_generic_bit_stands_with_any_other() {
    let mut device = Device::new();
    let bits = [
        ErrorRegister::CURRENT,
        ErrorRegister::VOLTAGE,
        ErrorRegister::TEMPERATURE,
        ErrorRegister::COMMUNICATION,
        ErrorRegister::DEVICE_PROFILE,
        ErrorRegister::MANUFACTURER,
        0,
    ];
    for (register, code) in bits.into_iter().zip(0x1000..) {
        report(
            &mut device,
            Emergency {
                code,
                register,
                info: [0; 5],
            },
        );
        assert_eq!(device.value(0x1001, 0), [register | ErrorRegister::GENERIC]);
        clear(&mut device, code);
        assert_eq!(device.value(0x1001, 0), [0]);
    }
}

#[test]
fn e09_each_communication_error_comes_once_with_its_end() {
    let mut device = Device::new();
    for code in [
        0x8110, 0x8120, 0x8130, 0x8140, 0x8210, 0x8220, 0x8230, 0x8240, 0x8250_u16,
    ] {
        let [low, high] = code.to_le_bytes();
        let emergency = Emergency {
            code,
            register: ErrorRegister::COMMUNICATION,
            info: [0; 5],
        };
        assert_eq!(
            report(&mut device, emergency),
            [format!("084: {low:02X} {high:02X} 11 00 00 00 00 00")]
        );
        assert!(report(&mut device, emergency).is_empty());
        assert_eq!(clear(&mut device, code), ["084: 00 00 00 00 00 00 00 00"]);
    }
}

#[test]
fn an_emergency_that_is_held_back_wakes_nobody_before_its_time() {
    let mut device = Device::new();
    assert_eq!(
        device.ask("604: 2B 15 10 00 10 27 00 00"),
        ["584: 60 15 10 00 00 00 00 00"]
    );
    assert_eq!(report(&mut device, OVERCURRENT).len(), 1);
    assert!(report(&mut device, OVERHEATED).is_empty());
    let start = device.now;
    device.poll();
    for _ in 0..3 {
        assert_eq!((device.poll() - start).ticks(), 1_000_000);
    }
}

#[test]
fn many_different_errors_at_once_never_lose_the_register() {
    let mut device = Device::new();
    for number in 1..=40 {
        // The first sixteen have a place in the list of errors; the others are of another kind.
        let register = if number <= 16 {
            ErrorRegister::MANUFACTURER
        } else {
            ErrorRegister::CURRENT
        };
        let emergency = Emergency {
            register,
            ..error(number)
        };
        assert_eq!(report(&mut device, emergency).len(), 1);
    }
    assert_eq!(device.value(0x1001, 0), [0x83]);
    for number in 1..=16 {
        assert_eq!(
            device.value(0x1001, 0),
            [0x83],
            "before error {number} is cleared"
        );
        clear(&mut device, 0xFF00 + number);
    }
    assert_eq!(device.value(0x1001, 0), [0]);
}

#[test]
fn e04_an_error_beyond_the_list_is_told_once_and_its_end_once() {
    let mut device = Device::new();
    for number in 1..=20 {
        assert_eq!(report(&mut device, error(number)).len(), 1);
    }
    for number in 1..=20 {
        assert!(report(&mut device, error(number)).is_empty(), "{number}");
    }
    assert_eq!(device.value(0x1003, 1), [20, 0xFF, 20, 20]);
    assert_eq!(clear(&mut device, 0xFF14), ["084: 00 00 81 00 00 00 00 00"]);
    assert!(clear(&mut device, 0xFF14).is_empty());
    assert_eq!(report(&mut device, error(20)).len(), 1, "it may come again");
}

#[test]
fn a_mapped_error_register_is_sent_when_it_changes() {
    let mut device = Device::new();
    device.ask("604: 23 00 18 01 84 01 00 C0");
    device.ask("604: 2F 00 1A 00 00 00 00 00");
    device.ask("604: 23 00 1A 01 08 00 01 10");
    device.ask("604: 2F 00 1A 00 01 00 00 00");
    device.ask("604: 23 00 18 01 84 01 00 40");
    device.send("000 [2] 01 04");
    assert_eq!(device.sent(), ["184 [1] 00"]);
    let emergency = Emergency {
        code: 0xFF01,
        register: 0x80,
        info: [0; 5],
    };
    device.node.report(emergency, device.now);
    device.poll();
    assert_eq!(
        device.sent(),
        ["084: 01 FF 81 00 00 00 00 00", "184 [1] 81"]
    );
    device.node.clear(0xFF01, device.now);
    device.poll();
    assert_eq!(
        device.sent(),
        ["084: 00 00 00 00 00 00 00 00", "184 [1] 00"]
    );
}
