//! `axis402 monitor`.

use master::axis402::{Watch, monitor};
use master::data_sheet::DataSheet;
use master::{MappedObject, NmtCommand, PdoSetup};

use crate::bench::Bench;

fn watch(bench: &mut Bench, nodes: &[u8], count: usize) -> Watch {
    Watch {
        nodes: nodes.iter().map(|id| bench.meet(*id)).collect(),
        sheet: DataSheet::standard(),
        count: Some(count),
    }
}

#[test]
fn the_statusword_is_told_in_words() {
    let (mut bench, _) = Bench::with_drives(&[4]);
    bench.master.nmt(NmtCommand::Start, 4);
    let watch = watch(&mut bench, &[], 2);
    let told = bench.told(|master, console| monitor(master, &watch, console));
    let lines: Vec<&str> = told.lines().collect();
    assert_eq!(lines.len(), 2, "{told}");
    assert!(lines[0].contains("  184   [2]  50 02 "), "{told}");
    assert!(lines[0].ends_with("  TPDO 1: switch on disabled"), "{told}");
    assert!(lines[1].ends_with("  TPDO 3 of node 4"), "{told}");
}

#[test]
fn a_node_that_is_named_says_what_its_pdos_carry() {
    let (mut bench, _) = Bench::with_drives(&[4, 5]);
    let setup = PdoSetup {
        cob_id: 0x2C7,
        transmission_type: 255,
        inhibit_time: None,
        event_timer: Some(10),
        objects: vec![MappedObject::new(0x6064, 32), MappedObject::new(0x6041, 16)],
    };
    bench.master.set_up_tpdo(4, 2, &setup).unwrap();
    bench.master.nmt(NmtCommand::Start, 0);
    let watch = watch(&mut bench, &[4], 8);
    let told = bench.told(|master, console| monitor(master, &watch, console));
    assert!(
        told.contains("TPDO 2: position actual value 0; switch on disabled\n"),
        "{told}"
    );
    // Node 5 sends as well, but nobody asked for it.
    assert!(!told.contains("  185   "), "{told}");
}
