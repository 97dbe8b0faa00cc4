//! `axis402 od read`, `od write` and `save`.

use master::axis402::{Group, Node, read, save, write};
use master::data_sheet::DataSheet;
use od_gen::DataType;

use crate::bench::{Bench, refusal};

fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

#[test]
fn objects_are_read_by_number_and_by_name() {
    let (mut bench, _) = Bench::with_drives(&[4]);
    let node = bench.meet(4);
    let wanted = names(&["6041", "revision number", "1008h", "0x6064:0"]);
    let told = bench.told(|master, console| read(master, &node, &wanted, None, false, console));
    assert_eq!(
        told,
        "6041h:00 Statusword: 0x0250 (switch on disabled)\n\
         1018h:03 Identity object: Revision number: 0x00010000\n\
         1008h:00 Manufacturer device name: Axis402 CiA 402 drive\n\
         6064h:00 Position actual value: 0\n"
    );
    let told =
        bench.told(|master, console| read(master, &node, &wanted[1..2], None, true, console));
    assert_eq!(told, "0x00010000\n");
}

#[test]
fn objects_are_written_by_number_and_by_name() {
    let (mut bench, _) = Bench::with_drives(&[4]);
    let node = bench.meet(4);
    write(
        &mut bench.master,
        &node,
        "profile acceleration",
        "50000",
        None,
    )
    .unwrap();
    assert_eq!(bench.master.read(4, 0x6083, 0), Ok(50_000u32));
    write(&mut bench.master, &node, "607D:1", "-1000", None).unwrap();
    assert_eq!(bench.master.read(4, 0x607D, 1), Ok(-1_000i32));
    write(
        &mut bench.master,
        &node,
        "6084",
        "0x10000",
        Some(DataType::Unsigned32),
    )
    .unwrap();
    assert_eq!(bench.master.read(4, 0x6084, 0), Ok(0x1_0000u32));
}

#[test]
fn what_the_drive_refuses_is_told_in_words() {
    let (mut bench, _) = Bench::with_drives(&[4]);
    let node = bench.meet(4);
    assert_eq!(
        refusal(write(&mut bench.master, &node, "1000", "1", None)),
        (
            "node 4 refuses 1000h:00 with 06010002h: attempt to write a read-only object"
                .to_owned(),
            1
        )
    );
    let wanted = names(&["5FFF"]);
    let result = bench.run(|master, console| read(master, &node, &wanted, None, false, console));
    let missing = "node 4 refuses 5FFFh:00 with 06020000h: object does not exist";
    assert_eq!(refusal(result), (missing.to_owned(), 1));
}

#[test]
fn what_means_nothing_never_reaches_the_bus() {
    let (mut bench, _) = Bench::with_drives(&[4]);
    let node = bench.meet(4);
    bench.master.bus_mut().take_trace();
    let mut refused = |object, value, data_type| {
        refusal(write(&mut bench.master, &node, object, value, data_type))
    };
    let (line, code) = refused("6083", "fast", None);
    assert_eq!(code, 2);
    assert!(
        line.starts_with("6083h:00 Profile acceleration: `fast` is not a number"),
        "{line}"
    );
    let (line, code) = refused("6060", "1000", None);
    assert!(
        code == 2 && line.contains("does not fit INTEGER8 (-128 to 127)"),
        "{line}"
    );
    let (line, code) = refused("2FFF", "1", None);
    assert!(code == 2 && line.contains("--type"), "{line}");
    let (line, code) = refused("profile exaltation", "1", None);
    assert!(
        code == 2 && line.starts_with("there is no object `profile exaltation`"),
        "{line}"
    );
    assert!(
        bench
            .master
            .bus()
            .trace()
            .iter()
            .all(|logged| logged.frame.standard_id() != Some(0x604))
    );
}

#[test]
fn a_silent_node_is_told_and_the_transfer_is_given_up() {
    let mut bench = Bench::new();
    let node = Node {
        id: 9,
        sheet: DataSheet::standard(),
    };
    let wanted = names(&["1000"]);
    let result = bench.run(|master, console| read(master, &node, &wanted, None, false, console));
    assert_eq!(refusal(result), ("node 9 does not answer".to_owned(), 1));
    let result = Node::meet(&mut bench.master, 9, None);
    assert_eq!(refusal(result).0, "node 9 does not answer");
}

#[test]
fn saved_parameters_last_over_a_power_cycle() {
    let (mut bench, drives) = Bench::with_drives(&[4]);
    let node = bench.meet(4);
    write(&mut bench.master, &node, "6083", "4321", None).unwrap();
    let told = bench.told(|master, console| save(master, &node, Group::All, console));
    assert_eq!(told, "node 4 has saved its parameters\n");
    bench.master.station_mut(drives[0]).power_cycle();
    bench.master.run_for(canopen::Duration::from_ticks(10_000));
    assert_eq!(bench.master.read(4, 0x6083, 0), Ok(4_321u32));
}
