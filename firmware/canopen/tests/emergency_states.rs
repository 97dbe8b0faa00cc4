//! Emergency messages and NMT states: what Stopped holds back, what a reset tells again, and what a device without a node-ID keeps to itself.

use crate::device::Device;
use crate::emergency::{OVERCURRENT, OVERHEATED, clear, error, report};
use canopen::cia301::emergency::{Emergency, ErrorRegister};
use canopen::cia301::nmt::{NmtState, Reset};

#[test]
fn e10_in_stopped_there_is_no_message_and_none_is_lost() {
    let mut device = Device::new();
    device.send("000 [2] 02 04");
    assert_eq!(device.node.state(), NmtState::Stopped);
    assert!(report(&mut device, OVERCURRENT).is_empty());
    assert_eq!(device.value(0x1001, 0), [3]);
    assert_eq!(device.value(0x1003, 1), [0x10, 0x23, 0x11, 0x22]);
    assert!(device.pass(1000).is_empty());
    device.send("000 [2] 80 04");
    assert_eq!(
        device.pass(1000),
        [(0, "084: 10 23 03 11 22 33 44 55".to_owned())]
    );
    assert_eq!(clear(&mut device, 0x2310), ["084: 00 00 00 00 00 00 00 00"]);
}

#[test]
fn e10_an_error_and_its_end_that_both_fell_into_stopped_go_out_both() {
    let mut device = Device::new();
    device.send("000 [2] 02 04");
    assert!(report(&mut device, OVERCURRENT).is_empty());
    assert!(clear(&mut device, 0x2310).is_empty());
    assert_eq!(
        device.ask("000 [2] 01 04"),
        [
            "084: 10 23 03 11 22 33 44 55",
            "084: 00 00 00 00 00 00 00 00",
            "184: 00 00 00 00 00 00 00 00"
        ]
    );
}

#[test]
fn e10_a_message_that_waits_outlives_stop() {
    let mut device = Device::new();
    device.node.report(OVERCURRENT, device.now);
    device.send("000 [2] 02 04");
    assert!(device.sent().is_empty());
    assert_eq!(
        device.ask("000 [2] 80 04"),
        ["084: 10 23 03 11 22 33 44 55"]
    );
}

#[test]
fn e10_an_error_told_before_stopped_ends_behind_it() {
    let mut device = Device::new();
    assert_eq!(report(&mut device, OVERCURRENT).len(), 1);
    device.send("000 [2] 02 04");
    assert!(clear(&mut device, 0x2310).is_empty());
    assert_eq!(
        device.ask("000 [2] 80 04"),
        ["084: 00 00 00 00 00 00 00 00"]
    );
}

#[test]
fn e10_the_inhibit_time_holds_across_stopped() {
    let mut device = Device::new();
    assert_eq!(
        device.ask("604: 2B 15 10 00 88 13 00 00"),
        ["584: 60 15 10 00 00 00 00 00"]
    );
    assert_eq!(report(&mut device, OVERCURRENT).len(), 1);
    assert!(report(&mut device, OVERHEATED).is_empty());
    device.send("000 [2] 02 04");
    assert!(device.pass(100).is_empty());
    device.send("000 [2] 80 04");
    assert_eq!(
        device.pass(1000),
        [(400, "084: 10 42 0B 00 00 00 00 00".to_owned())]
    );
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
    device.send("000 [2] 82 04");
    device.serve_reset();
    device.poll();
    assert_eq!(
        device.sent(),
        [
            "704 [1] 00",
            "084: 21 71 07 01 02 03 04 05",
            "084: 20 31 07 00 00 00 00 00"
        ]
    );
    assert_eq!(device.value(0x1001, 0), [0x07]);
    assert_eq!(device.value(0x1003, 0), [2]);
    assert_eq!(device.value(0x1003, 1), [0x20, 0x31, 0, 0]);
    assert_eq!(device.value(0x1003, 2), [0x21, 0x71, 1, 2]);
    // They are the same errors: not told once more, and over once.
    device.node.report(motor, device.now);
    assert_eq!(device.sent(), [""; 0]);
    device.node.clear(motor.code, device.now);
    assert_eq!(device.sent(), ["084: 00 00 05 00 00 00 00 00"]);
    // Reset node forgets them, and who still sees one reports it.
    device.send("000 [2] 81 04");
    assert_eq!(device.serve_reset(), Reset::Node);
    device.poll();
    assert_eq!(device.sent(), ["704 [1] 00"]);
    assert_eq!(device.value(0x1001, 0), [0]);
    assert_eq!(device.value(0x1003, 0), [0]);
    assert_eq!(
        report(&mut device, supply),
        ["084: 20 31 05 00 00 00 00 00"]
    );
}

#[test]
fn a_device_that_has_lost_its_node_id_sends_no_emergency_message() {
    for reset in ["000 [2] 82 04", "000 [2] 81 04"] {
        let mut device = Device::new();
        assert_eq!(report(&mut device, OVERCURRENT).len(), 1);
        assert!(device.ask("7E5: 04 01 00 00 00 00 00 00").is_empty());
        assert_eq!(
            device.ask("7E5: 11 FF 00 00 00 00 00 00"),
            ["7E4: 11 00 00 00 00 00 00 00"]
        );
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
    assert!(device.ask("7E5: 04 01 00 00 00 00 00 00").is_empty());
    assert_eq!(
        device.ask("7E5: 11 04 00 00 00 00 00 00"),
        ["7E4: 11 00 00 00 00 00 00 00"]
    );
    device.send("7E5: 04 00 00 00 00 00 00 00");
    device.serve_reset();
    device.poll();
    let sent = device.sent();
    assert_eq!(sent.len(), 17, "{sent:?}");
    assert_eq!(
        (&*sent[0], &*sent[1]),
        ("704 [1] 00", "084: 01 FF 81 01 01 01 01 01")
    );
    assert_eq!(device.node.overflows(), 0);
}
