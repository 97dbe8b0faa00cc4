//! `axis402 od dump` and `od load`.

use canopen::Duration;
use master::axis402::{dump, load};
use master::{MappedObject, PdoSetup};
use od_gen::Report;
use od_gen::dcf;
use od_gen::model::Commissioning;

use crate::bench::{Bench, refusal};

/// The DCF of a node, read as `od load` would read it.
fn configuration(bench: &mut Bench, node_id: u8) -> od_gen::Model {
    let node = bench.meet(node_id);
    let mut model = bench
        .run(|master, console| dump(master, &node, false, console))
        .unwrap();
    let commissioning = Commissioning {
        node_id,
        bit_rate: 1_000,
        ..Commissioning::default()
    };
    dcf::commission(&mut model, commissioning, "drive.dcf");
    let text = od_gen::print(&model);
    let report = Report::new("drive.dcf", &text);
    let findings: Vec<String> = report.findings.iter().map(ToString::to_string).collect();
    assert!(!report.has_errors(), "{findings:?}");
    report.model
}

#[test]
fn a_dump_tells_every_value_with_its_name() {
    let (mut bench, _) = Bench::with_drives(&[4]);
    let node = bench.meet(4);
    let told = bench.told(|master, console| dump(master, &node, true, console));
    for line in [
        "1018h:04 Identity object: Serial number: 1\n",
        "6041h:00 Statusword: 0x0250 (switch on disabled)\n",
    ] {
        assert!(told.contains(line), "{told}");
    }
    // A DOMAIN has no value; the list of errors is empty.
    let readable = node.sheet.model().entries().filter(|(_, entry)| {
        entry.access.is_readable() && entry.data_type != od_gen::DataType::Domain
    });
    assert_eq!(told.lines().count() + 8, readable.count());
    let absent = "8 values of the data sheet are not there\n";
    assert!(bench.progress.ends_with(absent), "{}", bench.progress);
}

#[test]
fn a_configuration_goes_from_one_drive_to_another() {
    let (mut bench, _) = Bench::with_drives(&[4, 5]);
    bench.master.write(4, 0x6083, 0, 77_777u32).unwrap();
    bench.master.write(4, 0x607D, 1, -5i32).unwrap();
    bench.master.write(4, 0x1017, 0, 250u16).unwrap();
    // Its node-ID, set by its own object; every drive has its own.
    bench.master.write(4, 0x5FF0, 1, 4u8).unwrap();
    let mapping = PdoSetup {
        cob_id: 0x384,
        transmission_type: 1,
        inhibit_time: Some(100),
        event_timer: None,
        objects: vec![MappedObject::new(0x6064, 32), MappedObject::new(0x6041, 16)],
    };
    bench.master.set_up_tpdo(4, 3, &mapping).unwrap();

    let dcf = configuration(&mut bench, 4);
    let node = bench.meet(5);
    let told = bench.told(|master, console| load(master, &node, &dcf, console));
    assert!(told.contains(" values written, "), "{told}");
    assert_eq!(bench.master.read(5, 0x6083, 0), Ok(77_777u32));
    assert_eq!(bench.master.read(5, 0x607D, 1), Ok(-5i32));
    assert_eq!(bench.master.read(5, 0x1017, 0), Ok(250u16));
    // The PDO is mapped as there, on the identifier of the node that has it.
    assert_eq!(
        bench
            .master
            .read::<u32>(5, 0x1802, 1)
            .map(|id| id & 0x8000_07FF),
        Ok(0x385)
    );
    assert_eq!(bench.master.read(5, 0x1802, 2), Ok(1u8));
    assert_eq!(bench.master.read(5, 0x1A02, 1), Ok(0x6064_0020u32));
    assert_eq!(bench.master.read(5, 0x1A02, 2), Ok(0x6041_0010u32));
    // Loaded twice, there is nothing left to write.
    let told = bench.told(|master, console| load(master, &node, &dcf, console));
    assert!(told.starts_with("0 values written, "), "{told}");
    // Two nodes with one node-ID would be the end of both.
    bench.master.take_received();
    bench.master.nmt(master::NmtCommand::ResetCommunication, 5);
    let boot = Duration::from_ticks(1_000_000);
    bench.master.expect_boot_up(5, boot).unwrap();
}

#[test]
fn a_configuration_moves_no_motor() {
    let (mut bench, _) = Bench::with_drives(&[4]);
    for controlword in [0x06u16, 0x07, 0x0F] {
        bench.master.write(4, 0x6040, 0, controlword).unwrap();
        bench.master.run_for(Duration::from_ticks(10_000));
    }
    bench.master.write(4, 0x607A, 0, 1_000i32).unwrap();
    let dcf = configuration(&mut bench, 4);
    for index in [0x6040, 0x607A, 0x60FF, 0x1010, 0x1011, 0x1003] {
        let object = dcf.object(index);
        let values = object.iter().flat_map(|object| &object.entries);
        assert!(
            values.filter(|entry| entry.configured.is_some()).count() == 0,
            "{index:04X}h"
        );
    }
}

#[test]
fn a_value_that_is_refused_is_told_and_the_rest_is_written() {
    let (mut bench, _) = Bench::with_drives(&[4]);
    let mut dcf = configuration(&mut bench, 4);
    let set = |model: &mut od_gen::Model, index, value| {
        let object = model
            .objects
            .iter_mut()
            .find(|object| object.index == index)
            .unwrap();
        object.entries[0].configured = Some(od_gen::model::DefaultValue::number(value));
    };
    set(&mut dcf, 0x1017, 123);
    set(&mut dcf, 0x6084, 654);
    set(&mut dcf, 0x6040, 0x0F);
    // Quick stop option code: the standard knows no 77.
    set(&mut dcf, 0x605A, 77);
    let node = bench.meet(4);
    let result = bench.run(|master, console| load(master, &node, &dcf, console));
    assert_eq!(refusal(result), ("node 4 refused 1 value".to_owned(), 1));
    assert!(
        bench
            .progress
            .contains("node 4 refuses 605Ah:00 with 0609003"),
        "{}",
        bench.progress
    );
    assert!(
        bench
            .progress
            .contains("6040h:00 Controlword is no setting: left out"),
        "{}",
        bench.progress
    );
    assert_eq!(bench.master.read(4, 0x1017, 0), Ok(123u16));
    assert_eq!(bench.master.read(4, 0x6084, 0), Ok(654u32));
}
