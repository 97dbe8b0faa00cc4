//! `axis402 scan`.

use canopen::Duration;
use master::NmtCommand;
use master::axis402::scan;

use crate::bench::Bench;

#[test]
fn everybody_on_the_bus_is_found_and_described() {
    let (mut bench, _) = Bench::with_drives(&[4, 127, 255]);
    let told = bench.told(scan);
    let lines: Vec<&str> = told.lines().collect();
    assert_eq!(lines.len(), 4, "{told}");
    let words = |line: &str| {
        line.split_whitespace()
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    let four = [
        "4", "00040192", "00000000", "00000402", "00010000", "00000001",
    ];
    assert_eq!(words(lines[1])[..6], four);
    assert!(lines[1].ends_with("Axis402 CiA 402 drive"), "{told}");
    assert_eq!(words(lines[2])[0], "127");
    assert!(
        lines[3].starts_with("2 nodes, and at least one device without a node-ID"),
        "{told}"
    );
}

#[test]
fn an_empty_bus_is_told_and_not_an_error() {
    assert_eq!(Bench::new().told(scan), "no node answers\n");
}

#[test]
fn a_stopped_node_is_known_by_its_heartbeat() {
    let (mut bench, _) = Bench::with_drives(&[4]);
    bench.master.write(4, 0x1017, 0, 100u16).unwrap();
    bench.master.nmt(NmtCommand::Stop, 4);
    bench.master.run_for(Duration::from_ticks(10_000));
    let told = bench.told(scan);
    assert!(
        told.contains("   4  stopped          (answers no SDO)\n1 node\n"),
        "{told}"
    );
}

#[test]
fn progress_goes_on_one_line_of_a_terminal_and_is_taken_off_it() {
    let mut bench = Bench::new().on_terminal();
    bench.told(scan);
    assert!(
        bench
            .progress
            .starts_with("\r\x1B[Kasking every node-ID: 0 %"),
        "{:?}",
        bench.progress
    );
    assert!(bench.progress.ends_with("\r\x1B[K"), "{:?}", bench.progress);
    assert!(!bench.progress.contains('\n'));
}
