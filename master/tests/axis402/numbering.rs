//! `axis402 lss`.

use canopen::{Duration, NodeId};
use master::Identity;
use master::axis402::{Numbering, Setting, find, number, scan, set};
use master::bus::simulated::Interference;
use sim::Axis402;
use sim::drive::Setup;

use crate::bench::{Bench, refusal};

const NUMBERING: Numbering = Numbering {
    first: 1,
    store: true,
};

const NOTHING: Setting = Setting {
    device: None,
    node_id: None,
    bit_rate: None,
    store: true,
};

fn identity(serial_number: u32) -> Identity {
    [0, 0x402, 0x0001_0000, serial_number].into()
}

fn stored(bench: &mut Bench, drive: master::bus::simulated::Handle<Axis402>, node_id: u8) {
    bench.master.station_mut(drive).power_cycle();
    bench
        .master
        .expect_boot_up(node_id, Duration::from_ticks(1_000_000))
        .unwrap();
}

#[test]
fn every_device_without_a_node_id_is_found_and_none_is_changed() {
    let (mut bench, _) = Bench::with_drives(&[255, 4, 255]);
    let told = bench.told(find);
    for serial_number in [1, 3] {
        assert!(
            told.contains(&identity(serial_number).to_string()),
            "{told}"
        );
    }
    assert!(told.ends_with("2 devices without a node-ID\n"), "{told}");
    assert_eq!(bench.progress, "", "progress is for a terminal");
    // They are in waiting state again and can be found once more.
    assert_eq!(bench.told(find).lines().count(), 3);
}

#[test]
fn devices_that_somebody_left_in_configuration_state_are_found_and_numbered() {
    let (mut bench, _) = Bench::with_drives(&[255]);
    bench.master.lss_switch_to_configuration();
    assert!(bench.told(find).ends_with("1 device without a node-ID\n"));
    bench.master.lss_switch_to_configuration();
    let told = bench.told(|master, console| number(master, NUMBERING, console));
    assert!(told.ends_with("1 device has a node-ID now\n"), "{told}");
}

#[test]
fn devices_get_the_lowest_free_node_ids_and_keep_them() {
    let (mut bench, drives) = Bench::with_drives(&[255, 1, 3, 255, 255]);
    let told = bench.told(|master, console| number(master, NUMBERING, console));
    assert!(told.contains("node 2: vendor 00000000h"), "{told}");
    assert!(told.ends_with("3 devices have a node-ID now\n"), "{told}");
    let told = bench.told(scan);
    assert!(told.ends_with("5 nodes\n"), "{told}");
    // A fastscan finds the highest serial number last: the lowest is numbered first.
    for (drive, node_id) in [(0, 2), (3, 4), (4, 5)] {
        stored(&mut bench, drives[drive], node_id);
    }
}

#[test]
fn node_ids_that_are_not_stored_are_forgotten() {
    let (mut bench, drives) = Bench::with_drives(&[255]);
    let numbering = Numbering {
        first: 40,
        store: false,
    };
    let told = bench.told(|master, console| number(master, numbering, console));
    assert!(told.starts_with("node 40: "), "{told}");
    bench.master.station_mut(drives[0]).power_cycle();
    assert!(
        bench
            .told(scan)
            .starts_with("no node answers, and at least one")
    );
}

#[test]
fn node_ids_run_out_with_a_word_about_the_device_that_got_none() {
    let (mut bench, _) = Bench::with_drives(&[255, 255]);
    let numbering = Numbering {
        first: 127,
        ..NUMBERING
    };
    let (line, code) = refusal(bench.run(|master, console| number(master, numbering, console)));
    assert_eq!(code, 1);
    assert!(
        line.starts_with("no node-ID is left for the device with vendor"),
        "{line}"
    );
    assert!(bench.output.starts_with("node 127: "), "{}", bench.output);
    // It is not left in configuration state: it can be found again.
    assert!(bench.told(find).ends_with("1 device without a node-ID\n"));
}

#[test]
fn a_scan_that_lost_an_answer_is_repeated() {
    let (mut bench, _) = Bench::with_drives(&[255]);
    let mut lost = 0;
    bench.master.bus_mut().interfere(move |logged| {
        let is_answer = logged.frame.standard_id() == Some(0x7E4);
        lost += usize::from(is_answer);
        if is_answer && lost == 9 {
            Interference::Lose
        } else {
            Interference::None
        }
    });
    let told = bench.told(find);
    assert!(told.starts_with(&format!("1: {}", identity(1))), "{told}");
    assert!(
        bench.progress.contains("once more and slower"),
        "{}",
        bench.progress
    );
}

#[test]
fn one_of_many_devices_is_set_by_its_identity() {
    let (mut bench, drives) = Bench::with_drives(&[255, 255, 9]);
    let setting = Setting {
        device: Some(identity(2)),
        node_id: NodeId::new(7),
        ..NOTHING
    };
    let told = bench.told(|master, console| set(master, setting, console));
    assert_eq!(told, "node 7 has booted\n");
    // A device that has a node-ID keeps it until its communication is reset.
    let setting = Setting {
        device: Some(identity(3)),
        node_id: NodeId::new(10),
        ..NOTHING
    };
    let told = bench.told(|master, console| set(master, setting, console));
    assert_eq!(
        told,
        "node 9 will be node 10 when its communication is reset\n"
    );
    bench.master.nmt(master::NmtCommand::ResetCommunication, 9);
    bench
        .master
        .expect_boot_up(10, Duration::from_ticks(1_000_000))
        .unwrap();
    stored(&mut bench, drives[1], 7);
    stored(&mut bench, drives[2], 10);
}

#[test]
fn nobody_is_set_where_it_is_not_clear_who() {
    let (mut bench, _) = Bench::with_drives(&[255, 255]);
    let setting = Setting {
        node_id: NodeId::new(7),
        ..NOTHING
    };
    let refused = refusal(bench.run(|master, console| set(master, setting, console)));
    assert_eq!(
        refused,
        (
            "more than one device answers: say which one with --identity".to_owned(),
            1
        )
    );
    let setting = Setting {
        device: Some(identity(5)),
        ..setting
    };
    let (line, _) = refusal(bench.run(|master, console| set(master, setting, console)));
    assert_eq!(line, format!("no device has {}", identity(5)));
    assert!(bench.told(scan).starts_with("no node answers, and"));
    let (line, _) = refusal(Bench::new().run(|master, console| set(master, setting, console)));
    assert!(line.starts_with("no device has "), "{line}");
}

#[test]
fn a_setup_of_its_own_is_a_device_like_any_other() {
    let mut bench = Bench::new();
    let drive = bench.attach(Axis402::new(Setup::unconfigured(0xFFFF_FFFF)));
    bench.master.run_for(Duration::from_ticks(10_000));
    let told = bench.told(|master, console| number(master, NUMBERING, console));
    assert!(told.contains("serial FFFFFFFFh"), "{told}");
    stored(&mut bench, drive, 1);
}
