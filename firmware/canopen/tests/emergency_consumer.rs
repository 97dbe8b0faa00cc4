//! The emergency consumer 1028h: messages of other devices, and what may be written.

use crate::device::{Device, abort};
use canopen::Event;
use canopen::cia301::emergency::ReceivedEmergency;

/// Sub-index 2 listens to node 5.
fn listening() -> Device {
    let mut device = Device::new();
    assert_eq!(
        device.ask("604: 23 28 10 02 85 00 00 00"),
        ["584: 60 28 10 02 00 00 00 00"]
    );
    device.events();
    device
}

fn heard(code: u16) -> Event {
    Event::EmergencyReceived(ReceivedEmergency {
        consumer: 2,
        code,
        register: 0x21,
        info: [1, 2, 3, 4, 5],
    })
}

#[test]
fn the_messages_of_another_device_are_events() {
    let mut device = listening();
    device.send("085: 10 86 21 01 02 03 04 05");
    device.send("085: 00 00 21 01 02 03 04 05");
    assert_eq!(device.events(), [heard(0x8610), heard(0)]);
    device.send("086: 10 86 21 01 02 03 04 05");
    device.send("085 [7] 10 86 21 01 02 03 04");
    device.send("085 [8] rtr");
    assert_eq!(device.events(), []);
}

#[test]
fn n09_a_stopped_device_hears_none() {
    let mut device = listening();
    device.send("000 [2] 02 04");
    device.events();
    device.send("085: 10 86 21 01 02 03 04 05");
    assert_eq!(device.events(), []);
    device.send("000 [2] 80 04");
    device.events();
    device.send("085: 10 86 21 01 02 03 04 05");
    assert_eq!(device.events().len(), 1);
}

#[test]
fn the_first_of_many_are_kept_and_the_others_counted() {
    let mut device = listening();
    for number in 0..6 {
        device.send(&format!("085: {number:02X} 86 21 01 02 03 04 05"));
    }
    let kept: Vec<Event> = (0x8600..0x8604).map(heard).collect();
    assert_eq!(device.events(), kept);
    assert_eq!(device.node.overflows(), 2);
}

#[test]
fn an_identifier_changes_while_it_is_not_valid() {
    let mut device = listening();
    let refused = [abort(0x1028, 2, 0x0609_0030)];
    assert_eq!(device.ask("604: 23 28 10 02 86 00 00 00"), refused);
    for value in ["01000000", "81010020", "01070000", "85000040"] {
        device.ask("604: 23 28 10 02 85 00 00 80");
        assert_eq!(device.ask(&format!("604: 23 28 10 02 {value}")), refused);
    }
    assert_eq!(
        device.ask("604: 23 28 10 02 86 00 00 00"),
        ["584: 60 28 10 02 00 00 00 00"]
    );
    device.send("086: 10 86 21 01 02 03 04 05");
    device.send("085: 10 86 21 01 02 03 04 05");
    assert_eq!(device.events(), [heard(0x8610)]);
}
