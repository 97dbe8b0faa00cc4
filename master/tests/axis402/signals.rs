//! Signals end the program, whatever it waits for.

use std::io::{BufRead, BufReader, Write};
use std::process::{Command, Stdio};

use sim::drive::Setup;

use crate::program::Served;

#[test]
fn a_monitor_runs_until_it_is_stopped() {
    let served = Served::start(Setup::with_node_id(1, 4));
    // From now on TPDO 1 comes every 100 ms.
    served.told(&["nmt", "start", "4"]);
    let mut monitor = Command::new(env!("CARGO_BIN_EXE_axis402"))
        .args(["--slcan", &served.address.to_string(), "monitor"])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(monitor.stdout.take().unwrap()).lines();
    let line = lines.next().unwrap().unwrap();
    assert!(line.ends_with("TPDO 1: switch on disabled"), "{line}");
    // That of the shell: a bare Debian has no program of that name.
    let kill = Command::new("sh")
        .args(["-c", &format!("kill -INT {}", monitor.id())])
        .status()
        .unwrap();
    assert!(kill.success());
    assert!(lines.all(|line| line.is_ok()));
    assert_eq!(monitor.wait().unwrap().code(), Some(0));
}

#[test]
fn a_signal_ends_a_program_that_waits_for_a_file() {
    let served = Served::start(Setup::with_node_id(1, 4));
    let address = served.address.to_string();
    let mut load = Command::new(env!("CARGO_BIN_EXE_axis402"))
        .args(["--slcan", &address, "--timeout", "50", "od", "load", "4"])
        .arg("/dev/stdin")
        .stdin(Stdio::piped())
        .spawn()
        .unwrap();
    // What comes is not all that there is: the rest is waited for.
    let mut writer = load.stdin.take().unwrap();
    writer.write_all(&[b'\n'; 1 << 17]).unwrap();
    let signal = format!("kill -TERM {0}; kill -TERM {0}", load.id());
    let kill = Command::new("sh").args(["-c", &signal]).status().unwrap();
    assert!(kill.success());
    assert_eq!(load.wait().unwrap().code(), Some(130));
    drop(writer);
}
