//! Emergency producer: E01 to E10 of the listed cases.

use crate::device::{Device, abort};
use canopen::cia301::emergency::{Emergency, ErrorRegister};
use canopen::cia301::nmt::{NmtState, Reset};

const OVERCURRENT: Emergency = Emergency {
    code: 0x2310,
    register: ErrorRegister::CURRENT,
    info: [0x11, 0x22, 0x33, 0x44, 0x55],
};
const OVERHEATED: Emergency = Emergency {
    code: 0x4210,
    register: ErrorRegister::TEMPERATURE,
    info: [0; 5],
};

fn report(device: &mut Device, emergency: Emergency) -> Vec<String> {
    device.node.report(emergency, device.now);
    device.poll();
    device.sent()
}

fn clear(device: &mut Device, code: u16) -> Vec<String> {
    device.node.clear(code, device.now);
    device.poll();
    device.sent()
}

/// One of many different errors.
fn error(number: u8) -> Emergency {
    Emergency {
        code: 0xFF00 + u16::from(number),
        register: ErrorRegister::MANUFACTURER,
        info: [number; 5],
    }
}

#[test]
fn e01_without_a_valid_cob_id_only_the_history_grows() {
    let mut device = Device::new();
    assert_eq!(device.ask("604#2314100084000080"), ["584#6014100000000000"]);
    assert!(report(&mut device, OVERCURRENT).is_empty());
    assert_eq!(device.value(0x1003, 0), [1]);
    assert_eq!(device.value(0x1001, 0), [3]);
    assert_eq!(device.ask("604#2314100084000000"), ["584#6014100000000000"]);
    assert_eq!(report(&mut device, OVERHEATED), ["084#10420B0000000000"]);
}

#[test]
fn e02_the_identifier_changes_only_while_it_is_not_valid() {
    let mut device = Device::new();
    assert_eq!(
        device.ask("604#2314100085000000"),
        [abort(0x1014, 0, 0x0609_0030)]
    );
    assert_eq!(
        device.ask("604#2314100084000000"),
        ["584#6014100000000000"],
        "the same value again"
    );
    assert_eq!(device.ask("604#2314100084000080"), ["584#6014100000000000"]);
    assert_eq!(device.ask("604#2314100090000000"), ["584#6014100000000000"]);
    assert_eq!(report(&mut device, OVERHEATED), ["090#1042090000000000"]);
}

#[test]
fn e02_extended_and_reserved_bits_are_refused() {
    let mut device = Device::new();
    for value in ["84000020", "84000040", "840800A0"] {
        assert_eq!(
            device.ask(&format!("604#23141000{value}")),
            [abort(0x1014, 0, 0x0609_0030)],
            "{value}"
        );
    }
}

#[test]
fn e03_the_first_error_shows_everywhere() {
    let mut device = Device::new();
    assert_eq!(report(&mut device, OVERCURRENT), ["084#1023031122334455"]);
    assert_eq!(device.ask("604#4001100000000000"), ["584#4F01100003000000"]);
    assert_eq!(device.ask("604#4003100000000000"), ["584#4F03100001000000"]);
    assert_eq!(device.ask("604#4003100100000000"), ["584#4303100110231122"]);
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
        ["084#0000090000000000"],
        "the other error stands"
    );
    assert!(clear(&mut device, 0x2310).is_empty());
    assert_eq!(clear(&mut device, 0x4210), ["084#0000000000000000"]);
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
        device.ask("604#2F03100001000000"),
        [abort(0x1003, 0, 0x0609_0030)]
    );
    assert_eq!(device.value(0x1003, 0), [1]);
    assert_eq!(device.ask("604#2F03100000000000"), ["584#6003100000000000"]);
    assert_eq!(device.ask("604#4003100000000000"), ["584#4F03100000000000"]);
    assert_eq!(
        device.ask("604#4003100100000000"),
        [abort(0x1003, 1, 0x0800_0024)]
    );
    assert_eq!(device.value(0x1001, 0), [3], "the error stands");
}

#[test]
fn e07_the_inhibit_time_delays_and_loses_nothing() {
    let mut device = Device::new();
    assert_eq!(device.ask("604#2B151000E8030000"), ["584#6015100000000000"]);
    for number in 1..=3 {
        device.node.report(error(number), device.now);
    }
    let expected = [
        (0, "084#01FF810101010101".into()),
        (100, "084#02FF810202020202".into()),
        (200, "084#03FF810303030303".into()),
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
    assert_eq!(sent[0], "084#03FF810303030303", "the oldest are lost");
    assert_eq!(sent[15], "084#12FF811212121212");
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
    assert_eq!(device.ask("604#2B151000D0070000"), ["584#6015100000000000"]);
    for _ in 0..12 {
        device.send("204#0102");
        device.send("204#0102030405060708");
    }
    assert_eq!(device.node.overflows(), 24 - 16);
    let sent = device.pass(10_000);
    assert_eq!(sent.len(), 16);
    assert_eq!(sent[15].1, "084#0000000000000000");
    assert_eq!(device.value(0x1001, 0), [0]);
}

#[test]
fn e07_a_new_inhibit_time_counts_for_a_message_that_is_held() {
    let mut device = Device::new();
    assert_eq!(device.ask("604#2B15100010270000"), ["584#6015100000000000"]);
    assert_eq!(report(&mut device, error(1)).len(), 1);
    assert!(report(&mut device, error(2)).is_empty());
    device.pass(10);
    assert_eq!(device.ask("604#2B151000E8030000"), ["584#6015100000000000"]);
    assert_eq!(device.pass(2000), [(90, "084#02FF810202020202".to_owned())]);
    assert!(report(&mut device, error(5)).len() == 1);
    assert!(report(&mut device, error(6)).is_empty());
    device.pass(10);
    // Longer than it was, then shorter: 200 ms in the end.
    assert_eq!(device.ask("604#2B15100010270000").len(), 1);
    assert_eq!(device.ask("604#2B151000D0070000").len(), 1);
    assert_eq!(
        device.pass(2000),
        [(190, "084#06FF810606060606".to_owned())]
    );
    assert_eq!(report(&mut device, error(3)).len(), 1);
    assert!(report(&mut device, error(4)).is_empty());
    assert_eq!(
        device.ask("604#2B15100000000000"),
        ["084#04FF810404040404", "584#6015100000000000"],
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
            [format!("084#{low:02X}{high:02X}110000000000")]
        );
        assert!(report(&mut device, emergency).is_empty());
        assert_eq!(clear(&mut device, code), ["084#0000000000000000"]);
    }
}

#[test]
fn e09_a_receive_pdo_of_a_wrong_length_is_reported_by_the_device_itself() {
    let mut device = Device::operational();
    device.send("204#0102");
    assert_eq!(device.sent(), ["084#1082110100000000"]);
    device.send("204#0102030405060708");
    assert_eq!(device.sent(), ["084#0000000000000000"]);
    device.send("204#0102");
    device.sent();
    device.send("000#8204");
    device.serve_reset();
    assert_eq!(
        device.sent(),
        ["704#00"],
        "communication starts without its old errors, and says nothing more"
    );
    assert_eq!(device.value(0x1001, 0), [0]);
}

/// The second receive PDO listens to 304h.
fn with_two_receive_pdos() -> Device {
    let mut device = Device::operational();
    assert_eq!(device.ask("604#2301140104030000"), ["584#6001140100000000"]);
    device
}

#[test]
fn p21_length_errors_of_two_receive_pdos_come_and_go_by_themselves() {
    let mut device = with_two_receive_pdos();
    assert_eq!(device.ask("204#0102"), ["084#1082110100000000"]);
    assert_eq!(device.ask("304#0102"), ["084#1082110200000000"]);
    assert!(device.ask("204#01").is_empty(), "told once");
    assert_eq!(
        device.ask("204#0102030405060708"),
        ["084#0000110000000000"],
        "the other one stands"
    );
    assert_eq!(device.value(0x1001, 0), [0x11]);
    assert_eq!(device.ask("204#01"), ["084#1082110100000000"]);
    assert_eq!(device.ask("304#0102030405060708"), ["084#0000110000000000"]);
    assert_eq!(device.ask("204#0102030405060708"), ["084#0000000000000000"]);
    assert_eq!(device.value(0x1001, 0), [0]);
}

#[test]
fn p21_a_receive_pdo_that_is_switched_off_ends_its_own_length_error() {
    let mut device = with_two_receive_pdos();
    device.ask("204#0102");
    device.ask("304#0102");
    assert_eq!(
        device.ask("604#2301140104030080"),
        ["084#0000110000000000", "584#6001140100000000"]
    );
    assert_eq!(device.ask("204#0102030405060708"), ["084#0000000000000000"]);
}

#[test]
fn y06_a_sync_error_ends_whatever_lengths_came_after_it() {
    let mut device = Device::operational();
    assert_eq!(device.ask("080#01"), ["084#4082110100000000"]);
    assert!(device.ask("080#0102").is_empty());
    assert_eq!(device.ask("080#"), ["084#0000000000000000"]);
}

#[test]
fn e10_in_stopped_there_is_no_message_and_none_is_lost() {
    let mut device = Device::new();
    device.send("000#0204");
    assert_eq!(device.node.state(), NmtState::Stopped);
    assert!(report(&mut device, OVERCURRENT).is_empty());
    assert_eq!(device.value(0x1001, 0), [3]);
    assert_eq!(device.value(0x1003, 1), [0x10, 0x23, 0x11, 0x22]);
    assert!(device.pass(1000).is_empty());
    device.send("000#8004");
    assert_eq!(device.pass(1000), [(0, "084#1023031122334455".to_owned())]);
    assert_eq!(clear(&mut device, 0x2310), ["084#0000000000000000"]);
}

#[test]
fn e10_an_error_and_its_end_that_both_fell_into_stopped_go_out_both() {
    let mut device = Device::new();
    device.send("000#0204");
    assert!(report(&mut device, OVERCURRENT).is_empty());
    assert!(clear(&mut device, 0x2310).is_empty());
    assert_eq!(
        device.ask("000#0104"),
        [
            "084#1023031122334455",
            "084#0000000000000000",
            "184#0000000000000000"
        ]
    );
}

#[test]
fn e10_a_message_that_waits_outlives_stop() {
    let mut device = Device::new();
    device.node.report(OVERCURRENT, device.now);
    device.send("000#0204");
    assert!(device.sent().is_empty());
    assert_eq!(device.ask("000#8004"), ["084#1023031122334455"]);
}

#[test]
fn e10_an_error_told_before_stopped_ends_behind_it() {
    let mut device = Device::new();
    assert_eq!(report(&mut device, OVERCURRENT).len(), 1);
    device.send("000#0204");
    assert!(clear(&mut device, 0x2310).is_empty());
    assert_eq!(device.ask("000#8004"), ["084#0000000000000000"]);
}

#[test]
fn e10_the_inhibit_time_holds_across_stopped() {
    let mut device = Device::new();
    assert_eq!(device.ask("604#2B15100088130000"), ["584#6015100000000000"]);
    assert_eq!(report(&mut device, OVERCURRENT).len(), 1);
    assert!(report(&mut device, OVERHEATED).is_empty());
    device.send("000#0204");
    assert!(device.pass(100).is_empty());
    device.send("000#8004");
    assert_eq!(
        device.pass(1000),
        [(400, "084#10420B0000000000".to_owned())]
    );
}

#[test]
fn an_emergency_that_is_held_back_wakes_nobody_before_its_time() {
    let mut device = Device::new();
    assert_eq!(device.ask("604#2B15100010270000"), ["584#6015100000000000"]);
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
    assert_eq!(clear(&mut device, 0xFF14), ["084#0000810000000000"]);
    assert!(clear(&mut device, 0xFF14).is_empty());
    assert_eq!(report(&mut device, error(20)).len(), 1, "it may come again");
}

#[test]
fn a_mapped_error_register_is_sent_when_it_changes() {
    let mut device = Device::new();
    device.ask("604#23001801840100C0");
    device.ask("604#2F001A0000000000");
    device.ask("604#23001A0108000110");
    device.ask("604#2F001A0001000000");
    device.ask("604#2300180184010040");
    device.send("000#0104");
    assert_eq!(device.sent(), ["184#00"]);
    let emergency = Emergency {
        code: 0xFF01,
        register: 0x80,
        info: [0; 5],
    };
    device.node.report(emergency, device.now);
    device.poll();
    assert_eq!(device.sent(), ["084#01FF810000000000", "184#81"]);
    device.node.clear(0xFF01, device.now);
    device.poll();
    assert_eq!(device.sent(), ["084#0000000000000000", "184#00"]);
}

#[test]
fn errors_that_stand_are_told_again_after_reset_communication() {
    let mut device = Device::new();
    let motor = Emergency {
        code: 0x7121,
        register: ErrorRegister::CURRENT,
        info: [1, 2, 3, 4, 5],
    };
    let gone = Emergency {
        code: 0x4310,
        register: ErrorRegister::TEMPERATURE,
        info: [0; 5],
    };
    let supply = Emergency {
        code: 0x3120,
        register: ErrorRegister::VOLTAGE,
        info: [0; 5],
    };
    for error in [motor, gone, supply] {
        device.node.report(error, device.now);
    }
    device.node.clear(gone.code, device.now);
    device.sent();
    device.send("000#8204");
    device.serve_reset();
    device.poll();
    assert_eq!(
        device.sent(),
        ["704#00", "084#2171070102030405", "084#2031070000000000"]
    );
    assert_eq!(device.value(0x1001, 0), [0x07]);
    assert_eq!(device.value(0x1003, 0), [2]);
    assert_eq!(device.value(0x1003, 1), [0x20, 0x31, 0, 0]);
    assert_eq!(device.value(0x1003, 2), [0x21, 0x71, 1, 2]);
    // They are the same errors: not told once more, and over once.
    device.node.report(motor, device.now);
    assert_eq!(device.sent(), [""; 0]);
    device.node.clear(motor.code, device.now);
    assert_eq!(device.sent(), ["084#0000050000000000"]);
    // Reset node forgets them, and who still sees one reports it.
    device.send("000#8104");
    assert_eq!(device.serve_reset(), Reset::Node);
    device.poll();
    assert_eq!(device.sent(), ["704#00"]);
    assert_eq!(device.value(0x1001, 0), [0]);
    assert_eq!(device.value(0x1003, 0), [0]);
    assert_eq!(report(&mut device, supply), ["084#2031050000000000"]);
}

#[test]
fn a_device_that_has_lost_its_node_id_sends_no_emergency_message() {
    for reset in ["000#8204", "000#8104"] {
        let mut device = Device::new();
        assert_eq!(report(&mut device, OVERCURRENT).len(), 1);
        assert!(device.ask("7E5#0401000000000000").is_empty());
        assert_eq!(device.ask("7E5#11FF000000000000"), ["7E4#1100000000000000"]);
        device.send(reset);
        device.serve_reset();
        assert!(device.sent().is_empty());
        assert!(report(&mut device, OVERHEATED).is_empty(), "after {reset}");
        assert!(clear(&mut device, OVERHEATED.code).is_empty());
    }
}

#[test]
fn a_device_without_a_node_id_drops_no_message_as_it_has_none() {
    let mut device = Device::off_with(255);
    device.boot(Reset::Node);
    for number in 1..=20 {
        assert!(report(&mut device, error(number)).is_empty());
    }
    assert_eq!(device.node.overflows(), 0);
    // It gets a node-ID, and tells what it can of the errors that stand: the list has sixteen.
    assert!(device.ask("7E5#0401000000000000").is_empty());
    assert_eq!(device.ask("7E5#1104000000000000"), ["7E4#1100000000000000"]);
    device.send("7E5#0400000000000000");
    device.serve_reset();
    device.poll();
    let sent = device.sent();
    assert_eq!(sent.len(), 17, "{sent:?}");
    assert_eq!((&*sent[0], &*sent[1]), ("704#00", "084#01FF810101010101"));
    assert_eq!(device.node.overflows(), 0);
}
