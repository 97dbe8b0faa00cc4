//! NMT start-up 1F80h: N16 of the listed cases.

use crate::device::{Device, abort};
use canopen::Event;
use canopen::cia301::nmt::{NmtState, Reset};
use canopen::outbox::Sender;

/// What is sent and what is told at power-on with this value of 1F80h.
fn power_on(startup: u32) -> (Vec<String>, Vec<Event>) {
    let mut device = Device::off();
    device.firmware.startup = Some(startup);
    device.boot(Reset::Node);
    device.poll();
    (device.sent(), device.events())
}

#[test]
fn n16_bit_2_decides_who_starts_the_device() {
    let pre_operational = Event::StateChanged(NmtState::PreOperational);
    let operational = Event::StateChanged(NmtState::Operational);
    assert_eq!(
        power_on(0),
        (
            vec![
                "704 [1] 00".to_string(),
                "184: 00 00 00 00 00 00 00 00".to_string()
            ],
            vec![pre_operational, operational]
        )
    );
    assert_eq!(
        power_on(4),
        (vec!["704 [1] 00".to_string()], vec![pre_operational])
    );
    // A master's word counts after that.
    let mut device = Device::off();
    device.boot(Reset::Node);
    device.firmware.startup = Some(0);
    device.boot(Reset::Node);
    assert_eq!(device.node.state(), NmtState::Operational);
    device.send("000 [2] 80 04");
    device.pass(1_000);
    assert_eq!(device.node.state(), NmtState::PreOperational);
}

#[test]
fn o03_identifiers_follow_the_node_id() {
    for node_id in [1_u8, 4, 127] {
        let mut device = Device::off_with(node_id);
        device.boot(Reset::Node);
        let id = u32::from(node_id);
        for (index, sub, cob_id) in [
            (0x1200, 1, 0x600 + id),
            (0x1200, 2, 0x580 + id),
            (0x1014, 0, 0x80 + id),
            (0x1400, 1, 0x200 + id),
            (0x1800, 1, 0x4000_0180 + id),
        ] {
            assert_eq!(
                device.value(index, sub),
                cob_id.to_le_bytes(),
                "{index:04X}h of node {node_id}"
            );
        }
    }
}

#[test]
fn n16_it_counts_at_the_next_boot() {
    let mut device = Device::new();
    assert_eq!(
        device.ask("604: 23 80 1F 00 00 00 00 00"),
        ["584: 60 80 1F 00 00 00 00 00"]
    );
    assert!(device.pass(1_000).is_empty());
    assert_eq!(device.node.state(), NmtState::PreOperational);
}

#[test]
fn n16_the_bits_of_an_nmt_master_are_refused() {
    let mut device = Device::new();
    for bit in [0, 1, 3, 4, 5, 6, 31] {
        let value = 1_u32 << bit;
        let bytes = value.to_le_bytes().map(|byte| format!("{byte:02X}"));
        assert_eq!(
            device.ask(&format!("604: 23 80 1F 00 {}", bytes.concat())),
            [abort(0x1F80, 0, 0x0609_0030)]
        );
    }
    assert_eq!(
        device.ask("604: 23 80 1F 00 04 00 00 00"),
        ["584: 60 80 1F 00 00 00 00 00"]
    );
}

#[test]
fn a_node_with_its_application_has_its_boot_up_message_to_send_and_no_more() {
    let mut device = Device::off();
    device.boot(Reset::Node);
    let mut sender = (&mut device.node, &mut device.firmware);
    let next = sender.pending().expect("the boot-up message");
    assert_eq!(next.cob_id, 0x704);
    assert!(sender.take(&next).is_some());
    assert!(sender.pending().is_none());
}
