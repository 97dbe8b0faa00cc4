//! The virtual drive on the simulated bus: what is around the core works, so that the core can be tested through it.

use canopen::{BitRate, Duration, NodeId};
use master::bus::simulated::{Bus, Handle};
use master::{Failure, Identity, MappedObject, Master, NmtCommand, PdoSetup};
use sim::Axis402;
use sim::drive::Setup;
use sim::plant::{Axis, Switch, Track};

const NODE: u8 = 4;
const SECOND: Duration = Duration::from_ticks(1_000_000);

fn bus_with(setup: Setup) -> (Master, Handle<Axis402>) {
    let mut master = Master::new(Bus::new(BitRate::Kbit1000));
    let drive = master.bus_mut().attach(Axis402::new(setup));
    (master, drive)
}

/// A drive with node-ID 4 that has booted.
fn booted() -> (Master, Handle<Axis402>) {
    let (mut master, drive) = bus_with(Setup::with_node_id(7, NODE));
    master.expect_boot_up(NODE, SECOND).unwrap();
    (master, drive)
}

/// In Operation Enabled, profile position.
fn enabled() -> (Master, Handle<Axis402>) {
    let (mut master, drive) = booted();
    master.write(NODE, 0x6060, 0, 1i8).unwrap();
    master.nmt(NmtCommand::Start, NODE);
    for (controlword, state) in [(0x06, 0x21), (0x07, 0x23), (0x0F, 0x27)] {
        master.controlword(NODE, controlword);
        master
            .wait_for_statusword(NODE, 0x6F, state, SECOND)
            .unwrap();
    }
    (master, drive)
}

#[test]
fn sdo_reads_and_writes_in_both_ways() {
    let (mut master, _) = booted();
    assert_eq!(master.read::<u32>(NODE, 0x1018, 4), Ok(7));
    assert!(
        master
            .read::<String>(NODE, 0x1008, 0)
            .unwrap()
            .starts_with("Axis402")
    );
    master.write(NODE, 0x6083, 0, 123_456u32).unwrap();
    assert_eq!(master.read::<u32>(NODE, 0x6083, 0), Ok(123_456));
    master
        .download_segmented(NODE, 0x6083, 0, &654_321u32.to_le_bytes())
        .unwrap();
    assert_eq!(master.read::<u32>(NODE, 0x6083, 0), Ok(654_321));
    let abort = Failure::Abort {
        index: 0x1000,
        sub: 0,
        code: 0x0601_0002,
    };
    assert_eq!(master.write(NODE, 0x1000, 0, 1u32), Err(abort));
}

#[test]
fn lss_settings_last_over_a_power_cycle() {
    let (mut master, drive) = bus_with(Setup::unconfigured(0x1234_5678));
    let identity = master.lss_fastscan().unwrap().unwrap();
    assert_eq!(identity.serial_number, 0x1234_5678);
    master
        .lss_configure_node_id(NodeId::new(11).unwrap())
        .unwrap();
    master.lss_store().unwrap();
    master.station_mut(drive).power_cycle();
    master.expect_boot_up(11, SECOND).unwrap();
    assert_eq!(master.lss_fastscan(), Ok(None));
}

#[test]
fn of_two_drives_the_selected_one_is_configured() {
    let (mut master, _) = bus_with(Setup::unconfigured(1));
    master
        .bus_mut()
        .attach(Axis402::new(Setup::unconfigured(2)));
    master
        .bus_mut()
        .attach(Axis402::new(Setup::with_node_id(3, 9)));
    master.expect_boot_up(9, SECOND).unwrap();
    let generic: Identity = [1, 2, 3, 4]
        .map(|sub| master.read::<u32>(9, 0x1018, sub).unwrap())
        .into();
    let with_serial = |serial_number| Identity {
        serial_number,
        ..generic
    };

    // Nobody has this one, so nobody answers, and nobody takes the node-ID that is meant for it.
    assert!(matches!(
        master.lss_select(with_serial(4)),
        Err(Failure::Timeout { .. })
    ));
    let id = |number| NodeId::new(number).unwrap();
    assert!(matches!(
        master.lss_configure_node_id(id(20)),
        Err(Failure::Timeout { .. })
    ));

    for (serial_number, node) in [(2, 12), (1, 11)] {
        master.lss_select(with_serial(serial_number)).unwrap();
        let identity = master.lss_inquire_identity().unwrap();
        assert_eq!(identity, with_serial(serial_number));
        assert_eq!(master.lss_inquire_node_id(), Ok(Some(NodeId::UNCONFIGURED)));
        master.lss_configure_node_id(id(node)).unwrap();
        master.lss_switch_to_waiting();
        master.expect_boot_up(node, SECOND).unwrap();
        assert_eq!(master.read::<u32>(node, 0x1018, 4), Ok(serial_number));
    }
    master.lss_select(with_serial(3)).unwrap();
    assert_eq!(master.lss_inquire_node_id(), Ok(Some(id(9))));
}

#[test]
fn settings_that_were_not_stored_do_not_last() {
    let (mut master, drive) = bus_with(Setup::unconfigured(1));
    master.lss_fastscan().unwrap().unwrap();
    master
        .lss_configure_node_id(NodeId::new(11).unwrap())
        .unwrap();
    master.station_mut(drive).power_cycle();
    master.expect_nothing_for(SECOND).unwrap();
    assert!(master.lss_fastscan().unwrap().is_some());
}

#[test]
fn a_store_that_fails_is_told_to_the_master() {
    let mut setup = Setup::unconfigured(1);
    let mut flash = setup.store.release();
    flash.break_down();
    setup.store = flash.into_store();
    let (mut master, _) = bus_with(setup);
    master.lss_switch_to_configuration();
    master
        .lss_configure_node_id(NodeId::new(11).unwrap())
        .unwrap();
    let refused = Failure::LssRefused {
        service: 0x17,
        error: 2,
    };
    assert_eq!(master.lss_store(), Err(refused));
}

#[test]
fn the_bit_rate_switches_for_master_and_drive() {
    let (mut master, _) = booted();
    master.port_mut().set_bit_rate(Some(BitRate::Kbit1000));
    master.lss_switch_to_configuration();
    master.lss_configure_bit_timing(BitRate::Kbit250).unwrap();
    let delay = Duration::from_ticks(20_000);
    master.lss_activate_bit_timing(delay);
    master.run_for(delay);
    master.port_mut().set_bit_rate(Some(BitRate::Kbit250));
    master.run_for(delay + delay);
    master.lss_switch_to_waiting();
    assert_eq!(master.read::<u32>(NODE, 0x1018, 4), Ok(7));
    master.port_mut().set_bit_rate(Some(BitRate::Kbit1000));
    assert!(matches!(
        master.read::<u32>(NODE, 0x1018, 4),
        Err(Failure::Timeout { .. })
    ));
}

#[test]
fn the_motor_goes_where_6064_says() {
    let (mut master, drive) = enabled();
    master.write(NODE, 0x607A, 0, -5_000i32).unwrap();
    master.controlword(NODE, 0x1F);
    master
        .wait_for_statusword(NODE, 0x1000, 0x1000, SECOND)
        .unwrap();
    master.controlword(NODE, 0x0F);
    master
        .wait_for_statusword(NODE, 0x1400, 0x0400, SECOND * 10)
        .unwrap();
    master.run_for(Duration::from_ticks(100_000));
    assert_eq!(master.read::<i32>(NODE, 0x6064, 0), Ok(-5_000));
    assert_eq!(master.station(drive).plant().position(), -5_000);
    assert!(master.station(drive).plant().is_energised());
}

#[test]
fn a_lost_supply_is_a_fault() {
    let (mut master, drive) = enabled();
    master.station_mut(drive).plant_mut().supply = false;
    master
        .wait_for_statusword(NODE, 0x4F, 0x08, SECOND * 10)
        .unwrap();
    assert!(!master.station(drive).plant().is_energised());
    let emergency = master.expect_from(0x080 + u16::from(NODE)).unwrap();
    let [low, high, ..] = emergency[..] else {
        panic!("{emergency:02X?}");
    };
    let code = u16::from_le_bytes([low, high]);
    assert_ne!(code, 0);
    assert_eq!(master.read::<u16>(NODE, 0x603F, 0), Ok(code));
}

#[test]
fn a_power_cycle_forgets_everything_that_is_not_stored() {
    let (mut master, drive) = enabled();
    master.write(NODE, 0x607A, 0, 77i32).unwrap();
    master.station_mut(drive).power_cycle();
    master.expect_boot_up(NODE, SECOND).unwrap();
    assert!(!master.station(drive).plant().is_energised());
    assert_eq!(
        master.read::<u16>(NODE, 0x6041, 0).map(|word| word & 0x4F),
        Ok(0x40)
    );
    assert_eq!(master.read::<i32>(NODE, 0x607A, 0), Ok(0));
}

#[test]
fn a_receive_pdo_that_was_mapped_and_moved_moves_the_motor() {
    const COB_ID: u16 = 0x2C4;
    let (mut master, drive) = enabled();
    let setup = PdoSetup {
        cob_id: COB_ID,
        transmission_type: 255,
        inhibit_time: None,
        event_timer: None,
        objects: vec![MappedObject::new(0x607A, 32), MappedObject::new(0x6040, 16)],
    };
    master.set_up_rpdo(NODE, 3, &setup).unwrap();
    assert_eq!(master.read::<u32>(NODE, 0x1402, 1), Ok(u32::from(COB_ID)));
    let set_point = |master: &mut Master, cob_id, target: i32| {
        for controlword in [0x1Fu16, 0x0F] {
            let data = [&target.to_le_bytes()[..], &controlword.to_le_bytes()].concat();
            master.send_data(cob_id, &data);
            master.run_for(Duration::from_ticks(10_000));
        }
        master.run_for(SECOND);
        master.station(drive).plant().position()
    };
    assert_eq!(set_point(&mut master, COB_ID, 1_234), 1_234);
    assert_eq!(master.read::<i32>(NODE, 0x607A, 0), Ok(1_234));

    // Nothing listens where it was before.
    let old = 0x400 + u16::from(NODE);
    assert_eq!(set_point(&mut master, old, 0), 1_234);

    // It has to be switched off before its mapping changes, which the set-up does.
    let swapped = PdoSetup {
        objects: setup.objects.iter().rev().copied().collect(),
        ..setup
    };
    master.set_up_rpdo(NODE, 3, &swapped).unwrap();
    let data = [&0x0Fu16.to_le_bytes()[..], &77i32.to_le_bytes()].concat();
    master.send_data(COB_ID, &data);
    master.run_for(Duration::from_ticks(10_000));
    assert_eq!(master.read::<i32>(NODE, 0x607A, 0), Ok(77));
}

#[test]
fn switches_stay_where_they_are_mounted_when_the_power_goes() {
    let (mut master, drive) = booted();
    let plant = master.station_mut(drive).plant_mut();
    plant.mount(&Axis {
        track: Track {
            positive_limit: Some(Switch::from(500)),
            ..Track::default()
        },
        ..Axis::default()
    });
    plant.displace(500);
    assert!(master.station(drive).plant().switch_states().positive_limit);
    master.station_mut(drive).power_cycle();
    master.expect_boot_up(NODE, SECOND).unwrap();
    // The drive counts from 0 again, but nothing has moved.
    let plant = master.station_mut(drive).plant_mut();
    assert_eq!(plant.position(), 0);
    assert!(plant.switch_states().positive_limit);
    plant.displace(-1);
    assert!(!plant.switch_states().positive_limit);
}
