//! Whole conversations as candump would show them. A change of any frame or any time shows here.

mod drive_faults;
mod faults;
mod process_data;

use canopen::{BitRate, Duration, NodeId};
use master::bus::simulated::Bus;
use master::trace::candump;
use master::{Identity, Master, NmtCommand};
use sim::drive::{Setup, VirtualDrive};
use tests::drive::AxisDrive;

/// A master and unconfigured drives with these serial numbers on one bus.
fn bus_with(serial_numbers: &[u32]) -> Master {
    let mut bus = Bus::new(BitRate::Kbit1000);
    for serial_number in serial_numbers {
        let drive: AxisDrive = VirtualDrive::new(Setup::unconfigured(*serial_number));
        bus.attach(drive);
    }
    Master::new(bus)
}

fn trace(master: &Master) -> String {
    let lines: Vec<String> = master
        .bus()
        .trace()
        .iter()
        .map(|logged| candump::line(logged.at, &logged.frame))
        .collect();
    lines.join("\n")
}

#[test]
fn boot_and_configuration_by_lss() {
    let mut master = bus_with(&[0x1234]);
    master.run_for(Duration::millis(10));
    master.lss_switch_to_configuration();
    let identity = master.lss_inquire_identity().unwrap();
    assert_eq!(identity.serial_number, 0x1234);
    master
        .lss_configure_node_id(NodeId::new(4).unwrap())
        .unwrap();
    master.lss_store().unwrap();
    master.lss_switch_to_waiting();
    master.expect_boot_up(4, Duration::millis(10)).unwrap();
    assert_eq!(master.read::<u32>(4, 0x1000, 0).unwrap() & 0xFFFF, 402);
    master.write(4, 0x1017, 0, 100_u16).unwrap();
    master.run_for(Duration::millis(250));
    insta::assert_snapshot!(trace(&master));
}

#[test]
fn a_short_move_by_pdo() {
    let mut master = bus_with(&[1]);
    master.run_for(Duration::millis(10));
    master.lss_switch_to_configuration();
    master
        .lss_configure_node_id(NodeId::new(4).unwrap())
        .unwrap();
    master.lss_switch_to_waiting();
    master.expect_boot_up(4, Duration::millis(10)).unwrap();
    master.nmt(NmtCommand::Start, 4);
    master.run_for(Duration::millis(5));
    for (controlword, state) in [(0x06, 0x21), (0x07, 0x23), (0x0F, 0x27)] {
        master.controlword(4, controlword);
        master
            .wait_for_statusword(4, 0x6F, state, Duration::millis(10))
            .unwrap();
    }
    master.send_data(0x404, &[0x1F, 0x00, 100, 0, 0, 0]);
    master.run_for(Duration::millis(3));
    master.send_data(0x404, &[0x0F, 0x00, 100, 0, 0, 0]);
    master.run_for(Duration::millis(120));
    assert_eq!(master.read::<i32>(4, 0x6064, 0).unwrap(), 100);
    insta::assert_snapshot!(trace(&master));
}

#[test]
fn a_scan_finds_two_drives_whose_serial_numbers_differ_in_one_bit() {
    for (first, second) in [
        (0, 1),
        (0x8000_0000, 0),
        (0xDEAD_BEEF, 0xDEAD_BEEE),
        (0x0001_0000, 0x0001_8000),
    ] {
        let mut master = bus_with(&[first, second]);
        master.run_for(Duration::millis(10));
        let mut found = Vec::new();
        for node_id in [4, 5] {
            let identity: Identity = master
                .lss_fastscan()
                .unwrap()
                .expect("a drive without a node-ID");
            found.push(identity.serial_number);
            master
                .lss_configure_node_id(NodeId::new(node_id).unwrap())
                .unwrap();
            master.lss_switch_to_waiting();
            master
                .expect_boot_up(node_id, Duration::millis(10))
                .unwrap();
        }
        assert_eq!(master.lss_fastscan().unwrap(), None, "nobody is left");
        found.sort_unstable();
        let mut expected = vec![first, second];
        expected.sort_unstable();
        assert_eq!(found, expected);
    }
}
